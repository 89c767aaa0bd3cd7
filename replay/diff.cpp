#include "replay/diff.h"

#include "replay/format/codec.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

using base::hex;
using base::join;

std::string digits_of(std::span<const std::byte> bytes) {
    std::string out;
    for (const std::byte b : bytes) {
        out += "0123456789abcdef"[std::to_integer<unsigned>(b) >> 4];
        out += "0123456789abcdef"[std::to_integer<unsigned>(b) & 15u];
    }
    return out.empty() ? "(empty)" : out;
}

std::string describe_input(const PlayerInput& input) {
    return input.status == InputStatus::disconnected ? std::string("disconnected") : digits_of(input.bytes);
}

/// The difference between the inputs or commands of one tick; empty if they are equal.
std::string difference_of(std::span<const PlayerInput> left, std::span<const PlayerInput> right) {
    for (std::size_t p = 0; p < std::min(left.size(), right.size()); ++p)
        if (left[p].status != right[p].status || !std::ranges::equal(left[p].bytes, right[p].bytes))
            return join("player ", p, ": input ", describe_input(left[p]), " against ",
                        describe_input(right[p]));
    if (left.size() != right.size()) return join(left.size(), " players against ", right.size());
    return {};
}

std::string difference_of(std::span<const Command> left, std::span<const Command> right) {
    for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i) {
        std::vector<std::byte> l, r;
        append_command(left[i], l);
        append_command(right[i], r);
        if (left[i].index() != right[i].index())
            return join("command ", i, ": ", name_of(left[i]), " against ", name_of(right[i]));
        if (l == r) continue;
        const auto at = std::ranges::mismatch(l, r).in1 - l.begin();
        return join("command ", i, " (", name_of(left[i]), ") differs from byte ", at,
                    " on: ", digits_of(std::span(l).subspan(static_cast<std::size_t>(at))), " against ",
                    digits_of(std::span(r).subspan(static_cast<std::size_t>(at))));
    }
    if (left.size() != right.size()) return join(left.size(), " commands against ", right.size());
    return {};
}

/// Iterates over the blocks of two recordings, tick by tick.
class TickPair {
  public:
    TickPair(const Recording& l, const Recording& r) : mode(l.header().mode), left(l), right(r) {}
    std::string difference(std::uint64_t tick) {
        if (mode == Mode::inputs)
            return difference_of(left.at(tick).inputs(tick), right.at(tick).inputs(tick));
        return difference_of(left.at(tick).commands(tick), right.at(tick).commands(tick));
    }

  private:
    Mode mode;
    BlockCursor left, right;
};

void find_first_hash(const Recording& left, const Recording& right, DiffReport& report) {
    report.states_agree = left.hash_at(report.from) == right.hash_at(report.from);
    if (!report.states_agree) return;
    for (std::uint64_t t = report.from; t < report.to; ++t) {
        if (left.hash_at(t + 1) == right.hash_at(t + 1)) continue;
        report.states_agree = false;
        report.tick = t;
        return;
    }
}

/// The last tick to compare is the one after which the states differ: later inputs explain nothing.
void find_first_input(const Recording& left, const Recording& right, DiffReport& report) {
    if (left.header().mode != right.header().mode) return;
    TickPair ticks(left, right);
    const std::uint64_t end = report.tick ? *report.tick + 1 : report.to;
    for (std::uint64_t t = report.from; t < end && !report.input_tick; ++t) {
        report.input_difference = ticks.difference(t);
        if (!report.input_difference.empty()) report.input_tick = t;
    }
}

std::string first_phase(std::span<const PhaseHash> left, std::span<const PhaseHash> right) {
    for (std::size_t i = 0; i < std::min(left.size(), right.size()); ++i)
        if (left[i].hash != right[i].hash) return left[i].phase;
    return {};
}

/// Compares states of one layout. The two worlds may have different capacities, which State::diff accepts.
void compare(const State& left, const State& right, std::uint64_t time, std::size_t limit,
             DiffReport& report) {
    report.compared_at = time;
    const std::size_t one_more = limit + (limit < SIZE_MAX ? 1 : 0);
    report.differences = State::diff(left, right, one_more);
    report.has_more = report.differences.size() > limit;
    if (report.has_more) report.differences.resize(limit);
}

/// For a side that re-simulation does not reproduce: its next keyframe still holds the recorded state. Moves `player`
/// to that state. Returns false if no keyframe follows.
bool go_to_next_keyframe(Player& player, std::uint64_t after) {
    const auto keyframes = player.recording().keyframes();
    const auto next = std::ranges::upper_bound(keyframes, after, {}, &Recording::Keyframe::time);
    if (next == keyframes.end()) return false;
    return player.seek_keyframe(static_cast<std::size_t>(next - keyframes.begin())).ok();
}

Status simulate(Player& left, Player& right, std::size_t limit, DiffReport& report) {
    const std::uint64_t tick = *report.tick;
    for (Player* player : {&left, &right}) {
        if (Status status = player->seek(tick); !status) return status;
        player->world().record_phase_hashes(true);
        if (Status status = player->step(); !status) return status;
    }
    report.left_reproduces = left.agrees();
    report.right_reproduces = right.agrees();
    report.phase = first_phase(left.world().phase_hashes(), right.world().phase_hashes());
    compare(left.world().state(), right.world().state(), tick + 1, limit, report);
    if (!report.differences.empty() || report.left_reproduces == report.right_reproduces) return {};

    Player& strange = report.left_reproduces ? right : left;
    Player& other = report.left_reproduces ? left : right;
    if (!go_to_next_keyframe(strange, tick)) return {};
    if (strange.time() > other.recording().end_tick()) return {};
    if (Status status = other.seek(strange.time()); !status) return status;
    compare(left.world().state(), right.world().state(), strange.time(), limit, report);
    return {};
}

void write_text(const Recording& left, const Recording& right, DiffReport& report) {
    std::string& out = report.text;
    const bool inputs = left.header().mode == Mode::inputs;
    if (report.states_agree)
        out = join("the states agree at all ", report.to - report.from + 1, " times from ", report.from,
                   " to ", report.to, "\n");
    else if (report.tick)
        out = join("first differing tick: ", *report.tick, "\n");
    else
        out = join("the states differ already at time ", report.from, ", where the comparison begins\n");

    if (left.header().mode != right.header().mode)
        out += "one holds inputs, the other commands: only states are compared\n";
    else if (report.input_tick)
        out += join(inputs ? "first differing input: tick " : "first differing command: tick ",
                    *report.input_tick, ", ", report.input_difference, "\n");
    else
        out += inputs ? "the inputs are equal up to there\n" : "the commands are equal up to there\n";

    if (!report.phase.empty()) out += join("first differing phase: ", report.phase, "\n");
    const auto blame = [&](const Recording& which, bool reproduces) {
        if (!reproduces)
            out += join(which.name(), ": re-simulating tick ", *report.tick,
                        " does not give the recorded hash: it was recorded by ",
                        "another engine, game or a faulty machine\n");
    };
    blame(left, report.left_reproduces);
    blame(right, report.right_reproduces);
    if (!report.differences.empty()) out += join("the states at time ", report.compared_at, ":\n");
    for (const Difference& difference : report.differences) out += join("  ", to_string(difference), "\n");
    if (report.has_more) out += join("  and more: these are the first ", report.differences.size(), "\n");
    if (left.end_tick() != right.end_tick())
        out += join("one ends at time ", left.end_tick(), ", the other at ", right.end_tick(), "\n");
}

} // namespace

Result<DiffReport> diff(const Side& left, const Side& right, std::size_t limit) {
    const Recording &l = left.recording, &r = right.recording;
    if (l.header().schema_hash != r.header().schema_hash)
        return Error{join(l.name(), " and ", r.name(), " cannot be compared: their states have schemas ",
                          hex(l.header().schema_hash), " and ", hex(r.header().schema_hash))};
    DiffReport report;
    report.from = std::max(l.start_tick(), r.start_tick());
    report.to = std::min(l.end_tick(), r.end_tick());
    if (report.from > report.to)
        return Error{join(l.name(), " and ", r.name(), " have no time in common: ", l.start_tick(), "..",
                          l.end_tick(), " and ", r.start_tick(), "..", r.end_tick())};
    find_first_hash(l, r, report);
    find_first_input(l, r, report);
    if (!report.states_agree) {
        Result<Player> left_player = Player::open(l, left.game);
        if (!left_player) return left_player.error();
        Result<Player> right_player = Player::open(r, right.game);
        if (!right_player) return right_player.error();
        if (report.tick) {
            if (const Status s = simulate(*left_player, *right_player, limit, report); !s) return s.error();
        } else {
            for (Player* player : {&*left_player, &*right_player})
                if (const Status s = player->seek(report.from); !s) return s.error();
            compare(left_player->world().state(), right_player->world().state(), report.from, limit, report);
        }
    }
    write_text(l, r, report);
    return report;
}

} // namespace lockstone::replay
