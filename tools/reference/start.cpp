#include "reference/start.h"

#include <cmath>

namespace reference {

using lockstone::Error, lockstone::Result, lockstone::Status, lockstone::to_double;

Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator*(const Vec& a, double s) { return {a.x * s, a.y * s, a.z * s}; }
double dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec cross(const Vec& a, const Vec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
Turn operator*(const Turn& a, const Turn& b) {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
Turn conjugate(const Turn& q) { return {-q.x, -q.y, -q.z, q.w}; }
Vec rotate(const Turn& q, const Vec& v) {
    const Vec axis{q.x, q.y, q.z}, twice = cross(axis, v) * 2;
    return v + twice * q.w + cross(axis, twice);
}

namespace {

/// The error "body 3: has axis locks, which the thesis' engine lacks".
Error lacks(std::size_t body, const std::string& what) {
    return Error{"body " + std::to_string(body) + ": has " + what + ", which the thesis' engine lacks"};
}

Status check_shape(std::size_t body, const lockstone::ShapeDef& shape) {
    if (shape.one_way != 0) return lacks(body, "a one-way shape");
    if (shape.rolling_resistance != lockstone::Real{}) return lacks(body, "rolling resistance");
    if (shape.surface_velocity != lockstone::Vec3{}) return lacks(body, "a conveyor's surface");
    return {};
}

/// The inertia about the principal axes is mass times the squared radii of gyration.
void set_mass(const lockstone::SetMass& mass, BodyStart& start) {
    const double m = to_double(mass.mass.value);
    const Vec k = vec(mass.gyration.value);
    const auto inverse = [&](double radius) { return radius > 0 ? 1 / (m * radius * radius) : 0; };
    start.mass_inv = 1 / m;
    start.inertia_inv = {inverse(k.x), inverse(k.y), inverse(k.z)};
    start.principal = turn(mass.principal.value);
}

Result<StartedBody> read_body(const lockstone::World& world, std::size_t index, lockstone::BodyId id) {
    const lockstone::BodyDef def = world.body(id);
    if (def.locks != 0) return lacks(index, "axis locks");
    StartedBody body{.id = id, .start = {}, .local_center = {}, .shapes = {}};
    BodyStart& start = body.start;
    start.orientation = turn(def.pose.rotation);
    start.position = vec(def.pose.position);
    start.velocity = vec(def.linear_velocity), start.rotation = vec(def.angular_velocity);
    if (def.kind == lockstone::BodyKind::dynamic) {
        const lockstone::SetMass mass = world.mass_properties(id);
        set_mass(mass, start);
        body.local_center = vec(mass.center.value);
        start.position = start.position + rotate(start.orientation, body.local_center);
    }
    // exp(-c t) and d^t are the same decay if d = exp(-c).
    start.linear_damping = std::exp(-to_double(def.linear_damping));
    start.angular_damping = std::exp(-to_double(def.angular_damping));
    start.gravity_scale = to_double(def.gravity_scale);
    start.in_fields = def.enable_fields != 0;
    for (const lockstone::ShapeId shape : world.shapes(id)) {
        body.shapes.push_back(world.shape(shape));
        if (const Status good = check_shape(index, body.shapes.back()); !good) return good.error();
    }
    return body;
}

Result<Field> read_field(const lockstone::FieldDef& def) {
    if (def.kind == lockstone::FieldKind::fluid)
        return Error{"a fluid is nothing that the thesis' engine has"};
    if (def.region.kind != lockstone::RegionKind::everywhere || def.mask != 0xffffffffu)
        return Error{"a force field with a region or a mask is nothing that the thesis' engine has"};
    const Attraction kind = def.kind == lockstone::FieldKind::point_gravity ? Attraction::point_gravity
                            : def.kind == lockstone::FieldKind::spring      ? Attraction::spring
                                                                            : Attraction::uniform;
    return Field{kind, vec(def.center), to_double(def.strength), to_double(def.softening),
                 vec(def.acceleration)};
}

} // namespace

Result<Start> read_start(const lockstone::World& world) {
    if (world.vehicle_count() > 0) return Error{"the thesis' engine has no vehicles"};
    if (world.character_count() > 0) return Error{"the thesis' engine has no characters"};
    if (world.joint_count() > 0) return Error{"the thesis' engine has no joints"};
    Start start;
    for (const lockstone::BodyId id : world.bodies()) {
        Result<StartedBody> body = read_body(world, start.bodies.size(), id);
        if (!body) return body.error();
        start.bodies.push_back(std::move(*body));
    }
    for (std::uint32_t row = 0; row < world.field_count(); ++row) {
        const Result<Field> field = read_field(world.field(world.field_at(row)));
        if (!field) return field.error();
        start.fields.push_back(*field);
    }
    return start;
}

} // namespace reference
