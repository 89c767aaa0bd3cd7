#include "math_oracle.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace oracle;

namespace {

/// The quaternion algebra in long double.
struct Reference {
    long double x, y, z, w;
};
Reference operator*(Reference a, Reference b) {
    return {a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y, a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
            a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w, a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z};
}
Reference unit(Reference q) {
    const long double n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return {q.x / n, q.y / n, q.z / n, q.w / n};
}
Reference of(Quat q) { return unit({value_of(q.x), value_of(q.y), value_of(q.z), value_of(q.w)}); }
Reference exponential(long double x, long double y, long double z) {
    const long double angle = std::sqrt(x * x + y * y + z * z),
                      s = angle == 0 ? 0.5L : std::sin(angle / 2) / angle;
    return {x * s, y * s, z * s, std::cos(angle / 2)};
}
Reference negated(Reference q) { return {-q.x, -q.y, -q.z, -q.w}; }

/// The largest difference of a component, in steps.
double steps_apart(Quat q, Reference r) {
    const long double scale = 1073741824.0L;
    long double worst = 0;
    for (long double d :
         {q.x.raw - r.x * scale, q.y.raw - r.y * scale, q.z.raw - r.z * scale, q.w.raw - r.w * scale})
        worst = std::fabs(d) > worst ? std::fabs(d) : worst;
    return static_cast<double>(worst);
}
/// The difference of rotations, for which q and -q are equal.
double rotation_steps_apart(Quat q, Reference r) {
    return std::fmin(steps_apart(q, r), steps_apart(q, negated(r)));
}
/// The angle between two rotations.
double angle_between(Quat q, Reference r) {
    const Reference d = of(conjugate(q)) * r;
    return static_cast<double>(2 * std::atan2(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z), std::fabs(d.w)));
}

Quat any_quat(Random& random) {
    const UnitVec3 axis = random.unit_vector();
    return from_axis_angle(axis, random.range(-pi, pi));
}

constexpr double bound = error_bound::rotation / 1000.0;

template <FixedPoint T> long double value(T x) {
    return std::ldexp(static_cast<long double>(x.raw), -T::fraction_bits);
}

/// The error of integrate_rotation against the exponential map, for turns of about 2^-k.
template <FixedPoint T> Sweep integration_errors(int count, int fault) {
    Sweep sweep;
    Random random = Random::seeded(30);
    constexpr int bits = std::numeric_limits<typename T::rep>::digits;
    for (int i = 0; i < count; ++i) {
        const Quat q = any_quat(random);
        Vector3<T> v{};
        const int shift = random.range(std::int32_t{0}, bits - 1);
        for (int c = 0; c < 3; ++c)
            v[c] = T::from_raw(static_cast<typename T::rep>(any_magnitude(random, bits) >> shift));
        Quat moved = integrate_rotation(q, v);
        moved.x.raw += fault;
        sweep.add(steps_apart(moved, unit(exponential(value(v.x), value(v.y), value(v.z)) * of(q))), bound);
    }
    return sweep;
}

} // namespace

TEST_CASE("from_axis_angle() returns the quaternion of the formula") {
    Random random = Random::seeded(31);
    Sweep sweep, faulty;
    for (int i = 0; i < points(200000); ++i) {
        const UnitVec3 axis = random.unit_vector();
        const Real angle = Real::from_raw(any_magnitude(random, 40));
        const long double half_angle = value_of(angle) / 2, s = std::sin(half_angle);
        Quat q = from_axis_angle(axis, angle);
        const Reference r =
            unit({value_of(axis.x) * s, value_of(axis.y) * s, value_of(axis.z) * s, std::cos(half_angle)});
        sweep.add(steps_apart(q, r), bound);
        q.y.raw += 4;
        faulty.add(steps_apart(q, r), bound);
    }
    INFO("worst " << sweep.worst);
    CHECK(sweep.failures == 0);
    CHECK(faulty.failures == faulty.count); // planted fault: four steps off
    CHECK(from_axis_angle(UnitVec3{unit_one, Unit{}, Unit{}}, 0_r) == Quat::identity());
}

TEST_CASE("to_axis_angle() returns an axis and an angle that give the quaternion back") {
    Random random = Random::seeded(32);
    long bad = 0;
    for (int i = 0; i < points(100000); ++i) {
        const Quat q = any_quat(random);
        const AxisAngle a = to_axis_angle(q);
        bad += rotation_steps_apart(from_axis_angle(a.axis, a.angle), of(q)) > 3 ? 1 : 0;
        bad += a.angle < 0_r || a.angle > pi ? 1 : 0;
    }
    CHECK(bad == 0);
    CHECK(to_axis_angle(Quat::identity()).angle == 0_r);
    CHECK(to_axis_angle(Quat::identity()).axis.x == unit_one);
    CHECK(to_axis_angle(Quat{Unit{}, Unit{}, Unit{}, -unit_one}).angle == 0_r);
    const AxisAngle tiny = to_axis_angle(Quat{Unit::from_raw(1), Unit{}, Unit{}, unit_one});
    CHECK(tiny.axis.x == unit_one);
    CHECK(tiny.angle.raw == 8); // 2 * 2^-30
}

TEST_CASE("from_to() rotates one direction to another even for equal or near or opposite directions") {
    Random random = Random::seeded(33);
    long bad = 0;
    const auto check = [&](UnitVec3 a, UnitVec3 b) {
        const UnitVec3 moved = rotate(from_to(a, b), a);
        for (int c = 0; c < 3; ++c) bad += std::abs(moved[c].raw - b[c].raw) > 5 ? 1 : 0;
    };
    for (int i = 0; i < points(100000); ++i) {
        const UnitVec3 a = random.unit_vector(), b = random.unit_vector();
        check(a, b);
        check(a, a);
        check(a, -a);
        // 2^-2 down to 2^-29 away from the opposite direction.
        const int off = random.range(std::int32_t{2}, 29);
        check(a, normalized(-a + any_perpendicular(a) * shift_right(unit_one, off)));
        check(a, normalized(a + any_perpendicular(a) * shift_right(unit_one, off)));
    }
    CHECK(bad == 0);
    const UnitVec3 x{unit_one, Unit{}, Unit{}};
    CHECK(from_to(x, x) == Quat::identity());
    CHECK(from_to(x, -x).w == Unit{});
}

TEST_CASE("from_euler() rotates about the fixed axes in the order x then y then z") {
    Random random = Random::seeded(34);
    Sweep sweep;
    for (int i = 0; i < points(100000); ++i) {
        const Real x = random.range(-4_r, 4_r), y = random.range(-4_r, 4_r), z = random.range(-4_r, 4_r);
        const Reference r = exponential(0, 0, value_of(z)) *
                            (exponential(0, value_of(y), 0) * exponential(value_of(x), 0, 0));
        sweep.add(steps_apart(from_euler(Vec3{x, y, z}), r), bound);
    }
    CHECK(sweep.failures == 0);
    CHECK(from_euler(Vec3{}) == Quat::identity());
}

TEST_CASE("from_rotation() returns the quaternion of a rotation matrix") {
    Random random = Random::seeded(35);
    Sweep sweep;
    for (int i = 0; i < points(200000); ++i) {
        const Quat q = any_quat(random);
        sweep.add(rotation_steps_apart(from_rotation(to_rotation(q)), of(q)), bound);
    }
    INFO("worst " << sweep.worst);
    CHECK(sweep.failures == 0);
    CHECK(from_rotation(Rotation::identity()) == Quat::identity());
    for (int axis = 0; axis < 3; ++axis) { // half turns, where w is zero
        UnitVec3 n{};
        n[axis] = unit_one;
        const Quat half_turn{n.x, n.y, n.z, Unit{}};
        CHECK(from_rotation(to_rotation(half_turn)) == half_turn);
    }
}

TEST_CASE("slerp() moves at constant speed along the shorter arc and nlerp() moves along the same arc") {
    Random random = Random::seeded(36);
    Sweep sweep, between;
    for (int i = 0; i < points(100000); ++i) {
        const Quat a = any_quat(random);
        Quat b = any_quat(random);
        if (i % 4 == 0)
            b = integrate_rotation(a, Vec3{Real::from_raw(any_magnitude(random, 20)), 0_r, Real::step()});
        const Real t = random.uniform();
        Reference ra = of(a), rb = of(b);
        if (ra.x * rb.x + ra.y * rb.y + ra.z * rb.z + ra.w * rb.w < 0) rb = negated(rb);
        const Reference d = rb * Reference{-ra.x, -ra.y, -ra.z, ra.w};
        const long double sine = std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z),
                          angle = 2 * std::atan2(sine, d.w);
        const long double part = sine == 0 ? 0 : angle * value_of(t) / sine, u = value_of(t);
        sweep.add(steps_apart(slerp(a, b, t), unit(exponential(d.x * part, d.y * part, d.z * part) * ra)),
                  bound);
        between.add(steps_apart(nlerp(a, b, t), unit({ra.x + (rb.x - ra.x) * u, ra.y + (rb.y - ra.y) * u,
                                                      ra.z + (rb.z - ra.z) * u, ra.w + (rb.w - ra.w) * u})),
                    bound);
    }
    INFO("worst slerp " << sweep.worst << ", nlerp " << between.worst);
    CHECK(sweep.failures == 0);
    CHECK(between.failures == 0);
}

TEST_CASE("interpolation starts at one end and stops at the other and clamps") {
    Random random = Random::seeded(37);
    long bad = 0;
    for (int i = 0; i < 10000; ++i) {
        const Quat a = any_quat(random), b = any_quat(random);
        bad += steps_apart(slerp(a, b, 0_r), of(a)) > bound || steps_apart(nlerp(a, b, -1_r), of(a)) > bound
                   ? 1
                   : 0;
        bad += rotation_steps_apart(slerp(a, b, 1_r), of(b)) > bound ||
                       rotation_steps_apart(nlerp(a, b, 2_r), of(b)) > bound
                   ? 1
                   : 0;
        bad += steps_apart(slerp(a, a, 0.5_r), of(a)) > bound ? 1 : 0;
    }
    CHECK(bad == 0);
}

TEST_CASE_TEMPLATE("a turn is the exponential map for small and large angles", T, I32F32, I4F60, I13F19,
                   I5F27, I2F30) {
    const Sweep sweep = integration_errors<T>(points(100000), 0);
    INFO("worst " << sweep.worst);
    CHECK(sweep.failures == 0);
    CHECK(integration_errors<T>(1000, 4).failures == 1000); // planted fault: four steps off
}

TEST_CASE("rotation functions do not overflow for arbitrary quaternions") {
    Random random = Random::seeded(38);
    for (int i = 0; i < 20000; ++i) {
        Quat q{};
        for (Unit* c : {&q.x, &q.y, &q.z, &q.w}) c->raw = static_cast<std::int32_t>(random.next_u32());
        if (i == 0) q = {Unit::min(), Unit::min(), Unit::min(), Unit::min()};
        Vec3 v{};
        const int bits = random.range(std::int32_t{1}, 63);
        for (int c = 0; c < 3; ++c) v[c] = Real::from_raw(any_magnitude(random, bits));
        integrate_rotation(q, v);
        slerp(q, Quat{q.w, q.x, q.y, q.z}, random.uniform());
        nlerp(q, Quat{q.w, q.x, q.y, q.z}, random.uniform());
        to_axis_angle(q);
        const UnitVec3 a{q.x, q.y, q.z}, b{q.w, q.x, q.y};
        from_to(a, b);
        from_rotation(Rotation{a, b, UnitVec3{q.z, q.w, q.x}});
        any_perpendicular(a);
    }
    CHECK(integrate_rotation(Quat::identity(), Vec3{}) == Quat::identity());
    CHECK(integrate_rotation(Quat::identity(), Vector3<Fixed<std::int32_t, 2>>{}) == Quat::identity());
}

namespace {

/// The angle error after ten minutes of 240 steps a second.
double drift(Quat (*advance)(Quat, Vector3<Separation>), double rate) {
    Quat q = Quat::identity();
    Reference r{0, 0, 0, 1};
    const double share = rate / 240 / std::sqrt(0.09 + 0.25 + 0.66);
    Vector3<Separation> v{};
    const double axis[3] = {0.3, 0.5, std::sqrt(0.66)};
    for (int c = 0; c < 3; ++c)
        v[c] = Separation::from_raw(static_cast<std::int32_t>(std::lround(std::ldexp(axis[c] * share, 27))));
    const Reference step = exponential(value(v.x), value(v.y), value(v.z));
    for (int i = 0; i < 144000; ++i) {
        q = advance(q, v);
        r = unit(step * r);
    }
    return angle_between(q, r);
}

/// Integrates with a half turn that is first rounded to the step of a Unit.
Quat advance_coarsely(Quat q, Vector3<Separation> v) {
    const Quat turn{to<Unit>(half(v.x)), to<Unit>(half(v.y)), to<Unit>(half(v.z)), unit_one};
    return normalized(turn * q);
}

} // namespace

TEST_CASE("ten minutes of rotation at 240 Hz drift by less than 5 microradians at any rate") {
    const auto ours = [](Quat q, Vector3<Separation> v) { return integrate_rotation(q, v); };
    double worst = 0, coarse = 0;
    for (double rate : {0.00001, 0.001, 0.02, 0.3, 1.0, 5.0, 50.0}) {
        const double error = drift(ours, rate);
        worst = error > worst ? error : worst;
        if (rate <= 0.02) coarse = std::fmax(coarse, drift(advance_coarsely, rate));
    }
    INFO("worst " << worst << " rad");
    CHECK(worst < 5e-6);
    CHECK(coarse > 1e-5); // planted fault: without the extra bits
}
