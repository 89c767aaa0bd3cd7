#include "law/zoo/object.h"

#include "law/zoo/draw.h"

#include <algorithm>
#include <cmath>

namespace lockstone::zoo {

namespace {

void add_disc(Object& o, double radius, double y) {
    for (int k = 0; k < 64; ++k)
        o.corners.push_back({radius * std::cos(2 * pi * k / 64), y, radius * std::sin(2 * pi * k / 64)});
    o.discs.push_back({radius, y});
}

/// An outline of some corners, at two heights, and some more points within it.
std::vector<D3> prism(SplitMix& random, double a, double h, double b, double flatness) {
    std::vector<D3> points;
    const std::uint32_t corners = 3 + random.below(9), inner = random.below(3) == 0 ? 0 : random.below(8);
    for (const double side : {-1.0, 1.0}) {
        for (std::uint32_t k = 0; k < corners; ++k) {
            const double turn = 2 * pi * k / corners;
            points.push_back({a * std::cos(turn), side * (h - flatness * unit(random)), b * std::sin(turn)});
        }
        for (std::uint32_t k = 0; k < inner; ++k) {
            const double turn = 2 * pi * unit(random), out = 0.7 * unit(random);
            points.push_back({a * out * std::cos(turn), side * (h + flatness * unit(random) * (1 - out)),
                              b * out * std::sin(turn)});
        }
    }
    return points;
}

bool bake(Object& o, const std::vector<D3>& points) {
    std::vector<LengthVec3> fixed;
    for (const D3& p : points) fixed.push_back(length_vec(p));
    const Result<AssetBytes> bytes = bake_hull(fixed);
    if (!bytes) return false;
    o.geometry = instance(ShapeKind::hull, o.assets->add(*bytes).value());
    o.corners.clear();
    for (const LengthVec3& p : fixed) o.corners.push_back({to_double(p.x), to_double(p.y), to_double(p.z)});
    return true;
}

void draw_round(SplitMix& random, Object& o, double large, double small) {
    o.rolls = true;
    const bool is_long = random.below(2) == 0;
    switch (random.below(4)) {
    case 0:
        o.geometry = sphere(real(small / 2));
        o.corners = {{0, 0, 0}}, o.radius = small / 2;
        o.about = in_text("ball of radius %.4g m", small / 2);
        break;
    case 1:
        o.geometry = capsule(real(small / 2), real(large / 2));
        o.corners = {{0, -large / 2, 0}, {0, large / 2, 0}}, o.radius = small / 2;
        o.about = in_text("capsule of radius %.4g m, segment %.4g m", small / 2, large);
        break;
    case 2: {
        const double r = (is_long ? small : large) / 2, h = (is_long ? large : small) / 2;
        o.geometry = cylinder(real(r), real(h));
        add_disc(o, r, -h), add_disc(o, r, h);
        o.about = in_text("cylinder of radius %.4g m, height %.4g m", r, 2 * h);
        break;
    }
    default: {
        const double r = (is_long ? small : large) / 2, h = (is_long ? large : small) / 2;
        o.geometry = cone(real(r), real(h));
        add_disc(o, r, -h), o.corners.push_back({0, h, 0});
        o.about = in_text("cone of radius %.4g m, height %.4g m", r, 2 * h);
        break;
    }
    }
}

/// Heights of the object's lowest point and of its centre of mass; the speed of its fastest point; energy per mass.
/// Semi-implicit Euler with steps of a length h conserves v^2 / 2 + g y - g h v_y / 2 while a body falls, not v^2 / 2 +
/// g y, so the energy is the former.
struct Reading {
    double lowest, centre, fastest, energy, rising; ///< rising: upward speed of the centre
};
Reading read(const World& w, BodyId body, const Object& o, const D3& gyration_squared, Quat principal) {
    const double step = 1.0 / (w.def().tick_rate * w.def().substeps);
    const Transform pose = w.pose(body);
    const Rotation turn = to_rotation(pose.rotation);
    const D3 x = {to_double(turn.x.x), to_double(turn.x.y), to_double(turn.x.z)},
             y = {to_double(turn.y.x), to_double(turn.y.y), to_double(turn.y.z)},
             z = {to_double(turn.z.x), to_double(turn.z.y), to_double(turn.z.z)};
    const D3 centre = to_double3(w.center_of_mass(body)), at = to_double3(pose.position),
             v = to_double3(w.linear_velocity(body)), spin = to_double3(w.angular_velocity(body));
    Reading r{1e9, centre[1], 0, 0, v[1]};
    for (const D3& c : o.corners) {
        D3 p;
        for (int i = 0; i < 3; ++i)
            p[static_cast<std::size_t>(i)] =
                at[static_cast<std::size_t>(i)] + x[static_cast<std::size_t>(i)] * c[0] +
                y[static_cast<std::size_t>(i)] * c[1] + z[static_cast<std::size_t>(i)] * c[2];
        r.lowest = std::min(r.lowest, p[1] - o.radius);
        const D3 arm = {p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
        const D3 s = {v[0] + spin[1] * arm[2] - spin[2] * arm[1], v[1] + spin[2] * arm[0] - spin[0] * arm[2],
                      v[2] + spin[0] * arm[1] - spin[1] * arm[0]};
        r.fastest = std::max(r.fastest, std::sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]));
    }
    const Rotation axes = to_rotation(normalized(pose.rotation * principal));
    double turning = 0;
    int i = 0;
    for (const UnitVec3 a : {axes.x, axes.y, axes.z}) {
        const double along = spin[0] * to_double(a.x) + spin[1] * to_double(a.y) + spin[2] * to_double(a.z);
        turning += gyration_squared[static_cast<std::size_t>(i++)] * along * along;
    }
    r.energy =
        9.81 * (centre[1] - 0.5 * step * v[1]) + 0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] + turning);
    return r;
}

} // namespace

Object draw_prism(SplitMix& random, double large, double small, double middle, double flatness) {
    Object o;
    o.assets = floor_library();
    o.size = large, o.thickness = small, o.flatness = flatness;
    while (!bake(o, prism(random, large / 2, small / 2, middle / 2, flatness))) {}
    o.about = in_text("prism of %.4g x %.4g x %.4g m", large, small, middle) +
              in_text(", sides flat to %.3g um", flatness * 1e6);
    return o;
}

Object draw_object(SplitMix& random) { return draw_object(random, 0.02, 0.0101); }

Object draw_object(SplitMix& random, double size_least, double thickness_least) {
    for (;;) {
        Object o;
        o.assets = floor_library();
        const double large = log_between(random, size_least, 20);
        const double least = std::max(thickness_least, large / 500);
        const double small = log_between(random, least, std::max(least, large)),
                     middle = log_between(random, small, std::max(small, large));
        o.size = large, o.thickness = small;
        switch (random.below(8)) {
        case 0:
        case 1:
            draw_round(random, o, large, small);
            break;
        case 2:
        case 3: {
            o.geometry = box(real(large / 2), real(small / 2), real(middle / 2));
            for (int k = 0; k < 8; ++k)
                o.corners.push_back({(k & 1 ? 1 : -1) * large / 2, (k & 2 ? 1 : -1) * small / 2,
                                     (k & 4 ? 1 : -1) * middle / 2});
            o.about = in_text("box of %.4g x %.4g x %.4g m", large, small, middle);
            break;
        }
        case 4: { // any points
            std::vector<D3> points;
            for (std::uint32_t k = 4 + random.below(60); k > 0; --k) {
                const D3 d = direction(random);
                points.push_back({d[0] * large / 2, d[1] * small / 2, d[2] * middle / 2});
            }
            if (!bake(o, points)) continue;
            o.about = in_text("hull of points on an ellipsoid of %.4g x %.4g x %.4g m", large, small, middle);
            o.rolls = true;
            break;
        }
        default:
            o = draw_prism(random, large, small, middle,
                           random.below(4) == 0 ? 0 : std::min(log_between(random, 1e-7, 1e-3), small / 20));
            break;
        }
        if (validate(o.geometry).empty()) return o;
    }
}

namespace {

constexpr double size_least = 0.01, thickness_least = 0.0051;

/// Every point within `radius` of a cylinder, cone, box or hull.
Object draw_rounded(SplitMix& random) {
    for (;;) {
        Object o = draw_object(random, size_least, thickness_least);
        const double radius = o.thickness * between(random, 0.05, 1);
        if (o.radius > 0 || radius < 0.0026) continue;
        o.geometry.radius = quantize<Length>(radius);
        o.radius = to_double(o.geometry.radius), o.size += 2 * radius;
        o.rolls = true;
        o.about += in_text(", rounded by %.4g m", radius);
        if (validate(o.geometry).empty()) return o;
    }
}

/// Two to four boxes, rotated or not, about a place.
Object draw_compound(SplitMix& random) {
    Object o;
    o.assets = floor_library();
    const double large = log_between(random, 4 * size_least, 10);
    const std::uint32_t count = 2 + random.below(3);
    o.size = 3 * large, o.thickness = large;
    double core = 0;
    for (std::uint32_t k = 0; k < count; ++k) {
        D3 half, at;
        for (double& h : half) h = log_between(random, std::max(thickness_least, large / 20), large) / 2;
        for (double& x : at) x = large * between(random, -0.5, 0.5);
        const Quat turn = random.below(2) == 0 ? Quat::identity() : any_turn(random);
        const CompoundPart part{box(real(half[0]), real(half[1]), real(half[2])), {vec(at), turn}};
        const Placed placed(part.local);
        for (int i = 0; i < 8; ++i)
            o.corners.push_back(placed.point(
                {(i & 1 ? 1 : -1) * half[0], (i & 2 ? 1 : -1) * half[1], (i & 4 ? 1 : -1) * half[2]}));
        const double inner = std::min({half[0], half[1], half[2]});
        if (inner > core) core = inner, o.core = at;
        o.thickness = std::min(o.thickness, 2 * inner);
        o.parts.push_back(part);
    }
    o.geometry = instance(ShapeKind::compound, o.assets->add(bake_compound(o.parts)).value());
    o.about = in_text("compound of %.4g boxes within %.4g m", count, large);
    return o;
}

} // namespace

Object draw_any(SplitMix& random) {
    const std::uint32_t kind = random.below(8);
    if (kind == 0) return draw_rounded(random);
    if (kind == 1) return draw_compound(random);
    return draw_object(random, size_least, thickness_least);
}

Object object_of(const AssetBytes& hull, const std::string& about) {
    Object o;
    o.assets = floor_library();
    o.geometry = o.assets->geometry(o.assets->add(hull).value()).value();
    D3 low{1e9, 1e9, 1e9}, high{-1e9, -1e9, -1e9};
    for (const Vec3& v : triangulate(o.geometry, *o.assets).vertices) {
        const D3 p = to_double3(v);
        for (std::size_t i = 0; i < 3; ++i)
            low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
        o.corners.push_back(p);
    }
    const D3 extent{high[0] - low[0], high[1] - low[1], high[2] - low[2]};
    o.size = *std::max_element(extent.begin(), extent.end());
    o.thickness = *std::min_element(extent.begin(), extent.end());
    double nearest = 1e9, farthest = 0; // corners, from the middle
    for (const D3& c : o.corners) {
        const double r = std::hypot(c[0] - 0.5 * (low[0] + high[0]), c[1] - 0.5 * (low[1] + high[1]),
                                    c[2] - 0.5 * (low[2] + high[2]));
        nearest = std::min(nearest, r), farthest = std::max(farthest, r);
    }
    constexpr std::size_t corners_of_ball = 40;
    o.rolls = o.corners.size() >= corners_of_ball && nearest > 0.9 * farthest;
    o.flatness = o.size / 4096; // facets within this distance are one face (src/shapes)
    o.about = about;
    return o;
}

std::string Drop::about() const {
    const D3 v = to_double3(velocity), w = to_double3(spin), at = to_double3(pose.position);
    return "seed " + std::to_string(seed) + ": " + object.about + ", " + in_text("%.4g kg/m^3, ", density) +
           "on a " + name_of(floor) + in_text(" from %.4g m", at[1]) +
           in_text(", v %.3g %.3g %.3g m/s", v[0], v[1], v[2]) +
           in_text(", w %.3g %.3g %.3g rad/s", w[0], w[1], w[2]) + ", " + std::to_string(def.tick_rate) +
           " Hz, " + std::to_string(def.substeps) + " substeps";
}

Drop draw_drop(std::uint64_t seed) {
    return draw_drop(seed, SplitMix(seed * 0x9e3779b97f4a7c15u + 1), draw_object);
}

Drop draw_drop(std::uint64_t seed, SplitMix random, Object (*draw)(SplitMix&)) {
    Drop d;
    d.seed = seed;
    d.object = draw(random);
    d.floor = static_cast<Floor>(random.below(floor_count));
    d.def = random.below(3) == 0 ? WorldDef::precise() : WorldDef{};
    constexpr std::uint32_t rates[] = {30, 60, 60, 120};
    d.def.tick_rate = rates[random.below(4)];
    d.def.bodies_max = d.def.shapes_max = 16, d.def.contacts_max = 256;
    d.density = log_between(random, 200, 8000);
    const Quat turn = random.below(4) == 0 ? Quat::identity() : any_turn(random);
    const double reach = 0.5 * std::sqrt(3.0) * d.object.size + d.object.radius;
    const double above = random.below(3) == 0 ? 0.001 : log_between(random, 0.01, 6);
    const double z = between(random, -1, 1), x = between(random, -1, 1);
    d.pose = {vec(x, reach + above, z), turn};
    const bool is_thrown = random.below(3) == 0;
    if (is_thrown) {
        const D3 way = direction(random);
        const double speed = log_between(random, 0.1, 10);
        d.velocity = vec(speed * way[0], -std::abs(speed * way[1]), speed * way[2]);
        const D3 about = direction(random);
        const double spin = log_between(random, 0.1, 30);
        d.spin = vec(spin * about[0], spin * about[1], spin * about[2]);
    }
    return d;
}

Drop drop_of(const Object& object, Floor floor, std::uint64_t seed) {
    SplitMix random(seed);
    Drop drop;
    drop.seed = seed;
    drop.object = object;
    drop.floor = floor;
    drop.seconds = 60;
    const Quat turn = any_turn(random);
    const Rotation axes = to_rotation(turn);
    double low = 0; // of the rotated object
    for (const D3& c : object.corners)
        low = std::min(low,
                       to_double(axes.x.y) * c[0] + to_double(axes.y.y) * c[1] + to_double(axes.z.y) * c[2]);
    drop.pose = {vec(0, 0.3 - low, 0), turn};
    drop.def.bodies_max = drop.def.shapes_max = 16, drop.def.contacts_max = 256;
    return drop;
}

Drop draw_flat_prism(std::uint64_t seed) {
    SplitMix random(seed);
    const double large = 0.1 * (1 + random.below(20)), small = large / (1 + random.below(8)),
                 middle = small + (large - small) * random.below(100) / 100.0;
    Drop drop;
    drop.seed = seed;
    drop.object = draw_prism(random, large, small, middle, large / (8192 << random.below(8)));
    drop.floor = static_cast<Floor>(seed % floor_count);
    drop.pose = {vec(0, small / 2 + 0.3, 0), Quat::identity()};
    drop.def.bodies_max = drop.def.shapes_max = 16, drop.def.contacts_max = 256;
    return drop;
}

std::string beam_fault(const Beam& beam) {
    const double half_height = 0.05335, edge = 0.5; // [rad], about the beam
    const auto turn = [](UnitVec3 axis, double angle) { return from_axis_angle(axis, real(angle)); };
    World w = World::create(beam.precise ? WorldDef::precise() : WorldDef{}).value();
    const ShapeDef floor{.geometry = plane(), .friction = real(beam.friction)},
        side{.geometry = box(real(beam.length / 2), real(half_height), 0.07645_r),
             .friction = real(beam.friction)};
    const BodyId ground = w.create_body({.kind = BodyKind::static_}).value();
    (void)w.create_shape(ground, floor).value();
    const Quat pose = normalized(turn({Unit{}, unit_one, Unit{}}, beam.yaw_degrees * pi / 180) *
                                 turn({unit_one, Unit{}, Unit{}}, edge));
    const BodyId body = w.create_body({.pose = {vec(0, 0.12, 0), pose}}).value();
    (void)w.create_shape(body, side).value();
    int tick = 0;
    while (tick < 480 && w.is_awake(body)) w.tick(), ++tick;
    const double height = to_double(w.center_of_mass(body).y);
    if (!w.is_awake(body) && std::abs(height - half_height) < 0.001) return {};
    return in_text("a beam of %.4g m turned by %.4g degrees, friction %.4g: ", beam.length, beam.yaw_degrees,
                   beam.friction) +
           in_text("it is at %.4g m after %.4g ticks", height, tick);
}

Played begin(const Drop& drop, Vec3 offset) {
    World w = World::create(drop.def, {}, drop.object.assets).value();
    add_floor(w, drop.floor, offset);
    const BodyId body = w.create_body({.pose = {drop.pose.position + offset, drop.pose.rotation},
                                       .linear_velocity = drop.velocity,
                                       .angular_velocity = drop.spin})
                            .value();
    (void)w.create_shape(body, {.geometry = drop.object.geometry, .density = real(drop.density)}).value();
    return {std::move(w), body};
}

Outcome play(const Drop& drop) {
    Played p = begin(drop);
    const SetMass mass = p.world.mass_properties(p.object);
    const D3 k = to_double3(mass.gyration.value), squared = {k[0] * k[0], k[1] * k[1], k[2] * k[2]};
    const auto now = [&] { return read(p.world, p.object, drop.object, squared, mass.principal.value); };
    const Reading start = now();
    Outcome out{.highest = 0, .centre_at_least = start.centre};
    Reading r = start;
    for (std::uint32_t t = 1; t <= static_cast<std::uint32_t>(drop.seconds) * drop.def.tick_rate; ++t) {
        p.world.tick();
        r = now();
        // A swept body that is stopped on its way down has the speed of the whole tick: the impact removes that energy.
        if (r.rising >= -0.01)
            out.energy_above_start = std::max(out.energy_above_start, (r.energy - start.energy) / 9.81);
        out.highest = std::max(out.highest, r.centre - start.centre);
        out.centre_at_least = std::min(out.centre_at_least, r.centre);
        const bool awake = p.world.is_awake(p.object);
        if (!awake && out.asleep_at < 0) out.asleep_at = double(t) / drop.def.tick_rate;
        if (awake) out.asleep_at = -1;
        const D3 at = to_double3(p.world.center_of_mass(p.object));
        if (std::max(std::abs(at[0]), std::abs(at[2])) + drop.object.size > 60) {
            out.left = true;
            break;
        }
        if (!awake) break;
    }
    out.lowest_at_end = r.lowest, out.speed_at_end = r.fastest;
    return out;
}

std::string energy_fault(const Drop& drop, const Outcome& out) {
    const double rise = 0.002 + 0.002 * drop.object.size; // the lift by pushing out an overlap
    if (out.energy_above_start <= rise) return {};
    return in_text("the energy rises by that of %.4g m of height (highest place: %.4g m above the start)",
                   out.energy_above_start, out.highest);
}

std::string rest_fault(const Drop& drop, const Outcome& out) {
    const Object& o = drop.object;
    if (out.left) return {};
    if (out.centre_at_least < -0.01)
        return in_text("its centre was %.4g m below the floor", -out.centre_at_least);
    if (out.lowest_at_end < -(0.001 + o.flatness))
        return in_text("it lies %.4g mm in the floor at the end", -1000 * out.lowest_at_end);
    if (out.asleep_at >= 0 && out.lowest_at_end > 0.001 + o.flatness)
        return in_text("it sleeps %.4g mm above the floor", 1000 * out.lowest_at_end);
    if (out.asleep_at < 0 && !o.rolls) return in_text("it is awake at the end: %.4g m/s", out.speed_at_end);
    return {};
}

} // namespace lockstone::zoo
