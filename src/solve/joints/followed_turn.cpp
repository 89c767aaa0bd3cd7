#include "solve/joints/followed_turn.h"

#include "lockstone/math/math.h"
#include "solve/bodies/free_turn.h"
#include "solve/kernels/kernels.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

Vec3 to_real(const std::int64_t v[3]) {
    const auto one = [](std::int64_t x) {
        return Real::from_raw(shift_right_rounded(x, real_to_accumulator));
    };
    return {one(v[0]), one(v[1]), one(v[2])};
}

/// R diag(radii^-2) R^T momentum, R for the body at `rotation`
Vec3 spin_at(Quat rotation, const FollowedTurn& turn, Vec3 momentum) {
    const Rotation axes = to_rotation(rotation * turn.principal);
    const Vec3 inside = mul_transposed<Real>(axes, momentum);
    return mul<Real>(axes, times_each(times_each(inside, turn.radii_inv), turn.radii_inv));
}

/// A followed body, with its lane.
struct Followed {
    FollowedFour& four;
    unsigned lane;
    FollowedTurn& turn;
    SolverBody& body;
    const BodyStep& step;

    Followed(SolverBodies& bodies, std::size_t at)
        : four(bodies.fours[at / followed_lanes]), lane(at % followed_lanes), turn(bodies.turns[at]),
          body(bodies.body[turn.body]), step(bodies.step[turn.body]) {}

    /// Angular momentum per mass, K m.
    Vec3 momentum() const {
        // Far above every speed that a body can keep [m/s]; no sum overflows 64 bits.
        constexpr std::int64_t most = std::int64_t{2048} << accumulator_bits;
        std::int64_t own[3];
        for (int i = 0; i < 3; ++i) own[i] = std::clamp(body.u[i] - four.precession[i][lane], -most, most);
        return mul<Real>(step.gyration, to_real(own));
    }
    Vec3 spin() const { return mul<Real>(step.gyration_inv, to_real(body.u)); }
    /// Sets u from w, clamped to the tip speed limit. Except for a stiff body, the change of u is added to g.
    void set_spin(Vec3 w, const StepConstants& constants) {
        const Vec3 fast = mul<Real>(step.gyration, w);
        const Real most = to<Real>(constants.tip_speed_max);
        for (int i = 0; i < 3; ++i) {
            const std::int64_t u = clamp(fast[i], -most, most).raw * (std::int64_t{1} << real_to_accumulator);
            std::int64_t& g = four.precession[i][lane];
            if (!turn.stiff) g = std::clamp(g + u - body.u[i], -precession_most, precession_most);
            body.u[i] = u;
        }
        give_spin(w);
    }
    /// Stores w in the format of TurnedBody.
    void give_spin(Vec3 w) {
        constexpr std::int64_t most = std::int64_t{2048} << Speed::fraction_bits;
        for (int i = 0; i < 3; ++i)
            turn.turned[9 + i] = static_cast<std::int32_t>(
                std::clamp(w[i].raw >> (Real::fraction_bits - Speed::fraction_bits), -most, most));
    }
};

// ---- single bodies, in Real ----------------------------------------------------------------------------------------

Quat quat_of(const FollowedFour::Lanes<std::int32_t> (&q)[4], unsigned i) {
    return {Unit::from_raw(q[0][i]), Unit::from_raw(q[1][i]), Unit::from_raw(q[2][i]),
            Unit::from_raw(q[3][i])};
}

/// Changes the momentum per mass of a body.
void set_momentum(Followed f, Vec3 from, Vec3 to) {
    if (from == to) return;
    const Vec3 change = mul<Real>(f.step.gyration_inv, to - from);
    constexpr std::int64_t most_u = std::int64_t{1} << 62; // leaves room for a subtraction
    for (int i = 0; i < 3; ++i)
        f.body.u[i] =
            std::clamp(add_saturated(f.body.u[i], shift_left_saturated(change[i].raw, real_to_accumulator)),
                       -most_u, most_u);
}

/// Contacts push a turned body with the rows of the start of the tick. On a thin body the push then has a part about
/// its own axis, where its inertia is small. This limits the momentum so that the body gains no more energy than the
/// rows gave.
Vec3 limit_energy(Followed f, const FreeTurn& turn, Vec3 momentum) {
    const Wide given = square_of(to_real(f.body.u)) - f.turn.energy_of_u,
               most = given.is_negative() ? f.turn.energy : f.turn.energy + given;
    const Vec3 limited = turn.with_energy(most, f.turn.rotation, momentum, FreeTurn::Keep::not_above);
    set_momentum(f, momentum, limited);
    return limited;
}

/// The turn of a substep for a body that turns too far for lanes: by its u, or by its momentum after
/// precess_exactly().
void turn_far(Followed f, const StepConstants& step) {
    auto& q = f.four.turn;
    const unsigned i = f.lane;
    Quat next;
    if (!f.turn.knows_energy) {
        next = integrate_rotation(quat_of(q, i), scale<Real>(f.spin(), step.substep_time));
    } else {
        const FreeTurn turn(f.turn.radii_inv, f.turn.principal);
        const Vec3 momentum = f.turn.held ? f.momentum() : limit_energy(f, turn, f.momentum());
        f.turn.knows_energy = false;
        const Quat to = turn.turned_exactly(f.turn.rotation, momentum, Real(step.substeps_per_second));
        next = normalized(to * conjugate(quat_of(f.four.start, i)));
    }
    q[0][i] = next.x.raw, q[1][i] = next.y.raw, q[2][i] = next.z.raw, q[3][i] = next.w.raw;
}

/// True if the midpoint rule does not converge. The test uses the momentum and, as in lanes, a turn of half a substep
/// of 1/4 rad.
bool turns_too_far(const FollowedTurn& turn, Vec3 w, Vec3 momentum, const StepConstants& step) {
    const Vec3 r = turn.radii_inv, speed = abs(w);
    const Real most = max(r.x, max(r.y, r.z)), least = min(r.x, min(r.y, r.z)),
               half_rate = Real(2 * step.substeps_per_second);
    return length(momentum) * (most * most - least * least) > half_turn_most * half_rate ||
           max(speed.x, max(speed.y, speed.z)) >= half_rate / Real(4);
}

/// Sets w to that of the middle of the coming substep, with the turn computed from the momentum. The speed stays
/// below the tip speed limit, because precession is set to zero there.
void precess_exactly(Followed f, Vec3 momentum, const StepConstants& step) {
    const FreeTurn turn(f.turn.radii_inv, f.turn.principal);
    const Quat middle = turn.turned(f.turn.rotation, momentum, Real(2 * step.substeps_per_second));
    Vec3 w = turn.spin_at(middle, momentum);
    const Real fast = length(mul<Real>(f.step.gyration, w)), most = to<Real>(step.tip_speed_max);
    if (fast > most - most / Real(16)) w = w * ((most - most / Real(16)) / fast);
    f.set_spin(w, step);
    f.turn.knows_energy = true;
    f.turn.energy = turn.energy(f.turn.rotation, momentum), f.turn.energy_of_u = square_of(to_real(f.body.u));
}

/// Computes g of a body that turns too far for lanes, with the same number of rounds.
void precess_far(Followed f, const StepConstants& step) {
    constexpr int rounds = 3;
    const Unit half_time = Unit::from_raw(step.substep_time.raw / 2);
    const Vec3 momentum = f.momentum();
    Vec3 w = f.spin();
    if (turns_too_far(f.turn, w, momentum, step)) return precess_exactly(f, momentum, step);
    for (int round = 0; round < rounds; ++round) {
        const Quat middle = integrate_rotation(f.turn.rotation, scale<Real>(w, half_time));
        w = spin_at(middle, f.turn, momentum);
    }
    f.set_spin(w, step);
}

/// R diag(own^2) R^T w at the present rotation
Vec3 momentum_of(const FollowedTurn& turn, Vec3 w) {
    const Rotation axes = to_rotation(turn.rotation * turn.principal);
    return mul<Real>(axes, times_each(times_each(mul_transposed<Real>(axes, w), turn.own), turn.own));
}

/// Applies the gyroscopic torque of the real body to the enlarged inertia for a substep. Three rounds of the midpoint
/// rule lose a little energy; two gain it.
void precess_stiff(Followed f, const StepConstants& step) {
    constexpr int rounds = 3;
    const Vec3 before = f.spin();
    Vec3 w = before;
    for (int round = 0; round < rounds; ++round) {
        const Vec3 sum = before + w, middle{half(sum.x), half(sum.y), half(sum.z)};
        const Vec3 torque = cross(momentum_of(f.turn, middle), middle);
        w = before + scale<Real>(spin_at(f.turn.rotation, f.turn, torque), step.substep_time);
    }
    f.set_spin(w, step);
}

// ---- start of a tick -----------------------------------------------------------------------------------------------

/// Free bodies are followed beyond 1 / spin_parts rad per tick. Below that, the arms of contacts, which are those of
/// the start of the tick, are the larger error: a top on a floor behaves better if its whole turn is made after the
/// tick.
constexpr int spin_parts = 2;
/// For bodies with joints. Chains under load come apart with 4, and gain energy with 8 when they are snatched.
constexpr int held_parts = 16;

/// Tests if a body turns about some axis by more than 1 / `parts` rad in a tick.
class TurnsBy {
    std::int32_t most; ///< Speed; below 2^30, since there are at most 1000 ticks a second

  public:
    TurnsBy(int parts, const StepConstants& step)
        : most(static_cast<std::int32_t>((std::int64_t{step.ticks_per_second} << Speed::fraction_bits) /
                                         parts)) {}
    bool operator()(const Velocity& v) const {
        const SpeedVec3& w = v.angular;
        return w.x.raw > most || w.y.raw > most || w.z.raw > most || w.x.raw < -most || w.y.raw < -most ||
               w.z.raw < -most;
    }
};
/// True if gyroscopic torque acts on the body.
bool is_gyroscope(const BodyColumns& columns, std::uint32_t row, const BodyStep& s) {
    if (!s.movable || (s.radii.x == s.radii.y && s.radii.y == s.radii.z)) return false;
    return s.turn == 0 && columns.traits(row).gyroscopic != 0 && s.angular_mask == 7u;
}

/// A body is thin if its largest radius of gyration exceeds this many times its smallest. Contact rows have the arms
/// of the start of the tick. While a thin body is followed, an impulse across its long axis at the start soon has a
/// part along that axis, and spins the body by the square of this ratio. Without joints, a thin body is therefore not
/// followed but turned after the tick, which adds no energy.
constexpr int thin_ratio = 4;

bool is_thin(Vec3 radii) {
    return max(radii.x, max(radii.y, radii.z)) > min(radii.x, min(radii.y, radii.z)) * thin_ratio;
}

template <class T> using Lanes = FollowedFour::Lanes<T>;

/// x / 2^drop, rounded, for |x| below 2^62. A negative drop multiplies.
std::int64_t shortened(std::int64_t x, int drop) {
    return drop > 0 ? shift_right_rounded(x, drop) : x * (std::int64_t{1} << std::min(-drop, 30));
}

/// Writes a diagonal as mantissas up to 2^30: the third entry, and the differences of the others from it. Returns
/// their fraction bits.
int set_diagonal(Lanes<std::int32_t> (&out)[3], unsigned lane, Vec3 d) {
    const int drop = bit_length(magnitude(d.x.raw) | magnitude(d.y.raw) | magnitude(d.z.raw)) - 30;
    std::int64_t m[3];
    for (int i = 0; i < 3; ++i) m[i] = shortened(d[i].raw, drop);
    out[0][lane] = static_cast<std::int32_t>(m[2]);
    for (int i = 0; i < 2; ++i) out[1 + i][lane] = static_cast<std::int32_t>(m[i] - m[2]);
    return Real::fraction_bits - drop;
}

/// Clamps a shift to the range that lanes support. Returns false if this changes it.
bool set_shift(std::int64_t& out, int shift, int least) {
    out = std::clamp(shift, least, 62);
    return out == shift;
}

/// radii^-2 / (2 substeps per second), the factor of a momentum with `momentum_bits`. Returns false if it does not
/// fit.
bool set_half_way(FollowedFour& four, unsigned lane, Vec3 radii_inv, int momentum_bits,
                  std::int32_t half_rate) {
    bool fits = true;
    for (int i = 0; i < 3; ++i) {
        const std::uint64_t inverse = magnitude(radii_inv[i].raw);
        const int drop = bit_length(inverse) - 31;
        const auto short_one =
            static_cast<std::uint64_t>(shortened(static_cast<std::int64_t>(inverse), drop));
        const std::uint64_t way = short_one * short_one / static_cast<std::uint32_t>(half_rate);
        const int way_drop = bit_length(way) - 30;
        const std::int64_t mantissa = shortened(static_cast<std::int64_t>(way), way_drop);
        four.half_way[i][lane] = static_cast<std::int32_t>(mantissa);
        const int bits = 2 * (Real::fraction_bits - drop) - way_drop + momentum_bits;
        fits =
            set_shift(four.half_way_drop[i][lane], mantissa == 0 ? 1 : bits - followed_half_bits, 1) && fits;
    }
    return fits;
}

/// The time of half a substep as a mantissa in [2^29, 2^30] with fraction bits.
struct HalfTime {
    std::int32_t mantissa;
    int bits;
    explicit HalfTime(std::int32_t half_rate)
        : mantissa(0), bits(29 + bit_length(static_cast<std::uint32_t>(half_rate))) {
        mantissa = static_cast<std::int32_t>((std::int64_t{1} << bits) / half_rate);
    }
};

std::int32_t half_rate_of(const StepConstants& step) {
    return static_cast<std::int32_t>(2 * step.substeps_per_second);
}

/// The square of half the largest momentum for lanes, with `bits` fraction bits: half_turn_most divided by the
/// difference of K^-2 along the axes of the smallest and the largest radius.
std::int64_t momentum_most_of(Vec3 radii_inv, std::int32_t half_rate, int bits) {
    const Real most = max(radii_inv.x, max(radii_inv.y, radii_inv.z)),
               least = min(radii_inv.x, min(radii_inv.y, radii_inv.z));
    const Real momentum = half(half_turn_most) * Real(half_rate) / (most * most - least * least);
    constexpr std::int64_t any = (std::int64_t{1} << 31) - 1; // bound of half a momentum
    const int drop = Real::fraction_bits - bits;
    const std::int64_t halved = std::min(any, drop >= 0 ? shift_right_rounded(momentum.raw, drop)
                                                        : shift_left_saturated(momentum.raw, -drop));
    return halved * halved;
}

/// Fills the data that depends on the radii of a body.
void set_radii(FollowedFour& four, unsigned lane, const BodyStep& s, const StepConstants& step) {
    const int k_bits = set_diagonal(four.radii, lane, s.radii),
              inverse_bits = set_diagonal(four.inverses, lane, s.radii_inv);
    four.inverse_bits[lane] = inverse_bits;
    const std::int32_t half_rate = half_rate_of(step);
    // Products of two mantissas and fine u drop 31 bits, and so do products of a turn and K.
    const int to_half =
        inverse_bits + followed_fine_bits - 31 + HalfTime(half_rate).bits - followed_half_bits;
    bool fits = set_shift(four.turn_drop[lane], to_half, 1);
    const int momentum_bits = k_bits + followed_fine_bits - 31;
    fits = set_half_way(four, lane, s.radii_inv, momentum_bits, half_rate) && fits;
    four.momentum_most[lane] = momentum_most_of(s.radii_inv, half_rate, momentum_bits);
    fits =
        set_shift(four.speed_raise[lane], accumulator_bits - (k_bits + followed_half_bits - 31), 0) && fits;
    four.speed_most[lane] = (std::int64_t{step.tip_speed_max.raw} << row_bits) >> four.speed_raise[lane];
    four.alone[lane] = fits ? 0 : -1;
    // Products of K' and K^-1 drop 30 bits.
    const int bits = k_bits + inverse_bits - 30 + followed_change_bits;
    four.change_raise[lane] = std::clamp(accumulator_bits - bits, 0, 62);
    four.change_drop[lane] = std::clamp(bits - accumulator_bits, 0, 62);
    four.change_most[lane] = bits > 50 ? std::int64_t{1} << 62 : std::int64_t{4096} << std::max(bits, 0);
}

void set_quat(Lanes<std::int32_t> (&out)[4], unsigned lane, Quat q) {
    out[0][lane] = q.x.raw, out[1][lane] = q.y.raw, out[2][lane] = q.z.raw, out[3][lane] = q.w.raw;
}

/// Adds an element. A full vector grows by only an eighth, since all bodies of a heap are added in one tick.
template <class T> T& add(std::vector<T>& v) {
    if (v.size() == v.capacity()) v.reserve(v.size() + v.size() / 8 + 16);
    return v.emplace_back();
}

/// Adds a body to the followed ones, without its data.
void follow(std::uint32_t row, SolverBodies& bodies) {
    const std::size_t at = bodies.turns.size();
    FollowedFour& four = at % followed_lanes == 0 ? add(bodies.fours) : bodies.fours.back();
    four.row[at % followed_lanes] = add(bodies.turns).body = row;
    bodies.step[row].turn = static_cast<std::uint32_t>(at + 1);
}

/// Fills the data of a followed body for the start of the tick.
void start_turn(const BodyColumns& columns, std::size_t at, const StepConstants& step, SolverBodies& bodies) {
    const unsigned lane = at % followed_lanes;
    FollowedTurn& turn = bodies.turns[at];
    FollowedFour& four = bodies.fours[at / followed_lanes];
    const std::uint32_t row = turn.body;
    if (row == bodies.still()) { // lane without a body
        four.start[3][lane] = four.principal[3][lane] = unit_one.raw;
        return;
    }
    const BodyStep& s = bodies.step[row];
    turn.principal = columns.mass[row].principal;
    turn.radii_inv = s.radii_inv;
    turn.own = columns.mass[row].gyration;
    turn.held = s.jointed;
    turn.stiff = s.radii != turn.own;
    turn.meets_still = false;
    four.any_held = four.any_held || turn.held;
    four.held[lane] = turn.held ? -1 : 0, four.stiff[lane] = turn.stiff ? -1 : 0;
    four.linear_mask[lane] = static_cast<std::int32_t>(s.linear_mask);
    set_quat(four.start, lane, normalized(columns.pose[row].rotation));
    set_quat(four.principal, lane, turn.principal);
    set_radii(four, lane, s, step);
    // Clears the flags of kernel paths that followed bodies cannot use: they end the tick differently, and damping
    // also has to damp their precession.
    const bool is_damped = (bodies.plain[row] & plain_damped) != 0;
    bodies.plain[row] &= plain_pose | plain_falls | (is_damped ? 0 : plain_velocity);
}

/// Pointers of a pass; the times stay zero.
FollowPass pass_of(SolverBodies& bodies) {
    return {bodies.body.data(), bodies.fours.data(), bodies.turns.data(), 0, 0, 0};
}
FollowPass pass_of(const StepConstants& step, SolverBodies& bodies) {
    FollowPass pass = pass_of(bodies);
    pass.tip_most = std::int64_t{step.tip_speed_max.raw} << row_bits;
    pass.half_rate = half_rate_of(step), pass.half_time = HalfTime(pass.half_rate).mantissa;
    return pass;
}

const FollowKernel& kernel_of(const SolverBodies& bodies) {
    return (bodies.kernel != nullptr ? *bodies.kernel : scalar_bodies).followed;
}

/// Calls visit(Followed) for the lanes in FollowedFours [first, last) that the kernel could not process.
template <class Visit>
void for_each_left(SolverBodies& bodies, std::uint32_t first, std::uint32_t last, Visit&& visit) {
    for (std::uint32_t i = first; i < last; ++i)
        for (unsigned lane = 0; bodies.fours[i].left != 0 && lane < followed_lanes; ++lane)
            if (((bodies.fours[i].left >> lane) & 1u) != 0)
                visit(Followed(bodies, i * followed_lanes + lane));
}

/// Computes K', its matrices, and g.
void answer(const FollowPass& pass, const StepConstants& step, SolverBodies& bodies, std::uint32_t first,
            std::uint32_t last) {
    kernel_of(bodies).answer(pass, first, last);
    for_each_left(bodies, first, last, [&](Followed f) {
        if (!f.turn.stiff) precess_far(f, step);
    });
}

/// FollowedFours per chunk of work
constexpr std::uint32_t fours_chunk = body_chunk / followed_lanes;
std::uint32_t count_of(const SolverBodies& bodies) { return static_cast<std::uint32_t>(bodies.fours.size()); }

} // namespace

/// Fills the data of FollowedFours [first, last) for the start of a tick.
static void start_fours(const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies,
                        std::uint32_t first, std::uint32_t last) {
    const std::size_t end = std::size_t{last} * followed_lanes;
    for (std::size_t at = std::size_t{first} * followed_lanes; at < end; ++at)
        start_turn(columns, at, step, bodies);
    const FollowPass pass = pass_of(step, bodies);
    kernel_of(bodies).start(pass, first, last);
    answer(pass, step, bodies, first, last);
    for (std::size_t at = std::size_t{first} * followed_lanes; at < end; ++at) {
        Followed f(bodies, at);
        if (f.turn.stiff) f.give_spin(f.spin());
        // Rows use the K^-1 of the kernel, which changes from here on.
        const BodyInertia now = f.turn.now;
        BodyStep& s = bodies.step[f.turn.body];
        f.turn.now = s;
        if (f.turn.body == bodies.still()) continue;
        s.inv_mantissa = f.turn.now.inv_mantissa = now.inv_mantissa;
        s.inv_exponent = f.turn.now.inv_exponent = now.inv_exponent;
    }
}

void follow_turns(const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    const TurnsBy far(spin_parts, step), far_for_joints(held_parts, step);
    const std::uint32_t count = static_cast<std::uint32_t>(columns.info.size());
    for (std::uint32_t row = 0; row < count; ++row) {
        if (!far_for_joints(columns.velocity[row])) continue; // skips the BodyStep of most bodies
        const BodyStep& s = bodies.step[row];
        if (!is_gyroscope(columns, row, s)) continue;
        if (s.jointed || (far(columns.velocity[row]) && !is_thin(s.radii))) follow(row, bodies);
    }
    while (bodies.turns.size() % followed_lanes != 0) { // unused lanes refer to the body that never moves
        bodies.fours.back().row[bodies.turns.size() % followed_lanes] = bodies.still();
        add(bodies.turns).body = bodies.still();
    }
    bodies.paths.take(!bodies.turns.empty(), base::Path::turns_not_followed, base::Path::turns_followed);
    bodies.paths.take(base::is_shared(tasks, count_of(bodies), fours_chunk), base::Path::followed_by_one,
                      base::Path::followed_by_workers);
    base::for_chunks(tasks, count_of(bodies), fours_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         start_fours(columns, step, bodies, first, last);
                     });
}

void advance_turns(const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    if (bodies.fours.empty()) return;
    const FollowPass pass = pass_of(step, bodies);
    base::for_chunks(tasks, count_of(bodies), fours_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         kernel_of(bodies).turn(pass, first, last);
                         for_each_left(bodies, first, last, [&](Followed f) { turn_far(f, step); });
                         answer(pass, step, bodies, first, last);
                         for (std::uint32_t i = first; i < last; ++i)
                             for (unsigned lane = 0; lane < followed_lanes; ++lane)
                                 if (bodies.fours[i].stiff[lane] != 0)
                                     precess_stiff(Followed(bodies, i * followed_lanes + lane), step);
                     });
}

void find_spins(const StepConstants& step, SolverBodies& bodies) {
    kernel_of(bodies).end(pass_of(step, bodies), 0, count_of(bodies));
    for_each_left(bodies, 0, count_of(bodies), [](Followed f) {
        f.turn.spin = to<Speed>(f.turn.stiff ? f.spin() : spin_at(f.turn.rotation, f.turn, f.momentum()));
    });
}

void forget_precession(SolverBodies& bodies, std::uint32_t turn) {
    const Followed f(bodies, turn - 1);
    for (auto& part : f.four.precession) part[f.lane] = 0;
}

/// now - before, within 2048 m/s.
static std::int64_t change_of(std::int64_t now, std::int64_t before) {
    constexpr std::int64_t most = std::int64_t{2048} << accumulator_bits;
    return std::clamp(sub_saturated(now, before), -most, most);
}
/// x / whole, rounded down, for x below a whole above 0; zero for x below 0.
static Unit share_of(Wide x, Wide whole) {
    if (x.is_negative()) return Unit{};
    std::int32_t raw = 0;
    for (int i = 0; i < Unit::fraction_bits; ++i) {
        x = x << 1, raw *= 2;
        if (!(x < whole)) x = x - whole, ++raw;
    }
    return Unit::from_raw(raw);
}
/// x times a share, rounded down.
static std::int64_t part_of(std::int64_t x, Unit share) {
    return static_cast<std::int64_t>((Wide::product(x, share.raw) >> Unit::fraction_bits).low_bits());
}

// ---- conversion between present rows and rows of the start --------------------------------------------------------

void turn_in(const StepConstants& step, SolverBodies& bodies) {
    kernel_of(bodies).turn_in(pass_of(step, bodies), 0, count_of(bodies));
}
void turn_out(SolverBodies& bodies) { kernel_of(bodies).turn_out(pass_of(bodies), 0, count_of(bodies)); }
void note_u(SolverBodies& bodies) { kernel_of(bodies).note_u(pass_of(bodies), 0, count_of(bodies)); }
void keep_velocity(SolverBodies& bodies) {
    kernel_of(bodies).keep_velocity(pass_of(bodies), 0, count_of(bodies));
}

/// Visits each followed body that conserves its momentum.
template <class Visit> static void for_each_followed(SolverBodies& bodies, const Visit& visit) {
    for (std::size_t at = 0; at < bodies.turns.size(); ++at) {
        const Followed f(bodies, at);
        if (f.turn.body != bodies.still() && !f.turn.stiff)
            visit(f, FreeTurn(f.turn.radii_inv, f.turn.principal));
    }
}
void note_energies(SolverBodies& bodies) {
    note_u(bodies);
    for_each_followed(bodies, [](Followed f, const FreeTurn& turn) {
        f.turn.impact_energy = turn.energy(f.turn.rotation, f.momentum());
        f.turn.impact_energy_of_u = square_of(to_real(f.body.u));
    });
}
void keep_energies(SolverBodies& bodies) {
    for_each_followed(bodies, [](Followed f, const FreeTurn&) {
        f.turn.impact_energy_of_u = square_of(to_real(f.body.u)) - f.turn.impact_energy_of_u;
    });
    keep_velocity(bodies);
    for_each_followed(bodies, [](Followed f, const FreeTurn& turn) {
        if (f.turn.impact_energy_of_u == Wide{}) return; // no impact
        const Wide most = f.turn.impact_energy + f.turn.impact_energy_of_u;
        const Vec3 momentum = f.momentum();
        set_momentum(f, momentum,
                     turn.shortened_to_energy(most, f.turn.rotation, momentum, FreeTurn::Keep::not_above));
    });
}

void find_still_contacts(std::span<const Contact> contacts, SolverBodies& bodies) {
    if (bodies.turns.empty()) return;
    const auto set = [&](std::uint32_t row, bool value) {
        if (const std::uint32_t at = bodies.step[row].turn; at != 0) {
            FollowedTurn& turn = bodies.turns[at - 1];
            turn.meets_still = value && !turn.stiff && !turn.held;
        }
    };
    for (const Contact& c : contacts) set(c.body_a, true), set(c.body_b, true);
    for (const Contact& c : contacts) {
        const bool slides = c.surface_velocity != SpeedVec3{};
        if (slides || bodies.step[c.body_b].moves) set(c.body_a, false);
        if (slides || bodies.step[c.body_a].moves) set(c.body_b, false);
    }
}

/// Visits each followed body whose contacts may take energy only.
template <class Visit> static void for_each_limited(SolverBodies& bodies, const Visit& visit) {
    for (std::size_t at = 0; at < bodies.turns.size(); ++at)
        if (bodies.turns[at].meets_still) {
            const Followed f(bodies, at);
            visit(f, FreeTurn(f.turn.radii_inv, f.turn.principal));
        }
}
static Wide energy_of(const Followed& f, const FreeTurn& turn, Vec3 momentum) {
    return square_of(to_real(f.body.v)) + turn.energy(f.turn.rotation, momentum);
}
void note_speeds(SolverBodies& bodies) {
    for_each_limited(bodies, [](Followed f, const FreeTurn& turn) {
        std::copy_n(f.body.v, 3, f.turn.pass_v), std::copy_n(f.body.u, 3, f.turn.pass_u);
        f.turn.pass_energy = energy_of(f, turn, f.momentum());
    });
}
void limit_speeds(SolverBodies& bodies) {
    for_each_limited(bodies, [](Followed f, const FreeTurn& turn) {
        std::int64_t dv[3], du[3], any = 0;
        for (int i = 0; i < 3; ++i) {
            any |= dv[i] = change_of(f.body.v[i], f.turn.pass_v[i]);
            any |= du[i] = change_of(f.body.u[i], f.turn.pass_u[i]);
        }
        if (any == 0) return;
        const Wide gain = energy_of(f, turn, f.momentum()) - f.turn.pass_energy;
        if (gain.is_negative() || gain == Wide{}) return;
        // The energy of a part s of the impulses is e + 2 b s + a s^2, with a that of the changes alone.
        const Wide a =
            square_of(to_real(dv)) + turn.energy(f.turn.rotation, mul<Real>(f.step.gyration, to_real(du)));
        const Unit part = share_of(a - gain, a);
        for (int i = 0; i < 3; ++i) {
            f.body.v[i] = add_saturated(f.turn.pass_v[i], part_of(dv[i], part));
            f.body.u[i] = add_saturated(f.turn.pass_u[i], part_of(du[i], part));
        }
    });
}

} // namespace lockstone::solve
