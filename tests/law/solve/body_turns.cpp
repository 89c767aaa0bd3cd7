// Bodies begin and end a tick with equal results in lanes and one by one, and whether or not they share the values that
// their traits determine.
#include "lockstone/math/random.h"
#include "support/rigs/joint_rig.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::rig;

namespace {

/// Wraps a kernel, counts the bodies that it handles and those that it leaves to the scalar code, and may flip one bit.
struct Counted {
    static inline const BodyKernel* real = nullptr;
    static inline std::uint32_t begun, not_begun, ended, not_ended;
    static inline bool is_faulty;

    static std::uint32_t begin(const StartPass& pass, const std::uint32_t* rows, std::uint32_t count,
                               std::uint32_t* left) {
        const std::uint32_t alone = real->begin_turning(pass, rows, count, left);
        begun += count - alone, not_begun += alone;
        return alone;
    }
    static std::uint32_t finish(const EndPass& pass, const std::uint32_t* rows, std::uint32_t count,
                                std::uint32_t* left) {
        const std::uint32_t alone = real->finish(pass, rows, count, left);
        ended += count - alone, not_ended += alone;
        if (is_faulty) pass.poses[rows[0]].rotation.x.raw ^= 1;
        return alone;
    }
    static BodyKernel of(const BodyKernel& kernel, bool faulty) {
        BodyKernel counted = kernel;
        real = &kernel, begun = not_begun = ended = not_ended = 0, is_faulty = faulty;
        counted.begin_turning = begin, counted.finish = finish;
        return counted;
    }
};

double chance(Random& random, double least, double most) {
    return least + (most - least) * to_double(random.uniform());
}
/// 10^x for a random x between the two.
double size(Random& random, double least, double most) { return std::pow(10.0, chance(random, least, most)); }

/// Bodies of all sizes and spins: rods, plates, cubes, with and without principal axes of their own; some near the end
/// of the world.
void add_bodies(Rig& rig, std::uint64_t seed) {
    Random random = Random::seeded(seed);
    for (int i = 0; i < 3000; ++i) {
        const bool extreme = random.below(8) == 0;
        const double k = extreme ? size(random, -3, 3) : size(random, -1.5, 0.3);
        const bool round = random.below(4) == 0;
        const double along = round ? 1 : extreme ? size(random, -2, 2) : chance(random, 0.2, 2);
        const double far = random.below(50) == 0 ? 999999999.9 : 100;
        const std::uint32_t row =
            rig.add(random.below(20) == 0 ? 0 : size(random, -2, 3),
                    {k, k * along, round ? k : k * chance(random, 0.2, 2)},
                    {far, chance(random, -far, far), chance(random, -far, far)},
                    turn({chance(random, -1, 1), 0.3, chance(random, -1, 1)}, chance(random, -3, 3)));
        if (random.below(2) == 0)
            rig.mass[row].principal =
                turn({0.2, chance(random, -1, 1), chance(random, -1, 1)}, chance(random, -3, 3));
        if (random.below(10) == 0) rig.traits[row].gyroscopic = 0;
        if (random.below(20) == 0) rig.traits[row].locks = random.below(64);
        const double spin = size(random, -5, extreme ? 3.3 : 1);
        for (int axis = 0; axis < 3; ++axis) {
            rig.velocity[row].linear[axis] = quantize<Speed>(chance(random, -30, 30));
            rig.velocity[row].angular[axis] = quantize<Speed>(chance(random, -spin, spin));
        }
    }
}

bool operator==(const Symmetric<Real>& a, const Symmetric<Real>& b) {
    return a.xx == b.xx && a.yy == b.yy && a.zz == b.zz && a.xy == b.xy && a.xz == b.xz && a.yz == b.yz;
}
bool is_alike(const BodyStep& a, const BodyStep& b) {
    const auto mantissas = [](const BodyStep& s) {
        const Symmetric<std::int32_t>& m = s.inv_mantissa;
        return std::array{m.xx, m.yy, m.zz, m.xy, m.xz, m.yz, s.inv_exponent};
    };
    return a.gyration == b.gyration && a.gyration_inv == b.gyration_inv && mantissas(a) == mantissas(b) &&
           a.gyration_bits == b.gyration_bits && a.gyration_inv_bits == b.gyration_inv_bits &&
           a.radii_inv == b.radii_inv;
}

/// Gives some bodies larger radii, as joints that pull hard do. `planted`: the bodies end the tick with the radii of
/// their traits.
void stiffen_some(Rig& rig, const StepConstants& step, bool planted) {
    for (std::uint32_t row = 0; row < rig.info.size(); row += 7) {
        if (!rig.bodies.step[row].movable) continue;
        const Vec3 k = rig.bodies.step[row].radii;
        set_radii(rig.columns(), row, {k.x + half(k.x), k.y, k.z + k.z}, step, rig.bodies, rig.bodies.clamps);
        if (planted && rig.bodies.step[row].angular_mask == 7u) rig.bodies.plain[row] |= plain_end;
    }
}

/// Returns how many bodies begin or end the tick with other values in lanes than alone.
int differences(std::uint64_t seed, const BodyKernel* kernel, bool stiff_as_traits = false) {
    Rig alone, lanes;
    add_bodies(alone, seed), add_bodies(lanes, seed);
    lanes.bodies.kernel = kernel;
    const StepConstants step = alone.constants();
    int different = 0;
    alone.begin(step), lanes.begin(step);
    stiffen_some(alone, step, false), stiffen_some(lanes, step, stiff_as_traits);
    for (std::size_t i = 0; i < alone.info.size(); ++i) {
        const SolverBody &a = alone.bodies.body[i], &b = lanes.bodies.body[i];
        different +=
            is_alike(alone.bodies.step[i], lanes.bodies.step[i]) && std::equal(a.u, a.u + 3, b.u) ? 0 : 1;
    }
    for (std::int32_t i = 0; i < step.substeps; ++i) alone.substep(step), lanes.substep(step);
    finish_step(step, alone.bodies, alone.columns());
    finish_step(step, lanes.bodies, lanes.columns());
    for (std::size_t i = 0; i < alone.info.size(); ++i)
        different += alone.pose[i] == lanes.pose[i] && alone.velocity[i] == lanes.velocity[i] ? 0 : 1;
    const ClampCounts &a = alone.bodies.clamps, &b = lanes.bodies.clamps;
    return different + (a.speed == b.speed && a.position == b.position ? 0 : 1);
}

bool begins_alike(const Rig& a, const Rig& b, std::size_t i) {
    const BodyStep &x = a.bodies.step[i], &y = b.bodies.step[i];
    const SolverBody &p = a.bodies.body[i], &q = b.bodies.body[i];
    const auto rest = [](const BodyStep& s) {
        return std::tuple(s.linear_mask, s.angular_mask, s.mass, s.movable, s.moves, s.jointed, s.radii,
                          s.linear_keep, s.angular_keep);
    };
    const auto push = [i](const Rig& rig) {
        const SolverBodies& all = rig.bodies;
        const BodyPush& s = (all.plain[i] & plain_falls) != 0 ? all.fall : all.push[i];
        return std::tuple(s.acceleration, std::to_array(s.dv), std::to_array(s.du));
    };
    const auto numbers = [](const SolverBody& s) {
        return std::tuple(std::to_array(s.v), std::to_array(s.u), std::to_array(s.shift),
                          std::to_array(s.theta), std::to_array(s.keep));
    };
    return is_alike(x, y) && rest(x) == rest(y) && numbers(p) == numbers(q) &&
           (!x.movable || push(a) == push(b)) && a.bodies.plain[i] == b.bodies.plain[i];
}

} // namespace

TEST_CASE("bodies begin a tick with the same values when they share the data of their traits and when they "
          "do not") {
    for (const bool faulty : {false, true}) {
        Rig alone, shared;
        const StepConstants step = alone.constants();
        for (Rig* rig : {&alone, &shared}) {
            add_bodies(*rig, 11);
            for (std::uint32_t i = 0; i < rig->info.size(); ++i) rig->info[i].traits = i % 80;
            for (std::uint32_t i = 0; i < 80; i += 3) rig->traits[i].linear_damping = real(0.1 * i);
            for (std::uint32_t i = 0; i < rig->info.size(); i += 5) rig->info[i].first_joint = 1;
        }
        // No force at all, and a force of zero. The planted fault: a force that is not zero.
        shared.pushes.assign(shared.pushes.size(), 0);
        if (faulty) alone.force[100].force = vec(1, 0, 0);
        begin_step(alone.columns(), alone.gravity, step, alone.bodies);
        begin_step(shared.columns(), shared.gravity, step, shared.bodies);
        int different = 0;
        for (std::size_t i = 0; i < alone.info.size(); ++i)
            different += begins_alike(alone, shared, i) ? 0 : 1;
        CHECK((different != 0) == faulty);
        CHECK(alone.bodies.clamps.speed == shared.bodies.clamps.speed);
        CHECK(shared.bodies.starts.size() == starts_max);
    }
}

TEST_CASE("bodies begin and end a tick with the same values in lanes and alone") {
    for (const Simd level : {Simd::scalar, Simd::sse41, Simd::avx2, Simd::neon, Simd::wasm128}) {
        const Kernels* kernels = kernels_of(level);
        if (kernels == nullptr) continue;
        for (const bool faulty : {false, true}) {
            const BodyKernel kernel = Counted::of(*kernels->bodies, faulty);
            const int different = differences(7, &kernel);
            CHECK((different != 0) == faulty); // planted fault: one bit of one body of a chunk
            // Planted fault: stiffened bodies end the tick with the radii of their traits.
            if (!faulty) CHECK(differences(7, &kernel, true) > 10);
            // Lanes handle most bodies, but not all.
            CHECK(Counted::begun > 4 * Counted::not_begun);
            CHECK(Counted::ended > 2 * Counted::not_ended);
            CHECK(Counted::not_begun > 0);
            CHECK(Counted::not_ended > 0);
        }
    }
}
