// Locks of trees of joints: the solver agrees with a dense solution in double precision at any mass ratio within the
// range of the factor, and remains stable beyond.
#include "draw.h"
#include "solve/joints/tree/block_matrix.h"
#include "support/about.h"
#include "support/effort.h"
#include "support/rigs/joint_rig.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::rig;

namespace {

int rounds(int quick, int thorough) { return std::getenv("LOCKSTONE_LONG") != nullptr ? thorough : quick; }

// ---- dense, in double -----------------------------------------------------------------------------------------

using Numbers = std::vector<double>;
using Table = std::vector<Numbers>;

/// Solves a x = b by elimination with pivots; leaves out directions without a pivot.
Numbers dense_solve(Table a, Numbers b) {
    const std::size_t n = b.size();
    double largest = 0;
    for (std::size_t i = 0; i < n; ++i) largest = std::max(largest, std::abs(a[i][i]));
    std::vector<bool> left_out(n);
    for (std::size_t c = 0; c < n; ++c) {
        std::size_t best = c;
        for (std::size_t i = c; i < n; ++i)
            if (std::abs(a[i][c]) > std::abs(a[best][c])) best = i;
        std::swap(a[c], a[best]), std::swap(b[c], b[best]);
        left_out[c] = std::abs(a[c][c]) < 1e-13 * largest;
        for (std::size_t i = c + 1; i < n && !left_out[c]; ++i) {
            const double f = a[i][c] / a[c][c];
            for (std::size_t k = c; k < n; ++k) a[i][k] -= f * a[c][k];
            b[i] -= f * b[c];
        }
    }
    Numbers x(n);
    for (std::size_t i = n; i-- > 0;) {
        double sum = b[i];
        for (std::size_t k = i + 1; k < n; ++k) sum -= a[i][k] * x[k];
        x[i] = left_out[i] ? 0 : sum / a[i][i];
    }
    return x;
}

/// Velocities of all bodies, six numbers each: v, then w.
Numbers motion_of(const Rig& rig) {
    Numbers out;
    for (std::size_t b = 0; b < rig.info.size(); ++b) {
        const SolverBody& body = rig.bodies.body[b];
        const auto speed = [](std::int64_t x) { return static_cast<double>(x) * 0x1p-47; };
        for (const std::int64_t x : body.v) out.push_back(speed(x));
        const Symmetric<Real>& k = rig.bodies.step[b].gyration_inv;
        const D3 u{speed(body.u[0]), speed(body.u[1]), speed(body.u[2])};
        out.push_back(to_double(k.xx) * u[0] + to_double(k.xy) * u[1] + to_double(k.xz) * u[2]);
        out.push_back(to_double(k.xy) * u[0] + to_double(k.yy) * u[1] + to_double(k.yz) * u[2]);
        out.push_back(to_double(k.xz) * u[0] + to_double(k.yz) * u[1] + to_double(k.zz) * u[2]);
    }
    return out;
}

/// M^-1 x; with `power` 1 M x.
Numbers times_mass(const Rig& rig, const Numbers& x, int power) {
    Numbers out(x.size());
    for (std::uint32_t b = 0; b < rig.info.size(); ++b) {
        const double m = std::pow(to_double(rig.mass[b].mass), power);
        const Rotation r = to_rotation(rig.pose[b].rotation * rig.mass[b].principal);
        const D3 axes[3] = {d3(r.x), d3(r.y), d3(r.z)}, k = d3(rig.mass[b].gyration);
        const D3 w{x[6 * b + 3], x[6 * b + 4], x[6 * b + 5]};
        D3 turned{};
        for (std::size_t i = 0; i < 3; ++i)
            turned = turned + (m * std::pow(k[i], 2 * power) * dot(axes[i], w)) * axes[i];
        for (std::size_t i = 0; i < 3; ++i) out[6 * b + i] = m * x[6 * b + i], out[6 * b + 3 + i] = turned[i];
    }
    return out;
}

double dot(const Numbers& a, const Numbers& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}
Numbers less(const Numbers& a, const Numbers& b) {
    Numbers out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] - b[i];
    return out;
}
/// (2 kinetic energy)^(1/2): the size of a motion, independent of units and masses.
double size(const Rig& rig, const Numbers& motion) {
    return std::sqrt(dot(motion, times_mass(rig, motion, 1)));
}

/// One row over all bodies: pulls B along `along` at its anchor and turns it about `about`; A the opposite way.
Numbers row(const Rig& rig, std::uint32_t j, D3 along, D3 about) {
    Numbers out(6 * rig.info.size());
    const auto side = [&](std::uint32_t b, double sign, D3 anchor) {
        if (b == Rig::world) return;
        const D3 turns = cross(anchor - rig.x(b), along) + about;
        for (std::size_t i = 0; i < 3; ++i)
            out[6 * b + i] += sign * along[i], out[6 * b + 3 + i] += sign * turns[i];
    };
    side(rig.joints[j].body_a, -1, d3(rig.frame_a(j).position));
    side(rig.joints[j].body_b, 1, d3(rig.frame_b(j).position));
    return out;
}

/// The locks of joint j, whose frames coincide; for a distance, the row along its line.
Table rows_of(const Rig& rig, std::uint32_t j) {
    const Rotation r = to_rotation(rig.frame_a(j).rotation);
    const D3 axes[3] = {d3(r.x), d3(r.y), d3(r.z)};
    Table rows;
    if (rig.defs[j].kind == JointKind::distance) {
        const D3 s = d3(rig.frame_b(j).position) - d3(rig.frame_a(j).position);
        rows.push_back(row(rig, j, (1 / length(s)) * s, {}));
        return rows;
    }
    for (std::size_t i = 0; i < 3; ++i)
        if (rig.defs[j].axis[i].mode == AxisMode::locked) rows.push_back(row(rig, j, axes[i], {}));
    for (std::size_t i = 0; i < 3; ++i)
        if (rig.defs[j].axis[3 + i].mode == AxisMode::locked) rows.push_back(row(rig, j, {}, axes[i]));
    return rows;
}

Table all_rows(const Rig& rig) {
    Table rows;
    for (std::uint32_t j = 0; j < rig.joints.size(); ++j)
        for (Numbers& r : rows_of(rig, j)) rows.push_back(std::move(r));
    return rows;
}

/// The motion nearest to `free` that all locks allow.
Numbers held(const Rig& rig, const Table& rows, const Numbers& free) {
    Table responses, k(rows.size(), Numbers(rows.size()));
    Numbers speed;
    for (const Numbers& r : rows) responses.push_back(times_mass(rig, r, -1)), speed.push_back(dot(r, free));
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t n = 0; n < rows.size(); ++n) k[i][n] = dot(rows[i], responses[n]);
    const Numbers impulse = dense_solve(k, speed);
    Numbers out = free;
    for (std::size_t i = 0; i < rows.size(); ++i)
        for (std::size_t n = 0; n < out.size(); ++n) out[n] -= impulse[i] * responses[i][n];
    return out;
}

// ---- random trees ---------------------------------------------------------------------------------------------

JointDef drawn_joint(Draw& draw) {
    switch (draw.below(4)) {
    case 0:
        return ball_joint();
    case 1:
        return hinge_joint();
    case 2:
        return slider_joint();
    default:
        return weld_joint();
    }
}

/// A random tree: each body hangs on an earlier one; masses up to a ratio; in motion.
Rig drawn_tree(Draw& draw, int bodies, double ratio, bool anchored) {
    Rig rig;
    rig.gravity = {};
    for (int i = 0; i < bodies; ++i) {
        const std::uint32_t on = i == 0 ? Rig::world : static_cast<std::uint32_t>(draw.below(i));
        const D3 at = i == 0 ? D3{} : rig.x(on) + draw.vector(1);
        // One draw per statement: the order of evaluation of arguments depends on the compiler, and would give other
        // trees.
        const double kg = std::pow(ratio, draw(0, 1));
        const D3 gyration{draw(0.2, 0.5), draw(0.2, 0.5), draw(0.2, 0.5)};
        const std::uint32_t b = rig.add(kg, gyration, at, draw.rotation());
        const double fast = std::min(2.0, 1000 / ratio); // impulses are bounded
        rig.velocity[b] = {to<Speed>(vec(draw.vector(fast))), to<Speed>(vec(draw.vector(fast)))};
        if (i == 0 && !anchored) continue;
        if (draw.below(5) == 0) {
            JointDef def = distance_joint(real(1));
            def.frame_a = {i == 0 ? vec(0.7, 0.5, 0.3) : vec(draw.vector(0.3)), Quat::identity()};
            def.frame_b = {vec(draw.vector(0.3)), Quat::identity()};
            const std::uint32_t j = rig.join_as_is(def, on, b);
            rig.defs[j].axis[0].target =
                real(length(d3(rig.frame_b(j).position) - d3(rig.frame_a(j).position)));
            continue;
        }
        const JointDef def = drawn_joint(draw);
        rig.join(def, on, b, i == 0 ? at : 0.5 * (at + rig.x(on)), draw.rotation());
    }
    return rig;
}

/// The distance of the engine's motion from the dense solution after so many passes, relative to the motion that the
/// locks remove. Light trees also use the direct solver here.
double off_after(Rig& rig, const Table& rows, int passes) {
    StepConstants step = rig.constants();
    step.tree_load = Real{};
    rig.begin(step);
    const Numbers free = motion_of(rig), wanted = held(rig, rows, free);
    for (int i = 0; i < passes; ++i) rig.solver.solve(step, rig.bodies, false);
    return size(rig, less(motion_of(rig), wanted)) / size(rig, less(free, wanted));
}

double widest(const Rig& rig) {
    double most = 0;
    for (std::uint32_t j = 0; j < rig.joints.size(); ++j) most = std::max(most, rig.gap(j));
    return most;
}

/// Links of 0.5 m along x, jointed to the world, and a ball at their end.
Rig chain(int links, double link, double ball) {
    Rig rig;
    std::uint32_t last = Rig::world;
    for (int i = 0; i < links; ++i) {
        const std::uint32_t b = rig.add(link, {0.05, 0.14, 0.14}, {0.5 * (i + 0.5), 0, 0});
        rig.join(ball_joint(), last, b, {0.5 * i, 0, 0});
        last = b;
    }
    const std::uint32_t end = rig.add(ball, {0.4, 0.4, 0.4}, {0.5 * links + 0.6, 0, 0});
    rig.join(ball_joint(), last, end, {0.5 * links, 0, 0});
    return rig;
}

struct Swing {
    double gap, energy_gain, speed;
};
Swing swing(Rig rig, int ticks) {
    Swing s{};
    const double before = rig.energy();
    for (int i = 0; i < ticks; ++i) {
        rig.tick();
        s.gap = std::max(s.gap, widest(rig));
        s.energy_gain = std::max(s.energy_gain, rig.energy() - before);
        for (std::uint32_t b = 0; b < rig.info.size(); ++b) s.speed = std::max(s.speed, length(rig.v(b)));
    }
    return s;
}

} // namespace

// ---- blocks ---------------------------------------------------------------------------------------------------

TEST_CASE("joint tree: the factor of a block solves the block") {
    Draw draw{std::mt19937_64{1}};
    for (int round = 0; round < rounds(300, 20000); ++round) {
        const int n = 1 + draw.below(6);
        Table b(static_cast<std::size_t>(n), Numbers(static_cast<std::size_t>(n)));
        for (Numbers& r : b)
            for (double& x : r) x = draw(-1, 1) * std::pow(2, -draw(0, 4));
        Table a = b; // B B^T plus a thousandth
        double largest = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            for (std::size_t k = 0; k < a.size(); ++k) {
                a[i][k] = dot(b[i], b[k]) + (i == k ? 1e-3 : 0);
                largest = std::max(largest, a[i][k]);
            }
        SymmetricBlock block{};
        const double unit = 0x1p60 / std::exp2(std::ceil(std::log2(largest * 1.0001)));
        Numbers right(a.size());
        std::int64_t x[6];
        for (std::size_t i = 0; i < a.size(); ++i) {
            for (std::size_t k = 0; k <= i; ++k)
                block.m[block_index(static_cast<int>(i), static_cast<int>(k))] =
                    static_cast<std::int64_t>(a[i][k] * unit);
            right[i] = draw(-5, 5);
            x[i] = static_cast<std::int64_t>(right[i] * 0x1p36);
        }
        BlockFactor factor;
        REQUIRE(factorise(block, n, factor));
        const auto worst = [&] {
            std::int64_t y[6];
            std::copy(x, x + 6, y);
            solve::solve(factor, n, y);
            const Numbers wanted = dense_solve(a, right);
            double most = 0, off = 0;
            for (std::size_t i = 0; i < a.size(); ++i) {
                off =
                    std::max(off, std::abs(static_cast<double>(y[i]) * 0x1p-36 * unit * 0x1p-60 - wanted[i]));
                most = std::max(most, std::abs(wanted[i]));
            }
            return off / most;
        };
        CHECK(worst() < 1e-6);
        factor.inverse[draw.below(n)] += std::int64_t{1} << 36; // planted
        CHECK(worst() > 1e-6);
    }
}

TEST_CASE(
    "joint tree: the factorisation rejects or raises pivots that are too small and skips rows of zeros") {
    SymmetricBlock block = block_of(scaled(1, 0), 3);
    block.m[block_index(1, 1)] = 1 << 20;
    block.m[block_index(2, 2)] = 0;
    BlockFactor factor;
    CHECK_FALSE(factorise(block, 3, factor));
    factorise_raised(block, 3, factor);
    CHECK(factor.inverse[1] == std::int64_t{1} << 60); // 2^24
    CHECK(factor.inverse[2] == 0);
}

// ---- trees ----------------------------------------------------------------------------------------------------

TEST_CASE("joint tree: three passes reach the dense solution at any mass ratio") {
    struct Case {
        /// At a ratio of 10000 speeds are small, because impulses are bounded, and rounding is visible.
        double ratio, most;
    };
    for (const Case c : {Case{1, 1e-4}, Case{100, 1e-4}, Case{1e4, 5e-3}}) {
        Draw draw{std::mt19937_64{7}};
        double most = 0, planted = 0;
        const int count = rounds(40, 2000);
        for (int round = 0; round < count; ++round) {
            Rig rig = drawn_tree(draw, 3 + draw.below(10), c.ratio, draw.below(2) == 0);
            const Table rows = all_rows(rig);
            most = std::max(most, off_after(rig, rows, 3));
            // planted: a joint that the engine lacks
            const auto lost = static_cast<std::ptrdiff_t>(draw.below(static_cast<int>(rig.joints.size())));
            rig.joints.erase(rig.joints.begin() + lost), rig.defs.erase(rig.defs.begin() + lost);
            planted += off_after(rig, rows, 3) / count;
        }
        CAPTURE(c.ratio);
        CHECK(most < c.most);
        CHECK(planted > 10 * c.most);
    }
}

TEST_CASE("joint tree: loops close after many passes") {
    Draw draw{std::mt19937_64{11}};
    const int count = rounds(100, 500);
    double off = 0, planted = 0;
    for (int round = 0; round < count; ++round) {
        Rig rig = drawn_tree(draw, 5 + draw.below(5), 10, true);
        const auto last = static_cast<std::uint32_t>(rig.info.size() - 1);
        rig.join(ball_joint(), 0, last, 0.5 * (rig.x(0) + rig.x(last)));
        const Table rows = all_rows(rig);
        off += off_after(rig, rows, 300) / count;
        rig.joints.pop_back(), rig.defs.pop_back(); // the joint that closes the loop
        planted += off_after(rig, rows, 300) / count;
    }
    CHECK(off < 0.03);
    CHECK(planted > 0.03);
}

// ---- motion ---------------------------------------------------------------------------------------------------

TEST_CASE("joint tree: a chain holds ten thousand times the mass of its link and gains no energy") {
    const Swing s = swing(chain(20, 1, 10000), 240);
    CHECK(s.gap < 0.03);
    CHECK(s.energy_gain <
          10000 * 9.81 * 0.05);     // the ball raised by five centimetres of its fall of ten metres
    Rig torn = chain(20, 1, 10000); // planted: a joint is missing
    const D3 at = torn.x(10);
    torn.joints[10] = torn.joints[9], torn.defs[10] = torn.defs[9];
    torn.run(60);
    CHECK(length(torn.x(10) - at) > 1);
}

TEST_CASE("joint tree: a chain beyond the range of masses yields and adds no energy") {
    for (const double link : {1.0, 0.001}) {
        const Swing s = swing(chain(10, link, 1e9), 240);
        CAPTURE(link);
        CHECK(s.energy_gain < 1e9 * 9.81 * 0.01); // the ball raised by a centimetre
        CHECK(s.speed < 1000);
    }
}

/// Planks hinged to each other and to both banks, taut, set swinging.
Rig bridge(int planks) {
    Rig rig;
    std::uint32_t last = Rig::world;
    const Quat across = turn({0, 1, 0}, -1.5707963267948966);
    for (int i = 0; i < planks; ++i) {
        const std::uint32_t b = rig.add(55, {0.58, 0.59, 0.14}, {0.5 * (i + 0.5), 0, 0});
        rig.join(hinge_joint(), last, b, {0.5 * i, 0, 0}, across);
        last = b;
    }
    rig.join(hinge_joint(), Rig::world, last, {0.5 * planks, 0, 0}, across);
    for (int b = 0; b < planks; ++b)
        rig.velocity[static_cast<std::uint32_t>(b)].linear =
            to<Speed>(vec(0, 0.5 * std::sin(2 * 3.14159265 * (b + 0.5) / planks), 0));
    return rig;
}

TEST_CASE("joint tree: a bridge that swings loses energy and its joints stay closed" *
          doctest::skip(lockstone::test::is_small_sample())) {
    Rig rig = bridge(30);
    double before = rig.energy();
    const double start = before;
    for (int second = 0; second < 6; ++second) {
        rig.run(60);
        CHECK(rig.energy() < before + 1); // of about 30 kJ
        before = rig.energy();
    }
    CHECK(before < start - 100);
    CHECK(widest(rig) < 1e-3);
}

TEST_CASE("joint tree: short bridges whose planks carry little load lose energy too") {
    for (const int planks : {3, 5, 7}) {
        CAPTURE(planks);
        Rig rig = bridge(planks);
        double before = rig.energy();
        const double start = before;
        for (int second = 0; second < 6; ++second) {
            rig.run(60);
            CHECK(rig.energy() < before + 1);
            before = rig.energy();
        }
        CHECK(before < start - 1);
        CHECK(widest(rig) < 1e-3);
    }
}

TEST_CASE("joint tree: each joint of a hanging chain bears the weight below it") {
    Rig rig;
    std::uint32_t last = Rig::world;
    constexpr int links = 12;
    for (int i = 0; i < links; ++i) {
        const std::uint32_t b =
            rig.add(i + 1 == links ? 500 : 2, {0.14, 0.05, 0.14}, {0, -0.5 * (i + 0.5), 0});
        rig.join(i % 2 == 0 ? ball_joint() : hinge_joint(), last, b, {0, -0.5 * i, 0});
        last = b;
    }
    rig.run(240);
    for (std::uint32_t j = 0; j < links; ++j) {
        const double below = (500 + 2.0 * (links - 1 - j)) * 9.81;
        CAPTURE(j);
        CHECK(to_double(rig.memory[j].force.y) == test::about(below, 0.002));
    }
    CHECK(widest(rig) < 2e-3);
}

TEST_CASE("joint tree: two hinges that lock the same door share its load and keep it in place") {
    Rig rig;
    const std::uint32_t door = rig.add(40, {0.05, 0.6, 0.3}, {0.5, 0, 0}),
                        handle = rig.add(1, {0.05, 0.05, 0.05}, {0.9, 0, 0});
    const Quat up = turn({0, 0, 1}, 1.5707963267948966); // x of the frame points up
    for (const double y : {-0.8, 0.8}) rig.join(hinge_joint(), Rig::world, door, {0, y, 0}, up);
    rig.join(weld_joint(), door, handle, {0.9, 0, 0});
    rig.run(240);
    CHECK(length(rig.x(door) - D3{0.5, 0, 0}) < 1e-3);
    CHECK(to_double(rig.memory[0].force.y + rig.memory[1].force.y) == test::about(41 * 9.81, 0.01));
    // the lower hinge is under pressure, the upper one under tension: 41 kg half a metre out over 1.6 m
    const double turning = 40 * 9.81 * 0.5 + 9.81 * 0.9;
    CHECK(std::abs(to_double(rig.memory[1].force.x)) < turning / 1.6 * 1.5);
    rig.joints.pop_back(), rig.joints.erase(rig.joints.begin()),
        rig.joints.erase(rig.joints.begin()); // planted: no hinges
    rig.run(60);
    CHECK(length(rig.x(door) - D3{0.5, 0, 0}) > 1);
}
