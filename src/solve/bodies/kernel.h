// The motion of bodies in a substep, written once over the lanes L. See solve/bodies/body_kernel.h.
//
// The six velocities of a body are adjacent, and lanes load them directly, so no body has to be gathered. Where six is
// not a multiple of the number of lanes, the last window overlaps the window before it and writes the same values
// again.
//
// Only files that are compiled for one instruction set include this. It must not use inline functions that other files
// use too, since the linker keeps only one of their copies.
#pragma once

#include "solve/bodies/body_kernel.h"
#include "solve/bodies/followed_kernel.h"
#include "solve/bodies/solver_body.h"
#include "solve/bodies/turn_kernel.h"

namespace lockstone::solve {

template <class L> class MovedBodies {
    static constexpr unsigned N = L::lanes, windows = (6 + N - 1) / N;
    static_assert(N <= 6, "a row of a body would reach beyond it");
    using V = typename L::V;
    using Pass = solve::BodyPass;
    using Body = solve::SolverBody;

    static constexpr unsigned place(unsigned window) { return window * N + N <= 6 ? window * N : 6 - N; }
    static std::int64_t* velocities(const Pass& pass, std::uint32_t i) {
        return reinterpret_cast<std::int64_t*>(&pass.bodies[i]);
    }
    static std::int32_t* moves(const Pass& pass, std::uint32_t i) {
        return reinterpret_cast<std::int32_t*>(velocities(pass, i) + 6);
    }

    struct Row {
        V at[windows];
    };
    static Row load(const std::int64_t* p) {
        Row row;
        for (unsigned k = 0; k < windows; ++k) row.at[k] = L::load64(p + place(k));
        return row;
    }
    /// The limits, computed once for many bodies.
    struct Limits {
        Row most, least;
    };
    static Limits limits_of(const Pass& pass) {
        Limits limits;
        limits.most = load(pass.most);
        for (unsigned k = 0; k < windows; ++k) // -2^k = ~(2^k - 1)
            limits.least.at[k] = L::without(L::splat(-1), limits.most.at[k]);
        return limits;
    }
    static bool is_beyond(const Row& row, const Limits& limits) {
        V beyond = L::splat(0);
        for (unsigned k = 0; k < windows; ++k)
            beyond = L::either(beyond, L::either(L::greater64(row.at[k], limits.most.at[k]),
                                                 L::greater64(limits.least.at[k], row.at[k])));
        return L::lanes_of(beyond) != 0;
    }

    template <class Combine>
    static void combine(const Body* bodies, std::int64_t* sums, const std::uint32_t* rows,
                        std::uint32_t count, Combine&& combined) {
        for (std::uint32_t k = 0; k < count; ++k) {
            const std::size_t i = rows != nullptr ? rows[k] : k;
            const Row row = load(reinterpret_cast<const std::int64_t*>(&bodies[i]));
            std::int64_t* const to = sums + 6 * i;
            Row sum = load(to);
            for (unsigned w = 0; w < windows; ++w) sum.at[w] = combined(sum.at[w], row.at[w]);
            for (unsigned w = 0; w < windows; ++w) L::store64(to + place(w), sum.at[w]);
        }
    }
    static void add_velocities(const Body* bodies, std::int64_t* sums, const std::uint32_t* rows,
                               std::uint32_t count) {
        combine(bodies, sums, rows, count, [](V a, V b) { return L::add(a, b); });
    }
    static void take_velocities(const Body* bodies, std::int64_t* sums, const std::uint32_t* rows,
                                std::uint32_t count) {
        combine(bodies, sums, rows, count, [](V a, V b) { return L::sub(a, b); });
    }

    /// Damps velocities within their limits, in two parts of 30 bits, as for one body.
    static void damp(Row& row, const Row& is_turn, const solve::BodyStep& step) {
        const V linear = L::splat(step.linear_keep.raw), angular = L::splat(step.angular_keep.raw),
                low_part = L::splat((std::int64_t{1} << 30) - 1), half = L::splat(std::int64_t{1} << 29);
        for (unsigned k = 0; k < windows; ++k) {
            const V keep = L::select(is_turn.at[k], angular, linear);
            const V whole = L::mul(L::template shift_right<30>(row.at[k]), keep),
                    rest = L::mul(L::both(row.at[k], low_part), keep);
            row.at[k] = L::add(whole, L::template shift_right<30>(L::add(rest, half)));
        }
    }

    static std::uint32_t integrate_velocities(const Pass& pass, std::uint32_t* left) {
        static constexpr std::int64_t turns[6] = {0, 0, 0, -1, -1, -1};
        const Limits limits = limits_of(pass);
        const Row change = load(pass.dv), is_turn = load(turns);
        std::uint32_t count = 0;
        for (std::uint32_t at = pass.first; at < pass.last; ++at) {
            const std::uint32_t i = pass.rows != nullptr ? pass.rows[at] : at;
            std::int64_t* const p = velocities(pass, i);
            Row row = load(p);
            for (unsigned k = 0; k < windows; ++k) row.at[k] = L::add(row.at[k], change.at[k]);
            if ((pass.plain[i] & solve::plain_velocity) == 0 || is_beyond(row, limits)) {
                left[count++] = i;
                continue;
            }
            if ((pass.plain[i] & solve::plain_damped) != 0) damp(row, is_turn, pass.steps[i]);
            for (unsigned k = 0; k < windows; ++k) L::store64(p + place(k), row.at[k]);
        }
        return count;
    }

    static std::uint32_t integrate_poses(const Pass& pass, std::uint32_t* left) {
        // Velocity with 27 fraction bits, raised so that no value is negative, in two parts of 30 bits and of the rest;
        // each part is multiplied by the time with 30 fraction bits.
        constexpr int drop = solve::accumulator_bits - 27, up = 57;
        constexpr std::int64_t top = INT32_MAX, bottom = INT32_MIN;
        const Limits limits = limits_of(pass);
        const V time = L::splat(pass.substep_time), half = L::splat(std::int64_t{1} << 29),
                most = L::splat(top), least = L::splat(bottom), raised = L::splat(std::int64_t{1} << up),
                low_part = L::splat((std::int64_t{1} << 30) - 1),
                back = L::splat(pass.substep_time * (1 << (up - drop - 30)));
        std::uint32_t count = 0;
        for (std::uint32_t at = pass.first; at < pass.last; ++at) {
            const std::uint32_t i = pass.rows != nullptr ? pass.rows[at] : at;
            const Row row = load(velocities(pass, i));
            if ((pass.plain[i] & solve::plain_pose) == 0 || is_beyond(row, limits)) {
                left[count++] = i;
                continue;
            }
            std::int32_t* const to = moves(pass, i);
            V moved[windows];
            for (unsigned k = 0; k < windows; ++k) {
                const V v = L::template shift_right<drop>(L::add(row.at[k], raised));
                const V whole = L::mul(L::template shift_right<30>(v), time),
                        rest = L::template shift_right<30>(L::add(L::mul(L::both(v, low_part), time), half));
                moved[k] = L::add(L::sub(load_extended<L>(to + place(k)), back), L::add(whole, rest));
                moved[k] = L::select(L::greater64(moved[k], most), most, moved[k]);
                moved[k] = L::select(L::greater64(least, moved[k]), least, moved[k]);
            }
            for (unsigned k = 0; k < windows; ++k) L::store32(to + place(k), moved[k]);
        }
        return count;
    }

  public:
    static constexpr solve::BodyKernel table() {
        return {integrate_velocities, integrate_poses, TurnedBodies<L>::begin,    TurnedBodies<L>::finish,
                add_velocities,       take_velocities, FollowedBodies<L>::table()};
    }
};

} // namespace lockstone::solve
