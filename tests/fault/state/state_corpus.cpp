// The state fuzzer's inputs and mutations of them: bytes are refused and change nothing, or give a world that can tick.
#include "fuzz/corpus.h"
#include "fuzz/seeds.h"
#include "lockstone/testing.h"

#include <doctest/doctest.h>

using namespace lockstone;

namespace {

/// The result of the check when `load` loads these bytes.
template <class Load> std::string complaint(const fuzz::Buffer& data, Load&& load) {
    bool loaded = false;
    return fuzz::check_state_load(fuzz::read_state_input(data), loaded, load);
}

fuzz::Buffer seed_named(const std::string& name) {
    for (fuzz::Seed& seed : fuzz::state_seeds())
        if (seed.name == name) return seed.bytes;
    throw std::runtime_error("no seed " + name);
}

/// Visits each number of the first rows of each column: world, column, row, field.
template <class Visit> void for_each_number(Visit&& visit) {
    for (std::uint8_t world = 0; world < fuzz::base_count; ++world) {
        const State& state = fuzz::base_of(world).now.state();
        for (std::uint8_t column = 0; column < state.layout().columns().size(); ++column) {
            const ColumnInfo& info = state.layout().columns()[column];
            const std::size_t rows = std::min<std::size_t>(state.bytes(column).size() / info.row_size, 5);
            for (std::uint8_t row = 0; row < rows; ++row)
                for (std::uint16_t leaf = 0; leaf < info.leaves.size(); ++leaf)
                    visit(world, column, row, leaf);
        }
    }
}

/// The input that sets one number to an edge value.
fuzz::Buffer at_edge(unsigned world, std::uint8_t column, std::uint8_t row, std::uint16_t leaf,
                     std::uint8_t edge) {
    const auto first = static_cast<std::uint8_t>(world | 16u);
    return fuzz::Script().u8(first).u8(column).u8(row).u16(leaf).u8(2).u8(edge).done();
}

} // namespace

TEST_CASE("state corpus: a spectator and a joining machine start from the state that the checks send") {
    for (std::size_t base = 0; base < fuzz::base_count; ++base)
        for (const bool joins : {false, true}) {
            INFO("world ", base, joins ? ", joins" : ", watches");
            std::uint64_t reached = 0;
            const fuzz::Ticking game(base);
            CHECK(fuzz::play_from_host(fuzz::base_of(base).now, game, joins, reached) == "");
            CHECK(reached > 1);
        }
}

TEST_CASE(
    "state corpus: the corpus holds every seed and the loader rejects each input or the world ticks on") {
    const std::vector<fuzz::Seed> seeds = fuzz::state_seeds();
    const std::vector<fuzz::Buffer> all = fuzz::corpus("state", seeds);
    for (const fuzz::Seed& seed : seeds)
        CHECK_MESSAGE(std::ranges::find(all, seed.bytes) != all.end(), seed.name);
    std::size_t taken = 0;
    for (const fuzz::Buffer& bytes : all) {
        bool loaded = false;
        CHECK(fuzz::check_state_load(bytes, loaded) == "");
        taken += loaded ? 1 : 0;
    }
    CHECK(taken >= 2 * fuzz::base_count);
    CHECK(taken < all.size());
}

TEST_CASE("state corpus: the loader rejects each of hundreds of mutations or the world ticks on") {
    const std::vector<fuzz::Buffer> all = fuzz::corpus("state", {});
    Random random = Random::seeded(2026);
    std::size_t taken = 0;
    const std::size_t count = fuzz::rounds(400);
    for (std::size_t i = 0; i < count; ++i) {
        bool loaded = false;
        CAPTURE(i);
        REQUIRE(fuzz::check_state_load(fuzz::mutated(all, random), loaded) == "");
        taken += loaded ? 1 : 0;
    }
    CHECK(taken > count / 20);
    CHECK(taken < count);
}

TEST_CASE("state corpus: the loader rejects an edge value of any number in any row or the world ticks on") {
    std::size_t taken = 0, fields = 0;
    const std::size_t step = std::getenv("LOCKSTONE_LONG") != nullptr ? 1 : 97;
    for_each_number([&](std::uint8_t world, std::uint8_t column, std::uint8_t row, std::uint16_t leaf) {
        if (fields++ % step != 0) return;
        for (std::uint8_t edge = 0; edge < 16; ++edge) {
            bool loaded = false;
            CAPTURE(world);
            CAPTURE(column);
            CAPTURE(leaf);
            CAPTURE(edge);
            REQUIRE(fuzz::check_state_load(at_edge(world, column, row, leaf, edge), loaded) == "");
            taken += loaded ? 1 : 0;
        }
    });
    CHECK(fields > 2000);
    CHECK(taken > 4 * fields / step);
}

TEST_CASE("state corpus: the loader rejects numbers that no command and no tick can make") {
    struct Wrong {
        const char *column, *field;
        std::uint8_t edge;
    };
    const State& state = fuzz::base_of(0).now.state();
    for (const Wrong& wrong : {Wrong{"body_traits.row", "mass.mass", 1},
                               {"body_traits.row", "mass.mass", 11},
                               {"body_traits.row", "mass.center.x", 12},
                               {"body_traits.row", "mass.center.y", 11},
                               {"body_traits.row", "mass.center.z", 15},
                               {"sleeping_contact.memory", "normal.x", 8},
                               {"sleeping_contact.memory", "normal.y", 0},
                               {"sleeping_contact.memory", "normal.z", 6}}) {
        CAPTURE(wrong.column);
        CAPTURE(wrong.field);
        const std::span<const LeafInfo> leaves = state.layout().find_column(wrong.column)->leaves;
        const auto leaf = std::ranges::find(leaves, std::string_view(wrong.field), &LeafInfo::name);
        bool loaded = true;
        CHECK(fuzz::check_state_load(at_edge(0, fuzz::detail::column_named(wrong.column), 0,
                                             static_cast<std::uint16_t>(leaf - leaves.begin()), wrong.edge),
                                     loaded) == "");
        CHECK_FALSE(loaded);
    }
}

TEST_CASE("state corpus: the check finds planted faults of loaders") {
    using fuzz::StateInput;
    const fuzz::WorldLoader right;
    const fuzz::Buffer good = seed_named("joints_image_good"), bad = seed_named("blocks_image_splice");
    REQUIRE(complaint(good, right) == "");
    REQUIRE(complaint(bad, right) == "");
    const auto touches = [&](World& w, const StateInput& in) {
        const Status status = right(w, in);
        if (!status) testing::state_of(w).edit_bytes(0)[0] ^= std::byte{1};
        return status;
    };
    CHECK(complaint(bad, touches) == "refused, but changed");
    const auto silent = [&](World& w, const StateInput& in) {
        return right(w, in) ? Status{} : Status{Error{""}};
    };
    CHECK(complaint(bad, silent) == "an error does not say what is wrong");
    const auto otherwise = [&](World& w, const StateInput& in) {
        const Status status = right(w, in);
        if (status) testing::state_of(w).edit_bytes(0)[0] ^= std::byte{1};
        return status;
    };
    CHECK(complaint(good, otherwise) == "taken, but the world holds something else");
    const auto trusting = [](World& w, const StateInput& in) {
        return testing::state_of(w).restore_portable(in.bytes);
    };
    CHECK(complaint(seed_named("drivers_image_rows"), trusting).find("refused when it was saved") !=
          std::string::npos);
}

TEST_CASE("state corpus: planted: the check finds two different worlds that tick differently") {
    fuzz::Subjects subjects(fuzz::base_of(0));
    CHECK(fuzz::check_ticks(subjects) == "");
    fuzz::Subjects others(fuzz::base_of(0));
    lockstone::test::scene::done(others.twin.set_gravity({}));
    CHECK(fuzz::check_ticks(others).find("two copies part") != std::string::npos);
}
