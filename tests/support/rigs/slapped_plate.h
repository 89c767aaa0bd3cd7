// Thin plates that fall, hit the floor with one edge, and slap down. For the tests and for the planted faults.
#pragma once

#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <algorithm>
#include <cmath>

namespace lockstone::test {

struct Plate {
    double length, width, thickness; ///< half extents [m]
    double tilt, roll;               ///< about z and about x at the start [rad]
    double height;                   ///< of its centre at the start [m]
    double spin_x, spin_z;           ///< [rad/s]
    int floor;                       ///< 0: a plane, 1: a box, 2: nine boxes with seams
};

/// A plate of 0.3 to 3 m that is 20 to 300 times as long as thick, or as thin as 8 mm.
inline Plate draw_plate(SplitMix& random) {
    Plate plate{};
    plate.length = 0.15 * std::pow(10.0, drawn(random, 0, 1));
    plate.width = plate.length * drawn(random, 0.3, 1);
    plate.thickness = 0.004 * std::pow(5.0, drawn(random, 0, 1));
    const double most = random.one_in(2) ? 0.06 : 0.6;
    plate.tilt = drawn(random, -most, most);
    plate.roll = drawn(random, -most, most);
    plate.height = plate.length + drawn(random, 0.5, 2.5);
    plate.spin_x = drawn(random, -2, 2);
    plate.spin_z = drawn(random, -2, 2);
    plate.floor = static_cast<int>(random.below(3));
    return plate;
}

inline void add_plate_floor(World& w, int kind) {
    using namespace scene;
    if (kind == 0) {
        add_floor(w);
        return;
    }
    const int side = kind == 2 ? 1 : 0;
    const double half = kind == 2 ? 2 : 8;
    for (int x = -side; x <= side; ++x)
        for (int z = -side; z <= side; ++z)
            add_wall(w, at(2 * half * x, -1, 2 * half * z), vec(half, 1, half));
}

/// Returns how deep the lowest corner of the plate gets into the floor within 4 s [m].
inline double slap_depth(const Plate& plate, std::uint32_t tick_rate) {
    using namespace scene;
    constexpr double degrees = 180 / 3.14159265358979323846;
    WorldDef def;
    def.tick_rate = tick_rate;
    World w = made(World::create(def));
    add_plate_floor(w, plate.floor);
    const Quat turn = normalized(turned(axis_x, plate.roll * degrees) * turned(axis_z, plate.tilt * degrees));
    const BodyId body =
        add(w, {.pose = at(0, plate.height, 0, turn), .angular_velocity = vec(plate.spin_x, 0, plate.spin_z)},
            {.geometry = box(real(plate.length), real(plate.thickness), real(plate.width))});
    double deepest = 0;
    for (std::uint32_t t = 0; t < 4 * tick_rate; ++t) {
        w.tick();
        const Transform pose = w.pose(body);
        for (unsigned corner = 0; corner < 8; ++corner) {
            const auto side = [&](unsigned bit, double extent) {
                return real((corner & bit) != 0 ? extent : -extent);
            };
            const Vec3 local{side(1, plate.length), side(2, plate.thickness), side(4, plate.width)};
            deepest = std::max(deepest, -to_double((pose.position + rotate(pose.rotation, local)).y));
        }
    }
    return deepest;
}

struct Slaps {
    int deep = 0;       ///< plates that get deeper than 10 mm
    double deepest = 0; ///< [m]
};
/// Drops random plates at 60 Hz.
inline Slaps slap_many(int count) {
    Slaps out;
    for (int seed = 1; seed <= count; ++seed) {
        SplitMix random(static_cast<std::uint64_t>(seed));
        const double depth = slap_depth(draw_plate(random), 60);
        out.deep += depth > 0.01 ? 1 : 0;
        out.deepest = std::max(out.deepest, depth);
    }
    return out;
}

} // namespace lockstone::test
