// Rows of the table: a scene, what is measured in it, the bound of each figure, and a twin that misses it.
#pragma once

#include "engines/scene.h"

#include <functional>
#include <limits>

namespace quality {

using namespace engines;

/// One figure: an error or a size, the smaller the better; 0 is perfect.
struct Value {
    std::string what, unit;
    double bound; ///< the largest that is good
};

/// How to run a row.
struct Plan {
    bool quick = false; ///< smaller and shorter, for the default tests; the bounds stay
    int planted = -1;   ///< the figure of this index has to miss its bound: something in the scene is wrong
    bool plants(int value) const { return planted == value; }
};

inline constexpr double unsupported = std::numeric_limits<double>::quiet_NaN();

/// What came out: as many figures as the row has values; none when the contestant cannot run the row.
struct Figures {
    std::vector<double> values = {};
    double seconds_per_tick = 0;
};

struct Row {
    std::string name, about;
    std::vector<Value> values;
    bool in_sample; ///< run by the default tests: small enough, and within its bounds
    std::function<Figures(const Contestant&, const Plan&)> run;
    bool precise = false; ///< Lockstone runs it as WorldDef::precise(): its default is not made for that
};

std::vector<Row> stack_rows();       ///< towers, houses of cards, arches, heavy on light
std::vector<Row> pile_rows();        ///< coming to rest, energy in a closed box
std::vector<Row> surface_rows();     ///< friction, rolling, bouncing, belts
std::vector<Row> domino_rows();      ///< a wave of dominoes
std::vector<Row> free_motion_rows(); ///< spinning bodies and orbits

std::vector<Row> joint_rows(); ///< chains, bridges, ragdolls, pendulums, motors, limits, tops

} // namespace quality
