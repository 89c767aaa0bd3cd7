// Draws the definition of a world, the arrangement of its bodies and all other objects at its start.
#include "draw.h"

#include "drawer.h"
#include "lockstone/play/ragdoll.h"

#include <utility>

namespace worlds {

void Drawer::choose_size() {
    // Uniform over powers of two, because thresholds lie at all scales.
    const std::uint32_t least = 5;
    std::uint32_t high = least;
    for (std::uint32_t doublings = v.below(10); doublings > 0; --doublings)
        high = std::min(2 * high, most.bodies_most);
    bodies = least + v.below(high);
    bodies = std::min(bodies, most.bodies_most);
    arrangement = static_cast<Arrangement>(v.below(static_cast<std::uint32_t>(Arrangement::count_)));
    tower = 1 + static_cast<std::int32_t>(v.below(6));
    if (v.chance(8)) drivers_of = 3;
    apply_theme();
    const std::uint32_t longest = v.chance(4) ? 120 : 40;
    story.ticks = std::clamp(most.work / bodies, 5u, longest);
    activity = v.below(4);
    if (theme == Theme::islands && !v.chance(4)) activity = 0; // commands make contacts bounce or roll
    // All bodies overlap: that is slow.
    if (arrangement == Arrangement::crowd && theme != Theme::crowd) bodies = std::min(bodies, 150u);
    // The side of a square that `bodies` fill in one layer of a metre, or in several layers.
    std::uint32_t root = 1;
    while (root * root < bodies) ++root;
    const Real layers = arrangement == Arrangement::deep_pit ? 0.16_r
                        : arrangement == Arrangement::cloud  ? 0.3_r
                        : arrangement == Arrangement::crowd  ? Real{}
                                                             : 0.4_r;
    side = Real(static_cast<std::int32_t>(root)) * layers + 1.5_r;
}

void Drawer::apply_theme() {
    switch (theme) {
    case Theme::mixed:
        bodies = 1500 + v.below(3500);
        break;
    case Theme::islands:
        arrangement = Arrangement::towers, tower = 2 + static_cast<std::int32_t>(v.below(5));
        bodies = 2500 + v.below(2500);
        break;
    case Theme::net:
        arrangement = Arrangement::net;
        bodies = 500 + v.below(500);
        break;
    case Theme::crowd:
        arrangement = Arrangement::crowd;
        bodies = 150 + v.below(60);
        break;
    case Theme::driven:
        bodies = 200 + v.below(400), drivers_of = 3;
        break;
    default:
        break;
    }
}

/// Some passes are one run only where contacts alone change velocities. This function drops the features that
/// `cannot_meet` excludes from such passes, except for those of joints.
void Drawer::keep_contacts_alone() {
    for (const Feature f :
         {Feature::joints, Feature::vehicles, Feature::ragdolls, Feature::fields, Feature::fluids,
          Feature::bounces, Feature::rolls, Feature::integrators, Feature::wild, Feature::far_away})
        drop(f);
}

void Drawer::choose_features() {
    if (most.has_large && v.chance(12))
        theme = static_cast<Theme>(1 + v.below(static_cast<std::uint32_t>(Theme::count_) - 1));
    const std::uint32_t of = 2u << v.below(3); // some worlds have half of all features, some an eighth
    for (std::uint32_t f = 0; f < feature_count; ++f)
        if (v.chance(of)) story.add(static_cast<Feature>(f));
    if (v.chance(4) || theme == Theme::islands) keep_contacts_alone();
    // These features change a world as a whole, so fewer worlds have them.
    if (!v.chance(4) || theme != Theme::none) drop(Feature::wild);
    if (theme != Theme::none) drop(Feature::far_away);
    // A thousand bullets in a pile take seconds a tick.
    if (theme == Theme::mixed || theme == Theme::islands) drop(Feature::bullets);
    if (!v.chance(3)) drop(Feature::drops_contacts);
    if (theme == Theme::net) story.add(Feature::joints), drop(Feature::joints_break);
    if (theme == Theme::crowd) story.add(Feature::drops_contacts), drop(Feature::groups);
    if (theme == Theme::driven) story.add(Feature::kinematic), story.add(Feature::bullets);
    if (!has(Feature::joints))
        for (const Feature f : {Feature::joint_springs, Feature::joint_limits, Feature::joint_motors,
                                Feature::joint_friction, Feature::joints_break, Feature::loops_of_joints})
            drop(f);
}

WorldDef Drawer::world_def(std::uint64_t seed) {
    WorldDef d;
    if (has(Feature::wild)) {
        v.set_wildness(1 + v.below(7));
        d = attack::world_def(v);
    } else {
        v.set_wildness(v.chance(4) ? 1 : 0);
        constexpr std::uint32_t rates[] = {60, 60, 30, 120, 20, 240}, steps[] = {4, 4, 8, 2, 1, 12};
        d.tick_rate = rates[v.below(6)];
        d.substeps = steps[v.below(6)];
        if (v.chance(8)) d.gravity = vector(Real(12));
        if (has(Feature::integrators)) d.integrator = static_cast<Integrator>(v.below(4));
        d.bounds_shift = v.chance(8) ? v.below(9) : 0;
        d.continuous = v.chance(8) ? 0 : 1;
    }
    d.sleeping = has(Feature::sleeps) || has(Feature::starts_asleep) ? 1 : 0;
    if (has(Feature::sleeps) && v.chance(2)) d.sleep_time = 0.1_r, d.sleep_speed = 0.1_r;
    d.seed = seed;
    d.bodies_max = d.shapes_max = 1 << 16;
    d.joints_max = 1 << 14;
    d.contacts_max = has(Feature::drops_contacts) ? 1 + v.below(theme == Theme::crowd ? 60 : 2 * bodies) : 0;
    d.fields_max = 8, d.characters_max = 64, d.vehicles_max = 64, d.pair_filters_max = 4096;
    return d;
}

World Drawer::start(std::uint64_t seed) {
    choose_features();
    choose_size();
    story.def = world_def(seed);
    if (has(Feature::far_away)) {
        const Real far = v.chance(3) ? Real(900000000) : v.chance(2) ? Real(1000000) : Real(30000);
        center = v.each_within(far, vector(far));
        bodies = std::min(bodies, 120u); // the broad phase is coarse there, and slow
    }
    if (has(Feature::wild)) bodies = std::min(bodies, 60u); // shapes of 100 m overlap all others
    return story_world(story.def);
}

Vec3 Drawer::place(std::uint32_t number) {
    const auto n = static_cast<std::int32_t>(number);
    switch (arrangement) {
    case Arrangement::wide_pit:
    case Arrangement::deep_pit: {
        const Real x = range(-side, side), z = range(-side, side);
        const Real area = max(Real(1), half(side * side));
        return {x, 0.5_r + Real(n) / area * half(0.7_r), z};
    }
    case Arrangement::towers: {
        // Four touching columns form one tower in a world of islands: enough contacts for packs that exceed a cache.
        if (theme == Theme::islands) {
            const std::int32_t block = n / (4 * tower), wide = 32;
            return {Real(block % wide) * 2.2_r + Real(n % 2) * 0.8_r - Real(35),
                    0.4_r + Real(n / 4 % tower) * 0.8_r,
                    Real(block / wide) * 2.2_r + Real(n / 2 % 2) * 0.8_r - Real(10)};
        }
        const std::int32_t high = tower, column = n / high;
        const std::int32_t row = std::max<std::int32_t>(1, static_cast<std::int32_t>(side.raw >> 32));
        const Real x = Real(column % row) * 1.3_r - half(side), z = Real(column / row) * 1.3_r - half(side);
        return {x, 0.4_r + Real(n % high) * 0.8_r, z};
    }
    case Arrangement::wall: {
        const std::int32_t wide = 12;
        const std::int32_t row = n / wide;
        const Real x = Real(n % wide) * 0.8_r + (row % 2 == 0 ? Real{} : 0.4_r) - Real(5);
        return {x, 0.4_r + Real(row % 10) * 0.7_r, Real(row / 10) * 1.1_r};
    }
    case Arrangement::crowd: {
        const Vec3 at = vector(half(Real(1)));
        return {at.x, at.y + Real(2), at.z};
    }
    case Arrangement::net: {
        const std::int32_t column = n % net_columns(), row = n / net_columns();
        return {Real(column) * 0.95_r, Real(4), Real(row) * 0.95_r};
    }
    default: {
        const Vec3 at = vector(side);
        return {at.x, at.y + side + Real(1), at.z};
    }
    }
}

void Drawer::make(const Assembly& assembly) {
    const Result<BodyId> made = world.create_body(assembly.body);
    if (!made) return;
    for (const ShapeDef& shape : assembly.shapes) told(world.create_shape(*made, shape));
}

void Drawer::add_joint(BodyId a, BodyId b) {
    JointDef def = joint_def();
    if (has(Feature::wild) && v.chance(2)) {
        def.body_a = a, def.body_b = b;
        return told(world.create_joint(def));
    }
    if (!b) return;
    Transform at = world.pose(b);
    if (a)
        for (int i = 0; i < 3; ++i)
            at.position[i] = at.position[i] + half(world.pose(a).position[i] - at.position[i]);
    told(world.create_joint(def, a, b, at));
}

void Drawer::add_joints() {
    const std::uint32_t count = world.body_count(), step = 1 + v.below(3), longest = 1 + v.below(24);
    std::uint32_t in_row = 0;
    for (std::uint32_t row = step; row < count; row += step) {
        const BodyId a = world.body_at(row - step), b = world.body_at(row);
        if (++in_row > longest || world.kind(b) == BodyKind::static_) {
            in_row = 0;
            continue;
        }
        add_joint(v.chance(12) ? BodyId{} : a, b);
        if (has(Feature::loops_of_joints) && v.chance(4)) add_joint(world.body_at(v.below(row)), b);
        if (world.joint_count() > 400) return;
    }
}

/// Joins each body to the next one in its row and in its column, so that joints form chains along diagonals.
void Drawer::add_net() {
    const auto columns = static_cast<std::uint32_t>(net_columns()), count = world.body_count();
    const std::uint32_t first = count - std::min(count, bodies);
    for (std::uint32_t row = first; row < count; ++row) {
        const BodyId b = world.body_at(row);
        if (world.kind(b) == BodyKind::static_) continue;
        if ((row - first) % columns != 0) add_joint(world.body_at(row - 1), b);
        if (row - first >= columns) add_joint(world.body_at(row - columns), b);
        if (world.joint_count() > 1500) return;
    }
}

void Drawer::add_vehicle() {
    const BodyId chassis = mover();
    if (!chassis) return;
    const Result<VehicleId> made = world.create_vehicle(attack::vehicle_def(v, chassis));
    if (made) told(world.set_vehicle_input(*made, attack::vehicle_input(v)));
}

void Drawer::add_character() {
    Vec3 at = vector(side);
    if (is_stacked()) at.x = at.x - Real(300); // beside the towers, whose contacts have passes of their own
    const Result<CharacterId> made =
        world.create_character(attack::character_def(v, center + Vec3{at.x, Real(1), at.z}));
    if (!made) return;
    CharacterInput input;
    input.velocity = vector(Real(4));
    input.jump = v.below(2), input.crouch = v.below(2);
    told(world.set_character_input(*made, input));
}

void Drawer::add_ragdoll() {
    RagdollDef d;
    const Vec3 at = vector(side);
    d.place = {center + Vec3{at.x, Real(2), at.z}, v.turn()};
    d.linear_velocity = vector(Real(3)), d.user_key = keys += 32;
    if (v.chance(2)) d.pose = ragdoll_t_pose();
    const Result<Ragdoll> made = make_ragdoll(world, d);
    if (made && v.chance(2))
        told(set_ragdoll_drive(world, *made, ragdoll_t_pose(),
                               {.frequency = Real(10), .torque_max = Real(100)}));
}

void Drawer::fill() {
    std::vector<Assembly> all = ground();
    for (std::uint32_t i = 0; i < bodies; ++i) {
        const Vec3 at = place(i);
        all.push_back(assembly(at));
    }
    if (has(Feature::assembled)) {
        Level level;
        level.bodies = all;
        for (std::uint32_t i = v.below(3); i > 0; --i) level.fields.push_back({field_def(), ++keys});
        if (assemble(world, level)) {
            story.start = level;
            story.steps.clear(); // the level contains the start
        }
    }
    if (!story.start)
        for (const Assembly& one : all) make(one);
    if (has(Feature::joints)) arrangement == Arrangement::net ? add_net() : add_joints();
    if (has(Feature::vehicles))
        for (std::uint32_t i = 1 + v.below(6); i > 0; --i) add_vehicle();
    if (has(Feature::characters))
        for (std::uint32_t i = 1 + v.below(4); i > 0; --i) add_character();
    if (has(Feature::ragdolls))
        for (std::uint32_t i = 1 + v.below(4); i > 0; --i) add_ragdoll();
    if (has(Feature::fields) || has(Feature::fluids))
        for (std::uint32_t i = 1 + v.below(3); i > 0; --i) told(world.create_field(field_def()));
}

Drawn Drawer::run() {
    fill();
    Drawn out;
    for (std::uint64_t t = 0; t < story.ticks; ++t) {
        if (activity > 0)
            for (std::uint32_t i = v.below(activity * 2); i > 0; --i) command();
        world.tick();
        out.hashes.push_back(world.hash());
    }
    out.story = std::move(story);
    return out;
}

Drawn draw(std::uint64_t seed, const Extent& extent) { return Drawer(seed, extent).run(); }

} // namespace worlds
