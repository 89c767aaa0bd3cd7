// Runs one pair of shapes through the lanes of an instruction set.
#pragma once

#include "solve/kernels/kernels.h"
#include "solve/pairs/pair_kernel.h"

#include <vector>

namespace lockstone::tests {

/// The place of B relative to A, whose frame is the world's.
struct PairStand {
    CoordinateVec3 position;
    Quat rotation;
    Coordinate reach; ///< of B's points
    Length thinnest;
    Length margin;
};
struct Recycled {
    bool serves;
    std::vector<solve::PairContact> contacts; ///< by row, where they are valid
};

inline Recycled recycle(std::span<const solve::ContactMemory> rows, const PairStand& now,
                        Simd level = best_simd()) {
    const Quat straight = Quat::identity();
    const Rotation axes = Rotation::identity();
    const solve::Velocity rest{};
    solve::PairLane lane{};
    for (int i = 0; i < 3; ++i) {
        lane.way.v[i] = now.position[i].raw * 256;
        lane.kept.v[i] = rows[0].made_position[i].raw;
    }
    lane.rotation_a = &straight, lane.rotation_b = &now.rotation, lane.axes_a = &axes;
    lane.made_rotation = &rows[0].made_rotation;
    lane.velocity_a = lane.velocity_b = &rest;
    lane.limit = solve::recycling_limit(rows, now.reach, now.thinnest).raw;
    lane.reach = static_cast<std::int32_t>(now.reach.raw);
    std::vector<solve::PairRow> lanes;
    for (const solve::ContactMemory& row : rows) lanes.push_back({&lane, &row});
    std::vector<solve::PairPlace> places(rows.size());
    std::vector<std::uint8_t> serves(rows.size());
    Recycled out{false, std::vector<solve::PairContact>(rows.size())};
    solve::kernels_of(level)->pairs->find({solve::PairWork::recycle, lanes.data(),
                                           static_cast<std::uint32_t>(rows.size()), unit_one, places.data(),
                                           out.contacts.data(), serves.data()});
    out.serves = serves[0] != 0 && solve::covers(rows[0], now.margin);
    return out;
}

} // namespace lockstone::tests
