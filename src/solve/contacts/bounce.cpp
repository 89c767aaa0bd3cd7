#include "solve/contacts/bounce.h"

#include "lockstone/math/math.h"
#include "lockstone/math/wide.h"

#include <algorithm>
#include <bit>

namespace lockstone::solve {

namespace {

using solve::SolverBodies;
using solve::SolverBody;

std::int64_t speed_part(std::int64_t v) { return saturate_to_int32(shift_right_rounded(v, row_bits)); }
/// Adds a component of a row [30 bits] times an impulse or a speed [31 bits]. Many contacts of one body, each within its limits,
/// may drive its velocity beyond 63 bits.
/// Modulo 2^64, as lanes add: a pack does the same whether its lanes are taken one by one or at once.
void add_modulo(std::int64_t& sum, std::int64_t x) {
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) + static_cast<std::uint64_t>(x));
}
void add_product(std::int64_t& sum, std::int64_t row, std::int64_t x) { sum = add_saturated(sum, row * x); }

/// One lane of a pack: the two bodies and the rows between them.
template <unsigned N> struct Lane {
    const ContactPack<N>& pack;
    unsigned lane;

    /// Level and tilts of the normal speed.
    void speeds(const SolverBody* bodies, std::int64_t (&out)[3]) const {
        speeds(bodies[pack.body_a[lane]], bodies[pack.body_b[lane]], out);
    }
    void speeds(const SolverBody& a, const SolverBody& b, std::int64_t (&out)[3]) const {
        speeds_along(a, b, pack.normal_a, pack.normal_b, 0, 1, out);
    }
    /// Speeds along the two tangents and about the normal (the twist).
    void slides(const SolverBody* bodies, std::int64_t (&out)[3]) const {
        speeds_along(bodies[pack.body_a[lane]], bodies[pack.body_b[lane]], pack.slide_a, pack.slide_b, 1, 2,
                     out);
    }
    /// Speeds along three rows, from direction `first` on; the first `lines` of them have a linear part.
    void speeds_along(const SolverBody& a, const SolverBody& b, const std::int32_t (&rows_a)[3][3][N],
                      const std::int32_t (&rows_b)[3][3][N], int first, int lines,
                      std::int64_t (&out)[3]) const {
        std::int64_t move[3], turn_a[3], turn_b[3], any = 0;
        for (int i = 0; i < 3; ++i) {
            move[i] = speed_part(sub_saturated(b.v[i], a.v[i]));
            turn_a[i] = speed_part(a.u[i]), turn_b[i] = speed_part(b.u[i]);
            for (const std::int64_t x : {move[i], turn_a[i], turn_b[i]}) any |= x ^ (x >> 63);
        }
        // Nine products with 30 bits are then below 2^63 in all: nothing saturates.
        const bool is_slow = any >> 29 == 0;
        for (int r = 0; r < 3; ++r) {
            std::int64_t line = 0, turning = 0;
            for (int i = 0; r < lines && i < 3; ++i) line += pack.d[first + r][i][lane] * move[i];
            for (int i = 0; i < 3; ++i) {
                const std::int64_t of_a = rows_a[r][i][lane] * turn_a[i],
                                   of_b = rows_b[r][i][lane] * turn_b[i];
                turning = is_slow ? turning + of_a + of_b : add_saturated(add_saturated(turning, of_a), of_b);
            }
            // Beyond 4096 m/s a point is at the end of every range.
            out[r] = saturate_to_int32(
                shift_right_rounded(is_slow ? turning + line : add_saturated(turning, line), row_bits));
        }
    }
    /// Of a point, out of those of the level and the tilts, which impulses may have driven beyond 32 bits.
    std::int64_t at_point(int k, const std::int64_t (&x)[3]) const {
        const PointLanes<N>& point = pack.points[k];
        if ((((x[1] ^ (x[1] >> 63)) | (x[2] ^ (x[2] >> 63))) >> 31) == 0) // two products below 2^61
            return saturate_to_int32(add_saturated(
                x[0], shift_right_rounded(point.arm[0][lane] * x[1] + point.arm[1][lane] * x[2], unit_bits)));
        // Impulses of tilts may be beyond 2^33: arms of up to 2^30 times them want 128 bits.
        const Wide tilt = Wide::product(point.arm[0][lane], x[1]) + Wide::product(point.arm[1][lane], x[2]);
        return saturate_to_int32(add_saturated(x[0], narrow_rounded(tilt, unit_bits)));
    }
    /// Adds an impulse along row `row` of a set to the velocities of the bodies that move; `line`: along this direction.
    void push(SolverBodies& bodies, const std::int32_t (&xa)[3][N], const std::int32_t (&xb)[3][N],
              const std::int32_t (*line)[N], std::int64_t p) const {
        const auto push_body = [&](SolverBody& to, std::int64_t share, const std::int32_t(&x)[3][N],
                                   std::int64_t sign) {
            const std::int64_t part = shift_right_rounded(p * share, unit_bits);
            for (int i = 0; i < 3; ++i) {
                if (line != nullptr) add_product(to.v[i], sign * line[i][lane] & to.keep[i], part);
                add_product(to.u[i], x[i][lane], part);
            }
        };
        if ((pack.movable_a >> lane) & 1u)
            push_body(bodies.body[pack.body_a[lane]], pack.share_a[lane], xa, -1);
        if ((pack.movable_b >> lane) & 1u)
            push_body(bodies.body[pack.body_b[lane]], pack.share_b[lane], xb, 1);
    }
    void push_normals(SolverBodies& bodies, const std::int64_t (&q)[3]) const {
        for (int r = 0; r < 3; ++r)
            push(bodies, pack.normal_a[r], pack.normal_b[r], r == 0 ? pack.d[0] : nullptr, q[r]);
    }
    void push_slides(SolverBodies& bodies, const std::int64_t (&q)[3]) const {
        for (int r = 0; r < 3; ++r)
            push(bodies, pack.slide_a[r], pack.slide_b[r], r < 2 ? pack.d[r + 1] : nullptr, q[r]);
    }
};

/// Whether no point will bounce in this tick: what a point that was pushed came in with stays as it is.
template <unsigned N>
bool is_settled(const Bounce& bounce, const ContactPack<N>& pack, std::int32_t speed_min) {
    for (int k = 0; k < pack.point_count; ++k) {
        const bool stays = bounce.impulse_max[k] > 0 && bounce.approach[k] > -speed_min;
        if (!stays && pack.points[k].kappa[bounce.lane] != 0) return false;
    }
    return true;
}

/// Twice the work of an impulse: times the sum of the speeds before and after it.
void add_work(Bounce& bounce, std::int64_t impulse, std::int64_t speeds) {
    constexpr std::int64_t limit = std::int64_t{1} << 62, most = std::int64_t{1} << 30;
    bounce.taken = std::clamp(bounce.taken - impulse * std::clamp(speeds, -most, most), -limit, limit);
}

} // namespace

template <unsigned N>
void note_warm_start(std::span<const ContactPack<N>> packs, Bounce* bounces, const WarmStart* warm,
                     const SolverBodies& bodies) {
    const auto before_it = [&](std::uint32_t row) {
        SolverBody body = bodies.body[row];
        for (int i = 0; i < 3; ++i) {
            body.v[i] = sub_saturated(body.v[i], warm[row].v[i] & body.keep[i]);
            body.u[i] = sub_saturated(body.u[i], warm[row].u[i]);
        }
        return body;
    };
    for (const ContactPack<N>& pack : packs)
        for (std::uint32_t i = 0; i < pack.bounce_count; ++i) {
            Bounce& bounce = bounces[pack.bounce + i];
            const Lane<N> at{pack, bounce.lane};
            std::int64_t before[3], after[3];
            bool is_found = false;
            for (int k = 0; k < pack.point_count; ++k) {
                const std::int64_t impulse = pack.points[k].impulse[bounce.lane];
                if (impulse == 0) continue;
                if (!is_found) {
                    at.speeds(before_it(pack.body_a[bounce.lane]), before_it(pack.body_b[bounce.lane]),
                              before);
                    at.speeds(bodies.body.data(), after);
                    is_found = true;
                }
                add_work(bounce, impulse, at.at_point(k, before) + at.at_point(k, after));
            }
        }
}

template <unsigned N>
void keep_approach(const ContactPack<N>& pack, Bounce* bounces, const std::int32_t (&speed)[4][N]) {
    for (std::uint32_t i = 0; i < pack.bounce_count; ++i) {
        Bounce& bounce = bounces[pack.bounce + i];
        for (int k = 0; k < pack.point_count; ++k) {
            const bool was_hit = pack.points[k].impulse[bounce.lane] > 0 || bounce.impulse_max[k] > 0;
            if (!was_hit) bounce.approach[k] = speed[k][bounce.lane];
        }
    }
}

template <unsigned N>
void measure_approach(const ContactPack<N>& pack, Bounce* bounces, const SolverBody* bodies) {
    std::int32_t found[4][N];
    for (std::uint32_t i = 0; i < pack.bounce_count; ++i) {
        const unsigned lane = bounces[pack.bounce + i].lane;
        const Lane<N> at{pack, lane};
        std::int64_t speed[3];
        at.speeds(bodies, speed);
        for (int k = 0; k < pack.point_count; ++k)
            found[k][lane] = static_cast<std::int32_t>(at.at_point(k, speed));
    }
    keep_approach(pack, bounces, found);
}

template <unsigned N>
void note_bounce(ContactPack<N>& pack, Bounce* bounces, std::int32_t speed_min,
                 const std::int32_t (&speed_before)[4][N], const std::int32_t (&speed_after)[4][N],
                 const std::int32_t (&impulse_before)[4][N]) {
    for (std::uint32_t i = pack.bounce_count; i-- > 0;) {
        Bounce& bounce = bounces[pack.bounce + i];
        for (int k = 0; k < pack.point_count; ++k) {
            const std::int32_t now = pack.points[k].impulse[bounce.lane];
            bounce.impulse_max[k] = std::max(bounce.impulse_max[k], now);
            if (now == impulse_before[k][bounce.lane]) continue; // no work
            add_work(bounce, std::int64_t{now} - impulse_before[k][bounce.lane],
                     std::int64_t{speed_before[k][bounce.lane]} + speed_after[k][bounce.lane]);
        }
        // Behind those that are still looked at; no two of a pack share a body that moves.
        if (is_settled(bounce, pack, speed_min))
            std::swap(bounce, bounces[pack.bounce + --pack.bounce_count]);
    }
}

namespace {

/// The points of a contact that bounce, and what is given to them. Work is twice that per m_ref, as Bounce::taken.
template <unsigned N> struct Rebound {
    ContactPack<N>& pack;
    unsigned lane;
    std::int64_t speed[3];       ///< level and tilts, with what was given so far
    std::int64_t change[4] = {}; ///< of impulses, in the phase that runs

    static bool has(std::uint32_t points, int k) { return ((points >> k) & 1u) != 0; }
    std::int64_t at_point(int k) const { return Lane<N>{pack, lane}.at_point(k, speed); }

    void add(int k, std::int64_t x) {
        constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
        PointLanes<N>& point = pack.points[k];
        x = std::clamp<std::int64_t>(point.impulse[lane] + x, 0, impulse_limit) - point.impulse[lane];
        point.impulse[lane] += static_cast<std::int32_t>(x);
        change[k] += x;
        const std::int64_t q[3] = {x, shift_right_rounded(point.arm[0][lane] * x, unit_bits),
                                   shift_right_rounded(point.arm[1][lane] * x, unit_bits)};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                speed[i] += shift_right_rounded(pack.response[lower[i][j]][lane] * q[j], response_bits);
    }
    /// Brings the speeds of some points to minus `target`.
    void reach(std::uint32_t points, const std::int64_t (&target)[4]) {
        const int count = pack.point_count;
        // First all points together, at their centre: so the order of its points does not turn a box that lands flat.
        std::int64_t error = 0, common = 0;
        for (int k = 0; k < count; ++k)
            if (has(points, k)) error += at_point(k) + target[k], ++common;
        const std::int64_t level = pack.response[0][lane];
        if (common > 1 && level > 0)
            for (int k = 0; k < count; ++k) // an error of four points is below 2^34, of 25 more bits here
                if (has(points, k))
                    add(k, -(error * (std::int64_t{1} << response_bits) / level) / (common * common));
        for (int round = 0; round < (common > 1 ? 4 : 1); ++round)
            for (int i = 0; i < count; ++i) {
                const int k = round % 2 == 0 ? i : count - 1 - i;
                if (has(points, k))
                    add(k, -shift_right_rounded((at_point(k) + target[k]) * pack.points[k].kappa[lane],
                                                kappa_bits));
            }
    }
    /// The impulses of this phase times speeds: products are below 2^59.
    std::int64_t power(const std::int64_t (&at)[3]) const {
        std::int64_t sum = 0;
        for (int k = 0; k < pack.point_count; ++k)
            if (change[k] != 0) sum += change[k] * Lane<N>{pack, lane}.at_point(k, at);
        return sum;
    }
};

/// The largest part, Unit, of impulses that does no more work than `most`. All of them times the speeds they meet are `before`, and times
/// those they leave `after`.
std::int64_t part_within(std::int64_t before, std::int64_t after, std::int64_t most) {
    constexpr std::int64_t one = std::int64_t{1} << unit_bits;
    const auto size = [](std::int64_t x) { return static_cast<std::uint64_t>(x < 0 ? -x : x); };
    const int drop =
        std::max(static_cast<int>(std::bit_width(size(before) | size(after) | size(most))) - 29, 0);
    const std::int64_t start = before >> drop, change = (after >> drop) - start, limit = most >> drop;
    if (2 * start + change <= limit) return one;
    if (change <= 0) return 0;
    // part^2 change + 2 part start = limit
    const auto root =
        static_cast<std::int64_t>(isqrt(static_cast<std::uint64_t>(start * start + limit * change)));
    return std::clamp<std::int64_t>((root - start) * one / change, 0, one);
}

/// What the points of a contact that bounce should part at, and which do.
template <unsigned N>
std::uint32_t find_targets(const Bounce& bounce, const ContactPack<N>& pack, std::int32_t speed_min,
                           std::int64_t (&target)[4]) {
    std::uint32_t points = 0;
    for (int k = 0; k < pack.point_count; ++k) {
        target[k] = 0;
        if (bounce.approach[k] > -speed_min || bounce.impulse_max[k] == 0 ||
            pack.points[k].kappa[bounce.lane] == 0)
            continue;
        target[k] = shift_right_rounded(std::int64_t{bounce.approach[k]} * bounce.restitution, unit_bits);
        points |= 1u << k;
    }
    return points;
}

/// First what still comes in is stopped: the next substep would have done that. Then the points part, at most with what they took.
/// False: none of them bounces. `given`: to the impulses of points.
template <unsigned N>
bool rebound(const Bounce& bounce, ContactPack<N>& pack, std::int32_t speed_min, const SolverBody* bodies,
             std::int64_t (&given)[4]) {
    std::int64_t target[4];
    const std::uint32_t points = find_targets(bounce, pack, speed_min, target);
    if (points == 0) return false;
    const unsigned lane = bounce.lane;
    Rebound<N> stop{pack, lane, {}};
    Lane<N>{pack, lane}.speeds(bodies, stop.speed);
    std::int64_t start[3];
    std::copy_n(stop.speed, 3, start);
    std::uint32_t closing = 0;
    for (int k = 0; k < pack.point_count; ++k)
        if (stop.has(points, k) && stop.at_point(k) < 0) closing |= 1u << k;
    if (closing != 0) stop.reach(closing, {0, 0, 0, 0});
    const std::int64_t stopped = -(stop.power(start) + stop.power(stop.speed));
    const std::int64_t taken = std::max<std::int64_t>(add_saturated(bounce.taken, stopped), 0);

    Rebound<N> part{pack, lane, {}};
    std::copy_n(stop.speed, 3, part.speed);
    part.reach(points, target);
    const std::int64_t most = product_rounded(product_rounded(taken, bounce.restitution, unit_bits),
                                              bounce.restitution, unit_bits),
                       share = part_within(part.power(stop.speed), part.power(part.speed), most);
    for (int k = 0; k < pack.point_count; ++k) {
        const std::int64_t kept = part.change[k] * share / (std::int64_t{1} << unit_bits);
        pack.points[k].impulse[lane] += static_cast<std::int32_t>(kept - part.change[k]);
        given[k] = stop.change[k] + kept;
    }
    return true;
}

/// Friction of these impulses, against the sliding that is left: at most as much as ends it, in the direction that would.
template <unsigned N>
void give_friction(const ContactPack<N>& pack, unsigned lane, const std::int64_t (&given)[4],
                   SolverBodies& bodies) {
    constexpr std::int64_t one = std::int64_t{1} << unit_bits, speed_limit = std::int64_t{1} << 28;
    constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
    std::int64_t pressing = 0, reach = 0;
    for (int k = 0; k < pack.point_count; ++k) {
        pressing += given[k];
        reach += shift_right_rounded(given[k] * pack.points[k].reach[lane], unit_bits);
    }
    const auto limit_of = [&](std::int64_t x) {
        return std::clamp<std::int64_t>(shift_right_rounded(x * pack.friction[lane], row_bits), 0,
                                        speed_limit);
    };
    const std::int64_t limit = limit_of(pressing), twist_limit = limit_of(reach);
    if (limit == 0) return;
    const Lane<N> at{pack, lane};
    std::int64_t speed[3], q[3] = {};
    at.slides(bodies.body.data(), speed);
    for (int r = 0; r < 3; ++r)
        speed[r] = std::clamp(speed[r] + (r < 2 ? pack.surface[r][lane] : 0), -speed_limit, speed_limit);
    const int rows = pack.several[lane] != 0 ? 3 : 2;
    for (int r = 0; r < rows; ++r) {
        std::int64_t sum = 0;
        for (int i = 0; i < rows; ++i) sum += pack.slide_inverse[lower[r][i]][lane] * speed[i];
        q[r] = std::clamp(-shift_right_rounded(sum, inverse_bits), -speed_limit, speed_limit);
    }
    const auto size = static_cast<std::int64_t>(isqrt(static_cast<std::uint64_t>(q[0] * q[0] + q[1] * q[1])));
    const std::int64_t twist = q[2] < 0 ? -q[2] : q[2];
    const std::int64_t part = std::min({one, size < limit ? one : limit * one / (size + 1),
                                        twist <= twist_limit ? one : twist_limit * one / twist});
    for (std::int64_t& x : q) x = x * part / one;
    at.push_slides(bodies, q);
}

} // namespace

template <unsigned N>
void give_back(std::span<const std::uint32_t> lanes, std::span<const Bounce> bounces,
               std::span<ContactPack<N>> packs, std::int32_t speed_min, SolverBodies& bodies) {
    for (const std::uint32_t at : lanes) {
        ContactPack<N>& pack = packs[at / N];
        // The entries of a pack follow one another; note_bounce() changes their order.
        const Bounce& bounce = *std::ranges::find(bounces.subspan(pack.bounce), at % N, &Bounce::lane);
        std::int64_t given[4];
        if (!rebound(bounce, pack, speed_min, bodies.body.data(), given)) continue;
        std::int64_t sum[3] = {};
        for (int k = 0; k < pack.point_count; ++k) {
            sum[0] += given[k];
            for (int i = 0; i < 2; ++i)
                sum[1 + i] += shift_right_rounded(pack.points[k].arm[i][bounce.lane] * given[k], unit_bits);
        }
        Lane<N>{pack, bounce.lane}.push_normals(bodies, sum);
        give_friction(pack, bounce.lane, given, bodies);
    }
}

template <unsigned N>
void solve_rolling(std::span<Rolling> rolling, std::span<const ContactPack<N>> packs, SolverBodies& bodies,
                   bool warm_start) {
    for (Rolling& rows : rolling) {
        const ContactPack<N>& pack = packs[rows.pack];
        SolverBody &a = bodies.body[pack.body_a[rows.lane]], &b = bodies.body[pack.body_b[rows.lane]];
        std::int64_t now[3], pressing = 0;
        for (int k = 0; k < pack.point_count; ++k) pressing += pack.points[k].impulse[rows.lane];
        for (int r = 0; r < 3; ++r) {
            std::int64_t speed = 0;
            for (int i = 0; i < 3; ++i)
                add_product(speed, rows.xa[r][i], speed_part(a.u[i])),
                    add_product(speed, rows.xb[r][i], speed_part(b.u[i]));
            now[r] = rows.impulse[r];
            if (!warm_start)
                now[r] = std::clamp<std::int64_t>(
                    now[r] - shift_right_rounded(saturate_to_int32(shift_right_rounded(speed, row_bits)) *
                                                     std::int64_t{rows.kappa[r]},
                                                 kappa_bits),
                    -impulse_limit, impulse_limit);
        }
        if (!warm_start) {
            const std::int64_t limit =
                std::min<std::int64_t>(shift_right_rounded(pressing * rows.bound, row_bits), impulse_limit);
            const std::int64_t square = now[0] * now[0] + now[1] * now[1] + now[2] * now[2];
            if (square > limit * limit) {
                const std::int64_t size = std::int64_t{isqrt(static_cast<std::uint64_t>(square))} + 1;
                for (std::int64_t& x : now) x = x * limit / size;
            }
        }
        for (int r = 0; r < 3; ++r) {
            const std::int64_t change = warm_start ? now[r] : now[r] - rows.impulse[r];
            rows.impulse[r] = static_cast<std::int32_t>(now[r]);
            const std::int64_t da = shift_right_rounded(change * pack.share_a[rows.lane], unit_bits),
                               db = shift_right_rounded(change * pack.share_b[rows.lane], unit_bits);
            for (int i = 0; i < 3; ++i)
                add_product(a.u[i], rows.xa[r][i], da), add_product(b.u[i], rows.xb[r][i], db);
        }
    }
}

/// Whether a point took an impact of more than 1 m/s. Smaller ones are not kept: a hand that stands on its fingers would shake for ever.
template <unsigned N> bool is_hard(const ContactPack<N>& pack, unsigned lane) {
    constexpr std::int32_t hard = 1 << speed_bits;
    for (int k = 0; k < pack.point_count; ++k)
        if (pack.points[k].impact[lane] > hard) return true;
    return false;
}

/// The impulses that stopped bodies in the last substep are not given to them again in this one. They would have to be taken back, and for a
/// body between two others one pass does that only in part: elastic balls would gain energy. A body that joints hold and that does not
/// bounce keeps these impulses: one pass does not stop a foot that a whole body pushes down.
template <unsigned N> void forget_impacts(ContactPack<N>& pack, WarmStart* warm) {
    constexpr std::int64_t one = 1;
    for (unsigned lane = 0; lane < N; ++lane) {
        if (((pack.keeps >> lane) & 1u) && is_hard<N>(pack, lane)) {
            for (PointLanes<N>& point : pack.points) point.impact[lane] = 0;
            continue;
        }
        std::int64_t taken[3] = {}, before = 0, after = 0;
        for (int k = 0; k < pack.point_count; ++k) {
            PointLanes<N>& point = pack.points[k];
            const std::int64_t impact = std::clamp(point.impact[lane], 0, point.impulse[lane]);
            before += point.impulse[lane];
            point.impulse[lane] -= static_cast<std::int32_t>(impact);
            after += point.impulse[lane];
            point.impact[lane] = 0;
            taken[0] -= impact;
            taken[1] -= shift_right_rounded(point.arm[0][lane] * impact, unit_bits);
            taken[2] -= shift_right_rounded(point.arm[1][lane] * impact, unit_bits);
        }
        if (taken[0] == 0) continue;
        std::int64_t slide[3];
        for (int r = 0; r < 3; ++r) { // friction as the normal impulses
            const std::int64_t less = before == 0 ? 0 : pack.slide[r][lane] * after / std::max(before, one);
            slide[r] = less - pack.slide[r][lane];
            pack.slide[r][lane] = static_cast<std::int32_t>(less);
        }
        const auto take_back = [&](WarmStart& to, std::int64_t share, std::int64_t sign, const auto& normal,
                                   const auto& across) {
            for (int r = 0; r < 3; ++r) {
                const std::int64_t n = shift_right_rounded(taken[r] * share, unit_bits),
                                   t = shift_right_rounded(slide[r] * share, unit_bits);
                for (int i = 0; i < 3; ++i) {
                    if (r == 0) add_modulo(to.v[i], sign * pack.d[0][i][lane] * n);
                    if (r < 2) add_modulo(to.v[i], sign * pack.d[r + 1][i][lane] * t);
                    add_modulo(to.u[i], normal[r][i][lane] * n);
                    add_modulo(to.u[i], across[r][i][lane] * t);
                }
            }
        };
        if ((pack.movable_a >> lane) & 1u)
            take_back(warm[pack.body_a[lane]], pack.share_a[lane], -1, pack.normal_a, pack.slide_a);
        if ((pack.movable_b >> lane) & 1u)
            take_back(warm[pack.body_b[lane]], pack.share_b[lane], 1, pack.normal_b, pack.slide_b);
    }
    pack.impacts = 0;
}

template void measure_approach(const ContactPack<1>&, Bounce*, const SolverBody*);
template void keep_approach(const ContactPack<1>&, Bounce*, const std::int32_t (&)[4][1]);
template void note_warm_start(std::span<const ContactPack<1>>, Bounce*, const WarmStart*,
                              const SolverBodies&);
template void give_back(std::span<const std::uint32_t>, std::span<const Bounce>, std::span<ContactPack<1>>,
                        std::int32_t, SolverBodies&);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<1>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<1>&, WarmStart*);
template void note_bounce(ContactPack<1>&, Bounce*, std::int32_t, const std::int32_t (&)[4][1],
                          const std::int32_t (&)[4][1], const std::int32_t (&)[4][1]);
template void measure_approach(const ContactPack<2>&, Bounce*, const SolverBody*);
template void keep_approach(const ContactPack<2>&, Bounce*, const std::int32_t (&)[4][2]);
template void note_warm_start(std::span<const ContactPack<2>>, Bounce*, const WarmStart*,
                              const SolverBodies&);
template void give_back(std::span<const std::uint32_t>, std::span<const Bounce>, std::span<ContactPack<2>>,
                        std::int32_t, SolverBodies&);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<2>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<2>&, WarmStart*);
template void note_bounce(ContactPack<2>&, Bounce*, std::int32_t, const std::int32_t (&)[4][2],
                          const std::int32_t (&)[4][2], const std::int32_t (&)[4][2]);
template void measure_approach(const ContactPack<4>&, Bounce*, const SolverBody*);
template void keep_approach(const ContactPack<4>&, Bounce*, const std::int32_t (&)[4][4]);
template void note_warm_start(std::span<const ContactPack<4>>, Bounce*, const WarmStart*,
                              const SolverBodies&);
template void give_back(std::span<const std::uint32_t>, std::span<const Bounce>, std::span<ContactPack<4>>,
                        std::int32_t, SolverBodies&);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<4>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<4>&, WarmStart*);
template void note_bounce(ContactPack<4>&, Bounce*, std::int32_t, const std::int32_t (&)[4][4],
                          const std::int32_t (&)[4][4], const std::int32_t (&)[4][4]);
template void measure_approach(const ContactPack<8>&, Bounce*, const SolverBody*);
template void keep_approach(const ContactPack<8>&, Bounce*, const std::int32_t (&)[4][8]);
template void note_warm_start(std::span<const ContactPack<8>>, Bounce*, const WarmStart*,
                              const SolverBodies&);
template void give_back(std::span<const std::uint32_t>, std::span<const Bounce>, std::span<ContactPack<8>>,
                        std::int32_t, SolverBodies&);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<8>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<8>&, WarmStart*);
template void note_bounce(ContactPack<8>&, Bounce*, std::int32_t, const std::int32_t (&)[4][8],
                          const std::int32_t (&)[4][8], const std::int32_t (&)[4][8]);

} // namespace lockstone::solve
