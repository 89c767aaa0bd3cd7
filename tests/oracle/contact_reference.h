// The passes over one contact, written as the equations of contact_solver.h: plain loops over plain integers.
// This is the place to read the contact solver for the first time, and to try a change on. The kernels compute the same bits
// for several contacts side by side; contact_reference.cpp compares them.
// Numbers have the fraction bits of pack.h. A product has 64 bits and the sum of the fraction bits.
#pragma once

#include "oracle/reference_numbers.h"
#include "solve/contacts/pack.h"

namespace lockstone::test::reference {

struct Motion {
    i64 v[3], u[3]; ///< u = K w: angular velocity times the radii of gyration, so both are speeds
};
struct Body {
    Motion velocity, warm, arrival; ///< PassData::bodies, warm, arrival
    i32 shift[3], theta[3];         ///< since the tick began
    i64 keep[3];                    ///< zero along locked axes, otherwise all ones
    bool movable;                   ///< impulses move the body
};
struct Point {
    i32 a, b;      ///< arm
    i32 gap0, gap; ///< at the start of the tick, and at present
    i32 p;         ///< impulse
    i32 impact;    ///< the part of p that stopped the bodies in this substep
    i32 h[3];      ///< column of H: shares of (level, tilts); zero for points that are no members
    i32 kappa;     ///< 1 / (arm^T S arm)
    i32 reach;     ///< distance from the centre
    bool is_member() const { return h[0] > 0; }
};
/// The rows D = (-d, xA; d, xB). The first `lines` rows of a Rows have a linear part d.
struct Rows {
    int lines;
    i32 d[3][3], a[3][3], b[3][3]; ///< [row][component]
};
struct Contact {
    int count;                     ///< points, 1 to 4
    Rows normal;                   ///< level and tilts
    Rows slide;                    ///< two tangents and the twist
    i32 alpha, beta;               ///< shares of the bodies
    i32 s[6], inverse[6];          ///< S, S^-1
    i32 x[4], soft_inverse[6];     ///< X, (S + X)^-1
    i32 slide_inverse[6], t[3];    ///< B: S^-1 of the slide rows; their impulses
    i32 mu, surface[2];            ///< friction; speed of the surface along the tangents
    i32 mass_scale, impulse_scale; ///< softness
    i32 bias_rate, push;           ///< overlap is pushed out at this rate, within the speed -push
    bool bounces, keeps;           ///< has restitution; keeps hard impacts in the warm start
    Point points[4];
    bool several() const { return count > 1; }
};

/// The passes over one contact.
class Solver {
    Contact& c;
    Body &a, &b;
    const PassSettings& settings;

    /// Velocities in the format of rows.
    struct Rounded {
        i32 apart[3], ua[3], ub[3];
    };
    static Rounded rounded_motion(const Motion& of_a, const Motion& of_b) {
        Rounded out;
        for (int i = 0; i < 3; ++i) {
            out.apart[i] = rounded(minus(of_b.v[i], of_a.v[i]), row_bits);
            out.ua[i] = rounded(of_a.u[i], row_bits), out.ub[i] = rounded(of_b.u[i], row_bits);
        }
        return out;
    }
    /// D v of one row.
    static i32 speed_of(const Rows& rows, int r, const Rounded& m) {
        i64 sum = 0;
        for (int i = 0; i < 3; ++i) {
            if (r < rows.lines) sum = plus(sum, times(rows.d[r][i], m.apart[i]));
            sum = plus(sum, times(rows.a[r][i], m.ua[i]), times(rows.b[r][i], m.ub[i]));
        }
        return bounded(rounded(sum, row_bits));
    }
    /// v += M^-1 D^T w. With `holds`, velocities along locked axes become zero.
    void push(const Rows& rows, const i32 (&w)[3], Motion& of_a, Motion& of_b, bool holds) const {
        const int count = c.several() ? 3 : rows.lines;
        for (int r = 0; r < count; ++r) {
            const i32 wa = rounded(times(w[r], c.alpha), unit_bits),
                      wb = rounded(times(w[r], c.beta), unit_bits);
            for (int i = 0; i < 3; ++i) {
                if (a.movable && r < rows.lines) of_a.v[i] = minus(of_a.v[i], times(rows.d[r][i], wa));
                if (b.movable && r < rows.lines) of_b.v[i] = plus(of_b.v[i], times(rows.d[r][i], wb));
                if (a.movable) of_a.u[i] = plus(of_a.u[i], times(rows.a[r][i], wa));
                if (b.movable) of_b.u[i] = plus(of_b.u[i], times(rows.b[r][i], wb));
            }
        }
        for (int i = 0; holds && i < 3; ++i)
            of_a.v[i] &= a.movable ? a.keep[i] : -1, of_b.v[i] &= b.movable ? b.keep[i] : -1;
    }
    /// The value of a quantity with level and tilts at a point: x0 + a x1 + b x2.
    static i32 at(const Point& k, const i32 (&x)[3]) {
        return low(i64{x[0]} + rounded(plus(times(x[1], k.a), times(x[2], k.b)), unit_bits));
    }
    /// Q = sum of p (1, a, b).
    void moments(const i32 (&p)[4], i32 (&q)[3]) const {
        i64 sum[3] = {};
        for (int k = 0; k < c.count; ++k) {
            sum[0] += p[k];
            sum[1] = plus(sum[1], times(p[k], c.points[k].a)),
            sum[2] = plus(sum[2], times(p[k], c.points[k].b));
        }
        q[0] = low(sum[0]), q[1] = rounded(sum[1], unit_bits), q[2] = rounded(sum[2], unit_bits);
    }

    // ---- gaps -------------------------------------------------------------------------------------------------------

    /// g = g0 + D . motion since the tick began.
    void measure_gaps() {
        i64 moved[3] = {};
        for (int r = 0; r < 3; ++r)
            for (int i = 0; i < 3; ++i) {
                const i64 shift =
                    minus(times(c.normal.d[r][i], b.shift[i]), times(c.normal.d[r][i], a.shift[i]));
                if (r < c.normal.lines) moved[r] = plus(moved[r], shift);
                moved[r] =
                    plus(moved[r], times(c.normal.a[r][i], a.theta[i]), times(c.normal.b[r][i], b.theta[i]));
            }
        if (!c.several()) {
            c.points[0].gap =
                rounded_within(plus(times(c.points[0].gap0, 1 << row_bits), moved[0]), row_bits, gap_limit);
            return;
        }
        const i32 middle = rounded_within(moved[0], row_bits, 1 << 30);
        const i32 tilt[2] = {rounded_within(moved[1], row_bits, 1 << 29),
                             rounded_within(moved[2], row_bits, 1 << 29)};
        for (int k = 0; k < c.count; ++k) {
            Point& point = c.points[k];
            const i64 level = plus(times(middle, one), times(point.gap0, one));
            const i64 sum = plus(level, times(tilt[0], point.a), times(tilt[1], point.b));
            point.gap = rounded_within(sum, unit_bits, gap_limit);
        }
    }

    // ---- normals ----------------------------------------------------------------------------------------------------

    struct Normals {
        i32 speed[3];                          ///< D v
        i32 bias[4], error[4], old[4], now[4]; ///< of points
        bool soft = false;                     ///< a member overlaps in the soft pass
        bool hit = false;                      ///< a member comes in faster than impact_speed
        bool leaves = false; ///< the block cannot be used: a point would pull, or no member closes
        bool busy = false;   ///< a point carries or closes
    };
    void find_speeds(const Motion& of_a, const Motion& of_b, i32 (&speed)[3]) const {
        const Rounded m = rounded_motion(of_a, of_b);
        for (int r = 0; r < 3; ++r) speed[r] = r == 0 || c.several() ? speed_of(c.normal, r, m) : 0;
    }
    /// The speed that closes a gap by the end of the substep, or minus the speed that pushes overlap out.
    i32 bias_of(const Point& point) const {
        if (point.gap > 0)
            return rounded(times(std::min(point.gap, settings.gap_max), settings.substeps_per_second),
                           gap_bits - speed_bits);
        if (!settings.soft) return 0;
        return std::max(rounded(times(std::max(point.gap, -overlap_max), c.bias_rate), gap_bits), c.push);
    }
    void measure_normals(Normals& n) const {
        find_speeds(a.velocity, b.velocity, n.speed);
        for (int k = 0; k < c.count; ++k) {
            const Point& point = c.points[k];
            const i32 speed = at(point, n.speed), away = low(-i64{speed});
            n.bias[k] = bias_of(point), n.old[k] = point.p;
            // The impacts of the next substep part their bodies, so this pass must not stop them.
            const bool comes_in = !settings.soft && c.bounces && away > settings.bounce_speed_min;
            if (comes_in) n.bias[k] = std::max(n.bias[k], away);
            n.error[k] = low(i64{speed} + n.bias[k]);
            const bool overlaps = point.gap <= 0, carries = point.p > 0,
                       closes = n.error[k] < 0 && point.gap0 < gap_limit;
            n.busy = n.busy || carries || closes;
            const i32 stops = low(i64{speed} + (overlaps ? 0 : n.bias[k]));
            const bool is_fast = stops < -impact_speed || (stops > impact_speed && carries);
            n.hit = n.hit || (point.is_member() && !comes_in && is_fast);
            n.leaves = n.leaves || (!point.is_member() && (carries || closes));
            n.soft = n.soft || (settings.soft && point.is_member() && overlaps);
        }
    }
    /// Speeds that come from passes or from overlap are a load and no impact: the bodies have to approach each other by
    /// their arrival velocities too.
    bool arrives() const {
        i32 speed[3];
        find_speeds(a.arrival, b.arrival, speed);
        const auto comes = [&](const Point& k) { return k.gap0 < gap_limit && at(k, speed) < -impact_speed; };
        return std::any_of(c.points, c.points + c.count, comes);
    }
    /// Q' = Q - (S + X)^-1 (D v + H bias + X Q),  p = H^T Q'.
    void solve_block(const i32 (&q)[3], Normals& n) const {
        i32 error[3], after[3];
        for (int i = 0; i < 3; ++i) {
            i64 sum = 0;
            for (int k = 0; k < c.count; ++k) sum = plus(sum, times(c.points[k].h[i], n.bias[k]));
            error[i] = bounded(low(i64{n.speed[i]} + rounded_within(sum, fit_bits, speed_limit)));
        }
        if (n.soft) {
            const i64 lost[3] = {times(c.x[0], q[0]), plus(times(c.x[1], q[1]), times(c.x[2], q[2])),
                                 plus(times(c.x[2], q[1]), times(c.x[3], q[2]))};
            for (int i = 0; i < 3; ++i)
                error[i] = bounded(low(i64{error[i]} + rounded_within(lost[i], response_bits, speed_limit)));
        }
        const i32(&inverse)[6] = n.soft ? c.soft_inverse : c.inverse;
        for (int i = 0; i < 3; ++i) {
            i64 sum = 0;
            for (int j = 0; j < 3; ++j) sum = plus(sum, times(inverse[lower[i][j]], error[j]));
            after[i] = low(i64{q[i]} - rounded_within(sum, inverse_bits, answer_limit));
        }
        for (int k = 0; k < c.count; ++k) {
            i64 sum = 0;
            for (int i = 0; i < 3; ++i) sum = plus(sum, times(c.points[k].h[i], after[i]));
            const i32 p = rounded_within(sum, fit_bits, impulse_limit);
            n.leaves = n.leaves || p < -pull_tolerance;
            n.now[k] = std::max(p, 0);
        }
    }
    /// p_k' = max(p_k - kappa_k mass_scale (s + bias_k) - impulse_scale p_k, 0)
    i32 corrected(const Point& point, i32 p, i32 error, i32 mass_scale, i32 impulse_scale) const {
        const i32 kappa = rounded(times(point.kappa, mass_scale), unit_bits);
        const i64 less = i64{rounded(times(bounded(error), kappa), kappa_bits)} +
                         rounded(times(p, impulse_scale), unit_bits);
        return std::clamp(low(p - less), 0, impulse_limit);
    }
    /// Each point in turn, forwards and backwards, twice. The three speeds follow by S.
    void sweep(i32 mass_scale, i32 impulse_scale, Normals& n) const {
        constexpr int answer_bits = response_bits - 2;
        i32 speed[3] = {n.speed[0], n.speed[1], n.speed[2]};
        for (int k = 0; k < c.count; ++k) n.now[k] = n.old[k];
        for (int visit = 0; visit < 4 * c.count; ++visit) {
            const int k = (visit / c.count) % 2 == 0 ? visit % c.count : c.count - 1 - visit % c.count;
            const Point& point = c.points[k];
            const i32 p =
                corrected(point, n.now[k], low(i64{at(point, speed)} + n.bias[k]), mass_scale, impulse_scale);
            const i32 change = p - n.now[k];
            n.now[k] = p;
            for (int i = 0; i < 3; ++i) {
                const i64 sum = plus(times(c.s[lower[i][0]], one), times(c.s[lower[i][1]], point.a),
                                     times(c.s[lower[i][2]], point.b));
                const i32 answer = rounded(sum, response_bits + unit_bits - answer_bits);
                speed[i] = low(i64{speed[i]} + rounded(times(answer, change), answer_bits));
            }
        }
    }
    void solve_normals() {
        Normals n;
        measure_normals(n);
        if (!n.busy) return;
        n.hit = n.hit && arrives();
        n.soft = n.soft && !n.hit;
        const i32 mass_scale = n.soft ? c.mass_scale : one, impulse_scale = n.soft ? c.impulse_scale : 0;
        i32 q[3], w[3], change[4];
        moments(n.old, q);
        if (c.several()) solve_block(q, n);
        if (c.several() && n.leaves) sweep(mass_scale, impulse_scale, n);
        if (!c.several()) n.now[0] = corrected(c.points[0], n.old[0], n.error[0], mass_scale, impulse_scale);
        moments(n.now, w);
        for (int i = 0; i < 3; ++i) w[i] = low(i64{w[i]} - q[i]);
        push(c.normal, w, a.velocity, b.velocity, true);
        for (int k = 0; k < c.count; ++k) {
            c.points[k].p = n.now[k], change[k] = n.now[k] - n.old[k];
            if (n.hit) c.points[k].impact = low(i64{c.points[k].impact} + change[k]);
        }
        if (!n.hit) return;
        moments(change, w);
        push(c.normal, w, a.arrival, b.arrival, true);
    }

    // ---- friction ---------------------------------------------------------------------------------------------------

    void solve_friction() {
        i64 pressing = 0, reach = 0;
        for (int k = 0; k < c.count; ++k) {
            pressing += c.points[k].p;
            reach = plus(reach, times(c.points[k].p, c.points[k].reach));
        }
        if (pressing <= 0 && c.t[0] == 0 && c.t[1] == 0 && c.t[2] == 0) return;
        const Rounded m = rounded_motion(a.velocity, b.velocity);
        const int rows = c.several() ? 3 : 2;
        i32 speed[3] = {}, now[3] = {}, w[3];
        for (int r = 0; r < rows; ++r)
            speed[r] = low(i64{speed_of(c.slide, r, m)} + (r < 2 ? c.surface[r] : 0));
        for (int r = 0; r < rows; ++r) {
            i64 sum = 0;
            for (int i = 0; i < rows; ++i) sum = plus(sum, times(c.slide_inverse[lower[r][i]], speed[i]));
            now[r] = low(i64{c.t[r]} - rounded_within(sum, inverse_bits, speed_limit));
        }
        const i32 least[3] = {now[0], now[1], now[2]};
        i32 from[3] = {c.t[0], c.t[1], 0};
        if (c.several()) {
            const i32 most = rounded_within(times(c.mu, rounded(reach, unit_bits)), row_bits, speed_limit);
            limit_twist(most, now), from[2] = std::clamp(c.t[2], -most, most);
        }
        hold_in_cone(rounded_within(times(c.mu, low(pressing)), row_bits, speed_limit), from, least, now);
        for (int r = 0; r < 3; ++r) w[r] = low(i64{now[r]} - c.t[r]), c.t[r] = now[r];
        push(c.slide, w, a.velocity, b.velocity, true);
    }
    /// A twist that the limit shortens by d moves tangent r by d B[r][2] / B[2][2], with B the inverse matrix.
    void limit_twist(i32 most, i32 (&now)[3]) const {
        const i64 change = i64{std::clamp(now[2], -most, most)} - now[2];
        now[2] = std::clamp(now[2], -most, most);
        const i64 own = c.slide_inverse[lower[2][2]];
        for (int r = 0; change != 0 && own > 0 && r < 2; ++r)
            now[r] = low(std::clamp<i64>(now[r] + change * c.slide_inverse[lower[2][r]] / own, -speed_limit,
                                         speed_limit));
    }
    /// Shortens (t1, t2) to `limit`: an exact cone, no pyramid. Where that adds energy, the impulse goes from `from` toward
    /// `now` as far as the limit allows.
    void hold_in_cone(i32 limit, const i32 (&from)[3], const i32 (&least)[3], i32 (&now)[3]) const {
        const auto is_within = [&](i64 x, i64 y) {
            return u64(x * x) + u64(y * y) <= u64(i64{limit} * limit);
        };
        if (is_within(now[0], now[1])) return;
        const i64 size = root(times(now[0], now[0]) + times(now[1], now[1])) + 1;
        const i32 end[3] = {low(times(now[0], limit) / size), low(times(now[1], limit) / size), now[2]};
        i32 step = 0; // of 4096
        if (is_within(from[0], from[1]) && adds_energy(least, from, end)) {
            const auto at = [&](int r, i64 s) { return from[r] + (((i64{now[r]} - from[r]) * s) >> 12); };
            for (i32 more = 2048; more > 0; more /= 2)
                if (is_within(at(0, step + more), at(1, step + more))) step += more;
            for (int r = 0; step > 0 && r < 3; ++r) now[r] = low(at(r, step));
        }
        if (step == 0) std::copy_n(end, 3, now);
    }
    /// The energy is that of `least` and (p - least)^T K (p - least), with K the inverse of B. It is compared with 24 bits
    /// of the adjugate of B and 17 of the impulses, and only where the rows respond unevenly.
    bool adds_energy(const i32 (&least)[3], const i32 (&from)[3], const i32 (&end)[3]) const {
        i64 m[3][3], k[6] = {}, x[6];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) m[i][j] = c.slide_inverse[lower[i][j]] / 2;
        const i64 part = (m[0][0] + m[1][1]) / 16;
        if (std::abs(m[0][0] - m[1][1]) <= part && std::abs(m[0][1]) <= part &&
            m[0][2] * m[0][2] <= m[0][0] * m[2][2] / 16 && m[1][2] * m[1][2] <= m[1][1] * m[2][2] / 16)
            return false;
        const bool twists = m[2][2] > 0;
        if (!twists) k[0] = m[1][1], k[1] = -m[0][1], k[2] = m[0][0];
        for (int i = 0; twists && i < 3; ++i)
            for (int j = 0; j <= i; ++j) { // the cofactor of (i, j)
                const int p = (i + 1) % 3, q = (i + 2) % 3, s = (j + 1) % 3, t = (j + 2) % 3;
                k[lower[i][j]] = m[p][s] * m[q][t] - m[p][t] * m[q][s];
            }
        for (int r = 0; r < 3; ++r) x[r] = i64{end[r]} - least[r], x[3 + r] = i64{from[r]} - least[r];
        shorten(k, 24), shorten(x, 17);
        const auto energy = [&](const i64* y) {
            i64 sum = 0;
            for (int i = 0; i < 9; ++i) sum += k[lower[i / 3][i % 3]] * y[i / 3] * y[i % 3];
            return sum;
        };
        return energy(x) - energy(x + 3) > energy(x + 3) / 256;
    }

    /// Takes the impulses that stopped the bodies out of the next warm start; friction shrinks in the same ratio.
    void forget_impacts() {
        constexpr i32 hard = 1 << speed_bits; // 1 m/s
        const bool is_hard =
            std::any_of(c.points, c.points + c.count, [](const Point& k) { return k.impact > hard; });
        i64 before = 0, after = 0;
        i32 taken[4], w[3], slide[3];
        for (int k = 0; k < c.count; ++k) {
            Point& point = c.points[k];
            const i32 impact = c.keeps && is_hard ? 0 : std::clamp(point.impact, 0, point.p);
            before += point.p, point.p -= impact, after += point.p;
            taken[k] = impact, point.impact = 0;
        }
        if (after == before) return;
        w[0] = low(after - before), w[1] = w[2] = 0;
        for (int k = 0; k < c.count; ++k) { // each point is rounded alone, unlike in moments()
            w[1] = low(i64{w[1]} - rounded(times(c.points[k].a, taken[k]), unit_bits));
            w[2] = low(i64{w[2]} - rounded(times(c.points[k].b, taken[k]), unit_bits));
        }
        for (int r = 0; r < 3; ++r) {
            const i32 less = low(c.t[r] * after / before);
            slide[r] = less - c.t[r], c.t[r] = less;
        }
        push(c.normal, w, a.warm, b.warm, false);
        push(c.slide, slide, a.warm, b.warm, false);
    }

  public:
    Solver(Contact& contact, Body& first, Body& second, const PassSettings& of)
        : c(contact), a(first), b(second), settings(of) {}

    /// v += M^-1 D^T p with the impulses of the last tick.
    void warm_start() {
        i32 p[4], q[3];
        for (int k = 0; k < c.count; ++k) p[k] = c.points[k].p;
        moments(p, q);
        push(c.normal, q, a.velocity, b.velocity, false);
        push(c.slide, c.t, a.velocity, b.velocity, true);
    }
    /// The soft pass ends with the normals, the relaxing pass with friction: the soft normal impulses also push overlap
    /// out, and friction within the limit of those would brake a sliding body too much.
    void pass() {
        if (settings.soft)
            solve_friction(), solve_normals();
        else
            measure_gaps(), solve_normals(), solve_friction(), forget_impacts();
    }
};

} // namespace lockstone::test::reference
