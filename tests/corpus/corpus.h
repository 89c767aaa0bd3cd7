// Models that others made: each is cooked as mesh, hull and convex parts, balls fall on the mesh, the hull falls on floors.
//
//   Row row = row_of("duck.dae", {});
//   for (const std::string& finding : row.findings) ...
#pragma once

#include "cook/cook.h"

#include <string>
#include <vector>

namespace lockstone::corpus {

/// Faults on purpose: each ends as a finding.
enum class Planted {
    none,
    refused,  ///< every kind, with a sentence that names no flag
    far,      ///< the deviation of what is made is a third of the model
    slow,     ///< parts take 20 s of a processor, and are 40
    silent,   ///< an inside-out mesh has no note
    holes,    ///< balls fall on a mesh that lacks every second triangle
    lifted,   ///< balls are thrown up after a second
    restless, ///< balls do not sleep
    sunk,     ///< the hull's corners are 1 cm below where the engine has them
};
const std::vector<std::pair<std::string, Planted>>& planted_faults();

/// One kind of asset: made, or the sentence of the refusal.
struct Tried {
    bool made = false, good = false;
    std::string sentence; ///< why not
    double share = 0;     ///< the deviation, of the model's largest extent
    std::size_t parts = 0;
    double seconds = 0; ///< of a processor
};

struct Row {
    std::string model;
    std::string sound; ///< "sound", or what the surface is
    double scale = 1;  ///< that the model is cooked with
    Tried mesh, hull, convex;
    std::size_t balls = 0, passed = 0; ///< that fell on the mesh, and through it
    double balls_asleep_at = 0;        ///< [s] the last of them; -1: one is awake at the end
    double deepest = 0;                ///< [m] the hull in a floor, at the end
    double hull_asleep_at = 0;         ///< [s] on the last floor; -1: awake at the end
    std::vector<std::string> findings;

    std::string text() const; ///< columns with tabs between
};

Row row_of(const std::string& path, Planted planted);

// The steps of it; each adds findings.
void drop_balls(Row& row, const cook::Soup& model, cook::CookOptions options, Planted planted);
void drop_hull(Row& row, const cook::Cooked& hull, Planted planted);

} // namespace lockstone::corpus
