// K of bodies at the start of a tick, and their poses and velocities at its end, written once over the lanes L. This
// gives the same bits as begin_turning() and turn() of solver_body.cpp, which handle the bodies that it skips.
//
// kernel.h includes this; the rules for its inclusion are there.
#pragma once

#include "math/elementary.h"
#include "solve/bodies/solver_body.h"
#include "solve/lanes/lane_fixed.h"
#include "solve/lanes/lane_rotation.h"

#include <bit>
#include <cstdint>

namespace lockstone::solve {

template <class L> class TurnedBodies {
    static constexpr unsigned N = L::lanes;
    static constexpr int real_bits = 32, speed_bits = 19, gap_bits = 27, mantissa_bits = 30,
                         small_turn_bits = real_bits - detail::SmallTurn::least_bits;
    // index of each entry in xx, yy, zz, xy, xz, yz
    static constexpr int entry_at[3][3] = {{0, 3, 4}, {3, 1, 5}, {4, 5, 2}};
    using V = typename L::V;
    using Rows = const std::uint32_t*;
    using Numbers = std::int64_t[N];

    static V half_of(int bits) { return L::splat(std::int64_t{1} << (bits - 1)); }
    static V negated(V x) { return L::sub(L::splat(0), x); }
    static V magnitude(V x) { return L::select(L::greater64(L::splat(0), x), negated(x), x); }
    static V wide(V x) { return extended<L>(x); }
    static V not_within(V x, std::int64_t below) { // |x| >= below
        return L::greater64(magnitude(x), L::splat(below - 1));
    }
    static int bit_length(std::int64_t x) {
        return x == 0 ? 0 : 64 - std::countl_zero(static_cast<std::uint64_t>(x));
    }
    static V load(const Numbers& numbers) { return L::from_lanes(numbers); }

    /// a b of two rotations.
    static void multiply(const V (&a)[4], const V (&b)[4], V (&out)[4]) {
        const auto rounded = [](V sum) { return L::template shift_right<30>(L::add(sum, half_of(30))); };
        const auto p = [&](int i, int j) { return L::mul(a[i], b[j]); };
        out[0] = rounded(L::sub(L::add(L::add(p(3, 0), p(0, 3)), p(1, 2)), p(2, 1)));
        out[1] = rounded(L::add(L::add(L::sub(p(3, 1), p(0, 2)), p(1, 3)), p(2, 0)));
        out[2] = rounded(L::add(L::sub(L::add(p(3, 2), p(0, 1)), p(1, 0)), p(2, 3)));
        out[3] = rounded(L::sub(L::sub(L::sub(p(3, 3), p(0, 0)), p(1, 1)), p(2, 2)));
    }
    /// R diag(d) R^T, with the bits of rotated_diagonal(). `form`: d with 31 bits, and the number of bits to drop.
    static void rotated_diagonal(const V (&r)[3][3], const V (&form)[4], V (&out)[6]) {
        V a[3][3];
        for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i)
                a[i][k] = L::template shift_right<30>(L::add(L::mul(r[k][i], form[k]), half_of(30)));
        const V drop = wide(form[3]), half = L::template shift_right<1>(L::shift_left_by(L::splat(1), drop));
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j) {
                const V sum = L::add(L::add(L::mul(a[i][0], r[0][j]), L::mul(a[i][1], r[1][j])),
                                     L::mul(a[i][2], r[2][j]));
                out[entry_at[i][j]] = L::shift_right_by(L::add(sum, half), drop);
            }
    }
    static V all_bits(const V (&entries)[6]) {
        V any = magnitude(entries[0]);
        for (int i = 1; i < 6; ++i) any = L::either(any, magnitude(entries[i]));
        return any;
    }
    /// m x of integers, rounded by Drop bits.
    template <int Drop> static void multiply(const V (&m)[6], const V (&x)[3], V (&out)[3]) {
        for (int i = 0; i < 3; ++i) {
            const V sum = L::add(L::add(L::mul64(m[entry_at[i][0]], x[0]), L::mul64(m[entry_at[i][1]], x[1])),
                                 L::mul64(m[entry_at[i][2]], x[2]));
            out[i] = L::template shift_right_signed<Drop>(L::add(sum, half_of(Drop)));
        }
    }
    /// True in the lanes where three products of x with numbers below 2^bits may exceed 64 bits. `room`: room_of(bits).
    static V is_long(const V (&x)[3], const Numbers& room) {
        V any = magnitude(x[0]);
        for (int i = 1; i < 3; ++i) any = L::either(any, magnitude(x[i]));
        return L::greater64(L::shift_right_by(any, load(room)), L::splat(0));
    }
    static std::int64_t room_of(std::int64_t bits) { return bits > 61 ? 0 : 61 - bits; }

    static void gather(const BodyStep* const* steps, Symmetric<Real> BodyStep::*matrix, V (&out)[6]) {
        const Symmetric<Real>* from[N];
        for (unsigned lane = 0; lane < N; ++lane) from[lane] = &(steps[lane]->*matrix);
        L::gather6(from, out);
    }
    /// Adds the rows of the lanes in `mask` to `left`, among the first `used` lanes.
    static std::uint32_t leave(unsigned mask, Rows rows, unsigned used, std::uint32_t* left) {
        std::uint32_t count = 0;
        for (unsigned lane = 0; lane < used; ++lane)
            if ((mask >> lane) & 1u) left[count++] = rows[lane];
        return count;
    }
    /// Calls pack(rows of N lanes) for all rows; it returns the mask of skipped lanes. The last pack repeats its own
    /// last row in unused lanes.
    template <class Pack>
    static std::uint32_t for_each_pack(Rows rows, std::uint32_t count, std::uint32_t* left, Pack&& pack) {
        std::uint32_t left_over = 0;
        for (std::uint32_t first = 0; first < count; first += N) {
            const unsigned used = count - first < N ? count - first : N;
            std::uint32_t lanes[N];
            for (unsigned i = 0; i < N; ++i) lanes[i] = rows[first + (i < used ? i : used - 1)];
            left_over += leave(pack(lanes), lanes, used, left + left_over);
        }
        return left_over;
    }

    /// The data of a pack of bodies at the start of a tick, before it is written body by body.
    struct Start {
        Numbers k[6], inverse[6], mantissa[6], k_bits, inverse_bits, u[3];
    };
    /// K and K^-1. Returns true in the lanes that are skipped.
    static V find_gyration(const StartPass& pass, const std::uint32_t (&rows)[N], Start& s) {
        const std::int32_t *rotations[N], *principals[N], *radii[N], *inverses[N];
        for (unsigned i = 0; i < N; ++i) {
            const GyrationForm& form = pass.forms[pass.form_of[pass.info[rows[i]].traits] - 1];
            rotations[i] = &pass.poses[rows[i]].rotation.x.raw;
            principals[i] = &form.principal.x.raw, radii[i] = form.radii, inverses[i] = form.inverses;
        }
        V q[4], principal[4], turned[4], r[3][3], form[4], entries[6];
        L::quads(rotations, q), L::quads(principals, principal);
        V left = rotation_of<L>(q, r); // the product of its entries may have no room
        multiply(q, principal, turned);
        left = L::either(left, rotation_of<L>(turned, r));
        L::quads(radii, form), rotated_diagonal(r, form, entries);
        for (int i = 0; i < 6; ++i) L::store64(s.k[i], entries[i]);
        L::store64(s.k_bits, all_bits(entries));
        L::quads(inverses, form), rotated_diagonal(r, form, entries);
        for (int i = 0; i < 6; ++i) L::store64(s.inverse[i], entries[i]);
        L::store64(s.inverse_bits, all_bits(entries));
        Numbers up, down;
        for (unsigned i = 0; i < N; ++i) {
            s.k_bits[i] = bit_length(s.k_bits[i]), s.inverse_bits[i] = bit_length(s.inverse_bits[i]);
            const std::int64_t drop = s.inverse_bits[i] - mantissa_bits;
            up[i] = drop < 0 ? -drop : 0, down[i] = drop < 0 ? 0 : drop;
        }
        const V by = load(down), half = L::template shift_right<1>(L::shift_left_by(L::splat(1), by)),
                raise = load(up);
        for (int i = 0; i < 6; ++i)
            L::store64(s.mantissa[i],
                       L::shift_right_by(L::add(L::shift_left_by(entries[i], raise), half), by));
        return L::either(left, L::greater64(load(s.inverse_bits), L::splat(62)));
    }
    /// u = K w. Returns true in the lanes where u may exceed its limit or its format.
    static V find_u(const StartPass& pass, const std::uint32_t (&rows)[N], Start& s) {
        Numbers room;
        // from the last component of `linear` on, so that four numbers exist
        const std::int32_t* velocities[N];
        for (unsigned i = 0; i < N; ++i)
            velocities[i] = &pass.velocities[rows[i]].linear.z.raw, room[i] = room_of(s.k_bits[i]);
        V k[6], last[4], w[3], u[3];
        L::quads(velocities, last);
        for (int i = 0; i < 6; ++i) k[i] = load(s.k[i]);
        for (int i = 0; i < 3; ++i) w[i] = wide(last[1 + i]);
        multiply<real_bits>(k, w, u);
        V left = is_long(w, room);
        for (int i = 0; i < 3; ++i) {
            left = L::either(left, L::greater64(u[i], L::splat(pass.tip_most)));
            left = L::either(left, L::greater64(L::splat(-1 - pass.tip_most), u[i]));
            L::store64(s.u[i], L::template shift_left<row_bits>(u[i]));
        }
        return left;
    }
    static void write_start(const StartPass& pass, std::uint32_t row, const Start& from, unsigned lane) {
        BodyStep& s = pass.steps[row];
        Real *const k = &s.gyration.xx, *const inverse = &s.gyration_inv.xx;
        std::int32_t* const mantissa = &s.inv_mantissa.xx;
        for (int i = 0; i < 6; ++i) {
            k[i].raw = from.k[i][lane], inverse[i].raw = from.inverse[i][lane];
            mantissa[i] = static_cast<std::int32_t>(from.mantissa[i][lane]);
        }
        s.gyration_bits = static_cast<std::int32_t>(from.k_bits[lane]);
        s.gyration_inv_bits = static_cast<std::int32_t>(from.inverse_bits[lane]);
        s.inv_exponent = real_bits + mantissa_bits - s.gyration_inv_bits;
        for (int i = 0; i < 3; ++i) pass.bodies[row].u[i] = from.u[i][lane];
    }

  public:
    static std::uint32_t begin(const StartPass& pass, Rows all, std::uint32_t count, std::uint32_t* left) {
        return for_each_pack(all, count, left, [&](const std::uint32_t(&rows)[N]) {
            Start start;
            const V given_up = find_gyration(pass, rows, start);
            const unsigned mask = L::lanes_of(L::either(given_up, find_u(pass, rows, start)));
            for (unsigned lane = 0; lane < N; ++lane)
                if (((mask >> lane) & 1u) == 0) write_start(pass, rows[lane], start, lane);
            return mask;
        });
    }

  private:
    /// exp(v / 2) q for small turns v, real_bits; each lane like turned_slightly() in math/rotation.cpp. Returns true
    /// in the lanes where q is too far from length one.
    static V turn(const V (&q)[4], const V (&v)[3], V (&out)[4]) {
        const auto square = [](V x) { return L::mul(x, x); };
        V h[3];
        for (int i = 0; i < 3; ++i) h[i] = L::template shift_left<1>(v[i]); // 34 bits
        const V z = L::template shift_right<32>(L::add(L::add(square(h[0]), square(h[1])), square(h[2])));
        const auto series = [&](std::int64_t first, std::int64_t second, std::int64_t third) {
            const V inner = L::sub(L::splat(second), L::template shift_right<36>(L::mul(z, L::splat(third))));
            return L::mul(z, L::sub(L::splat(first), L::template shift_right<36>(L::mul(z, inner))));
        };
        using Turn = detail::SmallTurn;
        const V sinc_less_1 = negated(
                    L::template shift_right<27>(series(Turn::sixth, Turn::one_of_120, Turn::one_of_5040))),
                c = negated(
                    L::template shift_right<32>(series(Turn::half, Turn::one_of_24, Turn::one_of_720)));
        const auto moved = [&](V from, V by_h) {
            const V more =
                L::template shift_right_signed<9>(L::mul(L::template shift_right<30>(by_h), sinc_less_1));
            const V change = L::add(L::add(L::mul(c, from), by_h), more);
            return L::add(L::mul(from, L::splat(1 << 16)), L::template shift_right_signed<18>(change));
        };
        const auto p = [&](int i, int j) { return L::mul(h[i], q[j]); };
        const V m[4] = {moved(q[0], L::sub(L::add(p(0, 3), p(1, 2)), p(2, 1))),
                        moved(q[1], L::add(L::sub(p(1, 3), p(0, 2)), p(2, 0))),
                        moved(q[2], L::add(L::sub(p(0, 1), p(1, 0)), p(2, 3))),
                        moved(q[3], negated(L::add(L::add(p(0, 0), p(1, 1)), p(2, 2))))};
        V squares = L::splat(0), cross = L::splat(0), high[4];
        for (int i = 0; i < 4; ++i) {
            high[i] = L::template shift_right<16>(m[i]);
            squares = L::add(squares, square(high[i]));
            cross = L::add(cross, L::mul(high[i], L::both(m[i], L::splat(0xffff))));
        }
        const V e = L::sub(L::add(squares, L::template shift_right_signed<15>(cross)),
                           L::splat(std::int64_t{1} << 60));
        const V half_e = L::template shift_right<11>(e);
        for (int i = 0; i < 4; ++i) {
            const V less = L::template shift_right_signed<34>(L::mul(high[i], half_e));
            out[i] = L::template shift_right<16>(L::add(L::sub(m[i], less), L::splat(1 << 15)));
        }
        return not_within(e, Turn::length_error);
    }
    static V rounded_velocity(V x) {
        return L::template shift_right_signed<row_bits>(L::add(x, half_of(row_bits)));
    }

    /// x * time, rounded to the fraction bits of x; |x| < 2^47.
    static V in_a_tick(V x, V time) {
        const V low = L::mul(L::both(x, L::splat(0xffff)), time),
                high = L::mul(L::template shift_right<16>(x), time);
        return L::template shift_right_signed<14>(
            L::add(high, L::template shift_right<16>(L::add(low, half_of(30)))));
    }
    static V rounded_by(V x, V drop) { // 1..62
        return L::shift_right_by(L::add(x, L::template shift_right<1>(L::shift_left_by(L::splat(1), drop))),
                                 drop);
    }
    static V half_turn(V x) { return L::template shift_right_signed<1>(L::add(x, L::splat(1))); }

    /// The angular momentum of a pack of bodies, which a turn without torque keeps; like Momentum of momentum.h.
    struct Momentum {
        V parts[3], mantissa[3], shift[3], principal[4];
        V left; ///< true in the lanes where a number has no room
    };
    static Momentum momentum_of(const EndPass& pass, const std::uint32_t (&rows)[N], const V (&u)[3]) {
        const BodyStep* steps[N];
        const std::int32_t *principals[N], *mantissas[N], *bits[N];
        Numbers room, size;
        for (unsigned i = 0; i < N; ++i) {
            const GyrationForm& form = pass.forms[pass.form_of[pass.info[rows[i]].traits] - 1];
            steps[i] = &pass.steps[rows[i]], room[i] = room_of(steps[i]->gyration_bits);
            principals[i] = &form.principal.x.raw;
            mantissas[i] = form.spin.mantissa, bits[i] = form.spin.bits;
        }
        V k[6], whole[3], more[4];
        gather(steps, &BodyStep::gyration, k);
        Momentum m;
        m.left = is_long(u, room);
        multiply<speed_bits>(k, u, whole);
        V any = magnitude(whole[0]);
        for (int i = 1; i < 3; ++i) any = L::either(any, magnitude(whole[i]));
        L::store64(size, any);
        for (unsigned i = 0; i < N; ++i) {
            const int beyond = bit_length(size[i]) - 30;
            size[i] = beyond < 0 ? 0 : beyond;
        }
        const V dropped = load(size),
                half = L::template shift_right<1>(L::shift_left_by(L::splat(1), dropped));
        for (int i = 0; i < 3; ++i) m.parts[i] = L::shift_right_by(L::add(whole[i], half), dropped);
        L::quads(principals, m.principal);
        V mantissa[4], shifts[4];
        L::quads(mantissas, mantissa), L::quads(bits, more);
        for (int i = 0; i < 4; ++i) {
            const V shift = L::sub(L::add(wide(more[i]), L::splat(real_bits - spin_bits)), dropped);
            const V wrong = L::either(L::greater64(L::splat(1), shift), L::greater64(shift, L::splat(62)));
            m.left = L::either(m.left, wrong);
            shifts[i] = L::select(wrong, L::splat(1), shift);
        }
        for (int i = 0; i < 3; ++i) {
            m.mantissa[i] = mantissa[i], m.shift[i] = shifts[i];
            const V spin = rounded_by(L::mul(magnitude(m.parts[i]), mantissa[3]), shifts[3]);
            m.left = L::either(m.left, L::greater64(spin, L::splat(pass.spin_most)));
        }
        return m;
    }
    /// Angular velocity of the bodies at rotations q, real_bits. Adds lanes without room to m.left.
    static void spin_at(Momentum& m, const V (&q)[4], V (&spin)[3]) {
        V turned[4], r[3][3], inside[3];
        multiply(q, m.principal, turned);
        m.left = L::either(m.left, rotation_of<L>(turned, r));
        for (int i = 0; i < 3; ++i) {
            const V along = L::add(L::add(L::mul(r[i][0], m.parts[0]), L::mul(r[i][1], m.parts[1])),
                                   L::mul(r[i][2], m.parts[2]));
            const V product = L::mul(L::template shift_right<30>(L::add(along, half_of(30))), m.mantissa[i]);
            const V half = L::template shift_right<1>(L::shift_left_by(L::splat(1), m.shift[i]));
            inside[i] = L::shift_right_by(L::add(product, half), m.shift[i]);
            m.left = L::either(m.left, not_within(inside[i], std::int64_t{1} << 31));
        }
        constexpr int drop = 30 + spin_bits - real_bits;
        for (int i = 0; i < 3; ++i) {
            const V sum = L::add(L::add(L::mul(r[0][i], inside[0]), L::mul(r[1][i], inside[1])),
                                 L::mul(r[2][i], inside[2]));
            spin[i] = L::template shift_right_signed<drop>(L::add(sum, half_of(drop)));
        }
    }
    static V sum_of_sizes(const V (&x)[3]) {
        return L::add(L::add(magnitude(x[0]), magnitude(x[1])), magnitude(x[2]));
    }
    static V is_no_small_turn(const V (&v)[3]) {
        V left = L::splat(0);
        for (int i = 0; i < 3; ++i)
            left = L::either(left, not_within(v[i], std::int64_t{1} << small_turn_bits));
        return left;
    }
    /// The turns by `rotation` of bodies whose angular velocity w changes with the turn, and w after it. Returns true
    /// in the lanes that are skipped.
    static V turn_with_spin(const EndPass& pass, const std::uint32_t (&rows)[N], const V (&q)[4],
                            const V (&u)[3], const V (&rotation)[3], V (&w)[3], V (&next)[4]) {
        const V time = L::splat(pass.tick_time);
        V halves[3], middle[4], spin[3], off[3], way[3], left = L::splat(0);
        for (int i = 0; i < 3; ++i) {
            halves[i] = half_turn(rotation[i]), off[i] = L::sub(rotation[i], in_a_tick(w[i], time));
            left = L::either(left, not_within(w[i], std::int64_t{1} << 46));
        }
        const V is_free = L::both(L::greater64(sum_of_sizes(rotation), L::splat(pass.least_free_turn)),
                                  L::greater64(L::splat(pass.free_turn_noise), sum_of_sizes(off)));
        Momentum m = momentum_of(pass, rows, u);
        left = L::either(L::either(left, is_free), turn(q, halves, middle));
        spin_at(m, middle, spin);
        for (int i = 0; i < 3; ++i) way[i] = L::add(rotation[i], in_a_tick(L::sub(spin[i], w[i]), time));
        left = L::either(L::either(left, is_no_small_turn(way)), turn(q, way, next));
        spin_at(m, next, w);
        return L::either(left, m.left);
    }

    /// The state of a pack of bodies at the end of a tick, before it is written body by body.
    struct End {
        Numbers position[3], rotation[4], linear[3], angular[3];
    };
    static V find_end(const EndPass& pass, const std::uint32_t (&rows)[N], End& end) {
        const SolverBody* bodies[N];
        const BodyStep* steps[N];
        const std::int32_t* rotations[N];
        Numbers room, gyroscopic;
        for (unsigned i = 0; i < N; ++i) {
            bodies[i] = &pass.bodies[rows[i]], steps[i] = &pass.steps[rows[i]];
            rotations[i] = &pass.poses[rows[i]].rotation.x.raw;
            room[i] = room_of(steps[i]->gyration_inv_bits);
            gyroscopic[i] = (pass.plain[rows[i]] & plain_round) != 0 ? 0 : -1;
            const Real* const at = &pass.poses[rows[i]].position.x;
            for (int axis = 0; axis < 3; ++axis) end.position[axis][i] = at[axis].raw;
        }
        V velocity[6], moves[6], inverse[6], q[4], next[4], theta[3], rotation[3], u[3], w[3];
        L::gather6(bodies, velocity), L::gather_motion(bodies, moves);
        gather(steps, &BodyStep::gyration_inv, inverse), L::quads(rotations, q);
        V left = L::splat(0);
        for (int i = 0; i < 3; ++i) {
            constexpr std::int64_t edge = std::int64_t{1000000000} << real_bits, fits = std::int64_t{1} << 58;
            const V to =
                L::add(load(end.position[i]), L::mul(moves[i], L::splat(1 << (real_bits - gap_bits))));
            L::store64(end.position[i], to);
            left = L::either(left, not_within(to, edge));
            left =
                L::either(left, L::either(not_within(velocity[i], fits), not_within(velocity[3 + i], fits)));
            L::store64(end.linear[i], rounded_velocity(velocity[i]));
            theta[i] = wide(moves[3 + i]), u[i] = rounded_velocity(velocity[3 + i]);
        }
        left = L::either(left, L::either(is_long(theta, room), is_long(u, room)));
        multiply<gap_bits>(inverse, theta, rotation), multiply<speed_bits>(inverse, u, w);
        left = L::either(left, is_no_small_turn(rotation));
        V turns = L::splat(0);
        for (int i = 0; i < 3; ++i)
            turns = L::either(turns, L::greater64(magnitude(rotation[i]), L::splat(pass.least_turn)));
        left = L::either(left, turn(q, rotation, next));
        const V with_spin = L::both(turns, load(gyroscopic));
        if (L::lanes_of(with_spin) != 0) {
            V turned[4], spin[3] = {w[0], w[1], w[2]};
            left =
                L::either(left, L::both(with_spin, turn_with_spin(pass, rows, q, u, rotation, spin, turned)));
            for (int i = 0; i < 3; ++i) w[i] = L::select(with_spin, spin[i], w[i]);
            for (int i = 0; i < 4; ++i) next[i] = L::select(with_spin, turned[i], next[i]);
        }
        for (int i = 0; i < 3; ++i) {
            constexpr int drop = real_bits - speed_bits;
            const V spin = L::template shift_right_signed<drop>(L::add(w[i], half_of(drop)));
            left = L::either(left, not_within(spin, std::int64_t{1} << 31));
            L::store64(end.angular[i], spin);
        }
        for (int i = 0; i < 4; ++i) L::store64(end.rotation[i], next[i]);
        return left;
    }
    static void write_end(const EndPass& pass, std::uint32_t row, const End& end, unsigned lane) {
        Real* const position = &pass.poses[row].position.x;
        Unit* const rotation = &pass.poses[row].rotation.x;
        Speed *const linear = &pass.velocities[row].linear.x, *const angular =
                                                                  &pass.velocities[row].angular.x;
        for (int i = 0; i < 3; ++i) {
            position[i].raw = end.position[i][lane];
            linear[i].raw = static_cast<std::int32_t>(end.linear[i][lane]);
            angular[i].raw = static_cast<std::int32_t>(end.angular[i][lane]);
        }
        for (int i = 0; i < 4; ++i) rotation[i].raw = static_cast<std::int32_t>(end.rotation[i][lane]);
    }

  public:
    static std::uint32_t finish(const EndPass& pass, Rows all, std::uint32_t count, std::uint32_t* left) {
        return for_each_pack(all, count, left, [&](const std::uint32_t(&rows)[N]) {
            End end;
            const unsigned mask = L::lanes_of(find_end(pass, rows, end));
            for (unsigned lane = 0; lane < N; ++lane)
                if (((mask >> lane) & 1u) == 0) write_end(pass, rows[lane], end, lane);
            return mask;
        });
    }
};

} // namespace lockstone::solve
