// A world whose ticks wake bodies, push them and change characters' shapes: each of these moves rows of the state while
// other parts of the tick use them.
#pragma once

#include "lockstone/testing.h"
#include "support/character_course.h"
#include "support/rigs/vehicle_rig.h"

#include <string>

namespace lockstone::test {

/// Two sleeping heaps of crates; two cars and two characters beside them.
struct MovingState {
    World w;
    BodyId car, other_car;
    CharacterId walker;

    static MovingState make() {
        using namespace scene;
        WorldDef def = drowsy_def();
        def.bodies_max = def.shapes_max = 128, def.contacts_max = 1024;
        def.vehicles_max = def.characters_max = 2;
        MovingState out{made(World::create(def)), {}, {}, {}};
        add_floor(out.w);
        for (int i = 0; i < 27; ++i) add_crate(out.w, at(i % 3 * 1.0, 0.5 + i / 9 * 1.0, i / 3 % 3 * 1.0));
        for (int i = 0; i < 8; ++i)
            add_crate(out.w, at(20 + i % 2 * 1.0, 0.5 + i / 4 * 1.0, i / 2 % 2 * 1.0));
        for (int i = 0; i < 2; ++i) {
            const BodyId car =
                add(out.w, {.pose = at(-12 - 6 * i, 1, 0)},
                    {.geometry = box(0.9_r, 0.3_r, 2_r), .local = at(0, 0.3, 0), .density = 150_r});
            made(out.w.create_vehicle(four_wheels(car, {0.78_r, -0.25_r, 1.35_r})));
            (i == 0 ? out.car : out.other_car) = car;
        }
        out.walker = character::add_character(out.w, 20, 0.01, -4);
        character::add_character(out.w, 30, 0.01, 0);
        for (int t = 0; t < 400; ++t) out.w.tick();
        return out;
    }
    /// Applies the commands of tick `t`, then ticks. One car falls onto the first heap. The character walks into the
    /// second heap, crouches and jumps.
    void play(int t) {
        using namespace scene;
        if (t == 2) {
            done(w.set_pose(car, at(1, 3.8, 1))), done(w.set_pose(other_car, at(-18, 1.5, 0)));
            done(w.set_vehicle_input(w.vehicle_at(1), {.throttle = 1_r, .steer = 0.5_r}));
        }
        character::drive(w, walker, 0, 3, t % 40 == 30, t % 20 >= 15);
        w.tick();
    }
};

/// Plays two copies; the second copy moves its state whenever it may. Returns the first tick after which they differ,
/// as a sentence.
inline std::string moving_state_differs(int ticks) {
    MovingState first = MovingState::make();
    if (first.w.awake_count() > 2) return "the heaps do not sleep";
    // Saved and loaded, so that no table has spare capacity.
    MovingState still{scene::made(World::create(first.w.def())), first.car, first.other_car, first.walker};
    scene::done(still.w.restore_portable(first.w.save_portable()));
    MovingState moving{still.w.clone(), first.car, first.other_car, first.walker};
    testing::state_of(still.w).move_at_every_chance(false);
    testing::state_of(moving.w).move_at_every_chance(true);
    std::uint32_t awake = 0;
    for (int t = 0; t < ticks; ++t) {
        still.play(t), moving.play(t);
        awake = std::max(awake, still.w.awake_count());
        if (still.w.hash() != moving.w.hash())
            return "tick " + std::to_string(t) + ": " + scene::difference(still.w, moving.w);
    }
    return awake < 20 ? "few bodies wake: " + std::to_string(awake) : "";
}

} // namespace lockstone::test
