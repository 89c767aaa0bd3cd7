// What vehicles compute besides the solver: curves, tyres, shares of weight, steering.
#include "play/vehicle/vehicle.h"

#include "lockstone/math/math.h"

namespace lockstone::sim {

namespace {

/// The share that is linear in the place: share = a + b x + c z, with sum 1 and no moment about the centre.
void find_shares(WeightShares& out) {
    Mat3 gram{};
    for (std::uint32_t i = 0; i < out.wheel_count; ++i) {
        const Vec3 row{Real(1), out.at[i].x, out.at[i].z};
        gram.x += row;
        gram.y += row * out.at[i].x;
        gram.z += row * out.at[i].z;
    }
    const Mat3 inv = inverse(gram);
    const Real least = decimal<Real>("0.02") / Real(out.wheel_count);
    bool good = true;
    for (std::uint32_t i = 0; i < out.wheel_count; ++i) {
        out.share[i] = inv.x.x + inv.x.y * out.at[i].x + inv.x.z * out.at[i].z;
        good = good && out.share[i] >= least && out.share[i] <= Real(1);
    }
    for (std::uint32_t i = 0; i < out.wheel_count && !good; ++i)
        out.share[i] = Real(1) / Real(out.wheel_count);
}

} // namespace

void find_shares(const VehicleDef& def, Vec3 center, WeightShares& known) {
    bool same = known.wheel_count == def.wheel_count;
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const Vec3 at = def.wheel[i].attachment - center;
        same = same && known.at[i] == at;
        known.at[i] = at;
    }
    known.wheel_count = def.wheel_count;
    if (!same) find_shares(known);
}

void find_steer_angles(const VehicleDef& def, Real steer, VehicleMemory& out) {
    // The wheels that do not steer stand on the line of the turning centre; if all do, the mean of all is it.
    Real fixed{}, fixed_count{}, all{};
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        out.wheel[i].steer = Real{};
        all += def.wheel[i].attachment.z;
        if (def.wheel[i].steer_max != Real{}) continue;
        fixed += def.wheel[i].attachment.z;
        fixed_count += Real(1);
    }
    if (steer == Real{} || def.tracks.enabled != 0) return;
    const Real line = fixed_count > Real{} ? fixed / fixed_count : all / Real(def.wheel_count);
    Real known{}, known_slope{}; // wheels that steer as far have one slope
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const WheelDef& own = def.wheel[i];
        if (own.steer_max == Real{}) continue;
        const Real parallel = out.wheel[i].steer = -steer * own.steer_max;
        Real ahead = own.attachment.z - line;
        if (def.ackermann == Real{} || ahead == Real{}) continue;
        if (parallel != known) known = parallel, known_slope = tan(parallel);
        Real slope = known_slope;
        if (ahead < Real{}) ahead = -ahead, slope = -slope; // a rear axle, seen in the mirror
        const Real ideal = atan2(ahead * slope, ahead - own.attachment.x * slope);
        const Real turned = own.attachment.z < line ? -ideal : ideal;
        out.wheel[i].steer = parallel + (turned - parallel) * def.ackermann;
    }
}

} // namespace lockstone::sim
