// One or two objects that drop on a floor, are stacked, are thrown at each other, or meet in space; and the laws for
// these cases.
//
//   Case c = draw_pair(seed);
//   std::string fault = pair_fault(c, track(c));
#pragma once

#include "law/zoo/object.h"

#include <optional>

namespace lockstone::zoo {

/// An object and its initial state.
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
    std::optional<Floor> floor;  ///< empty: in space, without gravity
    WorldDef def{};
    int ticks = 0; ///< the most ticks
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

/// A planted fault in the outcome. A law must report it.
enum class Wrong {
    nothing,
    pushed,    ///< the last object is 3 m/s faster from tick 10 on
    turned,    ///< the last object spins 3 rad/s faster from tick 10 on
    stuck,     ///< the last object stays where it is from tick 10 to 20, and keeps its velocity
    sunk,      ///< at the end, each object is 5 mm lower
    passed,    ///< no sweeps
    sleepless, ///< no sleep
    hung,      ///< each object sleeps 20 cm above its place
};

/// The measures of one object.
struct Part {
    double lowest_at_end = 0; ///< least height [m]
    /// least height of the centre of its core (of a hull: its centre of mass) at any tick [m]
    double centre_least = 0;
    double top_least = 0;    ///< least height of its highest point over all ticks [m]
    double speed_at_end = 0; ///< of its fastest point [m/s]
    double quickest = 0;     ///< greatest speed of its centre of mass [m/s]
};

/// The measures that the laws bound.
struct Track {
    std::vector<Part> parts;
    double energy_above_start = 0; ///< the most at any tick [J]
    double energy_allowed = 0;     ///< [J]
    double energy_at_start = 0;    ///< kinetic [J]
    double overlap_at_end = 0;     ///< of the two objects, at the end [m]
    double overlap_allowed = 0;    ///< [m]
    double quiet = 0;              ///< longest time in which all are at rest but not all asleep [s]
    double asleep_at = -1;         ///< [s]; -1: not all sleep
    int held = 0;                  ///< longest run of ticks in which an object has a speed but does not move
    double held_speed = 0;         ///< the greatest speed in such a run [m/s]
    double woken_way = 0;          ///< greatest motion of a point of a sleeping body, after all are woken [m]
    double momentum_off = 0;       ///< the most at the end, over the mass of both [m/s]
    double momentum_allowed = 0;   ///< [m/s]
    double spin_off = 0;           ///< angular momentum at the end less that of the start [kg m^2/s]
    double spin_allowed = 0;       ///< [kg m^2/s]
    double free_speed = 0;         ///< speed that one object reaches by its own fall and throw [m/s]
    int touching = 0;              ///< ticks in which the two objects touch
    bool moved_asleep = false;
    bool left = false; ///< an object has gone over the edge of the floor
    Faults faults{};
};
Track track(const Case& c, Wrong wrong = Wrong::nothing);

/// Laws. Each returns an error sentence, or an empty string if it holds.
std::string energy_law(const Case& c, const Track& t);  ///< the energy is never above the initial one
std::string depth_law(const Case& c, const Track& t);   ///< bodies at rest lie within 1 mm of their support
std::string passage_law(const Case& c, const Track& t); ///< no centre of mass gets below the floor
std::string asleep_law(const Case& c, const Track& t);  ///< bodies at rest fall asleep
std::string woken_law(const Case& c, const Track& t);   ///< sleeping bodies are at rest
std::string settled_law(const Case& c,
                        const Track& t); ///< objects that cannot roll sleep within the time of the case
/// Two objects that meet in space keep momentum and spin.
std::string momentum_law(const Case& c, const Track& t);
std::string held_law(const Case& c, const Track& t); ///< a body that the sweep stops loses its speed
/// The motion at `offset` equals that at the origin, bit by bit. `nudged`: there the last object begins 2^-32 m aside.
std::string far_law(const Case& c, Vec3 offset, bool nudged = false);

struct Law {
    const char* name;
    std::string (*fault)(const Case&, const Track&);
};
inline constexpr Law laws[] = {{"energy", energy_law},     {"depth", depth_law}, {"passage", passage_law},
                               {"asleep", asleep_law},     {"woken", woken_law}, {"settled", settled_law},
                               {"momentum", momentum_law}, {"held", held_law}};

} // namespace lockstone::zoo
