// Prints what saving, restoring and hashing cost, against one memcpy of the same bytes and
// one memcpy for each column. No assertions: timings depend
// on the machine. Run it on an idle core.
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
    World world{State(std::make_shared<const StateLayout>()), {}};
    world.tables = {layout.add_table("body", capacity), layout.add_table("contact", capacity)};
    for (int i = 0; i < 5; ++i) {
        const std::string n = std::to_string(i);
        layout.add_column<Transform>(world.tables[0], "body.pose" + n, Group::motion);
        layout.add_column<std::array<Speed, 6>>(world.tables[0], "body.velocity" + n, Group::motion);
        layout.add_column<Manifold>(world.tables[1], "contact.manifold" + n, Group::contact);
        layout.add_column<std::uint64_t>(world.tables[1], "contact.key" + n, Group::contact);
    }
    world.state = State(std::make_shared<const StateLayout>(std::move(layout)));
    for (TableId table : world.tables) world.state.resize(table, rows);
    Random random(1);
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

} // namespace

int main() {
    std::printf("%8s %10s %10s %10s %10s %7s %10s %7s %10s %9s\n", "rows", "bytes", "memcpy ns", "by column",
                "save ns", "ratio", "restore ns", "ratio", "hash ns", "hash GB/s");
    for (std::uint32_t rows : {16u, 72u, 256u, 1024u, 4096u, 16384u}) {
        World world = make_world(rows, rows * 2);
        Image image, plain;
        world.state.save(image);
        plain.bytes.resize(image.bytes.size());
        volatile std::byte sink{};
        const double copy = median_ns(image.size, [&] {
            std::memcpy(plain.bytes.data(), image.bytes.data(), image.size);
            sink = plain.bytes[image.size / 2];
        });
        const double twenty = median_ns(image.size, [&] {
            std::byte* to = plain.bytes.data();
            for (std::uint32_t column = 0; column < world.state.layout().columns().size(); ++column) {
                const auto from = std::as_const(world.state).bytes(column);
                std::memcpy(to, from.data(), from.size());
                to += from.size();
            }
            sink = plain.bytes[image.size / 2];
        });
        const double save = median_ns(image.size, [&] { world.state.save(image); });
        const double restore = median_ns(image.size, [&] { world.state.restore(image); });
        std::uint64_t sum = 0;
        const double hash = median_ns(image.size, [&] { sum += world.state.hash(); });
        std::printf("%8u %10zu %10.0f %10.0f %10.0f %7.2f %10.0f %7.2f %10.0f %9.2f%s\n", rows, image.size,
                    copy, twenty, save, save / copy, restore, restore / copy, hash,
                    static_cast<double>(image.size) / hash, sum == 0 ? " " : "");
    }
}
