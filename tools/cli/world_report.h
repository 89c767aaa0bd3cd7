// Figures about a world at the end of a run, and the cost of its snapshots.
#pragma once

#include "cli/timing.h"
#include "lockstone/world.h"
#include "json/json.h"

#include <map>

namespace lockstone::cli {

SnapshotCost measure_snapshot(const World& world);

/// Stores where bodies start, and reports at the end how far they moved.
class WorldReport {
  public:
    explicit WorldReport(const World& start);
    void add_tick(double microseconds, const World& world);
    /// The report. Lengths are in metres, energies in joules, times in microseconds.
    json::Value json(World& end) const;

  private:
    std::map<BodyId, Vec3> start_positions; ///< of dynamic bodies
    std::vector<double> tick_us;
    double penetration_ever = 0;
};

} // namespace lockstone::cli
