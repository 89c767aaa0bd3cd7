// Three small worlds that together have rows in every column. The state fuzzer damages them.
#pragma once

#include "fuzz/asset_samples.h"
#include "fuzz/edits.h"
#include "support/rigs/vehicle_rig.h"

namespace fuzz {

/// A game column that all of them have.
struct Purse {
    std::uint64_t coins;
    std::int32_t luck;
    std::uint32_t phase;
};
template <class V> constexpr void describe(Purse& p, V&& v) {
    v("coins", p.coins), v("luck", p.luck), v("phase", p.phase);
}
struct Bruise {
    std::int32_t points;
};
template <class V> constexpr void describe(Bruise& b, V&& v) { v("points", b.points); }

namespace detail {

using namespace lockstone::test::scene;

inline World empty_world(std::shared_ptr<const AssetLibrary> assets = nullptr) {
    WorldDef def;
    def.bodies_max = def.shapes_max = 12;
    def.contacts_max = 32;
    def.fields_max = def.pair_filters_max = def.characters_max = def.vehicles_max = 2;
    def.joints_max = 8;
    def.sleep_time = real(0.05);
    GameSchema schema;
    schema.add_record<Purse>("game.purse");
    schema.add_body_column<Bruise>("game.bruise");
    return made(World::create(def, schema, std::move(assets)));
}

/// A sleeping crate, a ball that moves over a belt, a sensor, water, bodies with a pair filter.
inline World world_of_blocks() {
    World w = empty_world();
    add_floor(w);
    const BodyId crate = add_crate(w, at(0, 0.5, 0));
    const BodyId ball = add(w, {.pose = at(2.2, 0.3, 0), .linear_velocity = vec(-1, -2, 0), .bullet = 1},
                            {.geometry = sphere(real(0.3)), .restitution = real(0.5)});
    const BodyId belt =
        add(w, {.kind = BodyKind::kinematic, .pose = at(3, -0.4, 0)},
            {.geometry = box(vec(1, 0.5, 1)), .surface_velocity = vec(1, 0, 0), .one_way = 1});
    made(w.create_shape(crate,
                        {.geometry = capsule(real(0.2), real(0.4)), .local = at(0, 1, 0), .sensor = 1}));
    made(w.create_field(water({.kind = RegionKind::box, .pose = at(3, 0, 0), .half_extent = vec(1, 1, 1)})));
    done(w.set_pair_filter(crate, belt, false));
    done(w.write(Column<Purse>{0}, Purse{7, -1, 2}));
    done(w.write(Column<Bruise>{1}, ball, Bruise{3}));
    done(w.destroy(add_ball(w, at(0, 5, 0)))); // leaves a free slot
    return w;
}

/// Joints of several kinds, hulls, a compound and a mesh, a sleeping pair.
inline World world_of_joints() {
    AssetLibrary library = library_with_hull();
    const Geometry hull = library.geometry(library.ids().front()).value();
    const auto add_asset = [&](const AssetBytes& bytes) {
        return library.geometry(library.add(std::span<const std::byte>(bytes)).value()).value();
    };
    const Geometry compound = add_asset(sample_compound()), mesh = add_asset(sample_mesh(false));
    World w = empty_world(std::make_shared<const AssetLibrary>(std::move(library)));
    add_floor(w);
    add(w, {.kind = BodyKind::static_, .pose = at(4, 0, 4)}, {.geometry = mesh});
    const BodyId stone = add(w, {.pose = at(4.2, 0.4, 4.2)}, {.geometry = hull});
    const BodyId lower = add(w, {.pose = at(0, 3, 0)}, {.geometry = compound});
    const BodyId door = add_crate(w, at(-3, 1.2, 0)), ball = add_ball(w, at(-3, 0.5, 2));
    JointDef hinge = hinge_joint();
    hinge.axis[about_x].mode = AxisMode::limited;
    hinge.axis[about_x].lower = real(-1), hinge.axis[about_x].upper = real(1);
    hinge.axis[about_x].motor_speed = real(2), hinge.axis[about_x].motor_force = real(50);
    hinge.break_force = Real(1000000);
    made(w.create_joint(hinge, {}, door, at(-3.5, 1.2, 0)));
    JointDef socket = ball_joint();
    socket.swing = real(0.7);
    made(w.create_joint(socket, door, ball, at(-3, 0.8, 1)));
    JointDef rope = rope_joint(Real(4));
    rope.body_b = lower, rope.frame_a = at(0, 6, 0);
    made(w.create_joint(rope));
    made(w.create_joint(weld_joint(real(3)), stone, lower, at(2, 2, 2)));
    add_crate(w, at(8, 0.5, 0));
    return w;
}

/// A driving car, and a character that walks to a crate.
inline World world_of_drivers() {
    World w = empty_world();
    add_floor(w);
    const BodyId chassis =
        add(w, {.pose = at(0, 0.8, 0), .mass = Real(1200)}, {.geometry = box(vec(0.8, 0.3, 2))});
    VehicleDef car = four_wheels(chassis, {0.75_r, -0.3_r, 1.4_r});
    const VehicleId id = made(w.create_vehicle(car));
    done(w.set_vehicle_input(id, {.throttle = 1_r, .steer = 0.3_r}));
    const CharacterId walker = made(w.create_character({.position = vec(4, 0, 0)}));
    done(w.set_character_input(walker, {vec(3, 0, 0), 0, 0}));
    add_crate(w, at(4.9, 0.5, 0));
    return w;
}

} // namespace detail

inline constexpr std::size_t base_count = 3;

/// A world at three successive ticks.
struct Base {
    lockstone::World before, now, after;
    lockstone::Image image_before, image; ///< of `before` and `now`
    Buffer portable;                      ///< of `now`
    Buffer delta;                         ///< from `now` to `after`

    explicit Base(lockstone::World start)
        : before(std::move(start)), now(before.clone()), after(before.clone()) {
        for (int i = 0; i < 11; ++i) before.tick();
        const Buffer at = before.save_portable();
        for (lockstone::World* w : {&now, &after}) lockstone::test::scene::done(w->restore_portable(at));
        now.tick(), after.tick(), after.tick();
        before.save(image_before), now.save(image);
        portable = now.save_portable();
        delta = after.save_delta(image);
    }
};

inline const Base& base_of(std::size_t index) {
    static const std::array<Base, base_count> all{
        Base(detail::world_of_blocks()), Base(detail::world_of_joints()), Base(detail::world_of_drivers())};
    return all[index];
}

} // namespace fuzz
