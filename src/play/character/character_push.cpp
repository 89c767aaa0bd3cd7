// Forces between characters and dynamic bodies. The solver skips contacts beside and below a character; this file
// replaces them by bounded forces.
#include "play/character/character_mover.h"

#include "lockstone/math/math.h"
#include "model/sleep.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

/// Speed along a direction at a point, per impulse as large as the body's mass: 1, or more if the body turns.
Real mobility(const Model& w, BodyId id, Vec3 point, UnitVec3 direction) {
    const std::uint32_t body = w.row_of(id);
    const Transform& pose = w.state.rows(w.m.body_pose)[body];
    const BodyMass& mass = w.mass_of(body);
    const Rotation axes = to_rotation(pose.rotation * mass.principal);
    const Vec3 lever = mul_transposed<Real>(axes, cross<Real>(point - pose.position, direction));
    Real sum = Real(1);
    for (int i = 0; i < 3; ++i) {
        const Real turned = mass.gyration[i] == Real{} ? Real{} : lever[i] / mass.gyration[i];
        sum += turned * turned;
    }
    return sum;
}

} // namespace

bool is_movers_contact(const Model& w, const CharacterScratch& scratch, BodyId body_a, BodyId body_b,
                       UnitVec3 normal) {
    const std::vector<std::uint32_t>& order = scratch.order_of_body;
    if (order.empty()) return false;
    const std::uint32_t a = order[body_a.index - 1], b = order[body_b.index - 1];
    if (a == 0 && b == 0) return false;
    const UnitVec3 up = w.state.rows(w.m.character)[(a != 0 ? a : b) - 1].def.up;
    return dot<Unit>(a != 0 ? normal : -normal, up) <= half(unit_one);
}

/// Stops a dynamic body that moves towards the character, like a body of the character's mass that also pushes.
void Mover::take_impact(const SpaceContact& c) {
    const BodyId body = space.neighbour(c.neighbour).body;
    const std::uint32_t at = w.row_of(body);
    const Real mass = w.mass_of(at).mass;
    const Real closing = dot<Real>(c.normal, velocity_of(body, c.point) - row.state.velocity) -
                         dot<Real>(c.normal, carried) * Real(rate);
    if (closing <= Real{} || mass == Real{}) return;
    const Real stopped = mass / mobility(w, body, c.point, c.normal) * closing;
    // The reduced mass is this share of the body's mass.
    const Real own_share = row.def.mass / (row.def.mass + mass);
    const Real most = mass * own_share * closing + row.def.push_force / Real(rate);
    const Vec3 impulse = scale<Real>(c.normal, -min(stopped, most));
    apply_impulse(w, at, impulse, cross(c.point - w.state.rows(w.m.body_pose)[at].position, impulse));
    space.update_body(body);
    row.state.velocity += level(impulse / -row.def.mass);
}

/// Adds to `away` the motion that keeps the character clear of moving bodies. It uses the normals at the start of the
/// tick, because at its end a thin body may be on the other side of the character.
void Mover::shove(Vec3& away) {
    const BodyId ground = ground_body();
    constexpr Real margin_max = Real(2);
    for (std::uint32_t i = 0; i < space.neighbours().size(); ++i) {
        const Neighbour& n = space.neighbour(i);
        if (!n.moves || n.body == ground) continue;
        const std::uint32_t body = w.row_of(n.body);
        const Real spin_rate = length(to<Real>(w.state.rows(w.m.body_velocity)[body].angular));
        const Real arm = length(feet - w.state.rows(w.m.body_pose)[body].position) + row.def.height;
        const Real margin = min(margin_max, skin * 2 + length(n.end.position - n.begin.position) +
                                                length(carried) + spin_rate * arm / Real(rate));
        const Vec3 at = feet;
        SpaceContact contacts[collide::Manifolds::max];
        std::uint32_t count = 0;
        space.for_each_contact(at, i, margin, /*at_end=*/false,
                               [&](const SpaceContact& c) { contacts[count++] = c; });
        for (std::uint32_t k = 0; k < count; ++k) {
            const SpaceContact& c = contacts[k];
            const auto missing = [&] {
                const Vec3 moved = n.end * inverse_mul(n.begin, c.point) - c.point;
                return dot<Real>(c.normal, moved - away) - (c.gap - skin);
            };
            if (n.kind == BodyKind::dynamic) {
                if (dot<Unit>(c.normal, up) < -half(unit_one)) continue; // it lies on the character's head
                if (missing() > Real{}) take_impact(c);
            }
            if (missing() > Real{}) away += scale<Real>(c.normal, missing());
        }
    }
}

void Mover::note_push(const SpaceHit& hit) {
    const Neighbour& n = space.neighbour(hit.neighbour);
    if (n.kind != BodyKind::dynamic || n.body == ground_body()) return;
    std::vector<CharacterPush>& pushes = scratch.pushes;
    for (const CharacterPush& p : pushes)
        if (p.body == n.body) return;
    pushes.push_back({n.body, hit.point, hit.normal});
}

/// Adds a force for this tick. The solver spreads it over the substeps, so that friction can hold a body if the force
/// is too weak.
void Mover::push_at(BodyId body, Vec3 point, Vec3 force) {
    const std::uint32_t at = w.row_of(body);
    BodyForce& sum = force_on(w, at);
    sum.force += force;
    sum.torque += cross(point - w.state.rows(w.m.body_pose)[at].position, force);
}

/// Accelerates the bodies that the character walks into to the wanted horizontal speed, with at most push_force each.
/// The force acts at the height of the body's centre of mass, within the range of the capsule, because on a face
/// parallel to the capsule a contact point may be at any height.
void Mover::apply_pushes() {
    const Vec3 wanted = level(row.input.velocity) + row.state.ground_velocity;
    for (const CharacterPush& p : scratch.pushes) {
        const UnitVec3 way = -flat(p.normal, up);
        const std::uint32_t body = w.row_of(p.body);
        const Real mass = w.mass_of(body).mass;
        const Real top = row.state.crouched != 0 ? row.def.crouch_height : row.def.height;
        const Real height = clamp(along(w.state.rows(w.m.body_pose)[body].position - feet), row.def.radius,
                                  top - row.def.radius);
        const Vec3 point = p.point + scale<Real>(up, height - along(p.point - feet));
        const Real closing = dot<Real>(way, wanted - velocity_of(p.body, point));
        if (way == UnitVec3{} || closing <= Real{} || mass == Real{}) continue;
        const Real needed = mass / mobility(w, p.body, point, way) * closing * Real(rate);
        wake(w, p.body);
        push_at(p.body, point, scale<Real>(way, min(needed, row.def.push_force)));
    }
}

/// Applies the character's weight to its ground. A sleeping body already had it when it fell asleep.
void Mover::weigh() {
    const BodyId ground = ground_body();
    if (!is_awake(w, w.row_of(ground))) return;
    push_at(ground, ground_point, scale<Real>(up, -(row.def.mass * row.def.gravity)));
}

} // namespace lockstone::sim
