// Followed bodies, whose turn the solver updates in each substep: all instruction sets give equal bits, and lanes agree
// with Real.
#include "lockstone/math/random.h"
#include "support/rigs/joint_rig.h"

#include <doctest/doctest.h>

#include <cstring>
#include <tuple>

using namespace lockstone;
using namespace lockstone::test::rig;

namespace {

double chance(Random& random, double least, double most) {
    return least + (most - least) * to_double(random.uniform());
}
/// 10^x for a random x between the two.
double size(Random& random, double least, double most) { return std::pow(10.0, chance(random, least, most)); }

/// Rods and plates that spin. `extreme`: some are far smaller, larger, thinner and faster than the lanes' numbers can
/// hold.
void add_spinning(Rig& rig, std::uint64_t seed, int count, bool extreme) {
    Random random = Random::seeded(seed);
    for (int i = 0; i < count; ++i) {
        const bool far = extreme && random.below(4) == 0;
        const double k = far ? size(random, -4, 4) : size(random, -1.5, 0.3);
        const double along = far ? size(random, -3, 3) : chance(random, 0.2, 0.9);
        const std::uint32_t row =
            rig.add(1, {k, k * along, k * chance(random, 0.2, 0.9)}, {0, 0, 0},
                    turn({chance(random, -1, 1), 0.3, chance(random, -1, 1)}, chance(random, -3, 3)));
        if (random.below(2) == 0)
            rig.mass[row].principal =
                turn({0.2, chance(random, -1, 1), chance(random, -1, 1)}, chance(random, -3, 3));
        const double spin = far ? size(random, 0, 3.3) : chance(random, 5, 80);
        for (int axis = 0; axis < 3; ++axis)
            rig.velocity[row].angular[axis] = quantize<Speed>(chance(random, -spin, spin));
        if (random.below(30) == 0) rig.traits[row].angular_damping = real(0.5);
    }
}

/// Two of three bodies have joints, and some of these are stiffened.
void begin(Rig& rig, const StepConstants& step, bool stiffens) {
    begin_step(rig.columns(), Vec3{}, step, rig.bodies);
    for (std::uint32_t row = 0; row < rig.info.size(); ++row) {
        BodyStep& s = rig.bodies.step[row];
        s.jointed = row % 3 != 0;
        if (stiffens && s.jointed && row % 7 == 0)
            set_radii(rig.columns(), row, {s.radii.x + half(s.radii.x), s.radii.y, s.radii.z + s.radii.z},
                      step, rig.bodies, rig.bodies.clamps);
    }
    follow_turns(rig.columns(), step, rig.bodies, nullptr);
}

/// Adds random changes to u, as contacts and joints do.
void kick(Rig& rig, Random& random, double most) {
    for (std::size_t i = 0; i < rig.info.size(); ++i)
        for (std::int64_t& u : rig.bodies.body[i].u)
            if (random.below(2) == 0) u += std::llround(chance(random, -most, most) * 0x1p47);
}

void substep(Rig& rig, const StepConstants& step, Random& random, double kicks) {
    integrate_velocities({Scheme::semi_implicit_euler, {}}, rig.columns(), step, rig.bodies);
    note_u(rig.bodies), kick(rig, random, kicks), keep_velocity(rig.bodies);
    turn_in(step, rig.bodies), kick(rig, random, kicks), turn_out(rig.bodies);
    integrate_poses(step, rig.bodies);
}

auto told(const FollowedTurn& turn) {
    const Symmetric<std::int32_t>& k = turn.now.inv_mantissa;
    return std::tuple(std::array{k.xx, k.yy, k.zz, k.xy, k.xz, k.yz, turn.now.inv_exponent},
                      std::to_array(turn.turned), turn.rotation, turn.held, turn.stiff);
}

/// A kernel that flips a bit, or one whose lanes hold no body.
struct Meddled {
    static inline FollowKernel real;
    static void answer(const FollowPass& pass, std::uint32_t first, std::uint32_t last) {
        real.answer(pass, first, last);
        pass.turns[first * followed_lanes].turned[0] ^= 1;
    }
    static void start(const FollowPass& pass, std::uint32_t first, std::uint32_t last) {
        real.start(pass, first, last);
        for (std::uint32_t i = first; i < last; ++i) {
            for (std::int64_t& mask : pass.fours[i].alone) mask = -1;
            pass.fours[i].left = 15;
        }
    }
    static BodyKernel faulty(const BodyKernel& kernel) {
        BodyKernel meddled = kernel;
        real = kernel.followed, meddled.followed.answer = answer;
        return meddled;
    }
    static BodyKernel without_room(const BodyKernel& kernel) {
        BodyKernel meddled = kernel;
        real = kernel.followed, meddled.followed.start = start;
        return meddled;
    }
};

/// Returns how many bodies move or turn otherwise in some tick.
int differences(const BodyKernel& by, const BodyKernel* other) {
    Rig a, b;
    a.bodies.kernel = &by, b.bodies.kernel = other;
    add_spinning(a, 5, 501, true), add_spinning(b, 5, 501, true); // 501 is no multiple of the lanes
    const StepConstants step = a.constants();
    Random random_a = Random::seeded(1), random_b = random_a;
    int different = 0, left = 0;
    for (int tick = 0; tick < 3; ++tick) {
        begin(a, step, true), begin(b, step, true);
        CHECK(a.bodies.fours.size() > 80);
        CHECK(a.bodies.turns.size() == b.bodies.turns.size());
        for (std::int32_t i = 0; i < step.substeps; ++i) {
            substep(a, step, random_a, 2), substep(b, step, random_b, 2);
            for (std::size_t at = 0; at < a.bodies.turns.size(); ++at)
                different += told(a.bodies.turns[at]) == told(b.bodies.turns[at]) ? 0 : 1;
            for (const FollowedFour& four : a.bodies.fours) left += four.left != 0;
            different += std::memcmp(a.bodies.body.data(), b.bodies.body.data(),
                                     a.info.size() * sizeof(SolverBody)) == 0
                             ? 0
                             : 1;
        }
        finish_step(step, a.bodies, a.columns()), finish_step(step, b.bodies, b.columns());
        for (std::size_t i = 0; i < a.info.size(); ++i)
            different += a.pose[i] == b.pose[i] && a.velocity[i] == b.velocity[i] ? 0 : 1;
    }
    CHECK(left > 100); // the lanes leave some bodies to the scalar code
    return different;
}

double distance(Quat a, Quat b) {
    const double parts[4] = {to_double(a.x) - to_double(b.x), to_double(a.y) - to_double(b.y),
                             to_double(a.z) - to_double(b.z), to_double(a.w) - to_double(b.w)};
    double sum = 0;
    for (const double part : parts) sum += part * part;
    return std::sqrt(sum);
}

/// Returns the largest difference between the followed K^-1 and the K^-1 of the body's rotation.
double inertia_error(const Rig& rig, const FollowedTurn& turn) {
    BodyStep s = rig.bodies.step[turn.body];
    set_gyration(s, to_rotation(turn.rotation * turn.principal));
    const auto entries = [](const auto& k) { return std::array{k.xx, k.yy, k.zz, k.xy, k.xz, k.yz}; };
    const auto now = entries(turn.now.inv_mantissa);
    const auto exact = entries(s.gyration_inv);
    double error = 0, largest = 0;
    for (std::size_t i = 0; i < 6; ++i) {
        largest = std::max(largest, std::abs(to_double(exact[i])));
        error = std::max(error, std::abs(std::ldexp(now[i], -turn.now.inv_exponent) - to_double(exact[i])));
    }
    return error / largest;
}

} // namespace

TEST_CASE("followed bodies turn alike in every instruction set") {
    for (const Simd level : {Simd::sse41, Simd::avx2, Simd::neon, Simd::wasm128}) {
        const Kernels* kernels = kernels_of(level);
        if (kernels == nullptr) continue;
        CHECK(differences(*kernels->bodies, &scalar_bodies) == 0);
        const BodyKernel faulty = Meddled::faulty(scalar_bodies); // planted fault: one bit
        CHECK(differences(*kernels->bodies, &faulty) > 0);
    }
    CHECK(differences(scalar_bodies, nullptr) == 0);
}

TEST_CASE("followed bodies turn in lanes as in Real up to rounding") {
    Rig lanes, alone;
    const BodyKernel without_room = Meddled::without_room(scalar_bodies);
    alone.bodies.kernel = &without_room;
    add_spinning(lanes, 9, 400, false), add_spinning(alone, 9, 400, false);
    const StepConstants step = lanes.constants();
    Random random = Random::seeded(2), same = random;
    double spin_error = 0, turn_error = 0, inverse_error = 0, turned = 0;
    begin(lanes, step, false), begin(alone, step, false);
    std::size_t in_lanes = 0;
    for (std::int32_t i = 0; i < step.substeps; ++i) {
        substep(lanes, step, random, 0.02), substep(alone, step, same, 0.02);
        for (const FollowedFour& four : lanes.bodies.fours) in_lanes += four.left == 0;
        for (const FollowedTurn& turn : lanes.bodies.turns)
            if (turn.body != lanes.bodies.still())
                inverse_error = std::max(inverse_error, inertia_error(lanes, turn));
    }
    finish_step(step, lanes.bodies, lanes.columns()), finish_step(step, alone.bodies, alone.columns());
    Rig before;
    add_spinning(before, 9, 400, false);
    for (std::uint32_t row = 0; row < lanes.info.size(); ++row) {
        spin_error = std::max(spin_error, length(lanes.w(row) - alone.w(row)) / length(alone.w(row)));
        turn_error = std::max(turn_error, distance(lanes.pose[row].rotation, alone.pose[row].rotation));
        turned = std::max(turned, distance(before.pose[row].rotation, alone.pose[row].rotation));
    }
    INFO(spin_error, " of w, ", turn_error, " of rotations, ", inverse_error, " of K^-1, ", turned);
    CHECK(in_lanes > lanes.bodies.fours.size() * 2); // in two of eight substeps
    CHECK(turned > 0.5);
    CHECK(spin_error < 1e-5);
    CHECK(turn_error < 1e-6);
    CHECK(inverse_error < 3e-8);
}

TEST_CASE("followed bodies stay unchanged when joints and contacts add no impulse") {
    Rig rig;
    add_spinning(rig, 3, 200, true);
    const StepConstants step = rig.constants();
    begin(rig, step, true);
    Random chance = Random::seeded(1);
    substep(rig, step, chance, 0.5);
    const std::vector<SolverBody> bodies = rig.bodies.body;
    const auto kept = [&] {
        std::vector<std::int64_t> all;
        for (const FollowedFour& four : rig.bodies.fours)
            for (const auto& part : four.precession) all.insert(all.end(), part, part + followed_lanes);
        return all;
    };
    const std::vector<std::int64_t> precession = kept();
    for (int i = 0; i < 100; ++i) {
        note_u(rig.bodies), keep_velocity(rig.bodies);
        turn_in(step, rig.bodies), turn_out(rig.bodies);
    }
    CHECK(kept() == precession);
    CHECK(std::memcmp(bodies.data(), rig.bodies.body.data(), rig.info.size() * sizeof(SolverBody)) == 0);
}
