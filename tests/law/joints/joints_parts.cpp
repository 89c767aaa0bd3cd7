// Rows of joints, one at a time: each Jacobian is the derivative of its error, and the computed inverse of a part is
// its inverse.
#include "draw.h"
#include "solve/joints/joint_parts.h"

#include "support/about.h"
#include "support/rigs/joint_rig.h"

#include <doctest/doctest.h>

#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::rig;

namespace {

int rounds(int quick, int thorough) { return std::getenv("LOCKSTONE_LONG") != nullptr ? thorough : quick; }

constexpr int kinds = static_cast<int>(RowKind::rack) + 1;

/// Two frames on two bodies, with the masses from which K is made.
struct Pair {
    Transform pose[2];
    Transform frame[2]; ///< in the body
    BodyStep step[2];
    JointDef def;
    double travel[2]; ///< angles and distances of gears and racks
};

Pair pair_of(Draw& draw, bool nearly_together) {
    Rig rig;
    const double apart = nearly_together ? 0.4 : 1.2;
    for (int i = 0; i < 2; ++i)
        rig.add(1, {draw(0.1, 0.6), draw(0.1, 0.6), draw(0.1, 0.6)}, draw.vector(1), draw.rotation(apart));
    rig.begin(rig.constants());
    Pair p{};
    for (std::size_t i = 0; i < 2; ++i) {
        p.pose[i] = rig.pose[i];
        p.step[i] = rig.bodies.step[i];
        p.frame[i] = {vec(draw.vector(0.5)), draw.rotation(apart)};
    }
    p.def.kind = JointKind::six_dof;
    for (JointAxis& a : p.def.axis) a.mode = AxisMode::free;
    p.def.ground_a = vec(3, 5, 1), p.def.ground_b = vec(-4, 5, 2), p.def.ratio = real(1.75);
    return p;
}

JointSide side(const Pair& p, std::size_t i, const Transform& pose) {
    JointSide s{};
    s.body = &p.step[i];
    s.lever = rotate(pose.rotation, p.frame[i].position);
    s.anchor = pose.position + s.lever;
    s.rotation = pose.rotation * p.frame[i].rotation;
    s.axes = to_rotation(s.rotation);
    return s;
}

JointPlace place(const Pair& p, const Transform& a, const Transform& b) {
    JointPlace j{};
    j.def = &p.def;
    j.a = side(p, 0, a), j.b = side(p, 1, b);
    j.s = j.b.anchor - j.a.anchor;
    j.twist = twist_between(j.a.rotation, j.b.rotation, Real{});
    j.orientation_error = orientation_between(j.a.rotation, j.b.rotation);
    j.target_error = target_between(j.a.rotation, j.b.rotation, Vec3{});
    return j;
}

/// A pose after a translation by v h and a rotation by w h.
Transform moved(const Transform& t, D3 v, D3 w, double h) {
    return {t.position + vec(h * v), integrate_rotation(t.rotation, vec(h * w))};
}

double value(const Scaled3& v, int i) { return std::ldexp(static_cast<double>(v.m[i]), -v.fraction_bits); }

/// J (v, K w) for one body.
double along(const Scaled3& d, const Scaled3& x, const BodyStep& step, D3 v, D3 w) {
    const D3 u = d3(mul<Real>(step.gyration, vec(w)));
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += value(d, i) * v[static_cast<std::size_t>(i)] + value(x, i) * u[static_cast<std::size_t>(i)];
    return sum;
}

/// Gears and racks measure travel, not poses: their rate follows from their definition.
double rate_of_turns(const Pair& p, RowKind kind, const JointPlace& j, const D3 v[2], const D3 w[2]) {
    const D3 xa = d3(to<Real>(j.a.axes.x)), xb = d3(to<Real>(j.b.axes.x));
    const double ratio = to_double(p.def.ratio);
    if (kind == RowKind::gear) return dot(xa, w[0]) + ratio * dot(xb, w[1]);
    return dot(xa, w[0]) - ratio * dot(xb, v[1] + cross(w[1], d3(j.b.lever)));
}

/// The largest difference between J v and dC/dt of one kind of row, over random motions.
double derivative_error(RowKind kind, Draw& draw, double flip) {
    // Locks are derivatives only where they are closed: twice the sine of half an angle changes at the rate of the
    // angle.
    const bool lock = kind >= RowKind::orientation_x && kind <= RowKind::target_z;
    double worst = 0;
    for (int round = 0; round < rounds(20, 400); ++round) {
        Pair p = pair_of(draw, true);
        if (lock) { // bring the frames together
            p.frame[1].rotation =
                normalized(conjugate(p.pose[1].rotation) * (p.pose[0].rotation * p.frame[0].rotation));
        }
        const JointPlace j = place(p, p.pose[0], p.pose[1]);
        const D3 v[2] = {draw.vector(1), draw.vector(1)}, w[2] = {draw.vector(1), draw.vector(1)};
        const double h = 1e-3;
        const RowValue row = row_value(kind, j);
        const double rate = flip * along(row.row.da, row.row.xa, p.step[0], v[0], w[0]) +
                            along(row.row.db, row.row.xb, p.step[1], v[1], w[1]);
        double expected = 0;
        if (kind == RowKind::gear || kind == RowKind::rack) {
            expected = rate_of_turns(p, kind, j, v, w);
        } else if (kind == RowKind::spin) {
            expected = dot(d3(to<Real>(j.b.axes.x)), w[1] - w[0]);
        } else {
            const auto at = [&](double t) {
                return to_double(row_value(kind, place(p, moved(p.pose[0], v[0], w[0], t),
                                                       moved(p.pose[1], v[1], w[1], t)))
                                     .position);
            };
            expected = (at(h) - at(-h)) / (2 * h);
        }
        worst = std::max(worst, std::abs(rate - expected));
    }
    return worst;
}

} // namespace

TEST_CASE("the Jacobian of every row is the derivative of its error") {
    Draw draw{std::mt19937_64(1)};
    for (int k = 0; k < kinds; ++k) {
        CAPTURE(k);
        CHECK(derivative_error(static_cast<RowKind>(k), draw, 1) < 1e-4);
    }
}

TEST_CASE("planted fault: the check reports a Jacobian with the wrong sign of body A in every row") {
    Draw draw{std::mt19937_64(2)};
    for (int k = 0; k < kinds; ++k) {
        CAPTURE(k);
        CHECK(derivative_error(static_cast<RowKind>(k), draw, -1) > 0.1);
    }
}

namespace {

/// The largest entry of inverse * k - 1 for this number of rows.
double inverse_error(Draw& draw, int count, double damage) {
    double worst = 0;
    for (int round = 0; round < rounds(200, 5000); ++round) {
        Row rows[3] = {};
        for (int r = 0; r < count; ++r) {
            rows[r].shift_a = 0, rows[r].shift_b = 3;
            for (int i = 0; i < 6; ++i) {
                rows[r].ja[i] = static_cast<std::int32_t>(draw(-1, 1) * 0x1p29);
                rows[r].jb[i] = static_cast<std::int32_t>(draw(-1, 1) * 0x1p29);
                rows[r].ra[i] = rows[r].ja[i], rows[r].rb[i] = rows[r].jb[i];
            }
        }
        double k[3][3] = {};
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j)
                for (int c = 0; c < 6; ++c)
                    k[i][j] += static_cast<double>(rows[i].ja[c]) * rows[j].ra[c] * 0x1p-56 +
                               static_cast<double>(rows[i].jb[c]) * rows[j].rb[c] * 0x1p-59;
        const Inverse inverse = invert(rows, count);
        for (int i = 0; i < count; ++i)
            for (int j = 0; j < count; ++j) {
                double sum = i == j ? -1 : 0;
                for (int c = 0; c < count; ++c)
                    sum += std::ldexp(static_cast<double>(inverse.m[inverse_index[i][c]]), -inverse.shift) *
                           k[c][j] * damage;
                worst = std::max(worst, std::abs(sum));
            }
    }
    return worst;
}

} // namespace

TEST_CASE(
    "the computed inverse of one to three rows is exact and the check reports one that is wrong by 1e-4") {
    Draw draw{std::mt19937_64(3)};
    for (int count = 1; count <= 3; ++count) {
        CAPTURE(count);
        CHECK(inverse_error(draw, count, 1) < 1e-5);
        CHECK(inverse_error(draw, count, 1.0001) > 5e-5); // planted fault: a scale that is off by 1e-4
    }
}

TEST_CASE("the inverse of a part is zero along directions in which no body can move") {
    Row rows[3] = {};
    for (int r = 0; r < 3; ++r) rows[r].ja[r] = rows[r].ra[r] = 1 << 28;
    rows[1].ra[1] = 0; // locked
    const Inverse inverse = invert(rows, 3);
    const auto entry = [&](int i, int j) {
        return std::ldexp(static_cast<double>(inverse.m[inverse_index[i][j]]), -inverse.shift);
    };
    CHECK(entry(0, 0) == test::about(1));
    CHECK(entry(1, 1) == 0);
    CHECK(entry(2, 2) == test::about(1));
    for (Row& row : rows) row = {};
    for (int count = 1; count <= 3; ++count)
        for (std::int32_t m : invert(rows, count).m) CHECK(m == 0);
}

TEST_CASE("equal rows share the impulse and cause no division by zero") {
    Row rows[3] = {};
    for (Row& row : rows) row.ja[0] = row.ra[0] = 1 << 28;
    const Inverse inverse = invert(rows, 3);
    double sum = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            sum += std::ldexp(static_cast<double>(inverse.m[inverse_index[i][j]]), -inverse.shift);
    CHECK(sum == test::about(1));
}

TEST_CASE("rows keep their precision from a lever of 127 m on a gyration of 1 mm to a gyration of 10 km") {
    for (const auto& [gyration, lever] :
         {std::pair{1e-3, 127.0}, {1e-3, 1e-3}, {1.0, 1.0}, {1e4, 127.0}, {1e4, 0.0}}) {
        // clang 14: a lambda cannot capture a structured binding
        const double radius = gyration, reach = lever;
        CAPTURE(radius);
        CAPTURE(reach);
        Rig rig;
        const std::uint32_t b = rig.add(1, {gyration, gyration, gyration}, {0, 0, 0});
        rig.begin(rig.constants());
        const std::int64_t arm[3] = {static_cast<std::int64_t>(lever * 0x1p24), 0, 0};
        WideRow wide{};
        wide.db = {{1 << 28, 0, 0}, 28};
        wide.xb = turning(rig.bodies.step[b], arm, 24);
        Row row{};
        const int e = set_rows(&row, &wide, 1);
        CHECK(std::ldexp(row.jb[0], e - 28) == test::about(1, 1e-3));
        CHECK(std::ldexp(row.jb[3], e - 28) == test::about(lever / gyration, 1e-4));
        std::int32_t largest = 0;
        for (std::int32_t x : row.jb) largest = std::max(largest, x);
        CHECK(largest <= 1 << 29);
        CHECK(largest >= 1 << 28);
    }
}

TEST_CASE("the shares of two bodies whose masses differ by a factor of 1e12 keep 23 bits") {
    Rig rig;
    const std::uint32_t light = rig.add(1e-3, {1, 1, 1}, {0, 0, 0}),
                        heavy = rig.add(1e9, {1, 1, 1}, {0, 0, 0});
    rig.begin(rig.constants());
    const Shares s =
        joint_shares(rig.mass[light], rig.bodies.step[light], rig.mass[heavy], rig.bodies.step[heavy]);
    const auto share = [](Share x) { return std::ldexp(x.mantissa, -30 - x.shift); };
    CHECK(share(s.a) == test::about(1, 1e-9));
    CHECK(share(s.b) == test::about(to_double(rig.mass[light].mass) / 1e9, 1.0 / (1 << 23)));
}
