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
/// Modulo 2^64, as lanes add: so a pack gives the same bits whether its lanes are computed one by one or at once.
void add_modulo(std::int64_t& sum, std::int64_t x) {
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) + static_cast<std::uint64_t>(x));
}
void sub_modulo(std::int64_t& sum, std::int64_t x) {
    sum = static_cast<std::int64_t>(static_cast<std::uint64_t>(sum) - static_cast<std::uint64_t>(x));
}
/// Adds a component of a row [30 bits] times an impulse or a speed [31 bits]. It saturates: many contacts of one body,
/// each within its limits, may drive its velocity beyond 63 bits.
void add_product(std::int64_t& sum, std::int64_t row, std::int64_t x) { sum = add_saturated(sum, row * x); }

/// One lane of a pack: the two bodies and the rows between them.
template <unsigned N> struct Lane {
    const ContactPack<N>& pack;
    unsigned lane;

    /// Level and tilts of the normal speed; `bodies` has velocities, or other data in their format.
    template <class Body> void speeds(const Body* bodies, std::int64_t (&out)[3]) const {
        speeds_of(bodies[pack.body_a[lane]], bodies[pack.body_b[lane]], out);
    }
    template <class Body> void speeds_of(const Body& a, const Body& b, std::int64_t (&out)[3]) const {
        speeds_along(a, b, pack.normal_a, pack.normal_b, 0, 1, out);
    }
    /// Speeds along the two tangents and about the normal (the twist).
    void slides(const SolverBody* bodies, std::int64_t (&out)[3]) const {
        speeds_along(bodies[pack.body_a[lane]], bodies[pack.body_b[lane]], pack.slide_a, pack.slide_b, 1, 2,
                     out);
    }
    /// Speeds along three rows. Row r has a linear part along direction first + r where r < lines.
    template <class Body>
    void speeds_along(const Body& a, const Body& b, const std::int32_t (&rows_a)[3][3][N],
                      const std::int32_t (&rows_b)[3][3][N], int first, int lines,
                      std::int64_t (&out)[3]) const {
        std::int64_t move[3], turn_a[3], turn_b[3], any = 0;
        for (int i = 0; i < 3; ++i) {
            move[i] = speed_part(sub_saturated(b.v[i], a.v[i]));
            turn_a[i] = speed_part(a.u[i]), turn_b[i] = speed_part(b.u[i]);
            for (const std::int64_t x : {move[i], turn_a[i], turn_b[i]}) any |= x ^ (x >> 63);
        }
        // Then the sum of all nine products with 30 bits is below 2^63, so it needs no saturation.
        const bool is_slow = any >> 29 == 0;
        for (int r = 0; r < 3; ++r) {
            std::int64_t line = 0, turning = 0;
            for (int i = 0; r < lines && i < 3; ++i) line += pack.d[first + r][i][lane] * move[i];
            for (int i = 0; i < 3; ++i) {
                const std::int64_t of_a = rows_a[r][i][lane] * turn_a[i],
                                   of_b = rows_b[r][i][lane] * turn_b[i];
                turning = is_slow ? turning + of_a + of_b : add_saturated(add_saturated(turning, of_a), of_b);
            }
            // Beyond 4096 m/s the speed saturates.
            out[r] = saturate_to_int32(
                shift_right_rounded(is_slow ? turning + line : add_saturated(turning, line), row_bits));
        }
    }
    /// The value at point k of a quantity with level and two tilts, x. Impulses may have driven x beyond 32 bits.
    std::int64_t at_point(int k, const std::int64_t (&x)[3]) const {
        const PointLanes<N>& point = pack.points[k];
        if ((((x[1] ^ (x[1] >> 63)) | (x[2] ^ (x[2] >> 63))) >> 31) == 0) // two products below 2^61
            return saturate_to_int32(add_saturated(
                x[0], shift_right_rounded(point.arm[0][lane] * x[1] + point.arm[1][lane] * x[2], unit_bits)));
        // The arms, up to 2^30, times impulses of tilts beyond 2^33 need 128 bits.
        const Wide tilt = Wide::product(point.arm[0][lane], x[1]) + Wide::product(point.arm[1][lane], x[2]);
        return saturate_to_int32(add_saturated(x[0], narrow_rounded(tilt, unit_bits)));
    }
    /// Adds impulse p along one row to the velocities of the bodies that move. `xa`, `xb`: angular parts of the row;
    /// `line`: its direction, null if the row has no linear part.
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

/// The impulses that a contact gives to its points in one impact. Work is measured as twice the energy divided by
/// m_ref.
template <unsigned N> struct Impact {
    const ContactPack<N>& pack;
    unsigned lane;
    std::int64_t speed[3];      ///< level and tilts, including the impulses so far
    std::int64_t given[4] = {}; ///< impulses of points, never negative

    static bool has(std::uint32_t points, int k) { return ((points >> k) & 1u) != 0; }
    std::int64_t at_point(int k) const { return Lane<N>{pack, lane}.at_point(k, speed); }

    void add(int k, std::int64_t x) {
        constexpr int lower[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};
        const PointLanes<N>& point = pack.points[k];
        // enough to stop a point and to send it back
        constexpr std::int64_t limit = 2 * std::int64_t{impulse_limit};
        x = std::clamp<std::int64_t>(given[k] + x, 0, limit) - given[k];
        given[k] += x;
        const std::int64_t q[3] = {x, shift_right_rounded(point.arm[0][lane] * x, unit_bits),
                                   shift_right_rounded(point.arm[1][lane] * x, unit_bits)};
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                speed[i] += shift_right_rounded(pack.response[lower[i][j]][lane] * q[j], response_bits);
    }
    /// Changes the impulses of the points in the bit set `points` so that their speeds approach `target`.
    void reach(std::uint32_t points, const std::int64_t (&target)[4]) {
        const int count = pack.point_count;
        // First all points together, at their centre, so that the order of the points does not turn a box that lands
        // flat.
        std::int64_t error = 0, common = 0;
        for (int k = 0; k < count; ++k)
            if (has(points, k)) error += at_point(k) - target[k], ++common;
        const std::int64_t level = pack.response[0][lane];
        if (common > 1 && level > 0)
            // the error of four points is below 2^34, and the product has 25 more bits
            for (int k = 0; k < count; ++k)
                if (has(points, k))
                    add(k, -(error * (std::int64_t{1} << response_bits) / level) / (common * common));
        for (int round = 0; round < (common > 1 ? 4 : 1); ++round)
            for (int i = 0; i < count; ++i) {
                const int k = round % 2 == 0 ? i : count - 1 - i;
                if (has(points, k))
                    add(k, -shift_right_rounded((at_point(k) - target[k]) * pack.points[k].kappa[lane],
                                                kappa_bits));
            }
    }
};

/// The largest fraction, Unit, of impulses that adds no energy. `before`: the sum of the full impulses times the speeds
/// before them; `after`: the same with the speeds after them.
std::int64_t part_without_gain(std::int64_t before, std::int64_t after) {
    constexpr std::int64_t one = std::int64_t{1} << unit_bits;
    const auto size = [](std::int64_t x) { return static_cast<std::uint64_t>(x < 0 ? -x : x); };
    const int drop = std::max(static_cast<int>(std::bit_width(size(before) | size(after))) - 30, 0);
    const std::int64_t start = before >> drop, change = (after >> drop) - start;
    if (2 * start + change <= 0) return one;
    // part^2 change + 2 part start = 0
    return change <= 0 ? 0 : std::clamp<std::int64_t>(-2 * start * one / change, 0, one);
}

/// The speed that closes the gap of a point within a substep.
template <unsigned N>
std::int64_t closing_limit(const ContactPack<N>& pack, int k, unsigned lane, const PassSettings& s) {
    const std::int64_t gap = std::clamp(pack.points[k].gap[lane], 0, s.gap_max);
    return shift_right_rounded(gap * s.substeps_per_second, gap_bits - speed_bits);
}

/// The speed at which a point parts at the end of the substep. It came in at `arrived`, and forces add `f` in this
/// substep. It reaches the surface after the fraction `time` [Unit] of the substep; `gap_speed` is its gap divided by
/// the substep. Semi-implicit integration has f for acceleration times substep. Twice the energy of the relative motion
/// at the surface is V^2 = arrived (arrived + f) + 2 f gap_speed before the impact. After the impact and the rest of
/// the substep, u^2 + f (1 - 2 time) u has to be e^2 V^2: then the height of a ball does not depend on where in a
/// substep it hits.
std::int64_t parting_speed(std::int64_t arrived, std::int64_t f, std::int64_t gap_speed, std::int64_t time,
                           std::int32_t restitution) {
    constexpr std::int64_t one = std::int64_t{1} << unit_bits;
    f = std::clamp(f, -arrived / 2, arrived / 2);
    const std::int64_t surface = arrived * (arrived + f) + 2 * f * gap_speed; // below 2^60
    const auto less = [&](std::int64_t x) { return product_rounded(x, restitution, unit_bits); };
    const std::int64_t half = shift_right_rounded(f * (one - 2 * time), unit_bits + 1);
    const std::int64_t square = std::max<std::int64_t>(less(less(surface)), 0) + half * half;
    return std::max<std::int64_t>(static_cast<std::int64_t>(isqrt(static_cast<std::uint64_t>(square))) - half,
                                  0);
}

} // namespace

template <unsigned N> void find_hits(ContactPack<N>& pack, const SolverBody* bodies, const PassSettings& s) {
    pack.struck = 0;
    for (unsigned lane = 0; lane < N; ++lane) {
        if (pack.bounces[lane] == 0) continue;
        const Lane<N> at{pack, lane};
        std::int64_t speed[3];
        at.speeds(bodies, speed);
        for (int k = 0; k < pack.point_count; ++k) {
            const std::int64_t closing = -at.at_point(k, speed);
            if (closing > s.bounce_speed_min && closing >= closing_limit(pack, k, lane, s) &&
                pack.points[k].kappa[lane] != 0)
                pack.struck |= 1u << lane;
        }
    }
}

namespace {

/// Applies the friction of these normal impulses against the remaining sliding: at most the impulse that ends the
/// sliding, in the direction of that impulse.
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

/// The change of a body's velocity by forces in a substep.
struct ForceChange {
    std::int64_t v[3], u[3];
};
ForceChange change_by_forces(const SolverBodies& bodies, std::uint32_t body) {
    ForceChange out{};
    if (body >= bodies.still() || !bodies.step[body].movable) return out;
    const BodyPush& push = (bodies.plain[body] & plain_falls) != 0 ? bodies.fall : bodies.push[body];
    for (int i = 0; i < 3; ++i) out.v[i] = push.dv[i] & bodies.body[body].keep[i], out.u[i] = push.du[i];
    return out;
}

/// A contact whose points hit each other in this substep.
template <unsigned N> class Rebound {
    Bounce& bounce;
    const ContactPack<N>& pack;
    const PassSettings& s;
    Lane<N> at;
    std::int64_t target[4] = {};  ///< speeds of points after the impact
    std::int64_t allowed[4] = {}; ///< speeds of points above which they would gain energy
    std::uint32_t points = 0;     ///< bit set of the points that hit

    /// The fraction [Unit] of the substep after which a point closes the gap `gap_speed` times the substep; more than 1
    /// if it does not.
    static std::int64_t time_of(std::int64_t gap_speed, std::int64_t closing) {
        constexpr std::int64_t one = std::int64_t{1} << unit_bits;
        if (gap_speed <= 0) return 0;
        return gap_speed > closing ? one + 1 : gap_speed * one / closing;
    }

  public:
    std::int64_t time = std::int64_t{1} << unit_bits; ///< of the impact

    Rebound(Bounce& of, const ContactPack<N>& in, const PassSettings& settings)
        : bounce(of), pack(in), s(settings), at{in, of.lane} {}

    /// Finds the points that hit, and the speeds at which they part. Returns false if no point hits.
    bool find_targets(const SolverBodies& bodies, const WarmStart* arrival, const Struck* struck,
                      std::int64_t (&before)[3]) {
        constexpr std::int64_t one = std::int64_t{1} << unit_bits, most = std::int64_t{1} << 28;
        std::int64_t arrived[3], ahead[3], forces[3];
        at.speeds(bodies.body.data(), before);
        at.speeds(arrival, arrived);
        at.speeds(struck, ahead);
        at.speeds_of(change_by_forces(bodies, pack.body_a[bounce.lane]),
                     change_by_forces(bodies, pack.body_b[bounce.lane]), forces);
        const std::int64_t since =
            std::max(struck[pack.body_a[bounce.lane]].time, struck[pack.body_b[bounce.lane]].time);
        for (int k = 0; k < pack.point_count; ++k) {
            // The speed that a warm start adds is no impact: passes take it out again.
            const std::int64_t f = std::clamp(-at.at_point(k, forces), -most, most),
                               came_in =
                                   std::min({-at.at_point(k, arrived), -at.at_point(k, before) - f, most}),
                               closing = std::min(came_in + f, most);
            if (std::min(closing, came_in) <= s.bounce_speed_min || pack.points[k].kappa[bounce.lane] == 0)
                continue;
            const std::int64_t gap = std::clamp(pack.points[k].gap[bounce.lane], -s.gap_max, s.gap_max);
            const std::int64_t gap_speed = std::clamp<std::int64_t>(
                shift_right_rounded(gap * s.substeps_per_second, gap_bits - speed_bits) +
                    at.at_point(k, ahead),
                0, most);
            const std::int64_t hits = std::max(time_of(gap_speed, closing), since);
            if (hits > one) continue;
            target[k] = parting_speed(came_in, f, gap_speed, hits, bounce.restitution);
            allowed[k] = std::max(closing, target[k]);
            points |= 1u << k;
            time = std::min(time, hits);
        }
        return points != 0;
    }
    void give(SolverBodies& bodies, const std::int64_t (&before)[3]) {
        Impact<N> impact{pack, bounce.lane, {before[0], before[1], before[2]}};
        impact.reach(points, target);
        std::int64_t most = 0, done = 0;
        for (int k = 0; k < pack.point_count; ++k)
            most -= impact.given[k] * allowed[k], done += impact.given[k] * impact.at_point(k);
        const std::int64_t part = part_without_gain(most, done);
        std::int64_t sum[3] = {};
        for (int k = 0; k < pack.point_count; ++k) {
            std::int64_t& given = impact.given[k];
            given = given * part / (std::int64_t{1} << unit_bits);
            bounce.impulse[k] =
                static_cast<std::int32_t>(std::min<std::int64_t>(bounce.impulse[k] + given, impulse_limit));
            sum[0] += given;
            for (int i = 0; i < 2; ++i)
                sum[1 + i] += shift_right_rounded(pack.points[k].arm[i][bounce.lane] * given, unit_bits);
        }
        at.push_normals(bodies, sum);
        give_friction(pack, bounce.lane, impact.given, bodies);
    }
};

/// Notes the impact of a body. It keeps its old velocity until the impact; later impacts start from its new velocity.
void note_impact(const SolverBody& was, const SolverBody& now, std::int64_t time, std::uint32_t round,
                 Struck& struck, WarmStart& arrival) {
    struck.round = round, struck.time = time;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t v = sub_saturated(now.v[i], was.v[i]), u = sub_saturated(now.u[i], was.u[i]);
        add_modulo(arrival.v[i], v), add_modulo(arrival.u[i], u);
        sub_modulo(struck.v[i], product_rounded(v, time, unit_bits));
        sub_modulo(struck.u[i], product_rounded(u, time, unit_bits));
    }
}

} // namespace

template <unsigned N>
void rebound(std::span<Bounce> bounces, std::span<ContactPack<N>> packs, const PassSettings& settings,
             SolverBodies& bodies, WarmStart* arrival, std::span<Struck> struck) {
    constexpr std::uint32_t rounds_max = 32;
    bool any = true;
    for (std::uint32_t round = 1; any && round <= rounds_max; ++round) {
        any = false;
        const auto changed = [&](std::uint32_t body) {
            return struck[body].round != 0 && struck[body].round + 1 >= round;
        };
        for (Bounce& bounce : bounces) {
            ContactPack<N>& pack = packs[bounce.pack];
            const std::uint32_t a = pack.body_a[bounce.lane], b = pack.body_b[bounce.lane];
            const bool is_found = round == 1 && ((pack.struck >> bounce.lane) & 1u) != 0;
            if (!is_found && !changed(a) && !changed(b)) continue;
            Rebound<N> impact(bounce, pack, settings);
            std::int64_t before[3];
            if (!impact.find_targets(bodies, arrival, struck.data(), before)) continue;
            const SolverBody was[2] = {bodies.body[a], bodies.body[b]};
            impact.give(bodies, before);
            any = true;
            pack.hit |= 1u << bounce.lane;
            if ((pack.movable_a >> bounce.lane) & 1u)
                note_impact(was[0], bodies.body[a], impact.time, round, struck[a], arrival[a]);
            if ((pack.movable_b >> bounce.lane) & 1u)
                note_impact(was[1], bodies.body[b], impact.time, round, struck[b], arrival[b]);
        }
    }
}

void begin_ways(std::span<const Struck> struck, SolverBodies& bodies) {
    for (std::size_t i = 0; i < struck.size(); ++i) {
        if (struck[i].round == 0) continue;
        bodies.plain[i] = static_cast<std::uint8_t>((bodies.plain[i] & ~plain_end) | plain_struck);
        for (int axis = 0; axis < 3; ++axis) {
            add_modulo(bodies.body[i].v[axis], struck[i].v[axis]);
            add_modulo(bodies.body[i].u[axis], struck[i].u[axis]);
        }
    }
}

void end_ways(std::span<const Struck> struck, SolverBodies& bodies) {
    for (std::size_t i = 0; i < struck.size(); ++i) {
        if (struck[i].round == 0) continue;
        for (int axis = 0; axis < 3; ++axis) {
            sub_modulo(bodies.body[i].v[axis], struck[i].v[axis]);
            sub_modulo(bodies.body[i].u[axis], struck[i].u[axis]);
        }
    }
}

void list_impacts(std::span<const Bounce> bounces, std::span<const std::uint32_t> contact_of_lane,
                  std::uint32_t lanes, std::vector<ContactImpact>& out) {
    out.clear();
    for (const Bounce& bounce : bounces) {
        if (std::ranges::all_of(bounce.impulse, [](std::int32_t p) { return p == 0; })) continue;
        ContactImpact& impact = out.emplace_back();
        impact.contact = contact_of_lane[bounce.pack * lanes + bounce.lane];
        for (std::size_t k = 0; k < 4; ++k) impact.impulse[k] = Speed::from_raw(bounce.impulse[k]);
    }
    std::ranges::sort(out, {}, &ContactImpact::contact);
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

/// True if a point took an impact of more than 1 m/s. Smaller impacts are not kept: a hand that stands on its fingers
/// would shake for ever.
template <unsigned N> bool is_hard(const ContactPack<N>& pack, unsigned lane) {
    constexpr std::int32_t hard = 1 << speed_bits;
    for (int k = 0; k < pack.point_count; ++k)
        if (pack.points[k].impact[lane] > hard) return true;
    return false;
}

/// The impulses that stopped bodies in the last substep are not part of the next warm start. Passes would have to take
/// them back, and for a body between two others one pass does that only in part: elastic balls would gain energy. A
/// contact without restitution keeps a hard impact where joints hold one of its bodies: one pass does not stop a foot
/// that a whole body pushes down.
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
        for (int r = 0; r < 3; ++r) { // friction shrinks in the ratio of the normal impulses
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

template void find_hits(ContactPack<1>&, const SolverBody*, const PassSettings&);
template void rebound(std::span<Bounce>, std::span<ContactPack<1>>, const PassSettings&, SolverBodies&,
                      WarmStart*, std::span<Struck>);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<1>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<1>&, WarmStart*);
template void find_hits(ContactPack<2>&, const SolverBody*, const PassSettings&);
template void rebound(std::span<Bounce>, std::span<ContactPack<2>>, const PassSettings&, SolverBodies&,
                      WarmStart*, std::span<Struck>);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<2>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<2>&, WarmStart*);
template void find_hits(ContactPack<4>&, const SolverBody*, const PassSettings&);
template void rebound(std::span<Bounce>, std::span<ContactPack<4>>, const PassSettings&, SolverBodies&,
                      WarmStart*, std::span<Struck>);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<4>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<4>&, WarmStart*);
template void find_hits(ContactPack<8>&, const SolverBody*, const PassSettings&);
template void rebound(std::span<Bounce>, std::span<ContactPack<8>>, const PassSettings&, SolverBodies&,
                      WarmStart*, std::span<Struck>);
template void solve_rolling(std::span<Rolling>, std::span<const ContactPack<8>>, SolverBodies&, bool);
template void forget_impacts(ContactPack<8>&, WarmStart*);

} // namespace lockstone::solve
