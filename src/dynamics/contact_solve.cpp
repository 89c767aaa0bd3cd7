// The solver's inner loops, once for every lane width. See contact.h for the symbols.
#include "dynamics/contact_block_solve.h"
#include "dynamics/followed_turn.h"

#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::dynamics {

namespace {

/// Of the lanes that are not `held` already.
template <unsigned N>
void solve_friction(ContactPack<N>& c, PointPack<N>& point, Pair<N>& p, std::uint32_t held) {
    Int32<N> t[2];
    for (int r = 1; r < 3; ++r) {
        const Int32<N> speed = row_speed(p, c.d[r], point.xa[r], point.xb[r]) + c.surface[r - 1];
        t[r - 1] = clamped(point.impulse[r] - rounded<30>(speed * point.kappa[r]));
    }
    for (unsigned lane = 0; lane < N; ++lane)
        clamp_to_cone(c.friction.lane[lane], point.impulse[0].lane[lane], t[0].lane[lane], t[1].lane[lane]);
    for (unsigned lane = 0; lane < N; ++lane)
        if ((held >> lane) & 1u)
            for (int r = 1; r < 3; ++r) t[r - 1].lane[lane] = point.impulse[r].lane[lane];
    for (int r = 1; r < 3; ++r) {
        push(p, c.d[r], point, r, t[r - 1] - point.impulse[r]);
        point.impulse[r] = t[r - 1];
    }
}

/// False when the point has no impulse in any lane that is not `held` already: then friction has nothing to do.
template <unsigned N> bool carries(const PointPack<N>& point, std::uint32_t held = 0) {
    for (unsigned lane = 0; lane < N; ++lane)
        if (!((held >> lane) & 1u) && (point.impulse[0].lane[lane] != 0 || point.impulse[1].lane[lane] != 0 ||
                                       point.impulse[2].lane[lane] != 0))
            return true;
    return false;
}

template <unsigned N>
NormalTarget<N> normal_target(const ContactPack<N>& c, const PointPack<N>& point, const StepConstants& step,
                              const Motion<N>& motion, bool bias) {
    const Int32<N> s = current_separation(c, point, motion);
    NormalTarget<N> t{point.kappa[0], splat<N>(0), splat<N>(0)};
    for (unsigned lane = 0; lane < N; ++lane) {
        if (point.kappa[0].lane[lane] == 0) continue; // a point this lane lacks
        if (s.lane[lane] > 0) { // speculative: close the gap by the end of the substep, no faster
            t.bias.lane[lane] = saturate_to_int32(shift_right_rounded(
                s.lane[lane] * step.substeps_per_second, Separation::fraction_bits - Speed::fraction_bits));
            if (t.bias.lane[lane] > impulse_limit) t.bias.lane[lane] = impulse_limit;
        } else if (bias) {
            const std::int64_t push_speed = shift_right_rounded(
                std::int64_t{s.lane[lane]} * c.bias_rate.lane[lane], Separation::fraction_bits);
            t.bias.lane[lane] = static_cast<std::int32_t>(
                push_speed < -step.push_speed_max.raw ? -step.push_speed_max.raw : push_speed);
            t.kappa.lane[lane] = point.kappa_soft.lane[lane];
            t.impulse_scale.lane[lane] = c.impulse_scale.lane[lane];
        }
    }
    return t;
}

/// False when the row has nothing to do in any lane: a block has done it.
template <unsigned N> bool aims(const NormalTarget<N>& target) {
    for (unsigned lane = 0; lane < N; ++lane)
        if (target.kappa.lane[lane] != 0) return true;
    return false;
}

template <unsigned N>
void solve_normal(ContactPack<N>& c, PointPack<N>& point, Pair<N>& p, const NormalTarget<N>& target) {
    const Int32<N> speed = row_speed(p, c.d[0], point.xa[0], point.xb[0]) + target.bias;
    const Int32<N> old = point.impulse[0];
    const Int32<N> wanted = old - rounded<30>(speed * target.kappa) - rounded<30>(old * target.impulse_scale);
    point.impulse[0] = clamped(max(wanted, splat<N>(0)));
    point.impulse_max = max(point.impulse_max, point.impulse[0]);
    const Int32<N> change = point.impulse[0] - old;
    const Int32<N> hit = max(speed, splat<N>(0) - speed) - splat<N>(impact_speed_min);
    point.impact = clamped(point.impact + where_positive(hit, change, splat<N>(0)));
    push(p, c.d[0], point, 0, change);
}

/// Takes an impact, or gives back what a warm start from one added too much, at the centre of the points. The points
/// then solve what is left of it rigidly: softness would take a share of the whole impact from the first of them.
template <unsigned N> void solve_mean(ContactPack<N>& c, Pair<N>& p, NormalTarget<N> (&targets)[4]) {
    const MeanRow<N>& mean = c.mean;
    std::uint32_t lanes = 0;
    for (unsigned lane = 0; lane < N; ++lane) {
        bool whole = mean.count_inv.lane[lane] != 0; // not of one point or none
        for (int k = 0; k < c.point_count; ++k)      // all points take part or none does
            whole = whole && (mean.share[k].lane[lane] == 0 || targets[k].kappa.lane[lane] != 0);
        if (whole) lanes |= 1u << lane;
    }
    if (lanes == 0) return;
    Int64<N> bias{};
    for (int k = 0; k < c.point_count; ++k) bias = bias + targets[k].bias * mean.count_inv;
    const Int32<N> error = splat<N>(0) - (row_speed(p, c.d[0], mean.xa, mean.xb) + rounded<30>(bias));
    const Int32<N> impact = max(error, splat<N>(0) - error) - splat<N>(impact_speed_min);
    Int32<N> change = where_positive(impact, error, splat<N>(0));
    bool any = false;
    for (unsigned lane = 0; lane < N; ++lane) {
        if (!((lanes >> lane) & 1u)) change.lane[lane] = 0;
        any = any || change.lane[lane] != 0;
    }
    if (!any) return;
    for (int k = 0; k < c.point_count; ++k) {
        PointPack<N>& point = c.points[k];
        const Int32<N> old = point.impulse[0];
        const Int32<N> wanted = clamped(max(old + rounded<30>(change * mean.share[k]), splat<N>(0)));
        for (unsigned lane = 0; lane < N; ++lane) {
            if (change.lane[lane] == 0) continue;
            point.impulse[0].lane[lane] = wanted.lane[lane];
            count_impact(point, lane, std::int64_t{wanted.lane[lane]} - old.lane[lane]);
            targets[k].kappa.lane[lane] = point.kappa[0].lane[lane];
            targets[k].impulse_scale.lane[lane] = 0;
            point.impulse_max.lane[lane] = std::max(point.impulse_max.lane[lane], wanted.lane[lane]);
        }
        push(p, c.d[0], point, 0, point.impulse[0] - old);
    }
}

template <unsigned N> bool bounces(const ContactPack<N>& c) {
    for (unsigned lane = 0; lane < N; ++lane)
        if (c.restitution.lane[lane] > 0) return true;
    return false;
}

/// Points that are not hit yet come in at this speed. Measured in every substep: a ball that returned with the speed
/// it had at the start of the tick would lose what it gained in the rest of it, a twentieth of its height a bounce.
template <unsigned N> void measure_approach(ContactPack<N>& c, const Pair<N>& p) {
    for (int k = 0; k < c.point_count; ++k) {
        PointPack<N>& point = c.points[k];
        const Int32<N> speed = row_speed(p, c.d[0], point.xa[0], point.xb[0]);
        const Int32<N> hit = max(point.impulse[0], point.impulse_max);
        point.approach = where_positive(hit, point.approach, speed);
    }
}

/// Normal speed and impulse of the points of a contact.
template <unsigned N> struct PointStates { Int32<N> speed[4], impulse[4]; };

template <unsigned N> PointStates<N> point_states(const ContactPack<N>& c, const Pair<N>& p) {
    PointStates<N> s{};
    for (int k = 0; k < c.point_count; ++k) {
        s.speed[k] = row_speed(p, c.d[0], c.points[k].xa[0], c.points[k].xb[0]);
        s.impulse[k] = c.points[k].impulse[0];
    }
    return s;
}

/// The work of what was pressed since `before`: impulse times the mean of the speeds before and after.
template <unsigned N> void count_taken(ContactPack<N>& c, const Pair<N>& p, const PointStates<N>& before) {
    constexpr std::int64_t limit = std::int64_t{1} << 62;
    const PointStates<N> after = point_states(c, p);
    for (int k = 0; k < c.point_count; ++k)
        for (unsigned lane = 0; lane < N; ++lane) {
            PointPack<N>& point = c.points[k];
            if (c.restitution.lane[lane] == 0 || point.kappa[0].lane[lane] == 0) continue;
            const std::int64_t change = std::clamp<std::int64_t>(
                divide_shifted(std::int64_t{after.impulse[k].lane[lane]} - before.impulse[k].lane[lane],
                               point.kappa[0].lane[lane], 30),
                -impulse_limit, impulse_limit);
            const std::int64_t speeds =
                std::clamp<std::int64_t>(std::int64_t{before.speed[k].lane[lane]} + after.speed[k].lane[lane],
                                         -impulse_limit, impulse_limit);
            point.taken.lane[lane] = std::clamp(point.taken.lane[lane] - change * speeds, -limit, limit);
        }
}

/// All normal rows once.
template <unsigned N>
void press(ContactPack<N>& c, Pair<N>& p, NormalTarget<N> (&targets)[4], bool backwards) {
    if (c.point_count > 1) {
        solve_block(c, p, targets);
        solve_mean(c, p, targets);
    }
    for (int k = 0; k < c.point_count; ++k) {
        const int at = backwards ? c.point_count - 1 - k : k;
        if (aims(targets[at])) solve_normal(c, c.points[at], p, targets[at]);
    }
}

/// All friction rows once, within the cones of the normal impulses as they are.
template <unsigned N> void rub(ContactPack<N>& c, Pair<N>& p, bool backwards) {
    const std::uint32_t held = solve_slide(c, p);
    if (held == (1u << N) - 1) return;
    for (int k = 0; k < c.point_count; ++k) {
        PointPack<N>& point = c.points[backwards ? c.point_count - 1 - k : k];
        if (carries(point, held)) solve_friction(c, point, p, held);
    }
}

} // namespace

namespace {

/// Adds an angular impulse change about one axis to both bodies.
template <unsigned N> inline void twist(Pair<N>& p, const RollingRows<N>& rows, int axis, Int32<N> dp) {
    const Int32<N> da = rounded<30>(dp * rows.ratio_a), db = rounded<30>(dp * rows.ratio_b);
    for (int i = 0; i < 3; ++i) {
        p.ua[i] = p.ua[i] + rows.xa[axis][i] * da;
        p.ub[i] = p.ub[i] + rows.xb[axis][i] * db;
    }
}

/// Shortens an impulse of three components to `limit`.
inline void clamp_to_ball(std::int64_t limit, std::int32_t& x, std::int32_t& y, std::int32_t& z) {
    const std::uint64_t square = static_cast<std::uint64_t>(std::int64_t{x} * x) +
                                 static_cast<std::uint64_t>(std::int64_t{y} * y) +
                                 static_cast<std::uint64_t>(std::int64_t{z} * z);
    if (square <= static_cast<std::uint64_t>(limit * limit)) return;
    const std::int64_t size = std::int64_t{isqrt(square)} + 1;
    for (std::int32_t* component : {&x, &y, &z})
        *component = static_cast<std::int32_t>(*component * limit / size);
}

/// What stopped the bodies in the last substep does not hold them in this one. Given to them again it would have to be
/// taken back, which one pass does not do wholly for a body between two others: elastic balls would gain energy.
template <unsigned N> void forget_impact(const ContactPack<N>& c, PointPack<N>& point) {
    for (unsigned lane = 0; lane < N; ++lane) {
        std::int32_t& normal = point.impulse[0].lane[lane];
        const std::int32_t impact = std::clamp(point.impact.lane[lane], 0, normal);
        point.impact.lane[lane] = 0;
        if (impact == 0) continue;
        normal -= impact;
        clamp_to_cone(c.friction.lane[lane], normal, point.impulse[1].lane[lane],
                      point.impulse[2].lane[lane]);
    }
}

} // namespace

template <unsigned N> void ContactSolver<N>::solve_rolling(const ContactPack<N>& c, Pair<N>& p) {
    RollingRows<N>& rows = rolling[c.rolling];
    constexpr Int32<N> none{};
    constexpr Int32<N> nothing[3] = {none, none, none};
    Int32<N> t[3];
    for (int r = 0; r < 3; ++r) {
        const Int32<N> speed = row_speed(p, nothing, rows.xa[r], rows.xb[r]);
        t[r] = clamped(rows.impulse[r] - rounded<30>(speed * rows.kappa[r]));
    }
    for (unsigned lane = 0; lane < N; ++lane) {
        std::int64_t limit = 0;
        for (int k = 0; k < c.point_count; ++k)
            limit += shift_right_rounded(
                std::int64_t{rows.share[k].lane[lane]} * c.points[k].impulse[0].lane[lane], row_bits);
        clamp_to_ball(limit < impulse_limit ? limit : impulse_limit, t[0].lane[lane], t[1].lane[lane],
                      t[2].lane[lane]);
    }
    for (int r = 0; r < 3; ++r) {
        twist(p, rows, r, t[r] - rows.impulse[r]);
        rows.impulse[r] = t[r];
    }
}

/// visit(pack) for all packs: one stage after the other, the packs of a stage by workers.
template <unsigned N>
template <class Visit>
void ContactSolver<N>::for_each_pack(Tasks* tasks, Visit&& visit) {
    for (std::uint32_t s = 0; s + 1 < stage_begin.size(); ++s) {
        const std::uint32_t begin = stage_begin[s], count = stage_begin[s + 1] - begin;
        base::for_chunks(tasks, count, pack_chunk,
                         [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                             for (std::uint32_t i = first; i < last; ++i) visit(packs[begin + i]);
                         });
    }
}

template <unsigned N> void ContactSolver<N>::warm_start(SolverBodies& bodies, Tasks* tasks) {
    const StartK start(bodies);
    for_each_pack(tasks, [&](ContactPack<N>& c) {
        Pair<N> p = gather(c, bodies);
        if (bounces(c)) measure_approach(c, p);
        for (int k = 0; k < c.point_count; ++k) {
            forget_impact(c, c.points[k]);
            if (!carries(c.points[k])) continue;
            for (int r = 0; r < 3; ++r) push(p, c.d[r], c.points[k], r, c.points[k].impulse[r]);
        }
        if (c.rolling != no_contact)
            for (int r = 0; r < 3; ++r) twist(p, rolling[c.rolling], r, rolling[c.rolling].impulse[r]);
        scatter(c, p, bodies);
    });
}

template <unsigned N>
void ContactSolver<N>::solve_pack(const StepConstants& step, SolverBodies& bodies, bool bias,
                                  ContactPack<N>& c) {
    Pair<N> p = gather(c, bodies);
    if (c.rolling != no_contact) solve_rolling(c, p);
    if (bias) rub(c, p, false);
    NormalTarget<N> targets[4];
    const Motion<N> motion = gather_motion(c, bodies);
    for (int k = 0; k < c.point_count; ++k) targets[k] = normal_target(c, c.points[k], step, motion, bias);
    if (bounces(c)) {
        const PointStates<N> before = point_states(c, p);
        press(c, p, targets, !bias);
        count_taken(c, p, before);
    } else
        press(c, p, targets, !bias);
    if (!bias) rub(c, p, true);
    scatter(c, p, bodies);
}

template <unsigned N>
void ContactSolver<N>::solve(const StepConstants& step, SolverBodies& bodies, bool bias, Tasks* tasks) {
    const StartK start(bodies);
    // The relaxing pass goes backwards over a contact: one pass alone favours whoever comes first, and a tower that is
    // pushed the same way every step starts to rock; a pair of mirrored passes does not. Friction comes last in it, when
    // the push is taken back: within the cone of an impulse that pushes out, what slides in overlap is braked twice.
    for_each_pack(tasks, [&](ContactPack<N>& c) { solve_pack(step, bodies, bias, c); });
}

template <unsigned N>
void ContactSolver<N>::apply_restitution(const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    const StartK start(bodies);
    for_each_pack(tasks, [&](ContactPack<N>& c) {
        if (!bounces(c)) return;
        Pair<N> p = gather(c, bodies);
        NormalTarget<N> targets[4];
        for (int k = 0; k < c.point_count; ++k) {
            const PointPack<N>& point = c.points[k];
            // Bounce where the point came in fast and was in fact hit; elsewhere aim at what is. With no more than the
            // point itself took: what another contact stopped is that one's to give back.
            Int32<N> target = splat<N>(0), kappa = splat<N>(0);
            for (unsigned lane = 0; lane < N; ++lane) {
                const std::int32_t approach = point.approach.lane[lane];
                if (c.restitution.lane[lane] == 0 || approach > -step.restitution_speed_min.raw ||
                    point.impulse_max.lane[lane] == 0)
                    continue;
                const std::int64_t taken = std::max<std::int64_t>(point.taken.lane[lane], 0);
                const std::int64_t most = std::int64_t{isqrt(static_cast<std::uint64_t>(taken))};
                target.lane[lane] = static_cast<std::int32_t>(shift_right_rounded(
                    std::max(std::int64_t{approach}, -most) * c.restitution.lane[lane], Unit::fraction_bits));
                kappa.lane[lane] = point.kappa[0].lane[lane];
            }
            targets[k] = {kappa, target, splat<N>(0)};
        }
        if (c.point_count > 1) solve_mean(c, p, targets);
        for (int k = 0; k < c.point_count; ++k) solve_normal(c, c.points[k], p, targets[k]);
        scatter(c, p, bodies);
    });
}

template void ContactSolver<1>::solve_pack(const StepConstants&, SolverBodies&, bool, ContactPack<1>&);
template void ContactSolver<1>::solve_rolling(const ContactPack<1>&, Pair<1>&);
template void ContactSolver<1>::warm_start(SolverBodies&, Tasks*);
template void ContactSolver<1>::solve(const StepConstants&, SolverBodies&, bool, Tasks*);
template void ContactSolver<1>::apply_restitution(const StepConstants&, SolverBodies&, Tasks*);
template void ContactSolver<4>::solve_pack(const StepConstants&, SolverBodies&, bool, ContactPack<4>&);
template void ContactSolver<4>::solve_rolling(const ContactPack<4>&, Pair<4>&);
template void ContactSolver<4>::warm_start(SolverBodies&, Tasks*);
template void ContactSolver<4>::solve(const StepConstants&, SolverBodies&, bool, Tasks*);
template void ContactSolver<4>::apply_restitution(const StepConstants&, SolverBodies&, Tasks*);

} // namespace lockstone::dynamics
