// Solving the members of a contact at once. See contact.h for the symbols and contact_rows.h for the preparation.
#pragma once

#include "dynamics/contact_pair.h"

#include <array>

namespace lockstone::dynamics {

inline constexpr std::int64_t block_error_max = std::int64_t{1} << 28; ///< [512 m/s]
inline constexpr std::int64_t block_small_max = std::int64_t{1} << 32;

/// sum of fit[i][k] x[k] over the points, Speed: how x lies over the members, level and tilts.
template <unsigned N>
std::array<std::int64_t, 3> fitted(const ContactPack<N>& c, unsigned lane, const std::int32_t (&x)[4]) {
    std::array<std::int64_t, 3> sum{}; // four products of 62 bits at most: halved before
    for (std::size_t i = 0; i < 3; ++i) {
        for (int k = 0; k < c.point_count; ++k)
            sum[i] += (std::int64_t{c.block.fit[i][k].lane[lane]} * x[k]) >> 2;
        sum[i] = shift_right_rounded(sum[i], fit_bits - 2);
    }
    return sum;
}

/// -(inverse) error, Speed. Entries within 2^31 and errors within 2^28: sums below 2^61.
template <unsigned N>
std::array<std::int32_t, 3> block_answer(const Int32<N> (&inverse)[6], unsigned lane,
                                         std::array<std::int64_t, 3> error) {
    constexpr int index[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
    for (std::int64_t& e : error) e = std::clamp(e, -block_error_max, block_error_max);
    std::array<std::int32_t, 3> w{};
    for (std::size_t i = 0; i < 3; ++i) {
        std::int64_t sum = 0;
        for (std::size_t j = 0; j < 3; ++j) sum += inverse[index[i][j]].lane[lane] * error[j];
        w[i] = static_cast<std::int32_t>(std::clamp<std::int64_t>(
            -shift_right_rounded(sum, block_inverse_entry_bits), -impulse_limit, impulse_limit));
    }
    return w;
}

/// Adds w along three rows to both bodies; only the row `linear` and those before it have a linear part.
template <unsigned N>
void push_block(Pair<N>& p, const ContactPack<N>& c, const Int32<N> (&xa)[3][3], const Int32<N> (&xb)[3][3],
                int first_direction, int linear, const Int32<N> (&w)[3]) {
    for (int r = 0; r < 3; ++r) {
        const Int32<N> da = rounded<30>(w[r] * c.points[0].ratio_a),
                       db = rounded<30>(w[r] * c.points[0].ratio_b);
        for (int i = 0; i < 3; ++i) {
            if (r < linear) {
                p.va[i] = p.va[i] - c.d[first_direction + r][i] * da;
                p.vb[i] = p.vb[i] + c.d[first_direction + r][i] * db;
            }
            p.ua[i] = p.ua[i] + xa[r][i] * da;
            p.ub[i] = p.ub[i] + xb[r][i] * db;
        }
    }
}

/// m x = rhs of 1 to 3 unknowns; m with response_bits, entries within 2^31, rhs within 2^33. False when nearly singular.
inline bool solve_small(int n, std::int64_t (&m)[4][4], std::int64_t (&rhs)[4], std::int64_t (&x)[4]) {
    constexpr std::int64_t pivot_min = 1 << 12, factor_max = std::int64_t{1} << (response_bits + 4);
    for (int c = 0; c < n; ++c) {
        if (m[c][c] < pivot_min) return false;
        for (int r = c + 1; r < n; ++r) {
            const std::int64_t f =
                std::clamp(m[r][c] * (1 << response_bits) / m[c][c], -factor_max, factor_max);
            for (int j = c; j < n; ++j)
                m[r][j] = std::clamp(m[r][j] - shift_right_rounded(f * m[c][j], response_bits),
                                     -block_small_max, block_small_max);
            rhs[r] = std::clamp(rhs[r] - shift_right_rounded(f * rhs[c], response_bits), -block_small_max,
                                block_small_max);
        }
    }
    for (int r = n - 1; r >= 0; --r) {
        std::int64_t sum = rhs[r];
        for (int j = r + 1; j < n; ++j) sum -= shift_right_rounded(m[r][j] * x[j], response_bits);
        x[r] = std::clamp(sum, -block_small_max, block_small_max) * (1 << response_bits) / m[r][r];
        if (x[r] > impulse_limit || x[r] < -impulse_limit) return false;
    }
    return true;
}

/// What one lane of a block's normals starts from.
struct BlockState {
    std::uint32_t members;
    bool soft, hit;
    std::int64_t speed[3], sums[3]; ///< D v and Q, Speed
    std::int64_t a[4], b[4];        ///< 30 fraction bits
    std::int32_t bias[4], old[4];   ///< Speed
};

/// arm of the point . (level, tilt, tilt)
inline std::int64_t at_point(const BlockState& s, int k, const std::int64_t (&x)[3]) {
    return x[0] + shift_right_rounded(s.a[k] * x[1], 30) + shift_right_rounded(s.b[k] * x[2], 30);
}

/// A member that is hit is stopped rigidly, and all with it: softness would take a share of the whole impact. False when
/// nothing presses and nothing comes in: then all points stay without impulse.
template <unsigned N>
bool begin_block(const ContactPack<N>& c, unsigned lane, const NormalTarget<N> (&targets)[4], BlockState& s) {
    bool idle = true;
    for (int k = 0; k < c.point_count; ++k) {
        if (targets[k].kappa.lane[lane] == 0) continue; // a point this lane lacks
        s.a[k] = c.block.arm[0][k].lane[lane];
        s.b[k] = c.block.arm[1][k].lane[lane];
        s.bias[k] = targets[k].bias.lane[lane];
        s.old[k] = c.points[k].impulse[0].lane[lane];
        const std::int64_t error = at_point(s, k, s.speed) + s.bias[k];
        idle = idle && s.old[k] == 0 && error >= 0;
        if (!((s.members >> k) & 1u)) continue;
        s.soft = s.soft || targets[k].impulse_scale.lane[lane] > 0;
        s.hit = s.hit || error < -impact_speed_min || (error > impact_speed_min && s.old[k] > 0);
        s.sums[0] += s.old[k];
        s.sums[1] += shift_right_rounded(s.a[k] * s.old[k], 30);
        s.sums[2] += shift_right_rounded(s.b[k] * s.old[k], 30);
    }
    s.soft = s.soft && !s.hit;
    return !idle;
}

/// All members at once. Returns those that would pull.
template <unsigned N>
std::uint32_t solve_all(const ContactPack<N>& c, unsigned lane, const BlockState& s,
                        std::array<std::int32_t, 3>& w, std::int32_t (&after)[4]) {
    const BlockRows<N>& block = c.block;
    std::array<std::int64_t, 3> error = fitted(c, lane, s.bias);
    const std::array<std::int64_t, 3> lies = s.soft ? fitted(c, lane, s.old) : std::array<std::int64_t, 3>{};
    for (std::size_t i = 0; i < 3; ++i) {
        error[i] += s.speed[i];
        if (s.soft)
            error[i] += shift_right_rounded(std::clamp(lies[i], -block_error_max, block_error_max) *
                                                block.gamma.lane[lane],
                                            block_inverse_entry_bits);
    }
    w = block_answer(s.soft ? block.soft : block.rigid, lane, error);
    std::uint32_t pulling = 0;
    for (int k = 0; k < c.point_count; ++k) {
        if (!((s.members >> k) & 1u)) continue;
        std::int64_t sum = 0; // three products of 32 and 33 bits, an eighth of each
        for (std::size_t i = 0; i < 3; ++i) sum += (block.fit[i][k].lane[lane] * (s.sums[i] + w[i])) >> 3;
        sum = shift_right_rounded(sum, fit_bits - 3);
        if (sum < 0) pulling |= 1u << k;
        after[k] = static_cast<std::int32_t>(std::clamp<std::int64_t>(sum, 0, impulse_limit));
    }
    return pulling;
}

/// The members but those that pull, one by one known: at most three. False when that does not go.
template <unsigned N>
bool solve_some(const ContactPack<N>& c, unsigned lane, const BlockState& s, std::uint32_t& pulling,
                std::array<std::int32_t, 3>& w, std::int32_t (&after)[4]) {
    const BlockRows<N>& block = c.block;
    constexpr int index[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
    std::int64_t free[3], sums[3]{}; // the speed that is left without these impulses, negative
    for (int i = 0; i < 3; ++i) {
        free[i] = -s.speed[i];
        for (int j = 0; j < 3; ++j)
            free[i] += shift_right_rounded(block.response[index[i][j]].lane[lane] *
                                               std::clamp(s.sums[j], -block_small_max, block_small_max),
                                           response_bits);
        free[i] = std::clamp(free[i], -block_small_max, block_small_max);
    }
    for (int round = 0; round < 3; ++round) {
        int own[4], n = 0;
        for (int k = 0; k < c.point_count; ++k)
            if (((s.members & ~pulling) >> k) & 1u) own[n++] = k;
        if (n == 0 || n == 4) return false;
        std::int64_t m[4][4], rhs[4], x[4]{};
        for (int i = 0; i < n; ++i) {
            const int k = own[i];
            std::int64_t along[3];
            for (int r = 0; r < 3; ++r) {
                const std::int64_t row[3] = {block.response[index[r][0]].lane[lane],
                                             block.response[index[r][1]].lane[lane],
                                             block.response[index[r][2]].lane[lane]};
                along[r] = at_point(s, k, row);
            }
            for (int j = 0; j < n; ++j)
                m[i][j] = std::clamp(at_point(s, own[j], along), -block_small_max, block_small_max);
            if (s.soft)
                m[i][i] += std::int64_t{block.gamma.lane[lane]} << (response_bits - block_inverse_entry_bits);
            rhs[i] = at_point(s, k, free) - s.bias[k];
        }
        if (!solve_small(n, m, rhs, x)) return false;
        std::uint32_t more = 0;
        for (int i = 0; i < n; ++i)
            if (x[i] < 0) more |= 1u << own[i];
        if (more != 0) {
            pulling |= more;
            continue;
        }
        for (std::int32_t& p : after) p = 0;
        for (int i = 0; i < n; ++i) {
            const int k = own[i];
            after[k] = static_cast<std::int32_t>(x[i]);
            sums[0] += x[i];
            sums[1] += shift_right_rounded(s.a[k] * x[i], 30);
            sums[2] += shift_right_rounded(s.b[k] * x[i], 30);
        }
        for (std::size_t i = 0; i < 3; ++i)
            w[i] = static_cast<std::int32_t>(
                std::clamp<std::int64_t>(sums[i] - s.sums[i], -impulse_limit, impulse_limit));
        return true;
    }
    return false;
}

template <unsigned N> void count_impact(PointPack<N>& point, unsigned lane, std::int64_t change) {
    point.impact.lane[lane] = static_cast<std::int32_t>(std::clamp(
        point.impact.lane[lane] + change, -std::int64_t{impulse_limit}, std::int64_t{impulse_limit}));
}

/// One lane of solve_block: what it pushes by. False when points have to do, or nothing has.
template <unsigned N>
bool solve_block_lane(ContactPack<N>& c, unsigned lane, const Int32<N> (&speed)[3],
                      NormalTarget<N> (&targets)[4], std::array<std::int32_t, 3>& w) {
    const auto leave_out = [&](int k) {
        targets[k].kappa.lane[lane] = targets[k].impulse_scale.lane[lane] = 0;
    };
    BlockState state{};
    state.members = static_cast<std::uint32_t>(c.block.members.lane[lane]);
    for (int i = 0; i < 3; ++i) state.speed[i] = speed[i].lane[lane];
    if (!begin_block(c, lane, targets, state)) {
        for (int k = 0; k < c.point_count; ++k) leave_out(k);
        return false;
    }
    std::int32_t after[4];
    std::uint32_t pulling = solve_all(c, lane, state, w, after);
    if (pulling != 0 && !solve_some(c, lane, state, pulling, w, after)) return false;
    for (int k = 0; k < c.point_count; ++k) {
        if (!((state.members >> k) & 1u)) continue;
        PointPack<N>& point = c.points[k];
        if (state.hit) count_impact(point, lane, std::int64_t{after[k]} - state.old[k]);
        point.impulse[0].lane[lane] = after[k];
        point.impulse_max.lane[lane] = std::max(point.impulse_max.lane[lane], after[k]);
        if (!((pulling >> k) & 1u)) leave_out(k);
    }
    return true;
}

/// Solves what can be solved as a block, and takes it out of the targets.
template <unsigned N> void solve_block(ContactPack<N>& c, Pair<N>& p, NormalTarget<N> (&targets)[4]) {
    bool any = false;
    for (unsigned lane = 0; lane < N; ++lane) any = any || c.block.count.lane[lane] != 0;
    if (!any) return;
    constexpr Int32<N> nothing[3] = {};
    const BlockRows<N>& block = c.block;
    const Int32<N> speed[3] = {row_speed(p, c.d[0], block.xa[0], block.xb[0]),
                               row_speed(p, nothing, block.xa[1], block.xb[1]),
                               row_speed(p, nothing, block.xa[2], block.xb[2])};
    Int32<N> push_by[3] = {};
    any = false;
    for (unsigned lane = 0; lane < N; ++lane) {
        std::array<std::int32_t, 3> w;
        if (block.count.lane[lane] == 0 || !solve_block_lane(c, lane, speed, targets, w)) continue;
        for (std::size_t i = 0; i < 3; ++i) push_by[i].lane[lane] = w[i];
        any = true;
    }
    if (any) push_block(p, c, block.xa, block.xb, 0, 1, push_by);
}

/// One lane of a block's friction.
struct SlideState {
    std::int64_t normal[4], all; ///< impulses and their sum, Speed
    std::int64_t arm[2][4];      ///< from the centre of the normal impulses, 30 fraction bits, at most 2
    std::int64_t centre[2];      ///< that centre, 30 fraction bits
    std::int64_t sums[3];        ///< impulses along both tangents and about the members' centre, Speed
};

/// False when nothing presses.
template <unsigned N> bool begin_slide(const ContactPack<N>& c, unsigned lane, SlideState& s) {
    for (int k = 0; k < c.point_count; ++k) {
        const PointPack<N>& point = c.points[k];
        s.normal[k] = point.impulse[0].lane[lane];
        s.all += s.normal[k];
        for (int i = 0; i < 2; ++i) {
            s.arm[i][k] = c.block.arm[i][k].lane[lane];
            s.centre[i] += (s.arm[i][k] * s.normal[k]) >> 4; // four products of 61 bits
            s.sums[i] += point.impulse[i + 1].lane[lane];
        }
        s.sums[2] += shift_right_rounded(s.arm[0][k] * point.impulse[2].lane[lane], 30) -
                     shift_right_rounded(s.arm[1][k] * point.impulse[1].lane[lane], 30);
    }
    if (s.all <= 0) return false;
    constexpr std::int64_t one = std::int64_t{1} << 30;
    for (int i = 0; i < 2; ++i) {
        s.centre[i] = std::clamp(s.centre[i] / s.all * 16, -one, one);
        for (int k = 0; k < c.point_count; ++k) s.arm[i][k] -= s.centre[i];
    }
    return true;
}

/// The twist about the centre of the normal impulses over their moment, times their sum, Speed.
inline std::int64_t slide_turn(const SlideState& s, int points, const std::int64_t (&total)[3]) {
    std::int64_t moment = 0; // sum of p r^2, Speed: r^2 below 4 with 27 bits, p below 2^30
    for (int k = 0; k < points; ++k)
        for (const auto& arm : s.arm) moment += (s.normal[k] * ((arm[k] * arm[k]) >> 33)) >> 27;
    if (moment == 0) return 0;
    const std::int64_t twist = total[2] - shift_right_rounded(s.centre[0] * total[1], 30) +
                               shift_right_rounded(s.centre[1] * total[0], 30);
    const std::int64_t turn = narrow_rounded(Wide::product(twist, divide_shifted(s.all, moment, 20)), 20);
    return std::clamp(turn, -std::int64_t{impulse_limit}, std::int64_t{impulse_limit});
}

/// To nearest; d is positive. Towards zero, friction would give way a little in every pass, and what leans would creep.
inline std::int64_t divide_rounded(std::int64_t n, std::int64_t d) { return (n + (n < 0 ? -d : d) / 2) / d; }

/// Shared out as normal impulses times a motion of the plane, which is what a plate that begins to slide does. `w` is
/// what the shares change in sum. False when a point would leave its cone: then points slide one by one.
template <unsigned N>
bool solve_slide_lane(const ContactPack<N>& c, unsigned lane, const std::array<std::int64_t, 3>& speed,
                      std::array<std::int32_t, 3>& w, std::int32_t (&after)[2][4]) {
    SlideState s{};
    if (!begin_slide(c, lane, s)) return false;
    w = block_answer(c.block.slide, lane, speed);
    const std::int64_t total[3] = {s.sums[0] + w[0], s.sums[1] + w[1], s.sums[2] + w[2]};
    const std::int64_t turn = slide_turn(s, c.point_count, total);
    const std::int64_t limit =
        shift_right_rounded(c.friction.lane[lane] * std::min<std::int64_t>(s.all, impulse_limit), row_bits);
    std::int64_t now[3]{};
    for (int k = 0; k < c.point_count; ++k) {
        after[0][k] = after[1][k] = 0;
        if (s.normal[k] == 0) continue;
        std::int64_t x = total[0] - shift_right_rounded(s.arm[1][k] * turn, 30);
        std::int64_t y = total[1] + shift_right_rounded(s.arm[0][k] * turn, 30);
        const std::int64_t reach = std::min<std::int64_t>(limit, impulse_limit);
        if (std::max(magnitude(x), magnitude(y)) > std::uint64_t{impulse_limit}) return false;
        if (x * x + y * y > reach * reach) {
            const std::int64_t size = std::int64_t{isqrt(static_cast<std::uint64_t>(x * x + y * y))} + 1;
            x = x * reach / size, y = y * reach / size;
        }
        after[0][k] = static_cast<std::int32_t>(divide_rounded(x * s.normal[k], s.all));
        after[1][k] = static_cast<std::int32_t>(divide_rounded(y * s.normal[k], s.all));
        now[0] += after[0][k];
        now[1] += after[1][k];
        now[2] += shift_right_rounded(std::int64_t{c.block.arm[0][k].lane[lane]} * after[1][k], 30) -
                  shift_right_rounded(std::int64_t{c.block.arm[1][k].lane[lane]} * after[0][k], 30);
    }
    for (std::size_t i = 0; i < 3; ++i) w[i] = saturate_to_int32(now[i] - s.sums[i]);
    return true;
}

/// Friction of the lanes that hold as a block: a bit for each.
template <unsigned N> std::uint32_t solve_slide(ContactPack<N>& c, Pair<N>& p) {
    const BlockRows<N>& block = c.block;
    std::int64_t normal[N]{}; // of lanes with a block
    bool any = false;
    for (unsigned lane = 0; lane < N; ++lane) {
        if (block.count.lane[lane] == 0) continue;
        for (int k = 0; k < c.point_count; ++k) normal[lane] += c.points[k].impulse[0].lane[lane];
        any = any || normal[lane] > 0;
    }
    if (!any) return 0;
    constexpr Int32<N> nothing[3] = {};
    const Int32<N> speed[3] = {row_speed(p, c.d[1], block.slide_a[0], block.slide_b[0]) + c.surface[0],
                               row_speed(p, c.d[2], block.slide_a[1], block.slide_b[1]) + c.surface[1],
                               row_speed(p, nothing, block.slide_a[2], block.slide_b[2])};
    Int32<N> push_by[3] = {};
    std::uint32_t held = 0;
    for (unsigned lane = 0; lane < N; ++lane) {
        if (normal[lane] <= 0) continue;
        std::array<std::int32_t, 3> w;
        std::int32_t after[2][4];
        if (!solve_slide_lane(c, lane, {speed[0].lane[lane], speed[1].lane[lane], speed[2].lane[lane]}, w,
                              after))
            continue;
        held |= 1u << lane;
        for (std::size_t i = 0; i < 3; ++i) push_by[i].lane[lane] = w[i];
        for (int k = 0; k < c.point_count; ++k)
            for (int r = 1; r < 3; ++r) c.points[k].impulse[r].lane[lane] = after[r - 1][k];
    }
    if (held != 0) push_block(p, c, block.slide_a, block.slide_b, 1, 2, push_by);
    return held;
}

} // namespace lockstone::dynamics
