// Worlds for characters: short functions that place a character, drive it and return its place.
#pragma once

#include "support/sim_scenes.h"

namespace lockstone::test::character {

using namespace lockstone::test::scene;

inline CharacterId add_character(World& w, double x, double y, double z, CharacterDef def = {}) {
    def.position = vec(x, y, z);
    return made(w.create_character(def));
}
inline D3 feet(const World& w, CharacterId c) { return to_double(w.pose(w.body_of(c)).position); }
inline bool stands(const World& w, CharacterId c) {
    return w.character_state(c).ground == CharacterGround::walkable;
}
inline void drive(World& w, CharacterId c, double x, double z, bool jump = false, bool crouch = false) {
    done(w.set_character_input(c, {vec(x, 0, z), jump ? 1u : 0u, crouch ? 1u : 0u}));
}
inline void run(World& w, int ticks) {
    for (int i = 0; i < ticks; ++i) w.tick();
}
/// A ramp that rises towards +x from the origin, `degrees` steep, 20 m long.
inline BodyId add_ramp(World& w, double degrees) {
    const double a = degrees * 3.14159265358979323846 / 180;
    return add_wall(w,
                    at(10 * std::cos(a) + 0.5 * std::sin(a), 10 * std::sin(a) - 0.5 * std::cos(a), 0,
                       turned(axis_z, degrees)),
                    vec(10, 0.5, 5));
}
/// `count` stairs of a height and depth from x = 1 on.
inline void add_stairs(World& w, int count, double height, double depth) {
    for (int i = 0; i < count; ++i)
        add_wall(w, at(1 + (i + 0.5) * depth, (i + 1) * height / 2, 0),
                 vec(depth / 2, (i + 1) * height / 2, 3));
    const double top = count * height;
    add_wall(w, at(1 + count * depth + 5, top / 2, 0), vec(5, top / 2, 3));
}
/// How deep a character's capsule is in any shape that it does not ignore; 0 without overlap.
inline double overlap(const World& w, CharacterId c) {
    const CharacterDef def = w.character(c);
    const bool crouched = w.character_state(c).crouched != 0;
    const Real height = crouched ? def.crouch_height : def.height;
    const Real middle = half(height);
    double depth = 0;
    // A capsule that is thinner by the depth no longer overlaps.
    for (const double less : {0.0, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05}) {
        Transform pose = w.pose(w.body_of(c));
        pose.position += Vec3{0_r, middle, 0_r};
        std::vector<ShapeId> shapes;
        w.overlap(capsule(def.radius - real(less), middle - def.radius), pose, {.ignore = w.body_of(c)},
                  shapes);
        if (shapes.empty()) return depth;
        depth = less == 0 ? 0.0001 : less;
    }
    return depth;
}

} // namespace lockstone::test::character
