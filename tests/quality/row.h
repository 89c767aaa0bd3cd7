// Rows of the table: a scene, its measured figures, the bound of each figure, and a planted fault that exceeds it.
#pragma once

#include "engines/scene.h"

#include <functional>
#include <limits>

namespace quality {

using namespace engines;

/// One figure: an error or a size. Smaller is better; 0 is perfect.
struct Value {
    std::string what, unit;
    double bound; ///< the largest accepted value
};

/// How to run a row.
struct Plan {
    bool quick = false; ///< smaller and shorter, for the default tests; the bounds do not change
    /// the figure that must exceed its bound, because the scene has a planted fault; -1: none
    int planted = -1;
    bool plants(int value) const { return planted == value; }
};

inline constexpr double unsupported = std::numeric_limits<double>::quiet_NaN();

/// The results: one figure for each value of the row; none when the contestant cannot run the row.
struct Figures {
    std::vector<double> values = {};
    double seconds_per_tick = 0;
};

struct Row {
    std::string name, about;
    std::vector<Value> values;
    bool in_sample; ///< the default tests run it: it is small and within its bounds
    std::function<Figures(const Contestant&, const Plan&)> run;
    /// Lockstone runs it as WorldDef::precise(), because its default is not made for it
    bool precise = false;
};

std::vector<Row> stack_rows();       ///< towers, houses of cards, arches, heavy on light
std::vector<Row> pile_rows();        ///< time to rest, energy in a closed box
std::vector<Row> surface_rows();     ///< friction, rolling, bouncing, belts
std::vector<Row> domino_rows();      ///< a wave of dominoes
std::vector<Row> free_motion_rows(); ///< spinning bodies and orbits

std::vector<Row> joint_rows(); ///< chains, bridges, ragdolls, pendulums, motors, limits, tops

} // namespace quality
