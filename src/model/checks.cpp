#include "model/checks.h"

#include "base/text.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "model/fields.h"

namespace lockstone::sim {

using base::join;

bool within(Vec3 v, Real most) { return abs(v.x) <= most && abs(v.y) <= most && abs(v.z) <= most; }

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
    if (std::string e = check_ranges(d); !e.empty()) return e;
    const bool moves = d.linear_velocity != Vec3{} || d.angular_velocity != Vec3{};
    if (d.awake == 0 && d.kind == BodyKind::dynamic && moves)
        return "awake is 0, but linear_velocity or angular_velocity is not: what sleeps does not move";
    if (d.mass == Real{}) return {};
    return check_range("mass", d.mass, mass_min, mass_max, " kg, or 0 for that of the shapes");
}

/// Returns an empty text if this kind of body can have the geometry.
static std::string check_body_kind(const Geometry& g, BodyKind kind) {
    if (g.kind == ShapeKind::plane && kind != BodyKind::static_) return "a plane needs a static body";
    if ((g.kind == ShapeKind::mesh || g.kind == ShapeKind::height_field) && kind == BodyKind::dynamic)
        return join("a ", name_of(g.kind), " needs a static or kinematic body");
    const bool is_primitive = g.kind <= ShapeKind::box;
    if (is_primitive && g.scale != scale_one && kind != BodyKind::static_)
        return "a scaled primitive needs a static body";
    return {};
}

std::string check(const ShapeDef& d, BodyKind kind) {
    if (std::string e = validate(d.geometry); !e.empty()) return e;
    if (std::string e = check_body_kind(d.geometry, kind); !e.empty()) return e;
    return check_ranges(d);
}

static std::string check(const Region& r) {
    constexpr const char* names[] = {"region.half_extent.x", "region.half_extent.y", "region.half_extent.z"};
    for (int i = 0; i < 3; ++i) {
        const bool used = r.kind == RegionKind::box || (r.kind == RegionKind::sphere && i == 0);
        const Real least = used ? 0.001_r : Real{};
        if (std::string e = check_range(names[i], r.half_extent[i], least, Real(1000000), " m"); !e.empty())
            return e;
    }
    return {};
}

std::string check(const FieldDef& d) {
    if (std::string e = check_ranges(d); !e.empty()) return e;
    return check(d.region);
}

std::string check(const ExplosionDef& d) { return check_ranges(d); }

/// Checks the relations between the fields of an axis, for the axis with this index.
static std::string check_relations(const JointAxis& d, std::uint32_t index) {
    if (d.lower > d.upper)
        return join("lower is ", to_string(d.lower), ", more than upper, ", to_string(d.upper));
    if (d.spring == 1 && d.frequency == Real{}) return "frequency of a spring must be more than 0 Hz";
    if (index != about_y && index != about_z) return {};
    for (const auto& [what, value] : {std::pair("lower", d.lower), {"upper", d.upper}, {"target", d.target}})
        if (std::string e = check_range(what, value, -pi, pi, " rad"); !e.empty()) return e;
    return {};
}

std::string check(const JointAxis& d, std::uint32_t index) {
    if (std::string e = check_ranges(d); !e.empty()) return e;
    return check_relations(d, index);
}

std::string check(const JointDef& d) {
    if (std::string e = check_ranges(d); !e.empty()) return e;
    if (d.body_a && !within(d.frame_a.position, Real(1000000)))
        return "frame_a.position must be within 1000000 m of body_a's origin";
    for (std::uint32_t i = 0; i < joint_axis_count; ++i)
        if (std::string e = check_relations(d.axis[i], i); !e.empty()) return join("axis[", i, "].", e);
    return {};
}

} // namespace lockstone::sim
