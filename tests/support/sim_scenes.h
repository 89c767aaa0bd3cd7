// Worlds for tests of the simulation: short functions that add objects, and checks that name the first difference of
// two worlds.
#pragma once

#include "lockstone/math/convert.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "lockstone/world.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace lockstone::test::scene {

using D3 = std::array<double, 3>;

inline Real real(double x) { return quantize<Real>(x); }
inline Vec3 vec(double x, double y, double z) { return {real(x), real(y), real(z)}; }
inline Transform at(double x, double y, double z, Quat rotation = Quat::identity()) {
    return {vec(x, y, z), rotation};
}
/// A rotation about one of the axes by degrees.
inline Quat turned(UnitVec3 axis, double degrees) {
    return from_axis_angle(axis, real(degrees * 3.14159265358979323846 / 180));
}
inline constexpr UnitVec3 axis_x{unit_one, Unit{}, Unit{}}, axis_y{Unit{}, unit_one, Unit{}},
    axis_z{Unit{}, Unit{}, unit_one};

inline double length(D3 v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
inline D3 operator-(D3 a, D3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline D3 operator+(D3 a, D3 b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline D3 operator*(double s, D3 a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(D3 a, D3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline D3 position(const World& w, BodyId b) { return to_double(w.center_of_mass(b)); }
inline D3 velocity(const World& w, BodyId b) { return to_double(w.linear_velocity(b)); }
inline D3 spin(const World& w, BodyId b) { return to_double(w.angular_velocity(b)); }

template <class T> T made(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}
inline void done(const Status& status) {
    if (!status) throw std::runtime_error(status.error().message);
}

/// A definition with small tables, so that states are small.
inline WorldDef small_def() {
    WorldDef def = WorldDef::precise(); // most laws have bounds for eight substeps
    def.bodies_max = def.shapes_max = 64;
    def.contacts_max = 512;
    def.fields_max = 4;
    def.sleeping = 0; // a tested body must not fall asleep
    return def;
}
inline WorldDef drowsy_def() {
    WorldDef def = small_def();
    def.sleeping = 1;
    return def;
}
inline WorldDef weightless(WorldDef def = small_def()) {
    def.gravity = {};
    return def;
}

inline BodyId add(World& w, const BodyDef& body, const ShapeDef& shape) {
    const BodyId id = made(w.create_body(body));
    made(w.create_shape(id, shape));
    return id;
}
inline BodyId add_floor(World& w, const ShapeDef& surface = {}) {
    ShapeDef floor = surface;
    floor.geometry = plane();
    return add(w, {.kind = BodyKind::static_}, floor);
}
inline BodyId add_wall(World& w, const Transform& pose, Vec3 half_extent) {
    return add(w, {.kind = BodyKind::static_, .pose = pose}, {.geometry = box(half_extent)});
}
inline BodyId add_crate(World& w, const Transform& pose, double half = 0.5) {
    return add(w, {.pose = pose}, {.geometry = box(real(half), real(half), real(half))});
}
inline BodyId add_ball(World& w, const Transform& pose, double radius = 0.5, double restitution = 0) {
    return add(w, {.pose = pose}, {.geometry = sphere(real(radius)), .restitution = real(restitution)});
}

/// Boxes of 1 m, stacked.
inline std::vector<BodyId> add_stack(World& w, int height) {
    std::vector<BodyId> boxes;
    for (int i = 0; i < height; ++i) boxes.push_back(add_crate(w, at(0, 0.5 + i, 0)));
    return boxes;
}
/// A wall with `base` boxes of 1 m in the bottom row and one fewer in each row above.
inline std::vector<BodyId> add_pyramid(World& w, int base) {
    std::vector<BodyId> boxes;
    for (int row = 0; row < base; ++row)
        for (int i = 0; i < base - row; ++i)
            boxes.push_back(add_crate(w, at(1.02 * (i - (base - row - 1) / 2.0), 0.5 + row, 0)));
    return boxes;
}

inline constexpr double speed_step =
    1.0 / (1 << 19); ///< of an impulse over mass [m/s]: rounding leaves up to this speed at rest

/// The compliance of contacts between bodies: a load F on a contact between m1 and m2 sinks it by F / m * give, 1 / m =
/// 1 / m1 + 1 / m2. In the steady state of a soft step (Catto, Solver2D, 2024) each substep pushes as much as it
/// releases, so the contact is a spring of m (2 pi f)^2 at any damping. f is contact_hertz, at most 3 / 16 of the
/// substep rate. On a static body f is twice that, and the result a quarter. [s^2]
inline double give(const WorldDef& def) {
    const double omega = 2 * 3.14159265358979323846 *
                         std::min(to_double(def.contact_hertz), 3.0 / 16 * def.tick_rate * def.substeps);
    return 1 / (omega * omega);
}

/// The motion of a pile over time.
struct Rest {
    double drift = 0;       ///< greatest horizontal distance of a centre of mass from its start [m]
    double penetration = 0; ///< deepest contact of the last tick [m]
    double kinetic = 0;     ///< [J]
};
inline Rest rest_after(World& w, const std::vector<BodyId>& bodies, int ticks) {
    std::vector<D3> start;
    for (BodyId b : bodies) start.push_back(position(w, b));
    for (int t = 0; t < ticks; ++t) w.tick();
    Rest rest;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
        const D3 way = position(w, bodies[i]) - start[i];
        rest.drift = std::max(rest.drift, std::hypot(way[0], way[2]));
    }
    for (const World::ContactPoint& p : w.contacts())
        rest.penetration = std::max(rest.penetration, -to_double(p.separation));
    rest.kinetic = to_double(w.kinetic_energy());
    return rest;
}

/// Returns whether all bodies have equal places and velocities in both worlds. A world that lost a part of its state
/// has another hash at once, but only a different motion shows that the part is needed.
inline bool same_motion(const World& a, const World& b) {
    return std::ranges::equal(a.bodies(), b.bodies(), [&](BodyId in_a, BodyId in_b) {
        return a.pose(in_a) == b.pose(in_b) && a.linear_velocity(in_a) == b.linear_velocity(in_b) &&
               a.angular_velocity(in_a) == b.angular_velocity(in_b);
    });
}

/// Returns a text like "tick 118, column body.velocity, row 7, linear.x: 1 (raw 0x80000) against 2 (raw 0x100000)";
/// empty when the worlds are equal.
inline std::string difference(const World& left, const World& right) {
    const std::vector<Difference> found = State::diff(left.state(), right.state(), 1);
    if (found.empty() && left.hash() == right.hash()) return {};
    return "tick " + std::to_string(left.tick_count()) + ", " +
           (found.empty() ? std::string("hashes differ, but no row does") : to_string(found[0]));
}

} // namespace lockstone::test::scene
