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

Real steer_angle(const VehicleDef& def, std::uint32_t wheel, Real steer) {
    const WheelDef& own = def.wheel[wheel];
    if (own.steer_max == Real{} || steer == Real{} || def.tracks.enabled != 0) return Real{};
    const Real parallel = -steer * own.steer_max;
    if (def.ackermann == Real{}) return parallel;
    // The wheels that do not steer stand on the line of the turning centre; if all do, the mean of all is it.
    Real fixed{}, fixed_count{}, all{};
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        all += def.wheel[i].attachment.z;
        if (def.wheel[i].steer_max != Real{}) continue;
        fixed += def.wheel[i].attachment.z;
        fixed_count += Real(1);
    }
    const Real line = fixed_count > Real{} ? fixed / fixed_count : all / Real(def.wheel_count);
    Real ahead = own.attachment.z - line, slope = tan(parallel);
    if (ahead == Real{}) return parallel;
    if (ahead < Real{}) ahead = -ahead, slope = -slope; // a rear axle, seen in the mirror
    const Real ideal = atan2(ahead * slope, ahead - own.attachment.x * slope);
    const Real turned = own.attachment.z < line ? -ideal : ideal;
    return parallel + (turned - parallel) * def.ackermann;
}

} // namespace lockstone::sim
