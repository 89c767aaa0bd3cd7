#include "tick/islands.h"

#include "base/joined.h"
#include "lockstone/math/math.h"
#include "model/sleep.h"

#include <algorithm>

namespace lockstone::sim {

/// Returns true if a dynamic body may be asleep. Checks the resting bodies one by one only if they are few compared
/// with the pairs; else returns true.
static bool may_sleep(const Model& w, std::size_t pairs) {
    const std::span<const BodyInfo> resting = w.state.rows(w.m.body_info).subspan(w.header().bodies_awake);
    return resting.size() > pairs / 4 ||
           std::ranges::any_of(resting, [](const BodyInfo& info) { return info.kind == BodyKind::dynamic; });
}

bool wake_touched(Model& w, const PlacedShapes& placed, std::span<const NearPair> near_pairs,
                  ContactScratch& contacts, IslandScratch& scratch) {
    std::vector<BodyId>& touched = scratch.touched;
    touched.clear();
    if (!may_sleep(w, near_pairs.size())) return false;
    const std::span<const Slot> body_slots = w.state.rows(w.m.body_slot);
    const std::span<const ShapeTraits> traits = w.state.rows(w.m.shape_traits.row);
    const std::uint32_t awake = w.header().bodies_awake;
    for (const NearPair& near : near_pairs) {
        const PlacedShapes::Filter &a = placed.shape[near.key.a.index - 1].filter,
                                   &b = placed.shape[near.key.b.index - 1].filter;
        const std::uint32_t row_a = body_slots[a.body].row, row_b = body_slots[b.body].row;
        const bool wakes_a = row_a >= awake, wakes_b = row_b >= awake;
        if (wakes_a == wakes_b || (traits[a.traits].sensor | traits[b.traits].sensor) != 0) continue;
        const BodyInfo& woken = w.state.rows(w.m.body_info)[wakes_a ? row_a : row_b];
        if (woken.kind != BodyKind::dynamic) continue;
        if (has_contact_points(w, placed, near, contacts)) touched.push_back(woken.id);
    }
    wake_islands(w, touched);
    return !touched.empty();
}

// ---- falling asleep -----------------------------------------------------------------------------------------

namespace {

/// An upper bound of the speeds of all points of a solid body: |v| + |w| times twice the largest gyration radius.
/// Rotation of a thin body about its long axis moves its surface by the smallest radius only: a needle that rolls
/// slowly is slow. So for a thin body each component of the angular velocity has the radius of its own axis. This
/// costs a rotation, which the function saves for other bodies.
Real speed_of(const Velocity& v, const BodyMass& mass, const Quat& rotation) {
    const Vec3& radii = mass.gyration;
    const Real most = max(radii.x, max(radii.y, radii.z)), least = min(radii.x, min(radii.y, radii.z));
    const Real linear = to<Real>(length(v.linear));
    if (most <= least * 4) return linear + to<Real>(length(v.angular)) * (most * 2);
    const Vec3 spin = rotate(conjugate(rotation * mass.principal), to<Real>(v.angular));
    return linear + length(Vec3{spin.x * radii.x, spin.y * radii.y, spin.z * radii.z}) * 2;
}

/// The mean velocity of a body in the tick, computed from its poses. Position correction of contacts and joints moves
/// a body without changing its velocity.
Velocity displacement_rate(const Transform& from, const Transform& to, std::int32_t tick_rate) {
    const Quat turn = to.rotation * conjugate(from.rotation);
    const Real twice = Real(turn.w < Unit{} ? -2 : 2);
    const Vec3 angle =
        Vec3{lockstone::to<Real>(turn.x), lockstone::to<Real>(turn.y), lockstone::to<Real>(turn.z)} * twice;
    return {lockstone::to<Speed>((to.position - from.position) * Real(tick_rate)),
            lockstone::to<Speed>(angle * Real(tick_rate))};
}

/// A body is still while it is slow, or while it is less than four times as fast and not far from the position at
/// which its still ticks began. Otherwise bodies that rock or shake on the spot between their neighbours would keep
/// an island awake. Both velocity and displacement are compared: a body that position correction moves has no
/// velocity, and a wedged body has no displacement.
/// source: Rouwe, Jolt Physics, Body::UpdateSleepStateInternal, for the idea to compare how far a body went
struct Stillness {
    std::uint32_t ticks_to_sleep;
    std::int32_t tick_rate;
    Speed slow, rocking;
    Speed bobbing; ///< limit for bodies at the surface of a fluid; they are fastest when they pass its level
    Speed away;    ///< limit of BodySleep::moved: the way at sleep_speed for sleep_time [tick m/s]

    explicit Stillness(const Config& c)
        : ticks_to_sleep(static_cast<std::uint32_t>(std::max<std::int64_t>(
              1, floor_to_int(c.sleep_time * static_cast<std::int32_t>(c.tick_rate))))),
          tick_rate(static_cast<std::int32_t>(c.tick_rate)), slow(to<Speed>(c.sleep_speed)),
          rocking(to<Speed>(c.sleep_speed * 4)), bobbing(to<Speed>(c.sleep_speed / Real(16))),
          away(to<Speed>(c.sleep_speed * Real(ticks_to_sleep))) {}

    bool is_fast(const SpeedVec3& linear) const {
        const Vec3 size = abs(to<Real>(linear));
        return max(size.x, max(size.y, size.z)) >= to<Real>(rocking);
    }
    /// `moved`: the sum of `went` over the still ticks.
    bool is_still(const Velocity& v, const Velocity& went, const Velocity& moved, bool is_afloat,
                  const BodyMass& mass, const Quat& rotation) const {
        const Real speed = max(speed_of(v, mass, rotation), speed_of(went, mass, rotation));
        if (is_afloat) return speed < to<Real>(bobbing);
        if (speed < to<Real>(slow)) return true;
        return speed < to<Real>(rocking) && speed_of(moved, mass, rotation) < to<Real>(away);
    }
    void count(BodySleep& sleep, const Velocity& v, const Transform& from, const Transform& at,
               bool is_afloat, const BodyMass& mass) const {
        if (is_fast(v.linear)) return restart(sleep); // needs no square roots
        const Velocity went = displacement_rate(from, at, tick_rate);
        if (is_fast(went.linear)) return restart(sleep);
        sleep.moved = {sleep.moved.linear + went.linear, sleep.moved.angular + went.angular};
        if (is_still(v, went, sleep.moved, is_afloat, mass, at.rotation))
            sleep.still_ticks = std::min(sleep.still_ticks + 1, 1u << 30);
        else
            restart(sleep);
    }
};

struct Islands {
    IslandScratch& s;
    std::uint32_t awake;
    std::span<const BodyInfo> info;
    std::span<const Velocity> velocity;

    Islands(const Model& w, IslandScratch& scratch)
        : s(scratch), awake(w.header().bodies_awake), info(w.state.rows(w.m.body_info)),
          velocity(w.state.rows(w.m.body_velocity)) {}

    std::uint32_t root(std::uint32_t row) { return base::root_of(s.parent, row); }
    bool is_dynamic(std::uint32_t row) const { return row < awake && info[row].kind == BodyKind::dynamic; }
    /// A moving kinematic body keeps the bodies that it holds awake.
    bool holds(std::uint32_t row) const {
        return row < awake && info[row].kind == BodyKind::kinematic && velocity[row] != Velocity{};
    }
    void link(std::uint32_t a, std::uint32_t b) {
        if (is_dynamic(a) && holds(b)) s.still_ticks[a] = 0;
        if (is_dynamic(b) && holds(a)) s.still_ticks[b] = 0;
        if (!is_dynamic(a) || !is_dynamic(b)) return;
        base::join(s.parent, a, b);
    }
    void find(const Links& links) {
        base::start_sets(s.parent, awake);
        for (const solve::ContactHead& c : links.contacts) link(c.body_a, c.body_b);
        for (const solve::Joint& j : links.joints) link(j.body_a, j.body_b);
        for (const solve::Standing& v : links.standing) link(v.chassis, v.ground);
        for (std::uint32_t row = 0; row < awake; ++row) {
            std::uint32_t& least = s.still_ticks[root(row)];
            least = std::min(least, s.still_ticks[row]);
        }
    }
};

/// Counts the still ticks of each awake body, in the state and in the scratch memory.
void count_still_ticks(Model& w, const Stillness& stillness, const Motion& motion, IslandScratch& s) {
    const std::uint32_t awake = w.header().bodies_awake;
    const std::span<BodySleep> sleep = w.state.edit(w.m.body_sleep, 0, awake);
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const solve::MassView mass = w.masses();
    const std::span<const Velocity> velocity = w.state.rows(w.m.body_velocity);
    const std::span<const Transform> pose = w.state.rows(w.m.body_pose);
    s.still_ticks.resize(awake);
    auto afloat = motion.afloat.begin();
    for (std::uint32_t row = 0; row < awake; ++row) {
        const bool is_afloat = afloat != motion.afloat.end() && *afloat == row;
        if (is_afloat) ++afloat;
        if (info[row].kind == BodyKind::dynamic)
            stillness.count(sleep[row], velocity[row], motion.before.of(w, row), pose[row], is_afloat,
                            mass[row]);
        s.still_ticks[row] = sleep[row].still_ticks;
    }
}

/// Finds the bodies of islands that have been still for long enough, in slot order, and links their rings.
void find_still_islands(Model& w, const Links& links, const Motion& motion, IslandScratch& s) {
    const Stillness stillness(w.config());
    count_still_ticks(w, stillness, motion, s);
    Islands islands(w, s);
    islands.find(links);
    const std::size_t begin = s.resting.size();
    for (std::uint32_t row = 0; row < islands.awake; ++row)
        if (islands.is_dynamic(row) && s.still_ticks[islands.root(row)] >= stillness.ticks_to_sleep)
            s.resting.push_back(islands.info[row].id);
    if (s.resting.size() == begin) return;
    std::sort(s.resting.begin() + static_cast<std::ptrdiff_t>(begin), s.resting.end());
    s.first.assign(islands.awake, 0), s.last.assign(islands.awake, 0);
    for (std::size_t i = begin; i < s.resting.size(); ++i) {
        const std::uint32_t slot = s.resting[i].index, row = w.row_of(s.resting[i]), root = islands.root(row);
        if (s.first[root] == 0) s.first[root] = slot;
        BodySleep& sleep = w.state.edit_row(w.m.body_sleep, row);
        sleep = {0, s.first[root], s.first[root], {}}; // each step closes the ring
        if (s.last[root] != 0)
            w.state.edit_row(w.m.body_sleep, w.state.rows(w.m.body_slot)[s.last[root] - 1].row).next = slot;
        s.last[root] = slot;
        w.state.edit_row(w.m.body_velocity, row) = {};
    }
}

void publish_sleep(const Model& w, std::span<const BodyId> bodies, std::vector<Event>& events) {
    for (BodyId body : bodies) {
        if (w.state.rows(w.m.body_info)[w.row_of(body)].kind != BodyKind::dynamic) continue;
        Event e{};
        e.kind = EventKind::body_sleep;
        e.body_a = body;
        e.tick = w.header().tick;
        events.push_back(e);
    }
}

} // namespace

void find_resting(Model& w, const Links& links, const Motion& motion, IslandScratch& s) {
    s.resting.clear();
    const std::span<const BodyInfo> bodies = w.state.rows(w.m.body_info).first(w.header().bodies_awake);
    for (std::uint32_t row = 0; row < bodies.size(); ++row) {
        const BodyInfo& info = bodies[row];
        if (info.kind == BodyKind::dynamic) continue;
        if (info.kind == BodyKind::static_ || w.state.rows(w.m.body_velocity)[row] == Velocity{})
            s.resting.push_back(info.id);
    }
    if (w.config().sleeping != 0) find_still_islands(w, links, motion, s);
}

void put_to_sleep(Model& w, PlacedShapes& placed, std::span<const BodyId> resting,
                  std::vector<Event>& events) {
    if (resting.empty()) return;
    put_to_rest(w, resting);
    for (std::uint32_t row = w.header().joints_awake; row-- > 0;) {
        const JointDef& def = w.state.rows(w.m.joint)[row].def;
        const bool held =
            (def.body_a && is_awake(w, w.row_of(def.body_a))) || is_awake(w, w.row_of(def.body_b));
        if (!held) put_joint_to_rest(w, row);
    }
    rest_contacts(w);
    publish_sleep(w, resting, events);
    placed.structure_stale = true;
}

} // namespace lockstone::sim
