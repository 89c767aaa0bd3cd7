// What vehicles compute besides the solver: curves, tyres, shares of weight, steering.
#include "play/vehicle/vehicle.h"

#include "lockstone/math/math.h"

namespace lockstone::sim {

Real curve_at(std::span<const CurvePoint> curve, Real x) {
    if (x <= curve.front().x) return curve.front().y;
    for (std::size_t i = 1; i < curve.size(); ++i) {
        const CurvePoint &a = curve[i - 1], &b = curve[i];
        if (x > b.x) continue;
        return b.x > a.x ? a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x)) : b.y;
    }
    return curve.back().y;
}

std::array<Real, vehicle_wheels_max> sprung_shares(const VehicleDef& def, Vec3 center) {
    // The share that is linear in the place: share = a + b x + c z, with sum 1 and no moment about the centre.
    std::array<Real, vehicle_wheels_max> shares{};
    const std::uint32_t n = def.wheel_count;
    Mat3 gram{};
    for (std::uint32_t i = 0; i < n; ++i) {
        const Vec3 at = def.wheel[i].attachment - center;
        const Vec3 row{Real(1), at.x, at.z};
        gram.x += row;
        gram.y += row * at.x;
        gram.z += row * at.z;
    }
    const Mat3 inv = inverse(gram);
    const Real least = decimal<Real>("0.02") / Real(n);
    bool good = true;
    for (std::uint32_t i = 0; i < n; ++i) {
        const Vec3 at = def.wheel[i].attachment - center;
        shares[i] = inv.x.x + inv.x.y * at.x + inv.x.z * at.z;
        good = good && shares[i] >= least && shares[i] <= Real(1);
    }
    for (std::uint32_t i = 0; i < n && !good; ++i) shares[i] = Real(1) / Real(n);
    return shares;
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
