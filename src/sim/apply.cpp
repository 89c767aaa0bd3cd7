// Commands: each is checked as a whole first, then applied; an error leaves every byte as it was.
#include "base/text.h"
#include "sim/data.h"

#include "lockstone/decimal.h"
#include "lockstone/math.h"

#include <algorithm>
#include <cstring>

namespace lockstone::sim {

namespace {

using Applied = World::Applied;
using base::join;

// ---- checks --------------------------------------------------------------------------------------------------

constexpr Real position_max = Real(1000000000);
constexpr Real speed_max = Real(500);
constexpr Real spin_max = Real(4095);
constexpr Real force_max = Real(2000000000);
constexpr Real mass_min = 0.001_r, mass_max = Real(1000000000); ///< [kg]: the sum of two is a Real

bool within(Vec3 v, Real most) { return abs(v.x) <= most && abs(v.y) <= most && abs(v.z) <= most; }

/// Empty when good.
std::string check_unit(const char* what, Quat q) {
    const auto square = [](Unit u) { return std::int64_t{u.raw} * u.raw; };
    const std::int64_t norm =
        (square(q.x) >> 2) + (square(q.y) >> 2) + (square(q.z) >> 2) + (square(q.w) >> 2);
    constexpr std::int64_t one = std::int64_t{1} << 58;
    if (norm > one - (one >> 10) && norm < one + (one >> 10)) return {};
    return join(what, " is not a unit quaternion: use Quat::identity(), from_axis_angle or normalized");
}

std::string check_pose(const char* what, const Transform& pose, Real most) {
    if (!within(pose.position, most))
        return join(what, ".position must be within ", floor_to_int(most), " m of the origin");
    return check_unit(what, pose.rotation);
}

std::string check_range(const char* what, Real value, Real low, Real high, const char* unit) {
    if (value >= low && value <= high) return {};
    return join(what, " is ", to_string(value), ", must be ", to_string(low), " to ", to_string(high), unit);
}

std::string check(const BodyDef& d) {
    if (d.kind > BodyKind::dynamic)
        return join("kind is ", static_cast<std::uint32_t>(d.kind), ", must be 0 to 2");
    if (d.locks > 63) return join("locks is ", d.locks, ", must be a sum of AxisLock bits, at most 63");
    if (d.gyroscopic > 1) return join("gyroscopic is ", d.gyroscopic, ", must be 0 or 1");
    if (d.bullet > 1) return join("bullet is ", d.bullet, ", must be 0 or 1");
    if (d.enable_fields > 1) return join("enable_fields is ", d.enable_fields, ", must be 0 or 1");
    if (std::string e = check_pose("pose", d.pose, position_max); !e.empty()) return e;
    if (length(d.linear_velocity) > speed_max) return "linear_velocity must be at most 500 m/s long";
    if (!within(d.angular_velocity, spin_max))
        return "angular_velocity must be within 4095 rad/s on each axis";
    if (std::string e = check_range("linear_damping", d.linear_damping, Real{}, Real(1000), " 1/s");
        !e.empty())
        return e;
    if (std::string e = check_range("angular_damping", d.angular_damping, Real{}, Real(1000), " 1/s");
        !e.empty())
        return e;
    if (std::string e = check_range("gravity_scale", d.gravity_scale, Real(-100), Real(100), ""); !e.empty())
        return e;
    if (d.mass == Real{}) return {};
    return check_range("mass", d.mass, mass_min, mass_max, " kg, or 0 for that of the shapes");
}

/// Empty when the kind of body can have the geometry.
std::string check_body_kind(const Geometry& g, BodyKind kind) {
    if (g.kind == ShapeKind::plane && kind != BodyKind::static_) return "a plane needs a static body";
    if ((g.kind == ShapeKind::mesh || g.kind == ShapeKind::height_field) && kind == BodyKind::dynamic)
        return join("a ", name_of(g.kind), " needs a static or kinematic body");
    const bool is_primitive = g.kind <= ShapeKind::box;
    if (is_primitive && g.scale != scale_one && kind != BodyKind::static_)
        return "a scaled primitive needs a static body";
    return {};
}

std::string check_surface(Real friction, Real restitution, Real rolling_resistance, Vec3 surface_velocity) {
    if (std::string e = check_range("friction", friction, Real{}, Real(4), ""); !e.empty()) return e;
    if (std::string e = check_range("restitution", restitution, Real{}, Real(1), ""); !e.empty()) return e;
    if (std::string e = check_range("rolling_resistance", rolling_resistance, Real{}, Real(1), " m");
        !e.empty())
        return e;
    if (!within(surface_velocity, Real(100))) return "surface_velocity must be within 100 m/s on each axis";
    return {};
}

std::string check(const ShapeDef& d, BodyKind kind) {
    if (std::string e = validate(d.geometry); !e.empty()) return e;
    if (std::string e = check_body_kind(d.geometry, kind); !e.empty()) return e;
    if (std::string e = check_pose("local", d.local, Real(64)); !e.empty()) return e;
    if (std::string e = check_range("density", d.density, 0.01_r, Real(100000), " kg/m^3"); !e.empty())
        return e;
    if (std::string e = check_surface(d.friction, d.restitution, d.rolling_resistance, d.surface_velocity);
        !e.empty())
        return e;
    for (const auto& [what, rule] :
         {std::pair("friction_mix", d.friction_mix), {"restitution_mix", d.restitution_mix}})
        if (rule > Mix::maximum)
            return join(what, " is ", static_cast<std::uint32_t>(rule), ", must be 0 to 4");
    if (d.sensor > 1) return join("sensor is ", d.sensor, ", must be 0 or 1");
    if (d.one_way > 1) return join("one_way is ", d.one_way, ", must be 0 or 1");
    return {};
}

std::string check(const FieldDef& d) {
    if (d.kind > FieldKind::spring)
        return join("kind is ", static_cast<std::uint32_t>(d.kind), ", must be 0 or 1");
    if (d.reserved != 0) return "reserved must be 0";
    if (!within(d.center, position_max)) return "center must be within 1e9 m of the origin";
    if (std::string e = check_range("strength", d.strength, Real(-100000000), Real(100000000), "");
        !e.empty())
        return e;
    return check_range("softening", d.softening, Real{}, Real(30000), " m");
}

template <class Tag> std::string text_of(Id<Tag> id) { return join(id.index, ":", id.generation); }

Error dead_body(const char* command, BodyId id) {
    return {join(command, ": body ", text_of(id), " is not alive: destroyed, null, or of another time")};
}
Error dead_shape(const char* command, ShapeId id) {
    return {join(command, ": shape ", text_of(id), " is not alive: destroyed, null, or of another time")};
}

// ---- slots ---------------------------------------------------------------------------------------------------

/// A slot for a new object in row `row`; the caller has checked that there is room.
std::uint32_t take_slot(State& state, TableId table, Column<Slot> column, std::uint32_t& first_free,
                        std::uint32_t row) {
    std::uint32_t index = first_free;
    if (index == 0) {
        const std::uint32_t count = state.count(table);
        state.resize(table, count + 1);
        index = count + 1;
        state.rows(column)[index - 1].generation = 1;
    }
    Slot& slot = state.rows(column)[index - 1];
    first_free = slot.next_free;
    slot.row = row;
    slot.next_free = 0;
    slot.alive = 1;
    return index;
}

void free_slot(std::span<Slot> slots, std::uint32_t index, std::uint32_t& first_free) {
    Slot& slot = slots[index - 1];
    slot.alive = 0;
    slot.row = 0;
    // Generations wrap after 2^32 lives of one slot; 0 stays null.
    slot.generation = slot.generation == 0xffffffffu ? 1 : slot.generation + 1;
    slot.next_free = first_free;
    first_free = index;
}

/// Moves the last row of a table into `row` and drops the last.
void remove_row(State& state, TableId table, std::uint32_t row) {
    const std::uint32_t last = state.count(table) - 1;
    const std::span<const ColumnInfo> columns = state.layout().columns();
    for (std::uint32_t c = 0; c < columns.size() && row != last; ++c) {
        if (columns[c].table != table.index) continue;
        const std::span<std::byte> bytes = state.bytes(c);
        std::memcpy(bytes.data() + std::size_t{row} * columns[c].row_size,
                    bytes.data() + std::size_t{last} * columns[c].row_size, columns[c].row_size);
    }
    state.resize(table, last);
}

// ---- mass ----------------------------------------------------------------------------------------------------

/// Moves the centre of mass within a body whose origin stays where it is.
void set_mass(Data& w, std::uint32_t row, const BodyMass& fresh) {
    BodyMass& mass = w.state.rows(w.m.body_mass)[row];
    const Vec3 moved = fresh.center - mass.center;
    mass = fresh;
    if (moved == Vec3{}) return;
    Transform& pose = w.state.rows(w.m.body_pose)[row];
    Velocity& velocity = w.state.rows(w.m.body_velocity)[row];
    const Vec3 arm = rotate(pose.rotation, moved);
    pose.position += arm;
    velocity.linear += cross<Speed>(velocity.angular, arm);
}

/// How far a body's shapes reach from its origin: stands in for the gyration radius of one that nothing turns, so that
/// the solver's rows of its contacts stay within their format.
Real reach_of(Data& w, const BodyInfo& info) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Real reach = Real(1);
    for (std::uint32_t slot = info.first_shape; slot != 0; slot = shapes[slots[slot - 1].row].next_shape) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        if (shape.geometry.kind == ShapeKind::plane) continue;
        const shapes::Extent e = shapes::extent_of(solid_of(w, shape));
        reach = max(reach, to<Real>(length(max(abs(e.lower), abs(e.upper)))) + length(shape.local.position));
    }
    return reach;
}

/// Sums up the shapes of a body. The body's origin stays where it is, its centre of mass moves.
void update_mass(Data& w, std::uint32_t row) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const BodyInfo& info = w.state.rows(w.m.body_info)[row];
    if (info.mass_fixed != 0) return;
    std::vector<MassPart>& parts = w.scratch.mass_parts;
    parts.clear();
    for (std::uint32_t slot = info.first_shape; slot != 0; slot = shapes[slots[slot - 1].row].next_shape) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        if (shape.sensor == 0)
            parts.push_back({shapes::mass_properties(solid_of(w, shape), shape.density), shape.local});
    }
    std::reverse(parts.begin(), parts.end()); // in order of creation
    const MassProperties total = combine(parts);
    const PrincipalGyration principal = principal_gyration(total);
    BodyMass mass{};
    mass.center = total.center;
    mass.gyration = principal.radii;
    mass.principal = principal.axes;
    // Without shapes: a ball of 1 kg with a gyration radius of 1 m.
    if (total.mass == Real{}) {
        const Real radius = info.kind == BodyKind::dynamic ? Real(1) : reach_of(w, info);
        mass.gyration = {radius, radius, radius};
        mass.principal = Quat::identity();
    }
    if (info.kind == BodyKind::dynamic) {
        const Real from_shapes = total.mass == Real{} ? Real(1) : clamp(total.mass, mass_min, mass_max);
        mass.mass = info.mass_override != Real{} ? info.mass_override : from_shapes;
    }
    set_mass(w, row, mass);
}

Vec3 center_offset(const Data& w, std::uint32_t row, Quat rotation) {
    return rotate(rotation, w.state.rows(w.m.body_mass)[row].center);
}

/// Velocity changes by an impulse [N s] and an angular impulse [N m s] about the centre of mass.
void push(Data& w, std::uint32_t row, Vec3 linear, Vec3 angular) {
    const BodyMass& mass = w.state.rows(w.m.body_mass)[row];
    if (mass.mass == Real{}) return;
    const std::uint32_t locks = w.state.rows(w.m.body_info)[row].locks;
    Velocity& velocity = w.state.rows(w.m.body_velocity)[row];
    const Rotation axes = to_rotation(w.state.rows(w.m.body_pose)[row].rotation * mass.principal);
    const Vec3 local = mul_transposed<Real>(axes, angular / mass.mass);
    const auto turned = [](Real l, Real k) { return l / k / k; };
    const Vec3 spin =
        lockstone::mul<Real>(axes, Vec3{turned(local.x, mass.gyration.x), turned(local.y, mass.gyration.y),
                                        turned(local.z, mass.gyration.z)});
    const Vec3 dv = linear / mass.mass;
    for (int i = 0; i < 3; ++i) {
        if (!((locks >> i) & 1u)) velocity.linear[i] = velocity.linear[i] + to<Speed>(dv[i]);
        if (!((locks >> (3 + i)) & 1u)) velocity.angular[i] = velocity.angular[i] + to<Speed>(spin[i]);
    }
}

// ---- one function a command ------------------------------------------------------------------------------------

struct Applier {
    Data& w;

    Result<Applied> operator()(const CreateBody& c) {
        if (std::string e = check(c.def); !e.empty()) return Error{"create_body: " + e};
        const std::uint32_t row = w.state.count(w.m.bodies);
        if (row == w.state.capacity(w.m.bodies))
            return Error{join("create_body: the world is full: bodies_max is ", row)};
        Header& h = w.header();
        const std::uint32_t index = take_slot(w.state, w.m.body_slots, w.m.body_slot, h.body_free, row);
        const BodyId id{index, w.state.rows(w.m.body_slot)[index - 1].generation};
        w.state.resize(w.m.bodies, row + 1);
        const BodyDef& d = c.def;
        w.state.rows(w.m.body_info)[row] = {
            id, d.kind, d.locks,          d.gyroscopic,      d.enable_fields, d.bullet, 0,
            0,  0,      d.linear_damping, d.angular_damping, d.gravity_scale, d.mass,   d.user_key};
        w.state.rows(w.m.body_pose)[row] = {d.pose.position, normalized(d.pose.rotation)};
        w.state.rows(w.m.body_velocity)[row] = {to<Speed>(d.linear_velocity), to<Speed>(d.angular_velocity)};
        update_mass(w, row);
        return Applied{id, {}, {}};
    }

    Result<Applied> operator()(const DestroyBody& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("destroy_body", c.body);
        while (const std::uint32_t slot = w.state.rows(w.m.body_info)[row].first_shape)
            remove_shape(row, slot);
        const std::uint32_t last = w.state.count(w.m.bodies) - 1;
        const BodyId moved = w.state.rows(w.m.body_info)[last].id;
        remove_row(w.state, w.m.bodies, row);
        w.state.rows(w.m.body_slot)[moved.index - 1].row = row;
        free_slot(w.state.rows(w.m.body_slot), c.body.index, w.header().body_free);
        forget_filters_of(c.body);
        w.scratch.structure_stale = true;
        return Applied{};
    }

    Result<Applied> operator()(const CreateShape& c) {
        const std::uint32_t body_row = w.row_of(c.body);
        if (body_row == Data::dead) return dead_body("create_shape", c.body);
        BodyInfo& info = w.state.rows(w.m.body_info)[body_row];
        if (std::string e = check(c.def, info.kind); !e.empty()) return Error{"create_shape: " + e};
        if (const Result<shapes::Solid> solid = w.scratch.solids.resolve(c.def.geometry); !solid)
            return Error{"create_shape: " + solid.error().message};
        const std::uint32_t row = w.state.count(w.m.shapes);
        if (row == w.state.capacity(w.m.shapes))
            return Error{join("create_shape: the world is full: shapes_max is ", row)};
        const std::uint32_t index =
            take_slot(w.state, w.m.shape_slots, w.m.shape_slot, w.header().shape_free, row);
        const ShapeId id{index, w.state.rows(w.m.shape_slot)[index - 1].generation};
        w.state.resize(w.m.shapes, row + 1);
        const ShapeDef& d = c.def;
        w.state.rows(w.m.shape)[row] = {id,
                                        c.body,
                                        d.geometry,
                                        info.first_shape,
                                        d.material,
                                        {d.local.position, normalized(d.local.rotation)},
                                        d.density,
                                        d.friction,
                                        d.restitution,
                                        d.rolling_resistance,
                                        d.surface_velocity,
                                        d.friction_mix,
                                        d.restitution_mix,
                                        d.category,
                                        d.mask,
                                        d.group,
                                        d.sensor,
                                        d.one_way,
                                        0,
                                        d.user_key};
        info.first_shape = index;
        ++info.shape_count;
        update_mass(w, body_row);
        w.scratch.structure_stale = true;
        return Applied{{}, id, {}};
    }

    Result<Applied> operator()(const DestroyShape& c) {
        const std::uint32_t row = w.row_of(c.shape);
        if (row == Data::dead) return dead_shape("destroy_shape", c.shape);
        const std::uint32_t body_row = w.row_of(w.state.rows(w.m.shape)[row].body);
        remove_shape(body_row, c.shape.index);
        update_mass(w, body_row);
        return Applied{};
    }

    Result<Applied> operator()(const CreateField& c) {
        if (std::string e = check(c.def); !e.empty()) return Error{"create_field: " + e};
        const std::uint32_t row = w.state.count(w.m.fields);
        if (row == w.state.capacity(w.m.fields))
            return Error{join("create_field: the world is full: fields_max is ", row)};
        const std::uint32_t index =
            take_slot(w.state, w.m.field_slots, w.m.field_slot, w.header().field_free, row);
        const FieldId id{index, w.state.rows(w.m.field_slot)[index - 1].generation};
        w.state.resize(w.m.fields, row + 1);
        w.state.rows(w.m.field)[row] = {id, c.def};
        return Applied{{}, {}, id};
    }

    Result<Applied> operator()(const DestroyField& c) {
        const std::uint32_t row = w.row_of(c.field);
        if (row == Data::dead) return Error{join("destroy_field: field ", text_of(c.field), " is not alive")};
        const FieldId moved = w.state.rows(w.m.field)[w.state.count(w.m.fields) - 1].id;
        remove_row(w.state, w.m.fields, row);
        w.state.rows(w.m.field_slot)[moved.index - 1].row = row;
        free_slot(w.state.rows(w.m.field_slot), c.field.index, w.header().field_free);
        return Applied{};
    }

    Result<Applied> operator()(const SetPose& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("set_pose", c.body);
        if (std::string e = check_pose("pose", c.pose, position_max); !e.empty())
            return Error{"set_pose: " + e};
        const Quat rotation = normalized(c.pose.rotation);
        w.state.rows(w.m.body_pose)[row] = {c.pose.position + center_offset(w, row, rotation), rotation};
        w.scratch.structure_stale = true;
        return Applied{};
    }

    Result<Applied> operator()(const SetVelocity& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("set_velocity", c.body);
        if (length(c.linear) > speed_max) return Error{"set_velocity: linear must be at most 500 m/s long"};
        if (!within(c.angular, spin_max))
            return Error{"set_velocity: angular must be within 4095 rad/s on each axis"};
        w.state.rows(w.m.body_velocity)[row] = {to<Speed>(c.linear), to<Speed>(c.angular)};
        return Applied{};
    }

    Result<Applied> operator()(const AddForce& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("add_force", c.body);
        if (!within(c.force, force_max) || !within(c.torque, force_max))
            return Error{"add_force: force and torque must be within 2e9 on each axis"};
        BodyForce& force = w.state.rows(w.m.body_force)[row];
        force.force += c.force;
        force.torque += c.torque;
        return Applied{};
    }

    Result<Applied> operator()(const AddForceAt& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("add_force_at", c.body);
        if (!within(c.force, force_max) || !within(c.point, position_max))
            return Error{"add_force_at: force must be within 2e9 N, point within 1e9 m on each axis"};
        BodyForce& force = w.state.rows(w.m.body_force)[row];
        force.force += c.force;
        force.torque += cross(c.point - w.state.rows(w.m.body_pose)[row].position, c.force);
        return Applied{};
    }

    Result<Applied> operator()(const AddImpulse& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("add_impulse", c.body);
        if (!within(c.linear, force_max) || !within(c.angular, force_max))
            return Error{"add_impulse: linear and angular must be within 2e9 on each axis"};
        push(w, row, c.linear, c.angular);
        return Applied{};
    }

    Result<Applied> operator()(const AddImpulseAt& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("add_impulse_at", c.body);
        if (!within(c.impulse, force_max) || !within(c.point, position_max))
            return Error{"add_impulse_at: impulse must be within 2e9 N s, point within 1e9 m on each axis"};
        push(w, row, c.impulse, cross(c.point - w.state.rows(w.m.body_pose)[row].position, c.impulse));
        return Applied{};
    }

    Result<Applied> operator()(const SetBodyParameters& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("set_body_parameters", c.body);
        BodyDef d{};
        d.linear_damping = c.linear_damping;
        d.angular_damping = c.angular_damping;
        d.gravity_scale = c.gravity_scale;
        d.locks = c.locks;
        d.gyroscopic = c.gyroscopic;
        d.bullet = c.bullet;
        if (std::string e = check(d); !e.empty()) return Error{"set_body_parameters: " + e};
        BodyInfo& info = w.state.rows(w.m.body_info)[row];
        info.linear_damping = c.linear_damping;
        info.angular_damping = c.angular_damping;
        info.gravity_scale = c.gravity_scale;
        info.locks = c.locks;
        info.gyroscopic = c.gyroscopic;
        info.bullet = c.bullet;
        return Applied{};
    }

    Result<Applied> operator()(const SetMaterial& c) {
        const std::uint32_t row = w.row_of(c.shape);
        if (row == Data::dead) return dead_shape("set_material", c.shape);
        if (std::string e =
                check_surface(c.friction, c.restitution, c.rolling_resistance, c.surface_velocity);
            !e.empty())
            return Error{"set_material: " + e};
        ShapeRow& shape = w.state.rows(w.m.shape)[row];
        shape.friction = c.friction;
        shape.restitution = c.restitution;
        shape.rolling_resistance = c.rolling_resistance;
        shape.surface_velocity = c.surface_velocity;
        return Applied{};
    }

    Result<Applied> operator()(const SetFilter& c) {
        const std::uint32_t row = w.row_of(c.shape);
        if (row == Data::dead) return dead_shape("set_filter", c.shape);
        ShapeRow& shape = w.state.rows(w.m.shape)[row];
        shape.category = c.category;
        shape.mask = c.mask;
        shape.group = c.group;
        return Applied{};
    }

    Result<Applied> operator()(const SetPairFilter& c) {
        for (BodyId body : {c.a, c.b})
            if (w.row_of(body) == Data::dead) return dead_body("set_pair_filter", body);
        if (c.a == c.b) return Error{"set_pair_filter: a and b are the same body"};
        if (c.collide > 1) return Error{join("set_pair_filter: collide is ", c.collide, ", must be 0 or 1")};
        const PairFilterRow fresh{std::min(c.a, c.b), std::max(c.a, c.b)};
        const std::span<PairFilterRow> rows = w.state.rows(w.m.pair_filter);
        const std::uint32_t count = static_cast<std::uint32_t>(rows.size());
        const auto at = std::lower_bound(rows.begin(), rows.end(), fresh);
        const std::uint32_t index = static_cast<std::uint32_t>(at - rows.begin());
        const bool is_there = at != rows.end() && *at == fresh;
        if (is_there == (c.collide == 0)) return Applied{};
        if (is_there) {
            std::copy(at + 1, rows.end(), at);
            w.state.resize(w.m.pair_filters, count - 1);
            return Applied{};
        }
        if (count == w.state.capacity(w.m.pair_filters))
            return Error{join("set_pair_filter: the world is full: pair_filters_max is ", count)};
        w.state.resize(w.m.pair_filters, count + 1);
        const std::span<PairFilterRow> wider = w.state.rows(w.m.pair_filter);
        std::copy_backward(wider.begin() + index, wider.end() - 1, wider.end());
        wider[index] = fresh;
        return Applied{};
    }

    Result<Applied> operator()(const SetMass& c) {
        const std::uint32_t row = w.row_of(c.body);
        if (row == Data::dead) return dead_body("set_mass", c.body);
        BodyInfo& info = w.state.rows(w.m.body_info)[row];
        if (c.mass == Real{}) {
            info.mass_fixed = 0;
            update_mass(w, row);
            return Applied{};
        }
        if (info.kind != BodyKind::dynamic) return Error{"set_mass: only a dynamic body has a mass"};
        if (std::string e =
                check_range("mass", c.mass, mass_min, mass_max, " kg, or 0 for that of the shapes");
            !e.empty())
            return Error{"set_mass: " + e};
        if (!within(c.center, Real(64))) return Error{"set_mass: center must be within 64 m on each axis"};
        for (int i = 0; i < 3; ++i)
            if (std::string e = check_range("gyration", c.gyration[i], mass_min, Real(100), " m"); !e.empty())
                return Error{"set_mass: " + e};
        if (std::string e = check_unit("principal", c.principal); !e.empty()) return Error{"set_mass: " + e};
        info.mass_fixed = 1;
        set_mass(w, row, {c.mass, c.center, c.gyration, normalized(c.principal)});
        w.scratch.structure_stale = true;
        return Applied{};
    }

    Result<Applied> operator()(const SetGravity& c) {
        if (!within(c.gravity, Real(1000)))
            return Error{"set_gravity: gravity must be within 1000 m/s^2 on each axis"};
        w.header().gravity = c.gravity;
        return Applied{};
    }

    Result<Applied> operator()(const WriteGame& c) {
        if (c.column >= w.m.game.size())
            return Error{join("write_game: game column ", c.column, " does not exist, the schema has ",
                              w.m.game.size())};
        const GameSchema::Entry& entry = w.schema.entries()[c.column];
        if (c.size > c.data.size() || c.offset > entry.row_size || c.size > entry.row_size - c.offset)
            return Error{join("write_game: ", c.size, " bytes at ", c.offset, " do not fit a row of ",
                              entry.name, ", which has ", entry.row_size)};
        const std::uint32_t row = entry.per_body ? w.row_of(c.body) : 0;
        if (row == Data::dead) return dead_body("write_game", c.body);
        const std::uint32_t column = w.m.game[c.column];
        const std::span<std::byte> bytes =
            w.state.bytes(column).subspan(std::size_t{row} * entry.row_size, entry.row_size);
        // Through the canonical form, so that a piece may end inside a field on any byte order.
        std::vector<std::byte>& canonical = w.scratch.canonical_row;
        canonical.clear();
        append_canonical(bytes, entry.leaves, canonical);
        std::memcpy(canonical.data() + c.offset, c.data.data(), c.size);
        read_canonical(canonical, entry.leaves, bytes);
        return Applied{};
    }

    void forget_filters_of(BodyId body) {
        const std::span<PairFilterRow> rows = w.state.rows(w.m.pair_filter);
        const auto end = std::remove_if(
            rows.begin(), rows.end(), [body](const PairFilterRow& r) { return r.a == body || r.b == body; });
        w.state.resize(w.m.pair_filters, static_cast<std::uint32_t>(end - rows.begin()));
    }

    void remove_shape(std::uint32_t body_row, std::uint32_t slot) {
        const std::span<Slot> slots = w.state.rows(w.m.shape_slot);
        const std::span<ShapeRow> shapes = w.state.rows(w.m.shape);
        BodyInfo& info = w.state.rows(w.m.body_info)[body_row];
        const std::uint32_t row = slots[slot - 1].row;
        std::uint32_t* link = &info.first_shape;
        while (*link != slot) link = &shapes[slots[*link - 1].row].next_shape;
        *link = shapes[row].next_shape;
        --info.shape_count;
        const ShapeId moved = shapes.back().id;
        remove_row(w.state, w.m.shapes, row);
        slots[moved.index - 1].row = row;
        free_slot(slots, slot, w.header().shape_free);
        w.scratch.structure_stale = true;
    }
};

} // namespace

Result<World::Applied> apply(Data& w, const Command& command) {
    Result<Applied> result = std::visit(Applier{w}, command);
    if (!result) return result;
    ++w.header().commands;
    if (w.journal != nullptr) w.journal->on_command(w.header().tick, command);
    return result;
}

} // namespace lockstone::sim
