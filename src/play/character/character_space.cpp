#include "play/character/character_space.h"

#include "base/assert.h"
#include "collide/query/cast.h"
#include "lockstone/math/math.h"
#include "scene/surface.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

#include <algorithm>
#include <array>

namespace lockstone::sim {

namespace {

/// Extra length of a capsule cast, so that it also stops at shapes that it would only come near to.
constexpr Real look_ahead = skin * 8;

Real per_tick(Speed v, std::uint32_t rate) {
    return Real::from_raw(divide_shifted(v.raw, rate, Real::fraction_bits - Speed::fraction_bits));
}
Vec3 per_tick(SpeedVec3 v, std::uint32_t rate) {
    return {per_tick(v.x, rate), per_tick(v.y, rate), per_tick(v.z, rate)};
}

/// The frame of a plane, moved to the foot of the perpendicular from `point`. Other frames stay the same.
Transform frame_near(const Neighbour& n, const Transform& frame, Vec3 point) {
    if (!n.is_plane) return frame;
    const UnitVec3 normal = to_rotation(frame.rotation).y;
    return {point - scale<Real>(normal, dot<Real>(normal, point - frame.position)), frame.rotation};
}

} // namespace

CharacterSpace::CharacterSpace(const Model& model, PlacedShapes& shapes, CharacterScratch& memory,
                               const CharacterRow& character)
    : w(model), row(character), up(character.def.up),
      rotation(from_to({Unit{}, unit_one, Unit{}}, character.def.up)), placed(shapes), scratch(memory) {}

void CharacterSpace::set_height(Real height) {
    const Result<shapes::Solid> solid = placed.solids.resolve(capsule_of(row.def, height).geometry);
    LOCKSTONE_ASSERT(solid.ok(), "a character of height ", height.raw);
    capsule = *solid;
    capsule_reach = shapes::reach_of(capsule);
    lift = scale<Real>(up, half(height));
}

bool CharacterSpace::sees(const ShapeRow& own, const ShapeRow& other) const {
    if (w.traits_of(other).sensor != 0 || other.body == own.body) return false;
    return filters_allow(w, own, other);
}

void CharacterSpace::place(Neighbour& n, const ShapeRow& shape) const {
    n.begin = n.end = placed.shape[n.slot].pose;
    n.moves = false;
    if (n.kind == BodyKind::static_) return;
    const std::uint32_t character = scratch.order_of_body[n.body.index - 1];
    // Characters later in the order are still at their old pose; earlier ones already have their velocity of this
    // tick.
    const std::uint32_t own_order = scratch.order_of_body[row.body.index - 1];
    if (character > own_order) return;
    const std::uint32_t body_row = w.row_of(n.body);
    const Velocity& v = w.state.rows(w.m.body_velocity)[body_row];
    if (v.linear == SpeedVec3{} && v.angular == SpeedVec3{}) return;
    const std::uint32_t rate = w.state.rows(w.m.config)[0].tick_rate;
    const Transform& body = w.state.rows(w.m.body_pose)[body_row];
    const Quat turned = integrate_rotation(body.rotation, per_tick(v.angular, rate));
    const Vec3 center = body.position + per_tick(v.linear, rate);
    n.end = {center + rotate(turned, w.traits_of(shape).local.position - w.mass_of(body_row).center),
             normalized(turned * w.traits_of(shape).local.rotation)};
    n.moves = true;
}

void CharacterSpace::collect(Vec3 feet, Real range) {
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const ShapeRow& own = shapes[w.row_of(row.shape)];
    const int shift = static_cast<int>(w.state.rows(w.m.config)[0].bounds_shift);
    const collide::Bounds here = collide::bounds_of(capsule, {center_of(feet), rotation}, Length{}, shift);
    const std::int64_t steps = (range.raw >> (Real::fraction_bits - Bound::fraction_bits + shift)) + 1;
    placed.broad_phase.query(collide::expand(here, Bound::from_raw(saturate_to_int32(steps))), scratch.slots);
    scratch.slots.insert(scratch.slots.end(), placed.planes.begin(), placed.planes.end());
    scratch.neighbours.clear();
    for (const std::uint32_t slot : scratch.slots) {
        const ShapeRow& shape = shapes[slots[slot].row];
        if (!sees(own, shape)) continue;
        Neighbour n{};
        n.slot = slot;
        n.body = shape.body;
        n.kind = w.state.rows(w.m.body_info)[w.row_of(shape.body)].kind;
        n.solid = &placed.shape[slot].solid;
        n.reach = placed.shape[slot].reach;
        n.is_plane = w.traits_of(shape).geometry.kind == ShapeKind::plane;
        n.one_way = w.traits_of(shape).one_way != 0;
        place(n, shape);
        scratch.neighbours.push_back(n);
    }
}

void CharacterSpace::update_body(BodyId body) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    for (Neighbour& n : scratch.neighbours)
        if (n.body == body) place(n, w.state.rows(w.m.shape)[slots[n.slot].row]);
}

bool CharacterSpace::is_far(const Neighbour& n, const Transform& frame, Vec3 center, Real range) const {
    if (n.is_plane) return false;
    const Real most = to<Real>(n.reach + capsule_reach) + range;
    const Vec3 apart = abs(center - frame.position);
    return apart.x > most || apart.y > most || apart.z > most;
}

bool CharacterSpace::collide_with(Vec3 center, const Neighbour& n, const Transform& frame,
                                  Real margin) const {
    if (is_far(n, frame, center, margin)) return false;
    const Transform own{center, rotation};
    collide::collide(*n.solid, capsule,
                     n.is_plane ? collide::plane_relative_pose(frame, own)
                                : collide::relative_pose(frame, own),
                     to<Length>(margin), scratch.narrow, scratch.manifolds);
    return scratch.manifolds.count != 0;
}

bool CharacterSpace::hit_at_start(Vec3 center, UnitVec3 direction, std::uint32_t index, SpaceHit& hit) const {
    // An overlap stops only motion that goes deeper. unstick() moves the character out of overlaps.
    bool found = false;
    Real deepest{};
    for_each_contact(center - lift, index, Real{}, true, [&](const SpaceContact& c) {
        if (dot<Unit>(c.normal, direction) >= Unit{} || (found && c.gap >= deepest)) return;
        found = true;
        deepest = c.gap;
        hit = {index, Real{}, c.point, c.normal, c.piece};
    });
    return found;
}

bool CharacterSpace::cast_one(Vec3 center, Vec3 way, UnitVec3 direction, Real length, std::uint32_t index,
                              SpaceHit& hit) const {
    const Neighbour& n = scratch.neighbours[index];
    if (is_far(n, n.end, center, length)) return false;
    const Transform frame = frame_near(n, n.end, center);
    const Rotation axes = to_rotation(frame.rotation);
    const auto local = [&](Vec3 v) { return mul_transposed<Coordinate>(axes, to<Coordinate>(v)); };
    const Rotation turned = to_rotation(conjugate(frame.rotation) * rotation);
    collide::CastHit found{};
    if (!collide::cast_shape(*n.solid, capsule, {turned, local(center - frame.position)}, local(way),
                             scratch.narrow, found))
        return false;
    if (found.normal == UnitVec3{}) return hit_at_start(center, direction, index, hit);
    const UnitVec3 normal = lockstone::mul<Unit>(axes, found.normal);
    if (n.one_way && dot<Unit>(axes.y, normal) < half(unit_one)) return false;
    const Real against = -dot<Real>(normal, direction);
    if (against <= Real{}) return false;
    const Real allowed = to<Real>(found.distance) - skin / against;
    hit = {index, max(allowed, Real{}), frame.position + lockstone::mul<Real>(axes, found.point), normal,
           found.feature};
    return true;
}

bool CharacterSpace::cast(Vec3 feet, Vec3 way, SpaceHit& hit, BodyId ignored) const {
    const Real distance = length(way);
    if (distance == Real{}) return false;
    const UnitVec3 direction = normalized(way);
    const Real looked = distance + look_ahead;
    const Vec3 looked_way = scale<Real>(direction, looked);
    const Vec3 center = center_of(feet);
    bool found = false;
    for (std::uint32_t i = 0; i < scratch.neighbours.size(); ++i) {
        SpaceHit at{};
        if (scratch.neighbours[i].body == ignored) continue;
        if (!cast_one(center, looked_way, direction, looked, i, at) || at.allowed >= distance) continue;
        if (!found || at.allowed < hit.allowed) hit = at;
        found = true;
    }
    return found;
}

bool CharacterSpace::advance(Vec3& feet, Vec3 way, SpaceHit& hit, Real& part, BodyId ignored) const {
    part = Real(1);
    if (!cast(feet, way, hit, ignored)) {
        feet += way;
        return false;
    }
    part = hit.allowed / length(way);
    feet += way * part;
    return true;
}

bool CharacterSpace::ray(Vec3 from, Vec3 way, SpaceHit& hit) const {
    bool found = false;
    const Real distance = length(way);
    for (std::uint32_t i = 0; i < scratch.neighbours.size(); ++i) {
        const Neighbour& n = scratch.neighbours[i];
        const Transform frame = frame_near(n, n.end, from);
        const Vec3 apart = abs(from - frame.position);
        const Real most = to<Real>(n.reach) + distance;
        if (!n.is_plane && (apart.x > most || apart.y > most || apart.z > most)) continue;
        const Rotation axes = to_rotation(frame.rotation);
        const auto local = [&](Vec3 v) { return mul_transposed<Coordinate>(axes, to<Coordinate>(v)); };
        collide::CastHit at{};
        if (!collide::cast_ray(*n.solid, local(from - frame.position), local(way), scratch.narrow, at))
            continue;
        const Real travelled = to<Real>(at.distance);
        if (found && travelled >= hit.allowed) continue;
        found = true;
        hit = {i, travelled, frame.position + lockstone::mul<Real>(axes, at.point),
               lockstone::mul<Unit>(axes, at.normal), at.feature};
    }
    return found;
}

Vec3 CharacterSpace::conveyor(const SpaceHit& hit) const {
    const Neighbour& n = scratch.neighbours[hit.neighbour];
    const ShapeRow& shape = w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[n.slot].row];
    const Vec3 velocity = touch_of(w.traits_of(shape), placed.shape[n.slot], hit.piece).velocity;
    if (velocity == Vec3{}) return {};
    const Vec3 turned = rotate(n.end.rotation, velocity);
    return turned - scale<Real>(hit.normal, dot<Real>(hit.normal, turned));
}

bool CharacterSpace::has_conveyor(const Neighbour& n) const {
    const ShapeRow& shape = w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[n.slot].row];
    const auto is_one = [](const MaterialSurface& s) { return s.surface_velocity != Vec3{}; };
    return w.traits_of(shape).surface_velocity != Vec3{} ||
           (n.solid->mesh != nullptr && std::ranges::any_of(n.solid->mesh->surfaces(), is_one)) ||
           (n.solid->height_field != nullptr &&
            std::ranges::any_of(n.solid->height_field->surfaces(), is_one));
}

Vec3 clipped(Vec3 wanted, std::span<const UnitVec3> planes) {
    // The nearest free displacement is `wanted`, its projection on a plane or on the line of two planes, or zero. All
    // are projections of `wanted`, so the longest one that no plane forbids is the nearest.
    constexpr Real tolerance = Real::from_raw(1 << 11); // 0.5 um
    const auto is_free = [&](Vec3 d) {
        for (const UnitVec3& n : planes)
            if (dot<Real>(n, d) < -tolerance) return false;
        return true;
    };
    if (is_free(wanted)) return wanted;
    Vec3 best{};
    Real longest{};
    const auto try_way = [&](Vec3 d) {
        const Real size = length(d);
        if (size > longest && is_free(d)) best = d, longest = size;
    };
    for (const UnitVec3& n : planes) try_way(wanted - scale<Real>(n, dot<Real>(n, wanted)));
    for (std::size_t i = 0; i < planes.size(); ++i)
        for (std::size_t j = i + 1; j < planes.size(); ++j) {
            const UnitVec3 line = normalized(cross<Real>(to<Real>(planes[i]), to<Real>(planes[j])));
            try_way(scale<Real>(line, dot<Real>(line, wanted)));
        }
    return best;
}

UnitVec3 flat(UnitVec3 n, UnitVec3 up) {
    const Vec3 along = to<Real>(n) - scale<Real>(up, dot<Real>(n, up));
    // A shorter rest is rounding.
    return length(along) < 0.0001_r ? UnitVec3{} : normalized(along);
}

} // namespace lockstone::sim
