#include "compare.h"

#include "lockstone/row.h"

#include <algorithm>
#include <span>

namespace worlds {

namespace {

void mix(std::uint64_t& digest, std::uint64_t word) {
    digest = (digest ^ word) * 0x9e3779b97f4a7c15u;
    digest ^= digest >> 29;
}

/// Events of the last tick, then its contact points.
std::uint64_t outputs_of(const World& world) {
    std::vector<std::byte> bytes;
    for (const Event& event : world.events())
        append_canonical(std::as_bytes(std::span(&event, 1)), leaves_of<Event>(), bytes);
    std::uint64_t digest = hash_bytes(bytes);
    for (const World::ContactPoint& p : world.contacts()) {
        mix(digest, p.shape_a.index), mix(digest, p.shape_b.index);
        for (int i = 0; i < 3; ++i)
            mix(digest, static_cast<std::uint64_t>(p.point[i].raw)),
                mix(digest, static_cast<std::uint64_t>(p.normal[i].raw));
        mix(digest, static_cast<std::uint64_t>(p.separation.raw));
        mix(digest, static_cast<std::uint64_t>(p.impulse.raw));
    }
    return digest;
}

/// The first phase of tick `t` after which the hashes of two players differ. Both have run the ticks before.
std::string first_phase(Player& left, Player& right, std::uint64_t t) {
    left.world().record_phase_hashes(true), right.world().record_phase_hashes(true);
    left.play(t), right.play(t);
    const std::span<const PhaseHash> a = left.world().phase_hashes(), b = right.world().phase_hashes();
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        if (std::string(a[i].phase) != b[i].phase)
            return std::string("phase ") + a[i].phase + " against " + b[i].phase;
        if (a[i].hash != b[i].hash) return std::string("phase ") + a[i].phase;
    }
    return left.world().hash() == right.world().hash() ? "no phase while phases are hashed"
                                                       : "after all phases";
}

std::string place(const Story& story, const Mode& mode, std::uint64_t t) {
    std::string out;
    {
        Player left(story, reference_mode()), right(story, mode);
        for (std::uint64_t before = 0; before < t; ++before) left.play(before), right.play(before);
        out = first_phase(left, right, t);
    }
    Player left(story, reference_mode()), right(story, mode);
    for (std::uint64_t now = 0; now <= t; ++now) left.play(now), right.play(now);
    for (const Difference& d : State::diff(left.world().state(), right.world().state(), 1))
        return out + ", " + lockstone::to_string(d);
    if (left.world().hash() != right.world().hash()) return out + ", hashes differ and no row does";
    return out + ", events or contacts of the tick";
}

} // namespace

std::uint64_t Course::digest() const {
    std::uint64_t d = 0;
    for (const std::uint64_t hash : states) mix(d, hash);
    for (const std::uint64_t hash : outputs) mix(d, hash);
    return d;
}

Course run(const Story& story, const Mode& mode) {
    Course course;
    Player player(story, mode);
    for (std::uint64_t t = 0; t < story.ticks; ++t) {
        player.play(t);
        course.states.push_back(player.world().hash());
        course.outputs.push_back(outputs_of(player.world()));
    }
    course.paths = player.paths();
    return course;
}

std::optional<Departure> departure(const Story& story, const Course& expected, const Mode& mode,
                                   testing::PathSet* paths) {
    Player player(story, mode);
    for (std::uint64_t t = 0; t < story.ticks; ++t) {
        player.play(t);
        if (player.world().hash() == expected.states[t] && outputs_of(player.world()) == expected.outputs[t])
            continue;
        return Departure{t, place(story, mode, t)};
    }
    if (paths != nullptr) *paths |= player.paths();
    return {};
}

std::optional<std::uint64_t> first_tick_apart(const Story& story, const Mode& mode) {
    Player left(story, reference_mode()), right(story, mode);
    for (std::uint64_t t = 0; t < story.ticks; ++t) {
        left.play(t), right.play(t);
        if (left.world().hash() != right.world().hash() ||
            outputs_of(left.world()) != outputs_of(right.world()))
            return t;
    }
    return {};
}

} // namespace worlds
