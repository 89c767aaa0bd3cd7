#include "math_oracle.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace oracle;

namespace {

using Reference3x3 = std::array<std::array<long double, 3>, 3>; // [column][row]

Reference3x3 of(const Mat3& m) {
    Reference3x3 r{};
    const Vec3 columns[3] = {m.x, m.y, m.z};
    for (std::size_t i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) r[i][static_cast<std::size_t>(j)] = value_of(columns[i][j]);
    return r;
}
long double determinant(const Reference3x3& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}
Reference3x3 inverse(const Reference3x3& m) {
    const long double d = determinant(m);
    Reference3x3 r{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, e = (j + 2) % 3;
            r[j][i] = (m[a][c] * m[b][e] - m[a][e] * m[b][c]) / d;
        }
    return r;
}
long double norm(const Reference3x3& m) {
    long double sum = 0;
    for (const auto& column : m)
        for (long double v : column) sum += v * v;
    return std::sqrt(sum);
}
long double distance(const Reference3x3& a, const Reference3x3& b) {
    Reference3x3 d{};
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) d[i][j] = a[i][j] - b[i][j];
    return norm(d);
}

constexpr long double step = 0x1p-32L;

Mat3 any_matrix(Random& random, int bits) {
    Mat3 m{};
    for (Vec3* column : {&m.x, &m.y, &m.z})
        for (int i = 0; i < 3; ++i)
            (*column)[i] = Real::from_raw(any_magnitude(random, 8) << (bits - 8) | random.next_u32() >> 8);
    return m;
}
Mat3 symmetric(Mat3 m) {
    m.x.y = m.y.x;
    m.x.z = m.z.x;
    m.y.z = m.z.y;
    return m;
}

/// |R D R^T - m| with the stored axes.
long double reconstruction_error(const Mat3& m, const Diagonal& d) {
    const Rotation r = to_rotation(d.axes);
    const UnitVec3 axes[3] = {r.x, r.y, r.z};
    Reference3x3 sum{};
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                sum[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] +=
                    value_of(axes[k][i]) * value_of(axes[k][j]) * value_of(d.values[k]);
    return distance(sum, of(m));
}

} // namespace

TEST_CASE("the determinant is within its error bound from grams to kilotons") {
    Random random = Random::seeded(40);
    long bad = 0, planted = 0;
    for (int i = 0; i < points(100000); ++i) {
        const Mat3 m = any_matrix(random, random.range(std::int32_t{26}, 41));
        const Reference3x3 r = of(m);
        const long double exact = determinant(r), size = norm(r);
        if (std::fabs(exact) > 2e9L) continue;
        const long double allowed = step * error_bound::determinant / 1000 +
                                    std::ldexp(size * size * size, -error_bound::determinant_relative_bits);
        const Real d = lockstone::determinant(m);
        bad += std::fabs(value_of(d) - exact) > allowed ? 1 : 0;
        planted += std::fabs(value_of(d) + 2 * allowed - exact) > allowed ? 1 : 0;
    }
    CHECK(bad == 0);
    CHECK(planted > 1000);
    CHECK(lockstone::determinant(Mat3::identity()) == 1_r);
    CHECK(lockstone::determinant(Mat3{}) == 0_r);
    CHECK(lockstone::determinant(Mat3::diagonal(100000_r, 100000_r, 100000_r)) == Real::max());
    CHECK(lockstone::determinant(Mat3::diagonal(100000_r, -100000_r, 100000_r)) == Real::min());
    CHECK(lockstone::determinant(Mat3::diagonal(2000000000_r, 0.001_r, 0.001_r)) > 1999_r);
}

TEST_CASE("the inverse is as accurate as the condition number allows from grams to kilotons") {
    Random random = Random::seeded(41);
    long bad = 0, checked = 0, planted = 0;
    for (int i = 0; i < points(100000); ++i) {
        const Mat3 m = any_matrix(random, random.range(std::int32_t{26}, 62));
        const Reference3x3 r = of(m);
        if (determinant(r) == 0) continue;
        const Reference3x3 exact = inverse(r);
        const long double condition = norm(r) * norm(exact), size = norm(exact);
        if (condition > 1e6L || size > 1e9L) continue;
        ++checked;
        const long double allowed = step * error_bound::inverse / 1000 +
                                    std::ldexp(size * condition, -error_bound::inverse_relative_bits);
        Reference3x3 ours = of(lockstone::inverse(m));
        bad += distance(ours, exact) > allowed ? 1 : 0;
        ours[1][1] += 2 * allowed;
        planted += distance(ours, exact) > allowed ? 1 : 0;
    }
    CHECK(checked > 50000);
    CHECK(bad == 0);
    CHECK(planted == checked);
    CHECK(lockstone::inverse(Mat3::identity()) == Mat3::identity());
    CHECK(lockstone::inverse(Mat3::diagonal(4_r, 0.5_r, -2_r)) == Mat3::diagonal(0.25_r, 2_r, -0.5_r));
    CHECK(lockstone::inverse(Mat3{}) == Mat3{});
    CHECK(lockstone::inverse(Mat3::diagonal(1_r, 1_r, 0_r)) == Mat3{});
    const Mat3 extreme = Mat3::diagonal(Real::min(), Real::max(), Real::min());
    CHECK(lockstone::inverse(extreme).x.x.raw == -2);
}

TEST_CASE("the eigenvalues and axes of a symmetric matrix give the matrix back") {
    Random random = Random::seeded(42);
    long double worst = 0;
    long bad = 0, planted = 0, not_turned = 0;
    for (int i = 0; i < points(30000); ++i) {
        const Mat3 m = symmetric(any_matrix(random, random.range(std::int32_t{26}, 60)));
        Diagonal d = diagonalize(m);
        // Axes are stored with steps of 2^-30: a quaternion is off by at most 2 of them, a matrix entry by 8.
        const long double allowed = norm(of(m)) * 10 * 0x1p-30L + 4 * step,
                          error = reconstruction_error(m, d);
        worst = std::max(worst, error / norm(of(m)) * 0x1p30L);
        bad += error > allowed ? 1 : 0;
        const Quat q = normalized(d.axes);
        not_turned += std::abs(q.w.raw - d.axes.w.raw) > 2 ? 1 : 0;
        d.values.y += Real::from_raw(static_cast<std::int64_t>(allowed * 3 * 0x1p32L));
        planted += reconstruction_error(m, d) > allowed ? 1 : 0;
    }
    INFO("worst relative error " << static_cast<double>(worst) << " * 2^-30");
    CHECK(bad == 0);
    CHECK(not_turned == 0);
    CHECK(planted > 20000);
}

TEST_CASE("the eigenvalues are within their own error bound") {
    Random random = Random::seeded(43);
    long bad = 0;
    for (int i = 0; i < points(30000); ++i) {
        const Mat3 m = symmetric(any_matrix(random, random.range(std::int32_t{40}, 60)));
        const Reference3x3 r = of(m);
        const Vec3 v = diagonalize(m).values;
        const long double a = value_of(v.x), b = value_of(v.y), c = value_of(v.z), n = norm(r);
        const long double second = r[0][0] * r[1][1] + r[1][1] * r[2][2] + r[2][2] * r[0][0] -
                                   r[1][0] * r[1][0] - r[2][0] * r[2][0] - r[2][1] * r[2][1];
        const long double allowed = std::ldexp(1.0L, -error_bound::eigenvalue_relative_bits) + 4 * step / n;
        bad += std::fabs(a + b + c - (r[0][0] + r[1][1] + r[2][2])) > n * allowed ? 1 : 0;
        bad += std::fabs(a * b + b * c + c * a - second) > 4 * n * n * allowed ? 1 : 0;
        bad += std::fabs(a * b * c - determinant(r)) > 4 * n * n * n * allowed ? 1 : 0;
    }
    CHECK(bad == 0);
}

TEST_CASE("a diagonal matrix keeps its axes and its order") {
    for (const Mat3& m :
         {Mat3::identity(), Mat3{}, Mat3::diagonal(1_r, 2_r, 3_r), Mat3::diagonal(3_r, 2_r, 1_r),
          Mat3::diagonal(5_r, 5_r, 0.001_r), Mat3::diagonal(-1_r, 1'000'000'000_r, 2_r)}) {
        const Diagonal d = diagonalize(m);
        CHECK(d.axes == Quat::identity());
        CHECK(Mat3::diagonal(d.values.x, d.values.y, d.values.z) == m);
    }
}

TEST_CASE("a nearly diagonal matrix keeps its order of axes") {
    Mat3 m = Mat3::diagonal(1_r, 3_r, 2_r);
    m.y.x = m.x.y = 0.0001_r;
    m.z.y = m.y.z = -0.0002_r;
    const Diagonal d = diagonalize(m);
    CHECK(abs(d.values.x - 1_r) < 0.001_r);
    CHECK(abs(d.values.y - 3_r) < 0.001_r);
    CHECK(d.axes.w > decimal<Unit>("0.9999"));
}

TEST_CASE("diagonalize() returns the moments of a box for its rotated inertia") {
    Random random = Random::seeded(44);
    for (int i = 0; i < 1000; ++i) {
        const Quat q = from_axis_angle(random.unit_vector(), random.range(0_r, pi));
        const Rotation r = to_rotation(q);
        const Vec3 moments{2_r, 3_r, 7.5_r};
        Mat3 m{};
        for (Vec3* column : {&m.x, &m.y, &m.z}) {
            const int j = column == &m.x ? 0 : column == &m.y ? 1 : 2;
            for (int k = 0; k < 3; ++k)
                (*column)[k] = mul<Real>(r.x[j], r.x[k]) * moments.x + mul<Real>(r.y[j], r.y[k]) * moments.y +
                               mul<Real>(r.z[j], r.z[k]) * moments.z;
        }
        Vec3 v = diagonalize(symmetric(m)).values;
        Real sorted[3] = {v.x, v.y, v.z};
        std::sort(std::begin(sorted), std::end(sorted));
        if (abs(sorted[0] - 2_r) > 0.00000002_r || abs(sorted[1] - 3_r) > 0.00000002_r ||
            abs(sorted[2] - 7.5_r) > 0.00000004_r)
            FAIL("values differ in case " << i);
    }
}
