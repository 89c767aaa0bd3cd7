// Prints the time of saving, restoring and hashing: of all rows, against one memcpy of as many bytes; and of a part
// that was written while the rest did not change, against a state that has only that part. It checks no times, because
// they depend on the machine. Run it on an idle core.
#include "support/state_sample.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <utility>

using namespace lockstone;
using namespace lockstone::test;

namespace {

struct World {
    State state;
    std::vector<TableId> tables;
};

/// Twenty columns in two tables, 8 to 64 bytes a row.
World make_world(std::uint32_t rows, std::uint32_t capacity) {
    StateLayout layout;
    World world{State(StateLayout().finished()), {}};
    world.tables = {layout.add_table("body", capacity), layout.add_table("contact", capacity)};
    for (int i = 0; i < 5; ++i) {
        const std::string n = std::to_string(i);
        layout.add_column<Transform>(world.tables[0], "body.pose" + n, Group::motion);
        layout.add_column<std::array<Speed, 6>>(world.tables[0], "body.velocity" + n, Group::motion);
        layout.add_column<Manifold>(world.tables[1], "contact.manifold" + n, Group::contact);
        layout.add_column<std::uint64_t>(world.tables[1], "contact.key" + n, Group::contact);
    }
    world.state = State(std::move(layout).finished());
    for (TableId table : world.tables) world.state.resize(table, rows);
    SplitMix random(1);
    scramble(world.state, random);
    return world;
}

/// Median nanoseconds of one call.
template <class Act> double median_ns(std::size_t bytes, Act&& act) {
    const int calls = static_cast<int>(std::max<std::size_t>(1, 4'000'000 / (bytes + 1000)));
    std::vector<double> samples;
    for (int sample = 0; sample < 31; ++sample) {
        const auto start = std::chrono::steady_clock::now();
        for (int i = 0; i < calls; ++i) act();
        const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
        samples.push_back(spent.count() / calls);
    }
    std::ranges::nth_element(samples, samples.begin() + 15);
    return samples[15];
}

/// Marks rows of every column as written.
void touch(State& state, std::uint32_t rows) {
    for (std::uint32_t column = 0; column < state.layout().columns().size(); ++column)
        state.edit_bytes(column, 0, rows);
}

struct Costs {
    double touch, save, restore, hash; ///< [ns], marking the rows included in all four
};
/// The costs for a world whose first rows are written before each call.
Costs costs_of(World& world, std::uint32_t written) {
    const std::size_t bytes = world.state.image_bytes();
    Image image, before;
    world.state.save(image);
    world.state.save(before);
    Costs costs{};
    const auto measured = [&](auto&& act) {
        return median_ns(bytes, [&] {
            touch(world.state, written);
            act();
        });
    };
    std::uint64_t sum = world.state.hash();
    costs.touch = measured([] {});
    costs.save = measured([&] { world.state.save(image); });
    costs.restore = measured([&] { world.state.restore(before); });
    costs.hash = measured([&] { sum += world.state.hash(); });
    if (sum == 0) std::printf(" ");
    return costs;
}

double memcpy_ns(std::size_t bytes) {
    const detail::Block from(bytes), to(bytes);
    std::memset(from.get(), 1, bytes);
    volatile std::byte sink{};
    return median_ns(bytes, [&] {
        std::memcpy(to.get(), from.get(), bytes);
        sink = to.get()[bytes / 2];
    });
}

void print_all_written() {
    std::printf("all rows written\n%8s %10s %10s %9s %10s %6s %10s %6s %10s %6s\n", "rows", "bytes",
                "memcpy ns", "mark ns", "save ns", "ratio", "restore ns", "ratio", "hash ns", "GB/s");
    for (const std::uint32_t rows : {16u, 72u, 120u, 256u, 1024u, 4096u, 16384u}) {
        World world = make_world(rows, rows * 2);
        const std::size_t bytes = world.state.image_bytes();
        const double copy = memcpy_ns(bytes);
        const Costs c = costs_of(world, rows);
        std::printf("%8u %10zu %10.0f %9.0f %10.0f %6.2f %10.0f %6.2f %10.0f %6.2f\n", rows, bytes, copy,
                    c.touch, c.save, c.save / copy, c.restore, c.restore / copy, c.hash,
                    static_cast<double>(bytes) / c.hash);
    }
}

void print_part_written() {
    constexpr std::uint32_t awake = 400;
    World alone = make_world(awake, 1000000);
    const Costs one = costs_of(alone, awake);
    std::printf("\n%u rows written, in tables with room for 1,000,000\n%8s %10s %10s %6s %10s %6s %10s %6s\n",
                awake, "rows", "bytes", "save ns", "ratio", "restore ns", "ratio", "hash ns", "ratio");
    for (const std::uint32_t rows : {awake, awake + 2000, awake + 20000}) {
        World world = make_world(rows, 1000000);
        const Costs c = costs_of(world, awake);
        std::printf("%8u %10zu %10.0f %6.2f %10.0f %6.2f %10.0f %6.2f\n", rows, world.state.image_bytes(),
                    c.save, c.save / one.save, c.restore, c.restore / one.restore, c.hash, c.hash / one.hash);
    }
}

} // namespace

int main() {
    print_all_written();
    print_part_written();
}
