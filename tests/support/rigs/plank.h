// A car that drives over a plank. For the tests and for the planted faults.
#pragma once

#include "support/rigs/vehicle_rig.h"
#include "support/split_mix.h"

#include <string>

namespace lockstone::test {

/// The wheels of one side of a car of 1,200 kg pass over a plank of 1 to 200 kg. Returns a sentence if a corner of the
/// plank is ever more than 5 mm below the ground, or if the plank jumps by more than 10 cm.
inline std::string plank_fault(std::uint64_t seed) {
    using namespace vehicle;
    SplitMix random(seed);
    const auto drawn = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random.below(1000)) / 999;
    };
    Setting setting;
    setting.world = random.below(2) == 0 ? WorldDef{} : WorldDef::precise();
    setting.pose = at(0, 0.8, -6);
    Rig rig = make_car(setting);
    const double mass = std::pow(10.0, drawn(0, 2.3)), wide = drawn(0.08, 0.2), thick = drawn(0.01, 0.025),
                 length = drawn(0.4, 1.2);
    BodyDef plank{.pose = at(0.75, thick, 1)};
    plank.mass = real(mass);
    const BodyId body = add(rig.w, plank, {.geometry = box(real(wide), real(thick), real(length))});
    VehicleInput input{};
    input.throttle = real(drawn(0.1, 0.6));
    rig.drive(input);
    double deepest = 0, highest = 0;
    for (int t = 0; t < 600; ++t) {
        rig.w.tick();
        const Transform pose = rig.w.pose(body);
        for (unsigned corner = 0; corner < 8; ++corner) {
            const auto side = [&](unsigned bit, double extent) {
                return real((corner & bit) != 0 ? extent : -extent);
            };
            const Vec3 place =
                pose.position + rotate(pose.rotation, Vec3{side(1, wide), side(2, thick), side(4, length)});
            deepest = std::max(deepest, -to_double(place.y)), highest = std::max(highest, to_double(place.y));
        }
    }
    if (deepest <= 0.005 && highest <= 0.1 + 2 * thick) return {};
    return "seed " + std::to_string(seed) + ": a plank of " + std::to_string(mass) + " kg is " +
           std::to_string(deepest) + " m in the ground, its highest corner at " + std::to_string(highest) +
           " m";
}

} // namespace lockstone::test
