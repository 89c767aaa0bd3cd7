#include "law/zoo/case.h"

#include "law/zoo/draw.h"

#include <algorithm>

namespace lockstone::zoo {

namespace {

/// The least and greatest height of a rotated object relative to its origin.
struct Heights {
    double low = 1e9, high = -1e9;
};
Heights heights(const Object& o, Quat rotation) {
    const Placed placed({Vec3{}, rotation});
    Heights h;
    for (const D3& c : o.corners) {
        const double y = placed.point(c)[1];
        h.low = std::min(h.low, y - o.radius), h.high = std::max(h.high, y + o.radius);
    }
    return h;
}

double reach(const Object& o) {
    double most = 0;
    for (const D3& c : o.corners) most = std::max(most, length(c));
    return most + o.radius;
}

WorldDef draw_def(SplitMix& random) {
    WorldDef def = random.below(3) == 0 ? WorldDef::precise() : WorldDef{};
    constexpr std::uint32_t rates[] = {30, 60, 60, 120};
    def.tick_rate = rates[random.below(4)];
    def.bodies_max = def.shapes_max = 16, def.contacts_max = 256;
    return def;
}

Vec3 draw_vector(SplitMix& random, double least, double most) {
    const D3 way = direction(random);
    return vec(times(log_between(random, least, most), way));
}

/// The limit of spins: 170 m/s, and 2 m in a tick, at the radius of gyration, which is at most half of the size.
double spin_most(const Object& o, const WorldDef& def) {
    return 2 * std::min(170.0, 2.0 * def.tick_rate) / o.size;
}
Vec3 draw_spin(SplitMix& random, double least, double most, const Object& o, const WorldDef& def) {
    const double limit = spin_most(o, def);
    return draw_vector(random, std::min(least, limit), std::min(most, limit));
}

/// Two objects in one library.
Case draw_two(SplitMix& random) {
    Case c;
    for (int i = 0; i < 2; ++i) {
        Thrown t;
        t.object = draw_any(random);
        t.density = log_between(random, 200, 8000);
        c.objects.push_back(std::move(t));
    }
    for (const AssetId id : c.objects[1].object.assets->ids())
        (void)c.objects[0].object.assets->add(c.objects[1].object.assets->bytes(id)).value();
    c.objects[1].object.assets = c.objects[0].object.assets;
    const double ratio = log_between(random, 1, 1e4);
    c.objects[1].mass_ratio = random.below(2) == 0 ? ratio : 1 / ratio;
    c.def = draw_def(random);
    return c;
}

/// The rocking period of a body grows with the root of its size: 12 s up to a metre, 54 s for 20 m.
int ticks_to_settle(const Case& c) {
    double size = 1;
    for (const Thrown& t : c.objects) size = std::max(size, t.object.size);
    return static_cast<int>(12 * std::sqrt(size) * c.def.tick_rate);
}

} // namespace

std::string Case::about() const {
    std::string text = "seed " + std::to_string(seed) + ": " + kind;
    for (const Thrown& t : objects) {
        const D3 v = to_double3(t.velocity), w = to_double3(t.spin), at = to_double3(t.pose.position);
        text += "; " + t.object.about +
                (t.mass_ratio > 0 ? in_text(", %.4g of the first mass", t.mass_ratio)
                                  : in_text(", %.4g kg/m^3", t.density)) +
                in_text(" at %.4g %.4g %.4g m", at[0], at[1], at[2]) +
                (t.pose.rotation == Quat::identity() ? "" : ", turned");
        if (length(v) > 0) text += in_text(", v %.3g %.3g %.3g m/s", v[0], v[1], v[2]);
        if (length(w) > 0) text += in_text(", w %.3g %.3g %.3g rad/s", w[0], w[1], w[2]);
    }
    return text + "; " + (floor ? name_of(*floor) : "space") + ", " + std::to_string(def.tick_rate) +
           " Hz, " + std::to_string(def.substeps) + " substeps";
}

Case draw_single(std::uint64_t seed) {
    const Drop d = draw_drop(seed, stream(seed, 1), draw_any);
    Case c;
    c.seed = seed, c.floor = d.floor, c.def = d.def;
    c.objects.push_back({d.object, d.pose, d.velocity, d.spin, d.density});
    c.ticks = ticks_to_settle(c);
    const double spin = length(to_double3(d.spin)), most = spin_most(d.object, d.def);
    if (spin > most) c.objects[0].spin = vec(times(most / spin, to_double3(d.spin)));
    return c;
}

Case draw_shot(std::uint64_t seed) {
    SplitMix random = stream(seed, 2);
    Case c;
    c.seed = seed, c.kind = "shot";
    Thrown t;
    t.object = draw_any(random);
    t.density = log_between(random, 200, 8000);
    c.floor = static_cast<Floor>(random.below(all_floor_count));
    c.def = draw_def(random);
    const Quat turn = any_turn(random);
    const double side = between(random, -1, 1), forth = between(random, -1, 1),
                 above = log_between(random, 0.01, 3);
    t.pose = {vec(side, above - heights(t.object, turn).low, forth), turn};
    const double down = between(random, 0.2, 1), about = between(random, 0, 2 * pi),
                 speed = log_between(random, 5, 300), flat = speed * std::sqrt(1 - down * down);
    t.velocity = vec(flat * std::cos(about), -speed * down, flat * std::sin(about));
    if (random.below(4) != 0) t.spin = draw_spin(random, 1, 1000, t.object, c.def);
    c.ticks = 2 * static_cast<int>(c.def.tick_rate);
    c.objects.push_back(std::move(t));
    return c;
}

Case draw_pair(std::uint64_t seed) {
    SplitMix random = stream(seed, 3);
    Case c = draw_two(random);
    c.seed = seed;
    c.floor = static_cast<Floor>(random.below(floor_count));
    c.ticks = ticks_to_settle(c);
    Thrown &first = c.objects[0], &second = c.objects[1];
    const bool is_flat = random.below(2) == 0;
    const Quat turn_first = is_flat ? Quat::identity() : any_turn(random);
    const Quat turn_second = is_flat ? Quat::identity() : any_turn(random);
    const Heights low = heights(first.object, turn_first), high = heights(second.object, turn_second);
    const double above = random.below(2) == 0 ? 0.001 : log_between(random, 0.01, 3);
    first.pose = {vec(0, above - low.low, 0), turn_first};
    const double top = above - low.low + low.high;
    if (random.below(2) == 0) { // stacked
        c.kind = is_flat ? "stack" : "heap";
        const double gap = random.below(2) == 0 ? 0.001 : log_between(random, 0.01, 3);
        const double side = first.object.size * between(random, -0.2, 0.2);
        second.pose = {vec(side, top + gap - high.low, 0), turn_second};
        return c;
    }
    c.kind = "throw";
    const double speed = log_between(random, 0.3, 20), about = between(random, 0, 2 * pi);
    const double far = reach(first.object) + reach(second.object) + 0.1 + std::min(3.0, 0.3 * speed);
    const double height = std::max(0.01 - high.low, top * unit(random));
    second.pose = {vec(far * std::cos(about), height, far * std::sin(about)), turn_second};
    const double time = far / speed, up = std::min(speed, 9.81 * time / 2);
    second.velocity = vec(-speed * std::cos(about), up, -speed * std::sin(about));
    if (random.below(2) == 0) second.spin = draw_spin(random, 0.1, 30, second.object, c.def);
    return c;
}

Case draw_meeting(std::uint64_t seed) {
    SplitMix random = stream(seed, 4);
    Case c = draw_two(random);
    c.seed = seed, c.kind = "meeting";
    c.def.gravity = {}, c.def.sleeping = 0; // sleep removes slow speeds
    Thrown &first = c.objects[0], &second = c.objects[1];
    first.pose.rotation = any_turn(random);
    second.pose.rotation = any_turn(random);
    const double far = reach(first.object) + reach(second.object) + 0.05;
    const D3 way = direction(random), aside = direction(random);
    const double speed = log_between(random, 0.1, 50);
    const double miss = 0.3 * std::min(reach(first.object), reach(second.object)) * unit(random);
    second.pose.position = vec(plus(times(far, way), times(miss, aside)));
    second.velocity = vec(times(-speed, way));
    if (random.below(2) == 0) first.spin = draw_spin(random, 0.1, 30, first.object, c.def);
    if (random.below(2) == 0) second.spin = draw_spin(random, 0.1, 30, second.object, c.def);
    c.ticks = std::min(240, static_cast<int>(3 * far / speed * c.def.tick_rate) + 10);
    return c;
}

Stage stage(const Case& c, Vec3 offset) {
    World w = World::create(c.def, {}, c.objects[0].object.assets).value();
    if (c.floor) add_floor(w, *c.floor, offset);
    std::vector<BodyId> bodies;
    for (const Thrown& t : c.objects) {
        BodyDef def{.pose = {t.pose.position + offset, t.pose.rotation},
                    .linear_velocity = t.velocity,
                    .angular_velocity = t.spin};
        if (t.mass_ratio > 0)
            def.mass = real(std::clamp(t.mass_ratio * to_double(w.mass(bodies[0])), 0.001, 1e9));
        bodies.push_back(w.create_body(def).value());
        (void)w.create_shape(bodies.back(), {.geometry = t.object.geometry, .density = real(t.density)})
            .value();
    }
    return {std::move(w), std::move(bodies)};
}

std::string far_law(const Case& c, Vec3 offset, bool nudged) {
    Stage near = stage(c), far = stage(c, offset);
    if (nudged) {
        Transform pose = far.world.pose(far.bodies.back());
        pose.position.x = pose.position.x + Real::from_raw(1);
        (void)far.world.set_pose(far.bodies.back(), pose);
    }
    for (int tick = 1; tick <= c.ticks; ++tick) {
        near.world.tick(), far.world.tick();
        for (std::size_t i = 0; i < near.bodies.size(); ++i) {
            const BodyId a = near.bodies[i], b = far.bodies[i];
            const Transform here = near.world.pose(a), there = far.world.pose(b);
            if (there.position - offset == here.position && there.rotation == here.rotation &&
                near.world.linear_velocity(a) == far.world.linear_velocity(b) &&
                near.world.angular_velocity(a) == far.world.angular_velocity(b) &&
                near.world.is_awake(a) == far.world.is_awake(b))
                continue;
            const D3 apart = minus(to_double3(there.position - offset), to_double3(here.position));
            return in_text("at x = %.4g m the motion parts in tick %.4g, by %.3g m", to_double(offset.x),
                           tick, length(apart));
        }
        if (near.world.awake_count() == 0) break;
    }
    return {};
}

} // namespace lockstone::zoo
