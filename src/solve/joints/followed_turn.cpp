#include "solve/joints/followed_turn.h"

#include "lockstone/math/math.h"

#include <algorithm>
#include <array>

namespace lockstone::solve {

namespace {

Vec3 to_real(const std::int64_t v[3]) {
    const auto one = [](std::int64_t x) {
        return Real::from_raw(shift_right_rounded(x, real_to_accumulator));
    };
    return {one(v[0]), one(v[1]), one(v[2])};
}

Vec3 times_each(Vec3 v, Vec3 by) { return {v.x * by.x, v.y * by.y, v.z * by.z}; }

/// R diag(radii^-2) R^T momentum with the body at `rotation`.
Vec3 spin_at(Quat rotation, const FollowedTurn& turn, Vec3 momentum) {
    const Rotation axes = to_rotation(rotation * turn.principal);
    const Vec3 inside = mul_transposed<Real>(axes, momentum);
    return mul<Real>(axes, times_each(times_each(inside, turn.radii_inv), turn.radii_inv));
}

/// Far beyond what a body keeps [m/s]: then |g| stays within this and the tip speed limit, and no sum leaves 64 bits.
constexpr std::int64_t own_max = std::int64_t{2048} << accumulator_bits;

struct OwnSpin {
    std::int64_t m[3]; ///< 47 fraction bits
};
OwnSpin own_spin(const SolverBody& b, const FollowedTurn& turn) {
    OwnSpin own;
    for (int i = 0; i < 3; ++i) own.m[i] = std::clamp(b.u[i] - turn.precession[i], -own_max, own_max);
    return own;
}

// ---- short vectors ------------------------------------------------------------------------------------------------

/// m / 2^bits, entries within 2^31: three products with mantissas of 30 bits fit into 64 bits.
struct Short3 {
    std::int64_t m[3];
    int bits;
};

/// Of entries within 2^62.
inline Short3 shortened(const std::int64_t (&v)[3], int bits) {
    const auto any =
        static_cast<std::uint64_t>((v[0] ^ (v[0] >> 63)) | (v[1] ^ (v[1] >> 63)) | (v[2] ^ (v[2] >> 63)));
    const int length = bit_length(any), drop = length > 31 ? length - 31 : 0;
    const std::int64_t up = (std::int64_t{1} << drop) >> 1;
    return {{(v[0] + up) >> drop, (v[1] + up) >> drop, (v[2] + up) >> drop}, bits - drop};
}

/// x with `bits` fraction bits into `to` of them, clamped to the range.
inline std::int64_t with_bits(std::int64_t x, int bits, int to) {
    const int drop = bits - to;
    if (drop > 0 && drop <= 62) [[likely]]
        return (x >> drop) + ((x >> (drop - 1)) & 1);
    return drop > 62 ? 0 : shift_left_saturated(x, std::min(-drop, 63));
}

/// A sum of products that is to be shortened.
Short3 times(const Symmetric<std::int32_t>& k, int k_bits, const Short3& v) {
    const std::int64_t sum[3] = {k.xx * v.m[0] + k.xy * v.m[1] + k.xz * v.m[2],
                                 k.xy * v.m[0] + k.yy * v.m[1] + k.yz * v.m[2],
                                 k.xz * v.m[0] + k.yz * v.m[1] + k.zz * v.m[2]};
    return shortened(sum, k_bits + v.bits);
}

/// A R v and A R^T v of a rotation.
Short3 times(const Rotation& r, const Short3& v) {
    std::int64_t sum[3];
    for (int i = 0; i < 3; ++i) sum[i] = r.x[i].raw * v.m[0] + r.y[i].raw * v.m[1] + r.z[i].raw * v.m[2];
    return shortened(sum, Unit::fraction_bits + v.bits);
}
Short3 times_transposed(const Rotation& r, const Short3& v) {
    const auto along = [&](const UnitVec3& e) {
        return e.x.raw * v.m[0] + e.y.raw * v.m[1] + e.z.raw * v.m[2];
    };
    const std::int64_t sum[3] = {along(r.x), along(r.y), along(r.z)};
    return shortened(sum, Unit::fraction_bits + v.bits);
}

// ---- turns of half a substep --------------------------------------------------------------------------------------

constexpr int half_bits = 33; ///< of turns of half a substep [rad]
/// Components of turns that series follow [rad], 2^-33.
constexpr std::int64_t half_max = std::int64_t{1} << (half_bits - 2);
using Half3 = std::array<std::int64_t, 3>;

bool is_far(const Half3& v) {
    return std::max({magnitude(v[0]), magnitude(v[1]), magnitude(v[2])}) >= magnitude(half_max);
}
Half3 half_of(const Short3& v) {
    return {with_bits(v.m[0], v.bits, half_bits), with_bits(v.m[1], v.bits, half_bits),
            with_bits(v.m[2], v.bits, half_bits)};
}

/// exp(phi) by Rodrigues' formula: x + sine (phi x x) + versine (phi x (phi x x)), for |phi| components up to 1/4. What series
/// leave out is below 2^-27 |phi|.
struct SmallTurn {
    static constexpr int bits = Unit::fraction_bits;
    std::int64_t phi[3], sine, versine; ///< sin |phi| / |phi| and (1 - cos |phi|) / |phi|^2

    explicit SmallTurn(const Half3& half) {
        for (std::size_t i = 0; i < 3; ++i) phi[i] = half[i] >> (half_bits - bits);
        const std::int64_t z = (phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2]) >> bits;
        constexpr std::int64_t one = std::int64_t{1} << bits;
        const auto by = [z](std::int64_t x) { return (x * z) >> bits; };
        sine = one - by(one / 6 - by(one / 120 - by(one / 5040)));
        versine = one / 2 - by(one / 24 - by(one / 720 - by(one / 40320)));
    }
    std::int64_t cosine() const {
        const std::int64_t z = (phi[0] * phi[0] + phi[1] * phi[1] + phi[2] * phi[2]) >> bits;
        return (std::int64_t{1} << bits) - ((versine * z) >> bits);
    }
    /// exp(sign phi) v, of components within 2^32.
    template <int Sign> void turn(std::int64_t (&v)[3]) const {
        const auto cross = [this](const std::int64_t(&x)[3], std::int64_t(&out)[3]) {
            out[0] = (phi[1] * x[2] - phi[2] * x[1]) >> bits;
            out[1] = (phi[2] * x[0] - phi[0] * x[2]) >> bits;
            out[2] = (phi[0] * x[1] - phi[1] * x[0]) >> bits;
        };
        std::int64_t once[3], twice[3];
        cross(v, once), cross(once, twice);
        for (int i = 0; i < 3; ++i) v[i] += (Sign * sine * once[i] + versine * twice[i]) >> bits;
    }
};

/// exp(turn) q, of a turn by twice `half`; |q| is brought back to one as far as roundings move it.
Quat turned_by(Quat q, const Half3& half) {
    const SmallTurn t(half);
    std::int64_t e[3];
    for (int i = 0; i < 3; ++i) e[i] = (t.sine * t.phi[i]) >> SmallTurn::bits;
    const std::int64_t c = t.cosine(), x = q.x.raw, y = q.y.raw, z = q.z.raw, w = q.w.raw;
    constexpr int extra = 15, bits = Unit::fraction_bits;
    std::int64_t sum[4] = {c * x + e[0] * w + e[1] * z - e[2] * y, c * y - e[0] * z + e[1] * w + e[2] * x,
                           c * z + e[0] * y - e[1] * x + e[2] * w, c * w - e[0] * x - e[1] * y - e[2] * z};
    std::int64_t size = 0; // 60 bits
    for (std::int64_t& s : sum) {
        s >>= extra;
        const std::int64_t rough = shift_right_rounded(s, bits - extra);
        size += rough * rough;
    }
    const std::int64_t more = ((std::int64_t{1} << (2 * bits)) - size) >> (bits + 1); // (1 - |q|^2) / 2
    const auto one = [&](std::int64_t s) {
        return Unit::from_raw(static_cast<std::int32_t>(
            shift_right_rounded(s + (((s >> extra) * more) >> (bits - extra)), bits - extra)));
    };
    return {one(sum[0]), one(sum[1]), one(sum[2]), one(sum[3])};
}

// ---- precession ---------------------------------------------------------------------------------------------------

Rotation principal_axes(const FollowedTurn& turn) {
    return to_rotation(turn.principal == Quat::identity() ? turn.rotation : turn.rotation * turn.principal);
}

void set_speed(SolverBody& b, FollowedTurn& turn, const OwnSpin& own, const std::int64_t (&u)[3],
               const StepConstants& step) {
    const std::int64_t most = std::int64_t{step.tip_speed_max.raw} << row_bits;
    for (int i = 0; i < 3; ++i) {
        b.u[i] = std::clamp(u[i], -most, most);
        turn.precession[i] = b.u[i] - own.m[i];
    }
}

/// g by the midpoint rule. Two rounds more than the explicit rule: then a body that spins fast loses energy by what is
/// left of the error, where with one or three more it gains.
constexpr int precession_rounds = 3;

/// Of a body that turns by more than series follow.
void precess_far(SolverBody& b, const BodyStep& s, FollowedTurn& turn, const StepConstants& step) {
    const Unit half_time = Unit::from_raw(step.substep_time.raw / 2);
    const OwnSpin own = own_spin(b, turn);
    const Vec3 momentum = mul<Real>(s.gyration, to_real(own.m));
    Vec3 w = mul<Real>(s.gyration_inv, to_real(b.u));
    for (int round = 0; round < precession_rounds; ++round) {
        const Quat middle = integrate_rotation(turn.rotation, scale<Real>(w, half_time));
        w = spin_at(middle, turn, momentum);
    }
    const Vec3 fast = mul<Real>(s.gyration, w);
    const Real most = to<Real>(step.tip_speed_max);
    std::int64_t u[3];
    for (int i = 0; i < 3; ++i) u[i] = clamp(fast[i], -most, most).raw << real_to_accumulator;
    set_speed(b, turn, own, u, step);
}

/// The turn of half a substep by u, in world axes.
Half3 half_turn(const SolverBody& b, const BodyStep& s, const StepConstants& step) {
    Short3 v = times(s.inv_mantissa, s.inv_exponent, shortened(b.u, accumulator_bits));
    for (std::int64_t& x : v.m) x *= step.substep_time.raw;
    v.bits += Unit::fraction_bits + 1;
    return half_of(v);
}

/// `axes`: the body's principal axes now; `start`: half_turn() by its u.
void precess(SolverBody& b, const BodyStep& s, FollowedTurn& turn, const Rotation& axes, const Half3& start,
             const StepConstants& step) {
    const OwnSpin own = own_spin(b, turn);
    const Short3 momentum =
        times_transposed(axes, times(turn.k, turn.k_bits, shortened(own.m, accumulator_bits)));
    if (is_far(start)) return precess_far(b, s, turn, step);
    Half3 half = half_of(times_transposed(axes, {{start[0], start[1], start[2]}, half_bits}));
    for (int round = 0; round < precession_rounds; ++round) {
        if (is_far(half)) return precess_far(b, s, turn, step);
        const SmallTurn t(half);
        std::int64_t v[3] = {momentum.m[0], momentum.m[1], momentum.m[2]};
        t.turn<-1>(v);
        for (std::size_t i = 0; i < 3; ++i) // 31 bits and what turning adds, times 30
            v[i] = with_bits(v[i] * turn.half_way[i], momentum.bits + turn.half_way_bits[i], half_bits);
        if (is_far({v[0], v[1], v[2]})) return precess_far(b, s, turn, step);
        t.turn<1>(v);
        half = {v[0], v[1], v[2]};
    }
    Short3 u = times(turn.k, turn.k_bits, times(axes, shortened({half[0], half[1], half[2]}, half_bits)));
    std::int64_t fast[3];
    for (int i = 0; i < 3; ++i)
        fast[i] = with_bits(u.m[i] * (2 * step.substeps_per_second), u.bits, accumulator_bits);
    set_speed(b, turn, own, fast, step);
}

/// R diag(own^2) R^T w with the body where it is now.
Vec3 momentum_of(const FollowedTurn& turn, Vec3 w) {
    const Rotation axes = to_rotation(turn.rotation * turn.principal);
    return mul<Real>(axes, times_each(times_each(mul_transposed<Real>(axes, w), turn.own), turn.own));
}

/// The gyroscopic torque of the body as it is, in a substep, on the body as it answers. Three rounds of the midpoint rule lose
/// a little energy; two gain it.
void precess_stiff(SolverBody& b, const BodyStep& s, const FollowedTurn& turn, const StepConstants& step) {
    constexpr int rounds = 3;
    const Vec3 before = mul<Real>(s.gyration_inv, to_real(b.u));
    Vec3 w = before;
    for (int round = 0; round < rounds; ++round) {
        const Vec3 sum = before + w, middle{half(sum.x), half(sum.y), half(sum.z)};
        const Vec3 torque = cross(momentum_of(turn, middle), middle);
        w = before + scale<Real>(spin_at(turn.rotation, turn, torque), step.substep_time);
    }
    const Vec3 u = mul<Real>(s.gyration, w);
    const Real most = to<Real>(step.tip_speed_max);
    for (int i = 0; i < 3; ++i) b.u[i] = clamp(u[i], -most, most).raw << real_to_accumulator;
}

/// Slower than this, arms of contacts, which are those of the start of the tick, are the larger error: a top on a floor
/// does better if all its turn is made after the tick.
constexpr int spin_parts = 2;
/// Chains under load come apart with 4, and gain energy where they are snatched with 8.
constexpr int held_parts = 16;

/// Whether a body feels gyroscopic torque and turns by more than 1 / `parts` of a radian in the tick about some axis.
bool spins(const BodyColumns& columns, std::uint32_t row, const BodyStep& s, int parts,
           const StepConstants& step) {
    if (!s.movable || (s.radii.x == s.radii.y && s.radii.y == s.radii.z)) return false;
    const Vec3 w = abs(to<Real>(columns.velocity[row].angular));
    if (!(max(w.x, max(w.y, w.z)) * parts > Real(step.ticks_per_second))) return false;
    return s.turn == 0 && columns.traits(row).gyroscopic != 0 && s.angular_mask == 7u;
}

/// Mantissas below 2^30 of entries below 2^length; returns their fraction bits.
int mantissas(const Symmetric<Real>& k, int length, Symmetric<std::int32_t>& out) {
    const int bits = Real::fraction_bits + 30 - length;
    const auto one = [bits](Real x) {
        return saturate_to_int32(with_bits(x.raw, Real::fraction_bits, bits));
    };
    out = {one(k.xx), one(k.yy), one(k.zz), one(k.xy), one(k.xz), one(k.yz)};
    return bits;
}

void set_half_way(FollowedTurn& turn, const StepConstants& step) {
    for (int i = 0; i < 3; ++i) {
        const std::uint64_t inverse = magnitude(turn.radii_inv[i].raw);
        const int length = bit_length(inverse), drop = length - 31;
        const auto short_one =
            static_cast<std::uint64_t>(with_bits(static_cast<std::int64_t>(inverse), drop, 0));
        const std::uint64_t way = short_one * short_one / magnitude(2 * step.substeps_per_second);
        const int way_drop = bit_length(way) - 30;
        turn.half_way[i] = with_bits(static_cast<std::int64_t>(way), way_drop, 0);
        turn.half_way_bits[i] = 2 * (Real::fraction_bits - drop) - way_drop;
    }
}

/// m = a b, both symmetric with mantissas below 2^30.
void set_product(TurnMatrix& out, const Symmetric<std::int32_t>& a, int a_bits,
                 const Symmetric<std::int32_t>& b, int b_bits) {
    const std::int64_t x[3][3] = {{a.xx, a.xy, a.xz}, {a.xy, a.yy, a.yz}, {a.xz, a.yz, a.zz}};
    const std::int64_t y[3][3] = {{b.xx, b.xy, b.xz}, {b.xy, b.yy, b.yz}, {b.xz, b.yz, b.zz}};
    std::int64_t m[3][3];
    std::uint64_t any = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            m[i][j] = x[i][0] * y[0][j] + x[i][1] * y[1][j] + x[i][2] * y[2][j];
            any |= magnitude(m[i][j]);
        }
    const int drop = std::max(bit_length(any) - 30, 0);
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            out.m[i][j] = static_cast<std::int32_t>(shift_right_rounded(m[i][j], drop));
    out.bits = a_bits + b_bits - drop;
}

/// K' K^-1 and its inverse, from where the body is now.
void set_matrices(FollowedTurn& turn, const BodyStep& start) {
    Symmetric<std::int32_t> now;
    const int now_bits = mantissas(turn.now.gyration, turn.now.gyration_bits, now);
    set_product(turn.to_now, now, now_bits, start.inv_mantissa, start.inv_exponent);
    set_product(turn.from_now, turn.k, turn.k_bits, turn.now.inv_mantissa, turn.now.inv_exponent);
}

void follow(const BodyColumns& columns, std::uint32_t row, const StepConstants& step, SolverBodies& bodies) {
    BodyStep& s = bodies.step[row];
    FollowedTurn turn{};
    turn.rotation = normalized(columns.pose[row].rotation);
    turn.principal = columns.mass[row].principal;
    turn.radii_inv = s.radii_inv;
    set_half_way(turn, step);
    turn.k_bits = mantissas(s.gyration, s.gyration_bits, turn.k);
    turn.body = row;
    turn.own = columns.mass[row].gyration;
    turn.stiff = s.radii != turn.own;
    // By a quarter: an entry is large, and all bodies of a heap come in one tick.
    if (const std::size_t count = bodies.turns.size(); count == bodies.turns.capacity())
        bodies.turns.reserve(count + count / 4 + 16);
    bodies.turns.push_back(turn);
    s.turn = static_cast<std::uint32_t>(bodies.turns.size());
    bodies.plain[row] = 0;
    FollowedTurn& kept = bodies.turns.back();
    if (turn.stiff) return;
    SolverBody& b = bodies.body[row];
    precess(b, s, kept, principal_axes(kept), half_turn(b, s, step), step);
}

} // namespace

void follow_turns(const BodyColumns& columns, const StepConstants& step, SolverBodies& bodies) {
    const std::uint32_t count = static_cast<std::uint32_t>(columns.info.size());
    for (std::uint32_t row = 0; row < count; ++row) {
        const bool jointed = bodies.step[row].jointed;
        if (!spins(columns, row, bodies.step[row], jointed ? held_parts : spin_parts, step)) continue;
        follow(columns, row, step, bodies);
        bodies.turns.back().held = jointed;
    }
    for (FollowedTurn& turn : bodies.turns) {
        turn.now = bodies.step[turn.body];
        if (turn.held) set_matrices(turn, turn.now);
    }
}

void advance_turn(SolverBody& b, const BodyStep& s, FollowedTurn& turn, const StepConstants& step) {
    const Half3 half = half_turn(b, s, step);
    turn.rotation =
        is_far(half) ? integrate_rotation(turn.rotation, scale<Real>(mul<Real>(s.gyration_inv, to_real(b.u)),
                                                                     step.substep_time))
                     : turned_by(turn.rotation, half);
    const Rotation axes = principal_axes(turn);
    if (turn.held) {
        set_gyration(turn.now, axes);
        set_matrices(turn, s);
    }
    if (turn.stiff)
        precess_stiff(b, s, turn, step);
    else
        precess(b, s, turn, axes, half, step);
}

// ---- rows of now and rows of the start ----------------------------------------------------------------------------

namespace {

template <class Visit> void for_each_held(SolverBodies& bodies, Visit&& visit) {
    for (FollowedTurn& turn : bodies.turns)
        if (turn.held) visit(turn, bodies.body[turn.body]);
}

struct Change {
    std::int64_t m[3]; ///< 47 fraction bits
};
Change change_of(const SolverBody& b, const std::int64_t (&before)[3]) {
    return {{b.u[0] - before[0], b.u[1] - before[1], b.u[2] - before[2]}};
}
bool is_none(const Change& change) { return (change.m[0] | change.m[1] | change.m[2]) == 0; }

/// M x, or M^T x, within 4096 m/s: no sum leaves 64 bits.
template <bool Transposed> Change times(const TurnMatrix& m, const std::int64_t (&x)[3]) {
    constexpr std::int64_t most = std::int64_t{4096} << accumulator_bits;
    const Short3 v = shortened(x, accumulator_bits);
    Change out;
    for (int i = 0; i < 3; ++i) {
        std::int64_t sum = 0; // 30 bits times 31, three times
        for (int k = 0; k < 3; ++k) sum += std::int64_t{Transposed ? m.m[k][i] : m.m[i][k]} * v.m[k];
        out.m[i] = std::clamp(with_bits(sum, m.bits + v.bits, accumulator_bits), -most, most);
    }
    return out;
}

/// What was added to u without being momentum.
void add_precession(FollowedTurn& turn, const Change& u, const Change& momentum) {
    for (int i = 0; i < 3; ++i)
        turn.precession[i] =
            std::clamp(turn.precession[i] + u.m[i] - momentum.m[i], -2 * own_max, 2 * own_max);
}

} // namespace

void turn_in(const StepConstants& step, SolverBodies& bodies) {
    const std::int64_t most = std::int64_t{step.tip_speed_max.raw} << row_bits;
    for_each_held(bodies, [most](FollowedTurn& turn, SolverBody& b) {
        const Change u = times<false>(turn.to_now, b.u);
        for (int i = 0; i < 3; ++i) {
            turn.u_outside[i] = b.u[i];
            b.u[i] = turn.u_inside[i] = std::clamp(u.m[i], -most, most);
        }
    });
}

void turn_out(SolverBodies& bodies) {
    for_each_held(bodies, [](FollowedTurn& turn, SolverBody& b) {
        const Change change = change_of(b, turn.u_inside);
        const Change faster = times<false>(turn.from_now, change.m);
        for (int i = 0; i < 3; ++i) b.u[i] = std::clamp(turn.u_outside[i] + faster.m[i], -own_max, own_max);
        // K^-1 K' is the transpose of K' K^-1.
        if (!turn.stiff) add_precession(turn, faster, times<true>(turn.to_now, change.m));
    });
}

void note_u(SolverBodies& bodies) {
    for_each_held(bodies,
                  [](FollowedTurn& turn, const SolverBody& b) { std::copy(b.u, b.u + 3, turn.u_outside); });
}

void keep_velocity(SolverBodies& bodies) {
    for_each_held(bodies, [](FollowedTurn& turn, const SolverBody& b) {
        if (turn.stiff) return;
        const Change change = change_of(b, turn.u_outside);
        if (is_none(change)) return;
        add_precession(turn, change, times<true>(turn.to_now, times<false>(turn.to_now, change.m).m));
    });
}

Vec3 spin_of(const SolverBody& b, const BodyStep& s, const FollowedTurn& turn) {
    if (turn.stiff) return mul<Real>(s.gyration_inv, to_real(b.u));
    return spin_at(turn.rotation, turn, mul<Real>(s.gyration, to_real(own_spin(b, turn).m)));
}

} // namespace lockstone::solve
