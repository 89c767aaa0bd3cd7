// A character's own motion: along the ground and over steps; in the air up, sideways and down.
#include "play/character/character_mover.h"

#include "lockstone/math/math.h"

namespace lockstone::sim {

namespace {

constexpr int slides_max = 5;
constexpr Real step_forward_min = 0.02_r; ///< [m]: smallest forward distance of a step attempt
constexpr Real face_offset = 0.01_r;      ///< [m]: distance behind an edge at which its face is tested

} // namespace

// ---- ground ----------------------------------------------------------------------------------------------------

/// True if the character can stand on the surface just behind an edge, as seen from the character.
bool Mover::face_is_walkable(const SpaceHit& hit) const {
    const UnitVec3 outward = flat(hit.normal, up);
    if (outward == UnitVec3{}) return false;
    const Vec3 above = scale<Real>(up, face_offset * 2);
    SpaceHit face{};
    return space.ray(hit.point - scale<Real>(outward, face_offset) + above, -above * Real(2), face) &&
           face.normal != UnitVec3{} && is_walkable(face.normal);
}

/// True if a capsule that comes down on `hit` with its feet at `landed` can stay there: on a walkable surface, on the
/// edge of one that is not higher than a step, or on another walkable surface that it touches there, which then
/// replaces `hit`.
bool Mover::stands_on(SpaceHit& hit, Vec3 landed) const {
    if (is_walkable(hit.normal)) return true;
    const Real height = along(hit.point - landed);
    if (dot<Unit>(hit.normal, up) > Unit{} && height <= row.def.step_height && face_is_walkable(hit))
        return true;
    bool found = false;
    space.for_each_contact(landed, skin + skin_slack * 2, [&](const SpaceContact& c) {
        if (found || !is_walkable(c.normal)) return;
        found = true;
        hit.neighbour = c.neighbour;
        hit.normal = c.normal;
        hit.point = c.point;
        hit.piece = c.piece;
    });
    return found;
}

void Mover::report_landing(const SpaceHit& hit, Vec3 ground_velocity) {
    const Neighbour& n = space.neighbour(hit.neighbour);
    Event e{};
    e.kind = EventKind::character_landed;
    e.shape_a = row.shape;
    e.shape_b = w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[n.slot].row].id;
    e.body_a = row.body;
    e.body_b = n.body;
    e.point = hit.point;
    e.normal = -hit.normal;
    e.approach_speed = to<Speed>(max(-along(row.state.velocity - ground_velocity), Real{}));
    e.tick = w.header().tick;
    scratch.landings.push_back(e);
    was_in_air = false;
}

void Mover::land(const SpaceHit& hit) {
    CharacterState& s = row.state;
    const Neighbour& n = space.neighbour(hit.neighbour);
    const BodyId body = n.body;
    const Vec3 belt = space.conveyor(hit), velocity = (n.moves ? velocity_of(body, feet) : Vec3{}) + belt;
    if (was_in_air) report_landing(hit, velocity);
    if (s.ground != CharacterGround::walkable)
        s.velocity = level(s.velocity - velocity);
    else if (s.ground_body != body)
        s.velocity = level(s.velocity + s.ground_velocity - velocity);
    else if (belt != belt_ridden)
        s.velocity = level(s.velocity + belt_ridden - belt);
    belt_ridden = belt;
    s.ground = CharacterGround::walkable;
    s.ground_velocity = velocity;
    s.ground_body = body;
    s.ground_shape = w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[n.slot].row].id;
    s.ground_normal = hit.normal;
    ground_point = hit.point;
}

void Mover::leave_ground() {
    CharacterState& s = row.state;
    s.velocity += s.ground_velocity;
    s.ground = CharacterGround::none;
    s.ground_velocity = {};
    s.ground_body = {};
    s.ground_shape = {};
    s.ground_normal = {};
}

/// Moves down to ground at most step_down below. If there is none, the character begins to fall.
void Mover::settle() {
    const Real depth = max(row.def.step_down, skin * 2);
    SpaceHit hit{};
    if (space.cast(feet, scale<Real>(up, -depth), hit)) {
        const Vec3 landed = feet - scale<Real>(up, hit.allowed);
        if (stands_on(hit, landed)) {
            if (hit.allowed > skin_slack) feet = landed;
            return land(hit);
        }
    }
    leave_ground();
}

// ---- walking ---------------------------------------------------------------------------------------------------

/// Moves up by a step, forward, and down onto ground. `gone`: the forward distance.
bool Mover::try_step(Vec3 way, Real& gone) {
    SpaceHit hit{};
    Vec3 at = feet;
    Real part{};
    space.advance(at, scale<Real>(up, row.def.step_height), hit, part);
    const Real lifted = along(at - feet);
    if (lifted < skin * 2) return false;
    const Real distance = max(length(way), step_forward_min);
    space.advance(at, scale<Real>(normalized(way), distance), hit, part);
    gone = distance * part;
    if (gone < half(step_forward_min)) return false;
    if (!space.cast(at, scale<Real>(up, -lifted), hit)) return false;
    const Vec3 landed = at - scale<Real>(up, hit.allowed);
    // Otherwise a round foot would climb edges of any height in several steps.
    if (along(hit.point - feet) > row.def.step_height) return false;
    if (along(landed - feet) < skin_slack || !stands_on(hit, landed)) return false;
    feet = landed;
    land(hit);
    return true;
}

void Mover::walk() {
    CharacterState& s = row.state;
    s.velocity = approached(level(s.velocity), level(row.input.velocity), row.def.acceleration);
    const Vec3 from = feet, wanted = per_tick(s.velocity);
    std::array<UnitVec3, slides_max> planes;
    std::size_t plane_count = 0;
    UnitVec3 ground = is_walkable(s.ground_normal) ? s.ground_normal : up;
    Vec3 rest = wanted; // perpendicular to `up`
    Real left = Real(1);
    bool was_blocked = false;
    for (int i = 0; i < 2 * slides_max && length(rest) > skin_slack / Real(16); ++i) {
        // The horizontal speed is the same uphill and downhill.
        const Vec3 way = rest - scale<Real>(up, dot<Real>(ground, rest) / to<Real>(dot<Unit>(ground, up)));
        SpaceHit hit{};
        Real part{};
        if (!space.advance(feet, way, hit, part)) break;
        left -= left * part;
        rest -= rest * part;
        if (is_walkable(hit.normal) && dot<Unit>(hit.normal, ground) < unit_one - Unit::from_raw(1 << 10)) {
            ground = hit.normal;
            continue;
        }
        Real gone{};
        if (const Real size = length(rest); try_step(rest, gone)) {
            ground = is_walkable(s.ground_normal) ? s.ground_normal : up;
            const Real kept = max(Real(1) - gone / size, Real{});
            left *= kept, rest *= kept;
            continue;
        }
        was_blocked = true;
        note_push(hit);
        if (plane_count == planes.size()) break;
        const UnitVec3 wall = flat(hit.normal, up);
        planes[plane_count++] = wall != UnitVec3{} ? wall : flat(ground, up); // a ceiling above a slope
        rest = level(clipped(wanted * left, std::span(planes).first(plane_count)));
    }
    if (was_blocked) {
        const Vec3 done = level(feet - from) * Real(rate);
        const Real speed = length(s.velocity), reached = length(done);
        s.velocity = reached > speed ? done * (speed / reached) : done;
    }
    settle();
}

// ---- in the air ------------------------------------------------------------------------------------------------

void Mover::fall() {
    CharacterState& s = row.state;
    const Real before = along(s.velocity);
    const Vec3 aside = approached(level(s.velocity), level(row.input.velocity), row.def.air_acceleration);
    const Real after = max(before - row.def.gravity / Real(rate), -row.def.fall_speed_max);
    s.velocity = aside + scale<Real>(up, after);
    s.ground = CharacterGround::none;
    s.ground_body = {}, s.ground_shape = {}, s.ground_normal = {}, s.ground_velocity = {};
    const Real height = half(before + after) / Real(rate); // exact for a parabola
    const Vec3 way = per_tick(aside);
    if (height > Real{}) {
        rise(height);
        return glide(way);
    }
    glide(way);
    drop(-height);
}

void Mover::rise(Real height) {
    SpaceHit hit{};
    Real part{};
    const Vec3 way = scale<Real>(up, height);
    if (!space.advance(feet, way, hit, part)) return;
    const std::span<const UnitVec3> ceiling(&hit.normal, 1);
    const Vec3 rest = clipped(way - way * part, ceiling);
    row.state.velocity = clipped(row.state.velocity, ceiling);
    SpaceHit again{};
    if (space.advance(feet, rest, again, part)) row.state.velocity = level(row.state.velocity);
}

void Mover::glide(Vec3 way) {
    CharacterState& s = row.state;
    std::array<UnitVec3, slides_max> planes;
    std::size_t count = 0;
    Vec3 rest = way;
    Real left = Real(1);
    while (count < planes.size() && length(rest) > skin_slack / Real(16)) {
        SpaceHit hit{};
        Real part{};
        if (!space.advance(feet, rest, hit, part)) return;
        left -= left * part;
        note_push(hit);
        const UnitVec3 wall = flat(hit.normal, up);
        // Jumping against ground that is too steep to stand on does not climb it either.
        planes[count++] = is_walkable(hit.normal) || wall == UnitVec3{} ? hit.normal : wall;
        const std::span<const UnitVec3> met(planes.data(), count);
        rest = clipped(way * left, met);
        s.velocity = clipped(level(s.velocity), met) + scale<Real>(up, along(s.velocity));
    }
}

void Mover::drop(Real height) {
    CharacterState& s = row.state;
    std::array<UnitVec3, slides_max> planes;
    std::size_t count = 0;
    const Vec3 way = scale<Real>(up, -max(height, skin_slack));
    Vec3 rest = way;
    Real left = Real(1);
    while (count < planes.size()) {
        SpaceHit hit{};
        Real part{};
        if (!space.cast(feet, rest, hit)) {
            feet += rest;
            return;
        }
        part = hit.allowed / length(rest);
        const Vec3 landed = feet + rest * part;
        feet = landed;
        left -= left * part;
        if (stands_on(hit, landed)) return land(hit);
        s.ground = CharacterGround::steep;
        s.ground_normal = hit.normal;
        planes[count++] = hit.normal;
        const std::span<const UnitVec3> met(planes.data(), count);
        s.velocity = clipped(s.velocity, met);
        rest = clipped(way * left, met);
        if (length(rest) > skin_slack / Real(16)) continue;
        // The character is wedged between walls: it may jump as if it stood.
        is_kept_up = left > 0.01_r;
        return;
    }
}

} // namespace lockstone::sim
