// Models from other sources: each is cooked as mesh, hull and convex parts; balls fall on the mesh, and the hull falls
// on floors.
//
//   Row row = row_of("duck.dae", {});
//   for (const std::string& finding : row.findings) ...
#pragma once

#include "cook/cook.h"

#include <string>
#include <vector>

namespace lockstone::corpus {

/// Planted faults. Each must end as a finding.
enum class Planted {
    none,
    refused,  ///< a refusal of every kind, with a sentence that names no flag
    far,      ///< the reported deviation is a third of the model
    slow,     ///< parts take 20 s of processor time, and are 40
    silent,   ///< a mesh that is inside out has no note
    holes,    ///< the mesh lacks every second triangle
    lifted,   ///< balls are thrown up after a second
    restless, ///< balls do not sleep
    sunk,     ///< the hull's corners are 1 cm below those in the engine
};
const std::vector<std::pair<std::string, Planted>>& planted_faults();

/// One kind of asset: made, or the sentence of its refusal.
struct Tried {
    bool made = false, good = false;
    std::string sentence; ///< reason of the refusal
    double share = 0;     ///< deviation, relative to the model's largest extent
    std::size_t parts = 0;
    double seconds = 0; ///< processor time
};

struct Row {
    std::string model;
    std::string sound; ///< "sound", or the fault of the surface
    double scale = 1;  ///< scale of the cooked model
    Tried mesh, hull, convex;
    std::size_t balls = 0, passed = 0; ///< balls that fell on the mesh, and those that passed through it
    double balls_asleep_at = 0;        ///< [s] time of the last one; -1: one is awake at the end
    double deepest = 0;                ///< [m] of the hull in a floor, at the end
    double hull_asleep_at = 0;         ///< [s] on the last floor; -1: awake at the end
    std::vector<std::string> findings;

    std::string text() const; ///< columns with tabs between
};

Row row_of(const std::string& path, Planted planted);

// The steps of row_of(). Each adds findings.
void drop_balls(Row& row, const cook::Soup& model, cook::CookOptions options, Planted planted);
void drop_hull(Row& row, const cook::Cooked& hull, Planted planted);

} // namespace lockstone::corpus
