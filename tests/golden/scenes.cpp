// The root hash of every scene at a few ticks, from a table in a file. A changed hash means changed behaviour. If the
// change is intended, put the printed rows into hashes.tsv and name the change in the commit.
#include "golden/table.h"

#include <doctest/doctest.h>

namespace lockstone::test::golden {

TEST_CASE("every scene has the hashes of tests/golden/hashes.tsv") {
    const Table expected = from_file();
    REQUIRE_FALSE(expected.empty());
    for (const SceneInfo& info : scenes()) {
        const auto first = expected.lower_bound({std::string(info.name) + " ", 0});
        CHECK_MESSAGE(
            (first != expected.end() && first->first.game.starts_with(std::string(info.name) + " ")),
            info.name, " has no row");
    }
    CHECK(differences(expected, computed(expected)) == "");
}

TEST_CASE("the comparison detects a golden hash that is off by one digit") {
    const std::string name = "two-blocks size=0 seed=1 players=0";
    Table table = from_file();
    std::erase_if(table, [&](const auto& row) { return row.first.game != name; });
    REQUIRE_FALSE(table.empty());
    std::string& hash = table.begin()->second;
    hash[7] = hash[7] == '0' ? '1' : '0';
    CHECK(differences(table, computed(table)) != "");
}

} // namespace lockstone::test::golden
