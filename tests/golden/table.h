// The table of tests/golden/hashes.tsv: root hashes of the built-in scenes at a few ticks.
#pragma once

#include "support/scripted_inputs.h"

#include <doctest/doctest.h>

#include <fstream>
#include <map>
#include <optional>
#include <sstream>

namespace lockstone::test::golden {

struct Key {
    std::string game; ///< Game::name
    std::uint64_t tick;
    friend auto operator<=>(const Key&, const Key&) = default;
};
using Table = std::map<Key, std::string>;

inline std::string hex16(std::uint64_t hash) {
    std::ostringstream out;
    out << std::hex;
    out.width(16);
    out.fill('0');
    out << hash;
    return out.str();
}

/// Lines of game, tick and hash, split by tabs.
inline Table read_table(std::istream& in) {
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

/// Runs the games of the table to the table's ticks, with the machine's best instruction set if none is given.
inline Table computed(const Table& wanted, std::optional<Simd> level = {}) {
    Table table;
    std::map<std::string, std::uint64_t> last;
    for (const auto& [key, hash] : wanted) last[key.game] = key.tick; // ascending, so the last tick remains
    for (const auto& [name, end] : last) {
        const auto game = make_scene_named(name).value();
        World world = game->start().value();
        if (level) REQUIRE(world.set_simd(*level));
        test::ScriptedInputs inputs(*game);
        for (std::uint64_t tick = 0;; ++tick) {
            if (wanted.contains({name, tick})) table[{name, tick}] = hex16(world.hash());
            if (tick == end) break;
            REQUIRE(game->advance(world, inputs.at(tick)).ok());
        }
    }
    return table;
}

/// The rows to paste into the table, one for each difference.
inline std::string differences(const Table& expected, const Table& found) {
    std::string rows;
    for (const auto& [key, hash] : expected)
        if (found.at(key) != hash)
            rows += key.game + '\t' + std::to_string(key.tick) + '\t' + found.at(key) + '\n';
    return rows;
}

inline Table from_file() {
    std::ifstream file(LOCKSTONE_SOURCE_DIR "/tests/golden/hashes.tsv");
    return read_table(file);
}

} // namespace lockstone::test::golden
