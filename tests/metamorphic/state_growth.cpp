// The capacity of a state's memory is no part of it: equal rows give equal bits, whenever the memory grew.
#include "support/state_sample.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace lockstone::test {
namespace {

struct Growing {
    std::shared_ptr<const StateLayout> layout;
    std::array<TableId, 3> tables;
    Column<Transform> pose;
    Column<Inventory> bag;
    Column<std::uint8_t> flag;
};
/// Columns with less than a page, with several pages, with rows of one byte; tables that begin with this capacity.
Growing growing(std::uint32_t capacity, std::uint32_t rows_max) {
    StateLayout layout;
    Growing g{};
    g.tables = {layout.add_table("pose", capacity, rows_max), layout.add_table("bag", capacity, rows_max),
                layout.add_table("flag", capacity, rows_max)};
    g.pose = layout.add_column<Transform>(g.tables[0], "pose.row", Group::motion);
    layout.add_column<Health>(g.tables[0], "pose.health", Group::game);
    g.bag = layout.add_column<Inventory>(g.tables[1], "bag.row", Group::contact);
    g.flag = layout.add_column<std::uint8_t>(g.tables[2], "flag.row", Group::game);
    g.layout = std::move(layout).finished();
    return g;
}

void fill_last_row(State& state, const Growing& g, std::uint32_t row) {
    state.edit_row(g.pose, row).position.x = Real(static_cast<int>(row) - 7);
    state.edit_row(g.bag, row).serial = row + 1;
    state.edit_row(g.flag, row) = static_cast<std::uint8_t>(row * 37 + 1);
}

constexpr std::uint32_t most = 700;

} // namespace

TEST_CASE("a state that grows row by row equals a state with all memory at every size") {
    const Growing small = growing(0, most), large = growing(most, most);
    State grows(small.layout), has_all(large.layout);
    std::vector<std::uint32_t> sizes;
    for (std::uint32_t rows = 1; rows <= most; ++rows) {
        for (const TableId table : small.tables) grows.resize(table, rows), has_all.resize(table, rows);
        fill_last_row(grows, small, rows - 1), fill_last_row(has_all, large, rows - 1);
        if (sizes.empty() || sizes.back() != grows.capacity(small.tables[0]))
            sizes.push_back(grows.capacity(small.tables[0]));
        REQUIRE(grows.hash() == has_all.hash());
        if (rows % 61 == 0 || rows < 20) REQUIRE(grows.save_portable() == has_all.save_portable());
        REQUIRE(grows.verify_versions().ok());
    }
    CHECK(sizes.size() < 24); // grows by quarters, from 8 rows on
    CHECK(sizes.back() == most);
    CHECK(State::diff(grows, has_all, 10).empty());
    CHECK(differing_pages(grows.hash_tree(), has_all.hash_tree()).empty());
    CHECK(grows.dump() == has_all.dump());
}

TEST_CASE("the size of a grown table depends only on its present and its requested number of rows") {
    // A function of the present and the wanted number of rows only.
    const TableInfo table{"t", 0, 1000};
    CHECK(table.grown(0) == 0);
    CHECK(table.grown(1) == 8);
    CHECK((TableInfo{"t", 8, 1000}.grown(8) == 8));
    CHECK((TableInfo{"t", 8, 1000}.grown(9) == 10));
    CHECK((TableInfo{"t", 8, 1000}.grown(500) == 562));
    CHECK((TableInfo{"t", 900, 1000}.grown(901) == 1000));
    CHECK((TableInfo{"t", 0, 3}.grown(1) == 3));
    CHECK((TableInfo{"t", 4096, 100000}.grown(4097) == 5120));
    CHECK((TableInfo{"t", 0xe0000000u, 0xffffffffu}.grown(0xe0000001u) == 0xffffffffu));
}

TEST_CASE("growth lists no changes and does not change the hash until a row is written") {
    const Growing g = growing(0, 20000);
    State state(g.layout);
    for (const TableId table : g.tables) state.resize(table, 300);
    SplitMix random(9);
    scramble(state, random);
    const std::uint64_t hash = state.hash();
    ChangeMark mark;
    std::vector<RowRange> changed;
    for (std::uint32_t column = 0; column < 4; ++column) state.take_changes(column, mark, changed);
    Image image;
    state.save(image);
    state.reserve(std::vector<std::uint32_t>{5000, 400, 20000});
    CHECK(state.capacity(g.tables[0]) == 5000);
    for (std::uint32_t column = 0; column < 4; ++column) {
        CHECK(state.take_changes(column, mark, changed) == 300);
        CHECK(changed.empty());
    }
    CHECK(state.verify_versions().ok());
    CHECK(state.verify_versions(image).ok());
    CHECK(state.hash() == hash);
    state.edit_row(g.pose, 250).position.y = Real(3);
    CHECK(state.hash() != hash);
    CHECK(state.take_changes(g.pose.index, mark, changed) == 300);
    CHECK(changed.size() == 1);
    CHECK(changed[0].first > 0);
    state.restore(image);
    CHECK(state.hash() == hash);
    CHECK(state.capacity(g.tables[0]) == 5000);
    const State empty(g.layout);
    state = empty;
    CHECK(state.hash() == empty.hash());
    CHECK(state.capacity(g.tables[0]) == 5000);
}

TEST_CASE("tables that are nearly full grow together, and others keep their capacity") {
    const Growing g = growing(100, 1000);
    State state(g.layout);
    state.resize(g.tables[0], 100), state.resize(g.tables[1], 88), state.resize(g.tables[2], 87);
    state.make_room({g.tables[0]}, 1);
    CHECK(state.capacity(g.tables[0]) == 125);
    CHECK(state.capacity(g.tables[1]) == 125);
    CHECK(state.capacity(g.tables[2]) == 100);
    state.make_room_for({{g.tables[0], 125}, {g.tables[2], 300}});
    CHECK(state.capacity(g.tables[0]) == 125);
    CHECK(state.capacity(g.tables[2]) == 337);
    const std::span<const std::byte> block = state.block_bytes();
    CHECK(std::all_of(block.begin() + 64, block.end(), [](std::byte b) { return b == std::byte{}; }));
}

TEST_CASE("a state takes no memory for rows that it does not have") {
    const Growing g = growing(0, 0xffffffffu);
    State state(g.layout);
    CHECK(state.layout().size_bytes() < 1000);
    state.resize(g.tables[1], 1);
    CHECK(state.layout().size_bytes() < 9 * sizeof(Inventory));
    CHECK(state.rows_max(g.tables[1]) == 0xffffffffu);
}

} // namespace lockstone::test
