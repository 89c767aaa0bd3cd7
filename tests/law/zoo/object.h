// Single objects of any proportion, and their drops: objects of games that no built-in scene has.
//
//   Drop drop = draw_drop(seed);              an object, a floor, a throw, a tick rate
//   Outcome out = play(drop);
//   std::string fault = energy_fault(drop, out);
#pragma once

#include "law/zoo/floor.h"
#include "lockstone/world.h"
#include "support/split_mix.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace lockstone::zoo {

/// A shape, and the points whose convex hull, grown by `radius`, equals it; in double precision, for laws.
struct Object {
    Geometry geometry{};
    std::vector<std::array<double, 3>> corners; ///< about 64 of each disc
    std::vector<std::array<double, 2>> discs;   ///< radius and height of discs about the local y axis [m]
    std::vector<CompoundPart> parts;            ///< of a compound
    std::array<double, 3> core{};               ///< of a compound, the centre of its thickest part
    double radius = 0;                          ///< [m]
    double thickness = 0;                       ///< least extent [m]
    double size = 0;                            ///< greatest extent [m]
    double flatness = 0;                        ///< greatest distance of its sides from planes [m]
    bool rolls = false;                         ///< round in some direction
    std::string about;
    std::shared_ptr<AssetLibrary> assets; ///< the object's and the floor's
};

struct Drop {
    std::uint64_t seed = 0;
    Object object;
    Floor floor = Floor::plane;
    WorldDef def{};
    Transform pose{};
    Vec3 velocity{}, spin{};
    double density = 1000;
    int seconds = 12;
    std::string about() const;
};

/// Each side of the prism lies within `flatness` of a plane, like the sides of exported models.
Object draw_prism(test::SplitMix& random, double large, double small, double middle, double flatness);
Object draw_object(test::SplitMix& random);
Object draw_object(test::SplitMix& random, double size_least, double thickness_least);
/// Objects from 1 cm on, including rounded ones and compounds.
Object draw_any(test::SplitMix& random);
Drop draw_drop(std::uint64_t seed);
/// Draws with this generator and this function for objects.
Drop draw_drop(std::uint64_t seed, test::SplitMix random, Object (*draw)(test::SplitMix&));
/// An object of a baked hull.
Object object_of(const AssetBytes& hull, const std::string& about);
/// The object, rotated as the seed says, 30 cm above the floor; for a minute.
Drop drop_of(const Object& object, Floor floor, std::uint64_t seed);
/// A prism that falls flat. Its sides differ from planes by up to 2^-13 of its size.
Drop draw_flat_prism(std::uint64_t seed);
/// Drops a beam of 10.7 x 15.3 cm onto one of its long edges. The beam must roll onto a side and sleep.
struct Beam {
    double length, yaw_degrees, friction; ///< [m]
    bool precise;
};
std::string beam_fault(const Beam& beam);
/// The world of a drop, moved by `offset`; the object is its last body.
struct Played {
    World world;
    BodyId object;
};
Played begin(const Drop& drop, Vec3 offset = {});

/// The measures that the laws bound.
struct Outcome {
    double energy_above_start = 0; ///< the most at any tick, as a height to which it lifts the object [m]
    double highest = 0;            ///< centre of mass above its start [m]
    double lowest_at_end = 0;      ///< least height of the object after the last tick [m]
    double centre_at_least = 0;    ///< least height of the centre of mass [m]
    double speed_at_end = 0;       ///< of the fastest point [m/s]
    double asleep_at = -1;         ///< [s]; -1: awake at the end
    bool left = false;             ///< it has passed the edge of the floor
};
Outcome play(const Drop& drop);
/// Laws. Each returns an error sentence, or an empty string if it holds.
std::string energy_fault(const Drop& drop,
                         const Outcome& out);                 ///< the energy is never above the initial one
std::string rest_fault(const Drop& drop, const Outcome& out); ///< the object ends on the floor, asleep

} // namespace lockstone::zoo
