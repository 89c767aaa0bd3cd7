// Plays a case and measures the values that the laws bound.
#include "law/zoo/case.h"
#include "law/zoo/draw.h"

#include <algorithm>

namespace lockstone::zoo {

namespace {

constexpr double gravity = 9.81;
constexpr int held_most = 4;           ///< [ticks]
constexpr double speed_step = 0x1p-19; ///< of a speed's format [m/s]

/// An object at one time.
struct Sight {
    std::vector<D3> points;
    D3 centre, core, velocity, momentum, spin; ///< momentum and spin (about the origin) over mass
    double lowest, highest, fastest, energy, kinetic;
};

class Player {
  public:
    Player(const Case& its_case, Wrong its_wrong)
        : c(its_case), wrong(its_wrong), p(stage(wrong_case(its_case, its_wrong))) {
        for (std::size_t i = 0; i < p.bodies.size(); ++i) {
            const SetMass mass = p.world.mass_properties(p.bodies[i]);
            gyration.push_back(to_double3(mass.gyration.value)), principal.push_back(mass.principal.value);
            masses.push_back(to_double(p.world.mass(p.bodies[i])));
        }
        out.parts.resize(p.bodies.size());
    }
    Track run();

  private:
    static Case wrong_case(Case c, Wrong wrong) {
        if (wrong == Wrong::passed) c.def.continuous = 0;
        if (wrong == Wrong::sleepless) c.def.sleeping = 0;
        return c;
    }
    std::vector<Sight> see() const;
    Sight see(std::size_t i) const;
    void note(const std::vector<Sight>& before, const std::vector<Sight>& now, int tick);
    void note_meeting(const std::vector<Sight>& now);
    void note_held(const std::vector<Sight>& before, const std::vector<Sight>& now);
    void note_quiet(const std::vector<Sight>& before, const std::vector<Sight>& now, int tick);
    void do_wrong(int tick);
    void look_at_sleep();
    void note_overlap();
    bool is_all_asleep() const {
        return std::none_of(p.bodies.begin(), p.bodies.end(), [&](BodyId b) { return p.world.is_awake(b); });
    }
    double whole(const std::vector<Sight>& now) const {
        double sum = 0;
        for (std::size_t i = 0; i < now.size(); ++i) sum += masses[i] * now[i].energy;
        return sum;
    }

    const Case& c;
    Wrong wrong;
    Stage p;
    std::vector<D3> gyration;
    std::vector<Quat> principal;
    std::vector<double> masses;
    std::vector<Sight> start;
    std::array<int, 2> held_ticks{};
    Transform stuck_at{};
    int quiet_ticks = 0;
    Track out;
};

/// Semi-implicit Euler with steps of a length h conserves v^2 / 2 + g y - g h v_y / 2 while a body falls, not v^2 / 2 +
/// g y, so the energy is the former. A swept body that is stopped on its way down has the speed of the whole tick, so
/// the height that it did not fall through is subtracted.
Sight Player::see(std::size_t i) const {
    const World& w = p.world;
    const BodyId body = p.bodies[i];
    const Object& o = c.objects[i].object;
    const Transform pose = w.pose(body);
    const Placed placed(pose);
    Sight s;
    s.centre = to_double3(w.center_of_mass(body)), s.velocity = to_double3(w.linear_velocity(body));
    const D3 turning = to_double3(w.angular_velocity(body));
    s.lowest = 1e9, s.highest = -1e9, s.fastest = length(s.velocity);
    for (const D3& corner : o.corners) {
        const D3 at = placed.point(corner);
        s.points.push_back(at);
        s.lowest = std::min(s.lowest, at[1] - o.radius), s.highest = std::max(s.highest, at[1] + o.radius);
        s.fastest = std::max(s.fastest, length(plus(s.velocity, across(turning, minus(at, s.centre)))));
    }
    s.core = o.geometry.kind == ShapeKind::hull ? s.centre : placed.point(o.core);
    for (const auto& [radius, y] : o.discs) {
        const double rim = radius * std::sqrt(std::max(0.0, 1 - placed.y[1] * placed.y[1])),
                     middle = placed.point({0, y, 0})[1];
        s.lowest = std::min(s.lowest, middle - rim - o.radius);
        s.highest = std::max(s.highest, middle + rim + o.radius);
    }
    const Placed axes({Vec3{}, normalized(pose.rotation * principal[i])});
    s.spin = across(s.centre, s.velocity);
    double twice = along(s.velocity, s.velocity);
    int k = 0;
    for (const D3& axis : {axes.x, axes.y, axes.z}) {
        const double inertia =
                         gyration[i][static_cast<std::size_t>(k)] * gyration[i][static_cast<std::size_t>(k)],
                     rate = along(turning, axis);
        twice += inertia * rate * rate;
        s.spin = plus(s.spin, times(inertia * rate, axis));
        ++k;
    }
    s.kinetic = twice / 2;
    const double step = 1.0 / (c.def.tick_rate * c.def.substeps),
                 unfallen = std::max(0.0, -s.velocity[1]) / c.def.tick_rate;
    s.energy = s.kinetic;
    if (c.floor) s.energy += gravity * (s.centre[1] - 0.5 * step * s.velocity[1] - unfallen);
    return s;
}

std::vector<Sight> Player::see() const {
    std::vector<Sight> all;
    for (std::size_t i = 0; i < p.bodies.size(); ++i) all.push_back(see(i));
    return all;
}

void Player::note(const std::vector<Sight>& before, const std::vector<Sight>& now, int tick) {
    double first = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        Part& part = out.parts[i];
        part.centre_least = std::min(part.centre_least, now[i].core[1]);
        part.top_least = std::min(part.top_least, now[i].highest);
        part.quickest = std::max(part.quickest, length(now[i].velocity));
        part.lowest_at_end = now[i].lowest, part.speed_at_end = now[i].fastest;
        first += masses[i] * start[i].energy;
        const double aside = std::hypot(now[i].centre[0], now[i].centre[2]);
        if (c.floor && aside + c.objects[i].object.size > 60) out.left = true;
    }
    out.energy_above_start = std::max(out.energy_above_start, whole(now) - first);
    note_quiet(before, now, tick);
    note_held(before, now);
}

/// Detects objects that have a velocity of 1 m/s or more but do not move so: the motion of a tick may differ from the
/// velocity by half of it only in the tick of an impact and in the next one, whose contacts stop it.
void Player::note_held(const std::vector<Sight>& before, const std::vector<Sight>& now) {
    for (std::size_t i = 0; i < now.size(); ++i) {
        const double speed = length(now[i].velocity);
        const D3 way = times(c.def.tick_rate, minus(now[i].centre, before[i].centre));
        const bool is_held = speed > 1 && length(minus(way, now[i].velocity)) > speed / 2;
        held_ticks[i] = is_held ? held_ticks[i] + 1 : 0;
        if (held_ticks[i] > held_most) out.held_speed = std::max(out.held_speed, speed);
        out.held = std::max(out.held, held_ticks[i]);
    }
}

/// At rest: no point is faster than half of the sleep speed, neither by its velocity nor by its motion.
void Player::note_quiet(const std::vector<Sight>& before, const std::vector<Sight>& now, int tick) {
    const double slow = to_double(c.def.sleep_speed) / 2;
    bool is_quiet = true;
    for (std::size_t i = 0; i < now.size(); ++i) {
        is_quiet = is_quiet && now[i].fastest < slow;
        for (std::size_t k = 0; k < now[i].points.size(); ++k)
            is_quiet =
                is_quiet && length(minus(now[i].points[k], before[i].points[k])) * c.def.tick_rate < slow;
    }
    const bool is_asleep = is_all_asleep();
    quiet_ticks = is_quiet && !is_asleep ? quiet_ticks + 1 : 0;
    out.quiet = std::max(out.quiet, static_cast<double>(quiet_ticks) / c.def.tick_rate);
    if (!is_asleep)
        out.asleep_at = -1;
    else if (out.asleep_at < 0)
        out.asleep_at = static_cast<double>(tick) / c.def.tick_rate;
}

/// Rounding: each pass over a contact rounds the speeds of both bodies by half a step along each axis, for the normal,
/// the friction and the twist; a substep has two passes. Angular momentum: the two points of an impulse move apart by
/// at most the motion of a tick, and the impulse, with its friction, is at most twice the reduced mass times the speed
/// of approach. Free tumbling keeps all but a thousandth. The rounding of speeds acts on arms of the length of the
/// distance of the centres.
void Player::note_meeting(const std::vector<Sight>& now) {
    D3 momentum{}, spin{};
    double mass = 0, speed = 0, whole_spin = 0, inverse = 0, arm = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        momentum = plus(momentum, times(masses[i], minus(now[i].velocity, start[i].velocity)));
        spin = plus(spin, times(masses[i], minus(now[i].spin, start[i].spin)));
        mass += masses[i], inverse += 1 / masses[i], speed += start[i].fastest;
        arm = std::max({arm, length(start[i].centre), length(now[i].centre)});
        whole_spin += masses[i] * std::max(length(start[i].spin), length(now[i].spin));
    }
    const double passes = 2.0 * c.def.substeps * (out.touching + 1);
    out.momentum_off = length(momentum) / mass;
    out.momentum_allowed = std::sqrt(3.0) * speed_step / 2 * 3 * passes;
    out.spin_off = length(spin);
    out.spin_allowed = 2 / inverse * speed * speed / c.def.tick_rate + 0.001 * whole_spin +
                       out.momentum_allowed * mass * arm;
}

void Player::do_wrong(int tick) {
    const BodyId last = p.bodies.back();
    const Vec3 v = p.world.linear_velocity(last), spin = p.world.angular_velocity(last);
    const D3 way = to_double3(v);
    const double speed = length(way);
    if (tick == 10 && wrong == Wrong::pushed)
        (void)p.world.set_velocity(last, speed > 0 ? vec(times((speed + 3) / speed, way)) : vec(3, 0, 0),
                                   spin);
    if (tick == 10 && wrong == Wrong::turned) (void)p.world.set_velocity(last, v, spin + vec(3, 0, 0));
    if (wrong != Wrong::stuck || tick < 10 || tick > 20) return;
    if (tick == 10) stuck_at = p.world.pose(last);
    (void)p.world.set_pose(last, stuck_at);
}

/// Sleeping bodies keep their places, also after they are woken.
void Player::look_at_sleep() {
    if (wrong == Wrong::hung || wrong == Wrong::sunk) {
        for (const BodyId body : p.bodies) {
            Transform pose = p.world.pose(body);
            pose.position.y = pose.position.y + real(wrong == Wrong::hung ? 0.2 : -0.005);
            (void)p.world.set_pose(body, pose);
        }
    } else {
        std::vector<Transform> slept;
        for (const BodyId body : p.bodies) slept.push_back(p.world.pose(body));
        for (int t = 0; t < 3; ++t) p.world.tick();
        for (std::size_t i = 0; i < slept.size(); ++i)
            out.moved_asleep = out.moved_asleep || !(p.world.pose(p.bodies[i]) == slept[i]);
    }
    const std::vector<Sight> from = see();
    for (std::size_t i = 0; i < from.size(); ++i) out.parts[i].lowest_at_end = from[i].lowest;
    for (const BodyId body : p.bodies) (void)p.world.wake_body(body);
    const auto ticks = static_cast<std::uint32_t>(to_double(c.def.sleep_time) * c.def.tick_rate);
    for (std::uint32_t t = 0; t < ticks; ++t) {
        p.world.tick();
        if (t == 0) note_overlap();
        const std::vector<Sight> now = see();
        for (std::size_t i = 0; i < now.size(); ++i)
            for (std::size_t k = 0; k < now[i].points.size(); ++k)
                out.woken_way = std::max(out.woken_way, length(minus(now[i].points[k], from[i].points[k])));
    }
}

void Player::note_overlap() {
    if (p.bodies.size() < 2) return;
    std::vector<ContactPoint> points;
    p.world.contacts(p.bodies[1], points);
    const ShapeId other = p.world.shapes(p.bodies[0])[0];
    for (const ContactPoint& point : points)
        if (point.shape_a == other || point.shape_b == other)
            out.overlap_at_end = std::max(out.overlap_at_end, -to_double(point.separation));
}

Track Player::run() {
    start = see();
    for (std::size_t i = 0; i < start.size(); ++i) // no body has been stopped yet
        start[i].energy += c.floor ? gravity * std::max(0.0, -start[i].velocity[1]) / c.def.tick_rate : 0;
    double highest = 0, fastest = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
        const double size = c.objects[i].object.size;
        out.energy_allowed += masses[i] * gravity * (0.002 + 0.002 * size);
        out.energy_at_start += masses[i] * start[i].kinetic;
        out.parts[i].centre_least = start[i].centre[1], out.parts[i].top_least = start[i].highest;
        highest = std::max(highest, start[i].highest), fastest = std::max(fastest, start[i].fastest);
    }
    // A load of a mass m' sinks a contact of a reduced mass m by m' / m g / (2 pi f)^2. A light body under a heavy one
    // counts as a quarter of it, so m is a fifth of the load; otherwise m is at least half of it.
    const double omega =
        2 * pi * std::min(to_double(c.def.contact_hertz), 3.0 / 16 * c.def.tick_rate * c.def.substeps);
    out.overlap_allowed = 0.001 + (masses.back() > masses[0] ? 5 : 2) * gravity / (omega * omega);
    out.free_speed = std::sqrt(fastest * fastest + (c.floor ? 2 * gravity * highest : 0));
    std::vector<Sight> before = start;
    std::vector<ContactPoint> points;
    for (int tick = 1; tick <= c.ticks && !out.left; ++tick) {
        p.world.tick();
        do_wrong(tick);
        const std::vector<Sight> now = see();
        note(before, now, tick);
        if (!c.floor) {
            p.world.contacts(p.bodies[0], points);
            out.touching += points.empty() ? 0 : 1;
        }
        before = now;
        if (is_all_asleep()) break;
    }
    if (!c.floor) { note_meeting(before); }
    if (c.floor && out.asleep_at >= 0) look_at_sleep();
    out.faults = p.world.faults();
    return out;
}

std::string which(const Case& c, std::size_t i) {
    return c.objects.size() == 1 ? "it" : i == 0 ? "the first" : "the second";
}

} // namespace

Track track(const Case& c, Wrong wrong) { return Player(c, wrong).run(); }

std::string energy_law(const Case& c, const Track& t) {
    const double allowed = c.floor ? t.energy_allowed : 0.005 * t.energy_at_start;
    if (t.energy_above_start <= allowed) return {};
    return in_text("the energy rises by %.4g J, and %.4g J is allowed", t.energy_above_start, allowed);
}

std::string depth_law(const Case& c, const Track& t) {
    if (!c.floor || t.left) return {};
    double flatness = 0;
    for (std::size_t i = 0; i < t.parts.size(); ++i) {
        flatness += c.objects[i].object.flatness;
        if (t.asleep_at < 0 && t.parts[i].speed_at_end > to_double(c.def.sleep_speed)) continue;
        if (t.parts[i].lowest_at_end < -(0.001 + c.objects[i].object.flatness))
            return which(c, i) +
                   in_text(" lies %.4g mm in the floor at the end", -1000 * t.parts[i].lowest_at_end);
        if (t.parts.size() == 1 && t.asleep_at >= 0 &&
            t.parts[i].lowest_at_end > 0.001 + c.objects[i].object.flatness)
            return in_text("it sleeps %.4g mm above the floor", 1000 * t.parts[i].lowest_at_end);
    }
    if (t.overlap_at_end > t.overlap_allowed + flatness)
        return in_text("the two sleep %.4g mm in each other, and %.4g mm is allowed", 1000 * t.overlap_at_end,
                       1000 * (t.overlap_allowed + flatness));
    return {};
}

std::string passage_law(const Case& c, const Track& t) {
    if (!c.floor) return {};
    for (std::size_t i = 0; i < t.parts.size(); ++i)
        if (t.parts[i].centre_least < -0.01)
            return which(c, i) + in_text(" is with its centre %.4g m below the floor, its top %.4g m above",
                                         -t.parts[i].centre_least, t.parts[i].top_least);
    return {};
}

std::string asleep_law(const Case& c, const Track& t) {
    const double most = 2 * to_double(c.def.sleep_time);
    if (!c.floor || t.quiet <= most) return {};
    return in_text("all points are slower than half of the sleep speed for %.4g s, and not all sleep",
                   t.quiet);
}

std::string woken_law(const Case& c, const Track& t) {
    const double most = to_double(c.def.sleep_speed) * to_double(c.def.sleep_time);
    if (t.moved_asleep) return "a sleeping object moves";
    if (t.woken_way <= most) return {};
    return in_text("a point that slept at %.4g s goes %.4g mm after it is woken", t.asleep_at,
                   1000 * t.woken_way);
}

std::string settled_law(const Case& c, const Track& t) {
    if (!c.floor || t.left || t.asleep_at >= 0 || c.ticks < 10 * static_cast<int>(c.def.tick_rate)) return {};
    double fastest = 0;
    for (std::size_t i = 0; i < t.parts.size(); ++i) {
        if (c.objects[i].object.rolls) return {};
        fastest = std::max(fastest, t.parts[i].speed_at_end);
    }
    return in_text("not all sleep at the end: %.4g m/s", fastest);
}

std::string held_law(const Case&, const Track& t) {
    if (t.held <= held_most) return {};
    return in_text("an object of up to %.4g m/s does not go as fast for %.4g ticks", t.held_speed, t.held);
}

std::string momentum_law(const Case& c, const Track& t) {
    if (c.floor) return {};
    if (t.momentum_off > t.momentum_allowed)
        return in_text("the velocity of the whole is off by %.4g m/s, and %.4g m/s is allowed",
                       t.momentum_off, t.momentum_allowed);
    if (t.spin_off > t.spin_allowed)
        return in_text("the angular momentum is off by %.4g kg m^2/s, and %.4g kg m^2/s is allowed",
                       t.spin_off, t.spin_allowed);
    return {};
}

} // namespace lockstone::zoo
