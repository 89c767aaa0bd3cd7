// The bytes that the hash covers, in every scene: each bit of each column and each row count. Each byte of the block is
// part of a row count or a live row, or it stays zero, or the engine never accesses it.
#include "base/hash.h"
#include "lockstone/testing.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const bool is_long = std::getenv("LOCKSTONE_LONG") != nullptr;
#ifdef NDEBUG
constexpr bool checks_versions = false;
#else
constexpr bool checks_versions = true; // see State::verify_versions
#endif

World after(const Game& game, int ticks) {
    ScriptedInputs inputs(game);
    World world = game.start().value();
    for (int t = 0; t < ticks; ++t) REQUIRE(game.advance(world, inputs.at(world.tick_count())).ok());
    return world;
}

const ColumnInfo& column(const State& s, std::uint32_t index) { return s.layout().columns()[index]; }
std::uint32_t column_count(const State& s) { return static_cast<std::uint32_t>(s.layout().columns().size()); }

/// Flips each bit of the first and the last row of a column: of all rows in the long run, of only the first where every
/// hash is computed twice. Returns the first bit that `hash` ignores, or an empty string. Adds the number of tested
/// bits to `bits`.
template <class Hash>
std::string first_uncounted(State& s, std::uint32_t index, std::uint64_t& bits, Hash&& hash) {
    const std::uint32_t row_size = column(s, index).row_size;
    const std::uint32_t rows = static_cast<std::uint32_t>(s.bytes(index).size() / row_size);
    const std::uint64_t before = hash(s);
    const std::uint32_t step = is_long ? 1 : checks_versions ? std::max(1u, rows) : std::max(1u, rows - 1);
    for (std::uint32_t row = 0; row < rows; row += step)
        for (std::uint32_t bit = 0; bit < row_size * 8; ++bit, ++bits) {
            const auto flip = [&] { s.edit_bytes(index, row, 1)[bit / 8] ^= std::byte{1} << (bit % 8); };
            flip();
            const bool seen = hash(s) != before;
            flip();
            if (!seen)
                return column(s, index).name + " row " + std::to_string(row) + " bit " + std::to_string(bit);
        }
    return hash(s) == before ? "" : "bits that were flipped back leave another hash";
}

/// The root hash computed without one column.
std::uint64_t hash_without(const State& s, std::uint32_t left_out) {
    const HashTree tree = s.hash_tree();
    base::HashStream stream;
    for (std::uint32_t c = 0; c < tree.columns.size(); ++c)
        if (c != left_out) stream.add(tree.columns[c]);
    return stream.digest();
}

enum class Byte : std::uint8_t { gap, count, live, dead };

/// The kind of each byte of the block, by the manifest. Empty when two columns share a byte.
std::vector<Byte> bytes_of(const State& s) {
    std::vector<Byte> kinds(s.block_bytes().size(), Byte::gap);
    std::size_t claimed = 0;
    const auto claim = [&](std::size_t offset, std::size_t size, Byte kind) {
        for (std::size_t i = offset; i < offset + size; ++i) {
            claimed += kinds[i] != Byte::gap ? 1u : 0u;
            kinds[i] = kind;
        }
    };
    claim(0, s.layout().tables().size() * sizeof(std::uint32_t), Byte::count);
    for (std::uint32_t c = 0; c < column_count(s); ++c) {
        const ColumnInfo& info = column(s, c);
        const std::size_t live = s.bytes(c).size();
        claim(info.offset, live, Byte::live);
        claim(info.offset + live, std::size_t{s.capacity({info.table})} * info.row_size - live, Byte::dead);
    }
    return claimed == 0 ? kinds : std::vector<Byte>{};
}

/// Returns an error sentence about the bytes that no manifest names. `filled`: the value of the gaps.
std::string stray_byte(const State& s, std::byte filled) {
    const std::vector<Byte> kinds = bytes_of(s);
    if (kinds.empty()) return "two columns share a byte";
    std::size_t gap = 0;
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        gap = kinds[i] == Byte::gap ? gap + 1 : 0;
        if (gap >= 64) return "64 bytes of no column before byte " + std::to_string(i);
        if (kinds[i] == Byte::dead && s.block_bytes()[i] != std::byte{})
            return "byte " + std::to_string(i) + " of a row that is not live is not zero";
        if (kinds[i] == Byte::gap && s.block_bytes()[i] != filled)
            return "byte " + std::to_string(i) + " between columns was written";
    }
    return {};
}

void fill_gaps(const State& s, std::byte with) {
    const std::vector<Byte> kinds = bytes_of(s);
    for (std::size_t i = 0; i < kinds.size(); ++i)
        if (kinds[i] == Byte::gap) const_cast<std::byte&>(s.block_bytes()[i]) = with;
}

} // namespace

TEST_CASE("every scene: each bit of each column and each row count changes the root hash") {
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        World world = after(*small_scene(info), is_long ? 40 : 12);
        State& s = testing::state_of(world);
        std::uint64_t bits = 0;
        for (std::uint32_t c = 0; c < column_count(s); ++c)
            CHECK(first_uncounted(s, c, bits, [](const State& state) { return state.hash(); }) == "");
        CHECK(bits > 3000);
        for (std::uint32_t table = 0; table < s.layout().tables().size(); ++table) {
            INFO(s.layout().tables()[table].name);
            State other = s;
            const std::uint32_t rows = s.count({table});
            other.resize({table}, rows < s.rows_max({table}) ? rows + 1 : rows - 1);
            CHECK(other.hash() != s.hash());
        }
    }
}

TEST_CASE(
    "planted fault: the check finds a hash without a column by that column in every scene with rows of it") {
    std::uint64_t caught = 0;
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        World world = after(*small_scene(info), 12);
        State& s = testing::state_of(world);
        for (std::uint32_t c = 0; c < column_count(s); ++c) {
            if (s.bytes(c).empty()) continue;
            std::uint64_t bits = 0;
            const auto hash = [c](const State& state) { return hash_without(state, c); };
            CHECK(first_uncounted(s, c, bits, hash) == column(s, c).name + " row 0 bit 0");
            ++caught;
        }
    }
    CHECK(caught > 200);
}

TEST_CASE(
    "every scene and tick: each byte of the block is a count or a live row or zero or an untouched gap") {
    for (const SceneInfo& info : scenes()) {
        INFO(info.name);
        const auto game = small_scene(info);
        ScriptedInputs inputs(*game);
        World usual = game->start().value(), filled = usual.clone();
        REQUIRE(stray_byte(usual.state(), std::byte{}) == "");
        const WorldDef& d = filled.def(); // a block that grows has gaps with other values
        scene::done(filled.reserve({d.bodies_max, d.shapes_max, d.contacts_max, d.fields_max,
                                    d.pair_filters_max, d.joints_max, d.characters_max, d.vehicles_max}));
        fill_gaps(filled.state(), std::byte{0xa5});
        Image image;
        for (int t = 0; t < (is_long ? 200 : 6); ++t) {
            INFO(t);
            filled.save(image);
            for (World* w : {&usual, &filled}) REQUIRE(game->advance(*w, inputs.at(w->tick_count())).ok());
            if (t % 2 == 1) { // a rollback: restore() must not write gaps either
                filled.restore(image);
                REQUIRE(game->advance(filled, inputs.at(filled.tick_count())).ok());
            }
            REQUIRE(scene::difference(usual, filled) == "");
            REQUIRE(stray_byte(filled.state(), std::byte{0xa5}) == "");
        }
    }
}

TEST_CASE("planted fault: the check finds a byte that is written beyond the live rows or between columns") {
    World world = after(*small_scene(*find_scene("rollback-arena")), 5);
    const State& s = world.state();
    REQUIRE(stray_byte(s, std::byte{}) == "");
    const std::vector<Byte> kinds = bytes_of(s);
    for (const Byte kind : {Byte::dead, Byte::gap}) {
        const auto at = std::ranges::find(kinds, kind) - kinds.begin();
        std::byte& byte = const_cast<std::byte&>(s.block_bytes()[static_cast<std::size_t>(at)]);
        byte ^= std::byte{1};
        CHECK(stray_byte(s, std::byte{}).find("byte " + std::to_string(at)) != std::string::npos);
        byte ^= std::byte{1};
    }
    CHECK(stray_byte(s, std::byte{}) == "");
}
