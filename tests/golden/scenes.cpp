// The root hash of every scene at a few ticks, from a table in a file. A change of a hash is a change of behaviour:
// when it is meant, put the printed rows into hashes.tsv and say in the commit what changed.
#include "support/scripted_inputs.h"

#include <doctest/doctest.h>

#include <fstream>
#include <map>
#include <sstream>

namespace lockstone::test {
namespace {

struct Key {
    std::string game; ///< Game::name
    std::uint64_t tick;
    friend auto operator<=>(const Key&, const Key&) = default;
};
using Table = std::map<Key, std::string>;

std::string hex16(std::uint64_t hash) {
    std::ostringstream out;
    out << std::hex;
    out.width(16);
    out.fill('0');
    out << hash;
    return out.str();
}

/// Lines of game, tick and hash, split by tabs.
Table read_table(std::istream& in) {
    Table table;
    std::string line;
    while (std::getline(in, line)) {
        if (line.empty() || line.front() == '#') continue;
        std::istringstream fields(line);
        Key key;
        std::string tick, hash;
        std::getline(fields, key.game, '\t');
        std::getline(fields, tick, '\t');
        std::getline(fields, hash, '\t');
        key.tick = std::stoull(tick);
        table[key] = hash;
    }
    return table;
}

/// Runs the games that the table names up to the ticks that it names.
Table computed(const Table& wanted) {
    Table table;
    std::map<std::string, std::uint64_t> last;
    for (const auto& [key, hash] : wanted) last[key.game] = key.tick; // ascending, so the last stays
    for (const auto& [name, end] : last) {
        const auto game = make_scene_named(name).value();
        World world = game->start().value();
        test::ScriptedInputs inputs(*game);
        for (std::uint64_t tick = 0;; ++tick) {
            if (wanted.contains({name, tick})) table[{name, tick}] = hex16(world.hash());
            if (tick == end) break;
            REQUIRE(game->advance(world, inputs.at(tick)).ok());
        }
    }
    return table;
}

/// The rows to paste, one for each difference.
std::string differences(const Table& expected, const Table& found) {
    std::string rows;
    for (const auto& [key, hash] : expected)
        if (found.at(key) != hash)
            rows += key.game + '\t' + std::to_string(key.tick) + '\t' + found.at(key) + '\n';
    return rows;
}

Table golden() {
    std::ifstream file(LOCKSTONE_SOURCE_DIR "/tests/golden/hashes.tsv");
    return read_table(file);
}

} // namespace

TEST_CASE("every scene has the hashes of tests/golden/hashes.tsv") {
    const Table expected = golden();
    REQUIRE_FALSE(expected.empty());
    for (const SceneInfo& info : scenes()) {
        const auto first = expected.lower_bound({std::string(info.name) + " ", 0});
        CHECK_MESSAGE(
            (first != expected.end() && first->first.game.starts_with(std::string(info.name) + " ")),
            info.name, " has no row");
    }
    CHECK(differences(expected, computed(expected)) == "");
}

TEST_CASE("a golden hash that is off by one digit is noticed") {
    const std::string name = "two-blocks size=0 seed=1 players=0";
    Table table = golden();
    std::erase_if(table, [&](const auto& row) { return row.first.game != name; });
    REQUIRE_FALSE(table.empty());
    std::string& hash = table.begin()->second;
    hash[7] = hash[7] == '0' ? '1' : '0';
    CHECK(differences(table, computed(table)) != "");
}

} // namespace lockstone::test
