// The data that the hash covers. The test also checks its own checker: it must detect hashes that skip data.
#include "base/hash.h"
#include "base/text.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

/// Flips every bit of every live row, and every bit of every count that stays within the capacity. Returns the first
/// flip that `hash` ignores, or an empty string.
template <class Hash> std::string first_unhashed_bit(State state, Hash&& hash) {
    const std::uint64_t before = hash(state);
    for (std::uint32_t column = 0; column < state.layout().columns().size(); ++column) {
        for (std::size_t bit = 0; bit < state.bytes(column).size() * 8; ++bit) {
            const auto mask = static_cast<std::byte>(1u << (bit % 8));
            state.edit_bytes(column)[bit / 8] ^= mask;
            const bool seen = hash(state) != before;
            state.edit_bytes(column)[bit / 8] ^= mask;
            if (!seen) return base::join(state.layout().columns()[column].name, " bit ", bit);
        }
    }
    for (std::uint32_t table = 0; table < state.layout().tables().size(); ++table)
        for (std::uint32_t bit = 0; bit < 32; ++bit) {
            State other = state;
            const std::uint32_t flipped = state.count({table}) ^ (1u << bit);
            if (flipped > state.rows_max({table})) continue;
            other.resize({table}, flipped);
            if (hash(other) == before)
                return base::join(state.layout().tables()[table].name, " count bit ", bit);
        }
    return "";
}

/// A hash of the tree's pages that leaves out the named parts.
struct Omission {
    std::string column{};        ///< leave out this column's pages
    bool last_page_only = false; ///< leave out only the last of them
    std::string table{};         ///< leave out this table's count
};
std::uint64_t partial_hash(const State& state, const Omission& omit) {
    const HashTree tree = state.hash_tree();
    base::HashStream stream;
    for (std::size_t column = 0; column < tree.pages.size(); ++column) {
        const bool named = state.layout().columns()[column].name == omit.column;
        for (std::size_t page = 0; page < tree.pages[column].size(); ++page)
            if (!named || (omit.last_page_only && page + 1 < tree.pages[column].size()))
                stream.add(tree.pages[column][page]);
    }
    for (std::uint32_t table = 0; table < state.layout().tables().size(); ++table)
        if (state.layout().tables()[table].name != omit.table) stream.add(state.count({table}));
    return stream.digest();
}

/// 171 contacts: the second page of contact.manifold holds one row.
State small_state(const Sample& s) { return random_state(s, 3, 171, 5, 21); }

} // namespace

TEST_CASE("a flip of any bit of any live row or count changes the root hash") {
    CHECK(first_unhashed_bit(small_state(make_sample()), [](const State& s) { return s.hash(); }) == "");
}

TEST_CASE("the check finds a hash that skips a column or a page or a count") {
    const State state = small_state(make_sample());
    const auto found = [&](const Omission& omit) {
        return first_unhashed_bit(state, [&](const State& s) { return partial_hash(s, omit); });
    };
    CHECK(found({}) == "");
    CHECK(found({.column = "game.health"}) == "game.health bit 0");
    CHECK(found({.column = "contact.manifold", .last_page_only = true}) ==
          base::join("contact.manifold bit ", 170 * sizeof(Manifold) * 8));
    CHECK(found({.table = "tag"}) == "tag count bit 0");
}

TEST_CASE("hash() is the root of hash_tree() and a changed row changes every node of its path") {
    const Sample s = make_sample();
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        const State state = random_state(s, seed);
        CHECK(state.hash() == state.hash_tree().root);
    }
    State state = small_state(s);
    const HashTree before = state.hash_tree();
    state.edit_row(s.manifold, 170).key ^= 1;
    const HashTree after = state.hash_tree();
    CHECK(after.root != before.root);
    for (std::uint32_t group = 0; group < group_count; ++group)
        CHECK((after.groups[group] != before.groups[group]) == (Group{group} == Group::contact));
    for (std::uint32_t column = 0; column < before.columns.size(); ++column)
        CHECK((after.columns[column] != before.columns[column]) == (column == s.manifold.index));
    CHECK(after.pages[s.manifold.index][0] == before.pages[s.manifold.index][0]);
    CHECK(after.pages[s.manifold.index][1] != before.pages[s.manifold.index][1]);
}

TEST_CASE("columns with equal rows and different names have different hashes") {
    const auto root = [](const char* name) {
        StateLayout layout;
        layout.add_column<Real>(layout.add_table("t", 4), name, Group::game);
        State state(std::move(layout).finished());
        state.resize({0}, 4);
        return state.hash_tree().columns[0];
    };
    CHECK(root("a") != root("b"));
    CHECK(root("a") == root("a"));
}

TEST_CASE("the comparison of two hash trees finds the pages that differ") {
    const Sample s = make_sample();
    State left = random_state(s, 8, 400, 0, 4), right = left;
    CHECK(differing_pages(left.hash_tree(), right.hash_tree()).empty());
    right.edit_row(s.manifold, 169).key ^= 1;
    right.edit_row(s.manifold, 399).key ^= 1;
    right.edit_row(s.velocity, 2).z.raw ^= 1;
    CHECK(differing_pages(left.hash_tree(), right.hash_tree()) ==
          std::vector<PageRef>{
              {s.velocity.index, 0, 0, 7}, {s.manifold.index, 0, 0, 169}, {s.manifold.index, 2, 340, 399}});
    right = left;
    right.resize(s.contact, 170); // a page that only one side has is a difference, in both directions
    const std::vector<PageRef> missing{{s.manifold.index, 1, 170, 339}, {s.manifold.index, 2, 340, 399}};
    CHECK(differing_pages(left.hash_tree(), right.hash_tree()) == missing);
    CHECK(differing_pages(right.hash_tree(), left.hash_tree()) == missing);
    right.resize(s.contact, 0);
    CHECK(differing_pages(right.hash_tree(), left.hash_tree()).size() == 3);
    State none = left;
    none.resize(s.contact, 0);
    CHECK(differing_pages(right.hash_tree(), none.hash_tree()).empty());
}

} // namespace lockstone::test
