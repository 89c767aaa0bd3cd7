// One object or two, dropped on a floor, stacked, thrown at each other, or meeting in space; and the laws that hold for them.
//
//   Case c = draw_pair(seed);
//   std::string fault = pair_fault(c, track(c));
#pragma once

#include "law/zoo/object.h"

#include <optional>

namespace lockstone::zoo {

/// An object and how it begins.
struct Thrown {
    Object object;
    Transform pose{};
    Vec3 velocity{}, spin{};
    double density = 1000;
    double mass_ratio = 0; ///< its mass over that of the first object; 0: its mass follows from its density
};

struct Case {
    std::uint64_t seed = 0;
    const char* kind = "drop";
    std::vector<Thrown> objects; ///< one or two
    std::optional<Floor> floor;  ///< none: in space, without gravity
    WorldDef def{};
    int ticks = 0; ///< at most
    std::string about() const;
};

Case draw_single(std::uint64_t seed); ///< draw_drop(seed)
Case draw_shot(
    std::uint64_t seed); ///< an object at 5 to 300 m/s, with a spin of up to 1000 rad/s, at any floor
Case draw_pair(
    std::uint64_t seed); ///< one lies on a floor, or falls; the other is stacked on it or thrown at it
Case draw_meeting(std::uint64_t seed); ///< two meet in space

/// The world of a case, moved by `offset`.
struct Stage {
    World world;
    std::vector<BodyId> bodies;
};
Stage stage(const Case& c, Vec3 offset = {});

/// A wrong outcome, made on purpose: a law must report it.
enum class Wrong {
    nothing,
    pushed,    ///< the last object is 3 m/s faster from tick 10 on
    turned,    ///< the last object spins 3 rad/s faster from tick 10 on
    stuck,     ///< the last object stays where it is from tick 10 to 20, and keeps its velocity
    sunk,      ///< each object is 5 mm lower when all is over
    passed,    ///< nothing is swept
    sleepless, ///< nothing falls asleep
    hung,      ///< each object sleeps 20 cm above its place
};

/// The measures of one object.
struct Part {
    double lowest_at_end = 0; ///< least height [m]
    double centre_least = 0;  ///< least height of its core's centre, of a hull that of mass, at any tick [m]
    double top_least = 0;     ///< least height of its highest point at any tick [m]
    double speed_at_end = 0;  ///< of its fastest point [m/s]
    double quickest = 0;      ///< greatest speed of its centre of mass [m/s]
};

/// The measures that the laws bound.
struct Track {
    std::vector<Part> parts;
    double energy_above_start = 0; ///< the most at any tick [J]
    double energy_allowed = 0;     ///< [J]
    double energy_at_start = 0;    ///< kinetic [J]
    double overlap_at_end = 0;     ///< of the two objects, after all is over [m]
    double overlap_allowed = 0;    ///< [m]
    double quiet = 0;              ///< longest time that all are at rest and not all asleep [s]
    double asleep_at = -1;         ///< [s]; -1: not all sleep
    int held = 0;                  ///< longest run of ticks in which an object is fast and does not go
    double held_speed = 0;         ///< at most in such a run [m/s]
    double woken_way = 0;          ///< farthest way of a point that sleeps, after all are woken [m]
    double momentum_off = 0;       ///< the most at the end, over the mass of both [m/s]
    double momentum_allowed = 0;   ///< [m/s]
    double spin_off = 0;           ///< angular momentum at the end less that of the start [kg m^2/s]
    double spin_allowed = 0;       ///< [kg m^2/s]
    double free_speed = 0;         ///< that one object reaches by its own fall and throw [m/s]
    int touching = 0;              ///< ticks in which the two objects touch
    bool moved_asleep = false;
    bool left = false; ///< an object has gone over the edge of the floor
    Faults faults{};
};
Track track(const Case& c, Wrong wrong = Wrong::nothing);

/// Laws: each returns what does not hold, in a sentence, or nothing.
std::string energy_law(const Case& c, const Track& t);  ///< energy never rises above that of the start
std::string depth_law(const Case& c, const Track& t);   ///< what rests lies within 1 mm of what it rests on
std::string passage_law(const Case& c, const Track& t); ///< no centre of mass gets below the floor
std::string asleep_law(const Case& c, const Track& t);  ///< what rests falls asleep
std::string woken_law(const Case& c, const Track& t);   ///< what sleeps is at rest
std::string settled_law(const Case& c,
                        const Track& t); ///< what cannot roll sleeps within the time of the case
std::string momentum_law(const Case& c, const Track& t); ///< two that meet in space keep momentum and spin
std::string held_law(const Case& c, const Track& t);     ///< what the sweep stops loses its speed
/// The motion `offset` away equals that at the origin, bit by bit. `nudged`: the last object begins 2^-32 m aside there.
std::string far_law(const Case& c, Vec3 offset, bool nudged = false);

struct Law {
    const char* name;
    std::string (*fault)(const Case&, const Track&);
};
inline constexpr Law laws[] = {{"energy", energy_law},     {"depth", depth_law}, {"passage", passage_law},
                               {"asleep", asleep_law},     {"woken", woken_law}, {"settled", settled_law},
                               {"momentum", momentum_law}, {"held", held_law}};

} // namespace lockstone::zoo
