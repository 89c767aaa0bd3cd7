#include "solve/joints/joint_parts.h"

#include "lockstone/math/math.h"
#include "solve/joints/joint_work.h"

#include <algorithm>

namespace lockstone::solve {

// ---- angles -------------------------------------------------------------------------------------------------------

Real twist_between(Quat a, Quat b, Real near) {
    const Quat q = conjugate(a) * b;
    const Real principal = atan2(to<Real>(q.x), to<Real>(q.w)) * 2, off = near - principal;
    if (off < Real(3) && off > Real(-3)) return principal; // off by less than a half turn
    const std::int64_t turns = floor_to_int(off / two_pi + half(Real(1)));
    return principal + two_pi * turns;
}

Vec3 orientation_between(Quat a, Quat b) {
    const Quat q = b * conjugate(a);
    const Vec3 twice = Vec3{to<Real>(q.x), to<Real>(q.y), to<Real>(q.z)} * Real(2);
    return q.w.raw < 0 ? -twice : twice;
}

Vec3 target_between(Quat a, Quat b, Vec3 target) {
    const Quat aim = integrate_rotation(Quat::identity(), target);
    const Quat q = normalized((conjugate(a) * b) * conjugate(aim));
    const Vec3 v{to<Real>(q.x), to<Real>(q.y), to<Real>(q.z)};
    const Real sine = length(v);
    // angle / sine tends to 2
    if (sine < decimal<Real>("0.0001")) return q.w.raw < 0 ? v * Real(-2) : v * Real(2);
    const Real half_angle = q.w.raw < 0 ? atan2(-sine, -to<Real>(q.w)) : atan2(sine, to<Real>(q.w));
    return v * (half_angle * 2 / sine);
}

Real angle_y_between(const Rotation& a, const Rotation& b) {
    return atan2(-dot<Real>(b.x, a.z), dot<Real>(b.x, a.x));
}
Real angle_z_between(const Rotation& a, const Rotation& b) {
    return atan2(dot<Real>(b.x, a.y), dot<Real>(b.x, a.x));
}
Real swing_between(const Rotation& a, const Rotation& b) {
    return atan2(length(to<Real>(cross<Unit>(a.x, b.x))), dot<Real>(a.x, b.x));
}

// ---- Jacobians ----------------------------------------------------------------------------------------------------

namespace {

constexpr int lever_bits = Length::fraction_bits;
constexpr std::int64_t arm_max = std::int64_t{1} << 31;

/// Fraction bits of directions and of gradients, whose components are up to 8.
constexpr int direction_bits = row_bits;

struct Direction {
    std::int64_t m[3]; ///< direction_bits, clamped to 2^31
};

Direction direction_of(Vec3 v) {
    Direction d{};
    for (int i = 0; i < 3; ++i)
        d.m[i] = std::clamp(shift_right_rounded(v[i].raw, Real::fraction_bits - direction_bits), -arm_max,
                            arm_max);
    return d;
}

/// lever x d with lever_bits; the lever is clamped at 128 m.
void arm_of(Vec3 lever, const Direction& d, std::int64_t out[3]) {
    std::int64_t r[3];
    for (int i = 0; i < 3; ++i)
        r[i] = std::clamp(shift_right_rounded(lever[i].raw, Real::fraction_bits - lever_bits), -arm_max,
                          arm_max);
    // 2^31 times 2^31, twice
    const auto entry = [&](int i, int j) {
        const std::int64_t wide =
            shift_right_rounded(r[i] * (d.m[j] >> 1) - r[j] * (d.m[i] >> 1), direction_bits - 1);
        return std::clamp(wide, -arm_max, arm_max);
    };
    out[0] = entry(1, 2), out[1] = entry(2, 0), out[2] = entry(0, 1);
}

Scaled3 as_scaled(const Direction& d) { return {{d.m[0], d.m[1], d.m[2]}, direction_bits}; }

/// Row that pulls a point of each body; each body has its own direction.
WideRow linear_row(const JointSide& a, Vec3 lever_a, Vec3 da, const JointSide& b, Vec3 lever_b, Vec3 db) {
    WideRow row{};
    std::int64_t arm[3];
    if (a.body->moves) {
        const Direction d = direction_of(da);
        row.da = as_scaled(d);
        arm_of(lever_a, d, arm);
        row.xa = turning(*a.body, arm, lever_bits);
    }
    if (b.body->moves) {
        const Direction d = direction_of(db);
        row.db = as_scaled(d);
        arm_of(lever_b, d, arm);
        row.xb = turning(*b.body, arm, lever_bits);
    }
    return row;
}

/// Row that turns each body about its own axis.
WideRow angular_row(const BodyInertia& a, Vec3 axis_a, const BodyInertia& b, Vec3 axis_b) {
    WideRow row{};
    if (a.moves) row.xa = turning(a, direction_of(axis_a).m, direction_bits);
    if (b.moves) row.xb = turning(b, direction_of(axis_b).m, direction_bits);
    return row;
}

Vec3 world_axis(int i) {
    Vec3 e{};
    e[i] = Real(1);
    return e;
}
Vec3 axis_of(const Rotation& r, int i) { return to<Real>(i == 0 ? r.x : i == 1 ? r.y : r.z); }

RowValue between(Real position, Vec3 axis, const JointPlace& p) {
    return {position, Real{}, angular_row(*p.a.body, -axis, *p.b.body, axis), axis, false};
}

RowValue along(const JointPlace& p, int i) {
    const Vec3 e = axis_of(p.a.axes, i);
    return {dot(e, p.s), dot(e, p.arc_in_a), linear_row(p.a, p.a.lever + p.s, -e, p.b, p.b.lever, e), e,
            true};
}

RowValue point(const JointPlace& p, int i) {
    const Vec3 e = world_axis(i);
    return {p.s[i], p.arc[i], linear_row(p.a, p.a.lever, -e, p.b, p.b.lever, e), e, true};
}

/// Lock of xB to the plane perpendicular to `normal`. With sign +: C = xB . normal. The gradient xB x normal vanishes
/// if xB points along the normal, and a row built from a tiny gradient would spin the bodies without bound. Near that
/// pose, the row turns xB back towards xA the shorter way, about A's own axis.
RowValue plane(const JointPlace& p, int about, UnitVec3 normal, Real sign) {
    const UnitVec3 xa = p.a.axes.x, xb = p.b.axes.x;
    const Real near = decimal<Real>("0.7"), out = dot<Real>(xb, normal) * sign;
    const bool steers = p.def->kind == JointKind::wheel ||
                        p.def->axis[about == 1 ? about_z : about_y].mode != AxisMode::locked;
    if (steers ? abs(out) < near : dot<Real>(xa, xb) > near)
        return between(out, to<Real>(cross<Unit>(xb, normal)) * sign, p);
    const Vec3 axis = axis_of(p.a.axes, about);
    if (steers) return between(out, axis, p);
    const UnitVec3 turn = normalized_or(cross<Unit>(xa, xb), p.a.axes.y);
    return between(dot<Real>(to<Real>(turn), axis) * swing_between(p.a.axes, p.b.axes), axis, p);
}

/// atan2(a, b) with a = xB . u, b = xB . xA: gradient xB x (b u - a xA) / (a^2 + b^2).
RowValue angle(const JointPlace& p, Real position, Vec3 u) {
    const Vec3 xa = to<Real>(p.a.axes.x), xb = to<Real>(p.b.axes.x);
    const Real a = dot(xb, u), b = dot(xb, xa);
    const Real n = max(mul_add(a, a, b * b), decimal<Real>("0.015625"));
    return between(position, cross(xb, (u * b - xa * a) / n), p);
}

RowValue swing(const JointPlace& p) {
    const Vec3 n = to<Real>(normalized(cross<Unit>(p.a.axes.x, p.b.axes.x)));
    return between(swing_between(p.a.axes, p.b.axes), n, p);
}

/// |v|^2 minus its part along n, over `distance`: the second derivative of a line's length when its end moves
/// sideways.
Real sideways(Vec3 v, Vec3 n, Real distance) {
    if (distance < decimal<Real>("0.001")) return {};
    const Vec3 across = v - n * dot(v, n);
    return dot(across, across) / distance;
}
Vec3 point_velocity(const JointSide& side) { return side.velocity + cross(side.w, side.lever); }

RowValue line(const JointPlace& p) {
    const UnitVec3 n = normalized_or(p.s, p.a.axes.x);
    const Vec3 e = to<Real>(n);
    const Real distance = length(p.s);
    const Real arc = dot(e, p.arc) + sideways(point_velocity(p.b) - point_velocity(p.a), e, distance);
    return {distance, arc, linear_row(p.a, p.a.lever, -e, p.b, p.b.lever, e), e, true};
}

RowValue pulley(const JointPlace& p) {
    const Vec3 ropes[2] = {p.a.anchor - p.def->ground_a, p.b.anchor - p.def->ground_b};
    const Vec3 na = to<Real>(normalized_or(ropes[0], p.a.axes.x));
    const Vec3 nb = to<Real>(normalized_or(ropes[1], p.b.axes.x));
    const Real la = length(ropes[0]), lb = length(ropes[1]), ratio = p.def->ratio;
    const Real arc_a = dot(na, p.a.centripetal) + sideways(point_velocity(p.a), na, la);
    const Real arc_b = dot(nb, p.b.centripetal) + sideways(point_velocity(p.b), nb, lb);
    WideRow row = linear_row(p.a, p.a.lever, na, p.b, p.b.lever, nb);
    // The ratio, up to 1000, does not fit into the directions, so it is multiplied in afterwards.
    for (Scaled3* v : {&row.db, &row.xb}) {
        for (int i = 0; i < 3; ++i) v->m[i] = narrow_rounded(Wide::product(v->m[i], ratio.raw), 44);
        v->fraction_bits -= 12;
    }
    return {mul_add(ratio, lb, la), mul_add(ratio, arc_b, arc_a), row, nb * ratio, true};
}

/// Both bodies turn the same way under a positive impulse.
RowValue gear(const JointPlace& p) {
    const Vec3 xa = to<Real>(p.a.axes.x), xb = to<Real>(p.b.axes.x);
    WideRow row = angular_row(*p.a.body, xa, *p.b.body, xb);
    for (int i = 0; i < 3; ++i)
        row.xb.m[i] = narrow_rounded(Wide::product(row.xb.m[i], p.def->ratio.raw), 44);
    row.xb.fraction_bits -= 12;
    return {p.travel, Real{}, row, xb * p.def->ratio, false};
}

RowValue rack(const JointPlace& p) {
    const Vec3 xa = to<Real>(p.a.axes.x), xb = to<Real>(p.b.axes.x);
    WideRow row = angular_row(*p.a.body, xa, *p.b.body, Vec3{});
    const WideRow pull = linear_row(p.a, Vec3{}, Vec3{}, p.b, p.b.lever, -xb);
    row.db = pull.db, row.xb = pull.xb;
    for (Scaled3* v : {&row.db, &row.xb}) {
        for (int i = 0; i < 3; ++i) v->m[i] = narrow_rounded(Wide::product(v->m[i], p.def->ratio.raw), 44);
        v->fraction_bits -= 12;
    }
    return {p.travel, Real{}, row, -xb * p.def->ratio, true};
}

/// lever x e for the three world axes e, with lever_bits, and K^-1 times these arms.
void point_arms(const JointSide& side, std::int64_t sign, Scaled3 d[3], Scaled3 x[3]) {
    std::int64_t r[3];
    for (int i = 0; i < 3; ++i)
        r[i] = sign * std::clamp(shift_right_rounded(side.lever[i].raw, Real::fraction_bits - lever_bits),
                                 -arm_max, arm_max);
    const std::int64_t arms[3][3] = {{0, r[2], -r[1]}, {-r[2], 0, r[0]}, {r[1], -r[0], 0}};
    for (int i = 0; i < 3; ++i) {
        d[i].m[i] = sign * (std::int64_t{1} << direction_bits);
        d[i].fraction_bits = direction_bits;
        x[i] = turning(*side.body, arms[i], lever_bits);
    }
}

} // namespace

void point_values(const JointPlace& p, RowValue out[3]) {
    Scaled3 d[2][3] = {}, x[2][3] = {};
    if (p.a.body->moves) point_arms(p.a, -1, d[0], x[0]);
    if (p.b.body->moves) point_arms(p.b, 1, d[1], x[1]);
    for (int i = 0; i < 3; ++i)
        out[i] = {p.s[i], p.arc[i], {d[0][i], x[0][i], d[1][i], x[1][i]}, world_axis(i), true};
}

/// The gradient is (xA + xB) / (1 + xA . xB), kept below 8 near opposite axes.
RowValue twist_value(Real twist, UnitVec3 xa, UnitVec3 xb, const BodyInertia& a, const BodyInertia& b) {
    const Real d = max(Real(1) + dot<Real>(xa, xb), decimal<Real>("0.015625"));
    const Vec3 axis = (to<Real>(xa) + to<Real>(xb)) / d;
    return {twist, Real{}, angular_row(a, -axis, b, axis), axis, false};
}

RowValue row_value(RowKind kind, const JointPlace& p) {
    const int k = static_cast<int>(kind);
    switch (kind) {
    case RowKind::point_x:
    case RowKind::point_y:
    case RowKind::point_z:
        return point(p, k);
    case RowKind::along_x:
    case RowKind::along_y:
    case RowKind::along_z:
        return along(p, k - static_cast<int>(RowKind::along_x));
    case RowKind::orientation_x:
    case RowKind::orientation_y:
    case RowKind::orientation_z: {
        const int i = k - static_cast<int>(RowKind::orientation_x);
        return between(p.orientation_error[i], world_axis(i), p);
    }
    case RowKind::target_x:
    case RowKind::target_y:
    case RowKind::target_z: {
        const int i = k - static_cast<int>(RowKind::target_x);
        return between(p.target_error[i], axis_of(p.a.axes, i), p);
    }
    case RowKind::twist:
        return twist_value(p.twist, p.a.axes.x, p.b.axes.x, *p.a.body, *p.b.body);
    case RowKind::lock_y:
        return plane(p, 1, p.a.axes.z, Real(-1));
    case RowKind::lock_z:
        return plane(p, 2, p.a.axes.y, Real(1));
    case RowKind::angle_y:
        return angle(p, angle_y_between(p.a.axes, p.b.axes), -to<Real>(p.a.axes.z));
    case RowKind::angle_z:
        return angle(p, angle_z_between(p.a.axes, p.b.axes), to<Real>(p.a.axes.y));
    case RowKind::spin:
        return between(p.twist, to<Real>(p.b.axes.x), p);
    case RowKind::swing:
        return swing(p);
    case RowKind::line:
        return line(p);
    case RowKind::pulley:
        return pulley(p);
    case RowKind::gear:
        return gear(p);
    default:
        return rack(p);
    }
}

// ---- coordinates --------------------------------------------------------------------------------------------------

std::array<Real, joint_axis_count> joint_coordinates(const JointDef& def, const Transform& frame_a,
                                                     const Transform& frame_b, Real twist) {
    std::array<Real, joint_axis_count> position{};
    const Vec3 s = frame_b.position - frame_a.position;
    const Rotation a = to_rotation(frame_a.rotation), b = to_rotation(frame_b.rotation);
    switch (def.kind) {
    case JointKind::distance:
        position[along_x] = length(s);
        return position;
    case JointKind::pulley:
        position[along_x] = mul_add(def.ratio, length(frame_b.position - def.ground_b),
                                    length(frame_a.position - def.ground_a));
        return position;
    case JointKind::gear:
    case JointKind::rack_and_pinion:
        position[about_x] = twist;
        return position;
    default:
        break;
    }
    const Vec3 along = mul_transposed<Real>(a, s);
    position[along_x] = along.x, position[along_y] = along.y, position[along_z] = along.z;
    position[about_x] = twist_between(frame_a.rotation, frame_b.rotation, counts_turns(def) ? twist : Real{});
    position[about_y] = angle_y_between(a, b);
    position[about_z] = angle_z_between(a, b);
    return position;
}

} // namespace lockstone::solve
