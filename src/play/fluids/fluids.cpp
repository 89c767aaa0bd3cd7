#include "play/fluids/fluids.h"
#include "base/poison.h"

#include "lockstone/math/math.h"
#include "scene/parts.h"
#include "shapes/shown_area.h"
#include "shapes/submerged.h"
#include "solve/bodies/region.h"

#include <algorithm>
#include <tuple>

namespace lockstone::sim {

using solve::accumulator_bits;
using solve::BodyStep;
using solve::SolverBody;
using solve::StepConstants;

namespace {

constexpr int real_to_accumulator = accumulator_bits - Real::fraction_bits;
constexpr Real kick_max = Real(2048); ///< [m/s] per part and substep: velocities stay below 2^16
constexpr Unit least_share = Unit::from_raw(1 << 10); ///< share of a volume; smaller shares count as zero

Vec3 real_of(const std::int64_t v[3]) {
    const auto one = [](std::int64_t x) {
        return Real::from_raw(shift_right_rounded(x, real_to_accumulator));
    };
    return {one(v[0]), one(v[1]), one(v[2])};
}

Vec3 masked(Vec3 v, std::uint32_t mask) {
    return {mask & 1u ? v.x : Real{}, mask & 2u ? v.y : Real{}, mask & 4u ? v.z : Real{}};
}

Real per_substep(Real rate, const StepConstants& step) {
    return Real::from_raw(divide_shifted(rate.raw, step.substeps_per_second, 0));
}

/// Adds dv along the free axes and du, both clamped to kick_max. du must already be zero about locked axes.
void kick(SolverBody& b, Vec3 dv, Vec3 du) {
    for (int i = 0; i < 3; ++i) {
        b.v[i] += (clamp(dv[i], -kick_max, kick_max).raw << real_to_accumulator) & b.keep[i];
        b.u[i] += clamp(du[i], -kick_max, kick_max).raw << real_to_accumulator;
    }
}

/// Solves s' (1 + a + b s') = s for s'.
Real slowed(Real s, Real a, Real b) {
    const Real c = Real(1) + a;
    return s * 2 / (c + sqrt(c * c + b * s * 4));
}

} // namespace

// ---- once a tick -----------------------------------------------------------------------------------------------

void FluidSolver::gather(const Model& w) {
    fluids.clear();
    for (const FieldRow& row : w.state.rows(w.m.field)) {
        if (row.def.kind != FieldKind::fluid) continue;
        const Region& region = row.def.region;
        const UnitVec3 up = up_of(region);
        fluids.push_back({row.id, row.def, up, surface_of(region, up)});
    }
    std::sort(fluids.begin(), fluids.end(), [](const Fluid& a, const Fluid& b) {
        return std::tuple(-std::int64_t{a.def.priority}, a.id) <
               std::tuple(-std::int64_t{b.def.priority}, b.id);
    });
}

/// True if a part may be in the fluid within the tick. `center`: centre of its volume in the world; `reach`: upper
/// bound of the distance of its points from there.
bool FluidSolver::reaches(const Model& w, const StepConstants& step, const Fluid& fluid, Vec3 center,
                          Real reach, std::uint32_t body_row, bool& is_cut) const {
    const Region& region = fluid.def.region;
    is_cut = false;
    if (!is_between_walls(region, center)) return false;
    if (region.kind != RegionKind::box) return true;
    const Vec3 p = rotate_inverse(region.pose.rotation, center - region.pose.position),
               h = region.half_extent;
    const Velocity& v = w.state.rows(w.m.body_velocity)[body_row];
    const Real speed = to<Real>(length(v.linear)) + Real(1);
    const Real margin = reach + speed / Real(step.ticks_per_second);
    is_cut = h.y - p.y < margin;
    return p.y - h.y < margin;
}

void FluidSolver::add_part(const Model& w, const StepConstants& step, std::uint32_t body_row,
                           const shapes::Solid& solid, const Transform& local, shapes::Scaled volume,
                           std::uint32_t category) {
    const Transform& pose = w.state.rows(w.m.body_pose)[body_row];
    const Velocity& velocity = w.state.rows(w.m.body_velocity)[body_row];
    const Real mass = w.mass_of(body_row).mass;
    const Real scale = w.traits_of(w.state.rows(w.m.body_info)[body_row]).drag_scale;
    const Rotation axes = to_rotation(pose.rotation * local.rotation);
    const Vec3 lever = rotate(pose.rotation, local * shapes::volume_center(solid));
    const shapes::Extent extent = shapes::extent_of(solid);
    const Real reach = to<Real>(length(extent.upper - extent.lower));
    bool is_first = true;
    for (std::uint32_t i = 0; i < fluids.size(); ++i) {
        const FieldDef& def = fluids[i].def;
        Part part{&solid, local, i, is_first, false, false, {}, {}, {}, {}, {}};
        if ((def.mask & category) == 0) continue;
        if (!reaches(w, step, fluids[i], pose.position + lever, reach, body_row, part.is_cut)) continue;
        part.is_equal = !is_first && fluids[parts.back().fluid].def.priority == def.priority;
        is_first = false;
        const Vec3 slip = to<Real>(velocity.linear) + cross(to<Real>(velocity.angular), lever) - def.velocity;
        const UnitVec3 direction = normalized_or(slip, fluids[i].up);
        const shapes::ShownArea shown =
            shapes::shown_area(solid, lockstone::mul_transposed<Unit>(axes, direction));
        part.area_center = shown.center;
        const auto over_mass = [&](Real c) { // 1e6 * 4e4 m^2 exceeds a Real, but may fit over the mass
            return shapes::unscaled<Real>(shapes::scaled(c) * shapes::scaled(shown.area) *
                                          shapes::scaled(scale) / shapes::scaled(mass));
        };
        part.linear = over_mass(def.drag_linear);
        part.quadratic = over_mass(def.drag_quadratic);
        part.angular = over_mass(def.drag_angular);
        part.displaced = shapes::unscaled<Real>(volume * shapes::scaled(def.density) / shapes::scaled(mass));
        parts.push_back(part);
    }
}

void FluidSolver::find_parts(const Model& w, PlacedShapes& placed, const StepConstants& step,
                             std::uint32_t body_row) {
    const BodyInfo& info = w.state.rows(w.m.body_info)[body_row];
    const Vec3 center = w.mass_of(body_row).center;
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    for (std::uint32_t slot = info.first_shape; slot != 0;) {
        const ShapeRow& shape = w.state.rows(w.m.shape)[slots[slot - 1].row];
        const std::uint32_t number = slot - 1;
        slot = shape.next_shape;
        if (w.traits_of(shape).sensor != 0) continue;
        const shapes::Solid& solid = solid_of(w, placed, shape);
        const Transform local{w.traits_of(shape).local.position - center, w.traits_of(shape).local.rotation};
        Volume& known = volumes[number];
        if (known.parts.empty() || known.geometry != w.traits_of(shape).geometry) {
            known.geometry = w.traits_of(shape).geometry;
            known.parts.clear();
            for_each_part(solid, local, [&](const shapes::Solid& part, const Transform&, std::size_t) {
                known.parts.push_back(shapes::volume_of(part));
            });
        }
        for_each_part(solid, local, [&](const shapes::Solid& part, const Transform& place, std::size_t i) {
            add_part(w, step, body_row, part, place, known.parts[i], w.traits_of(shape).category);
        });
    }
}

void FluidSolver::prepare(const Model& w, PlacedShapes& placed, const FieldsOfTick& fields,
                          const StepConstants& step, const solve::SolverBodies& bodies) {
    parts.clear(), wet.clear(), floating.clear();
    gather(w);
    if (fluids.empty()) return;
    volumes.resize(std::max<std::size_t>(volumes.size(), w.state.count(w.m.shape_slots)));
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    for (std::uint32_t row = 0; row < w.header().bodies_awake; ++row) {
        if (w.traits_of(info[row]).enable_fields == 0 || !bodies.step[row].movable) continue;
        const std::uint32_t first = static_cast<std::uint32_t>(parts.size());
        find_parts(w, placed, step, row);
        const std::uint32_t count = static_cast<std::uint32_t>(parts.size()) - first;
        if (count == 0) continue;
        const Vec3 pull = solve::field_acceleration(fields.pulls, w.state.rows(w.m.body_pose)[row].position,
                                                    fields.categories.empty() ? solve::every_category
                                                                              : fields.categories[row]);
        wet.push_back({row, first, count, w.header().gravity + pull});
        const auto own = std::span(parts).subspan(first, count);
        if (std::ranges::any_of(own, [](const Part& part) { return part.is_cut; })) floating.push_back(row);
    }
}

// ---- in a substep ----------------------------------------------------------------------------------------------

namespace {

/// Present pose of a body within a substep.
struct Now {
    Vec3 position;
    Quat rotation;
};

Now now_of(const Transform& pose, const SolverBody& b, const BodyStep& s) {
    constexpr int to_real = Real::fraction_bits - Separation::fraction_bits;
    Now now{pose.position, pose.rotation};
    Vec3 theta{};
    for (int i = 0; i < 3; ++i) {
        now.position[i] += Real::from_raw(std::int64_t{b.shift[i]} << to_real);
        theta[i] = Real::from_raw(std::int64_t{b.theta[i]} << to_real);
    }
    if (theta == Vec3{}) return now;
    const Vec3 turn = masked(solve::mul<Real>(s.gyration_inv, theta), s.angular_mask);
    now.rotation = integrate_rotation(pose.rotation, turn);
    return now;
}

/// K^-1 (r x d); zero about locked axes
template <class Direction> Vec3 arm_of(const BodyStep& s, Vec3 lever, Direction d) {
    return solve::mul<Real>(s.gyration_inv, masked(cross<Real>(lever, d), s.angular_mask));
}

/// Applies the drag of one stream at a point of a body. `linear` and `quadratic`: c A f / m.
void drag(SolverBody& b, const BodyStep& s, const StepConstants& step, Vec3 lever, Vec3 stream, Real linear,
          Real quadratic) {
    const Vec3 spin = solve::mul<Real>(s.gyration_inv, real_of(b.u));
    const Vec3 slip = real_of(b.v) + cross(spin, lever) - stream;
    const Real speed = length(slip);
    const UnitVec3 d = normalized(slip);
    const Vec3 x = arm_of(s, lever, d);
    Real mobility = dot<Real>(x, x);
    for (int i = 0; i < 3; ++i)
        if (b.keep[i] != 0) mobility += mul<Real>(d[i], d[i]);
    if (speed == Real{} || mobility == Real{}) return;
    const Real a = per_substep(linear * mobility, step), c = per_substep(quadratic * mobility, step);
    const Real lost = (speed - slowed(speed, a, c)) / mobility;
    kick(b, -lockstone::scale<Real>(d, lost), -(x * lost));
}

/// u' (1 + rate h) = u
void slow_turning(SolverBody& b, const StepConstants& step, Real rate) {
    const Real substeps = Real(step.substeps_per_second);
    const Unit keep = to<Unit>(substeps / (substeps + rate));
    for (std::int64_t& u : b.u) u = narrow_rounded(Wide::product(u, keep.raw), Unit::fraction_bits);
}

/// Shares of one part that fluids of higher priority have taken. The fluids of the part are visited by priority.
struct Shares {
    Unit rest = unit_one, taken{}; ///< share that is left; largest share taken at the present priority
    Vec3 moment{}, taken_moment{}; ///< shares times their centres

    void next_priority() {
        rest = rest - taken, taken = Unit{};
        moment += taken_moment, taken_moment = Vec3{};
    }
    /// Returns the share of a fluid. `under`: the share that it would have without the other fluids.
    shapes::Submerged take(shapes::Submerged under, Vec3 middle) {
        if (rest < least_share) return {};
        if (under.fraction == unit_one && rest != unit_one) // wholly in the fluid, which gets the rest
            under.center = (middle - moment) / to<Real>(rest);
        under.fraction = min(under.fraction, rest);
        if (under.fraction > taken)
            taken = under.fraction, taken_moment = under.center * to<Real>(under.fraction);
        return under;
    }
};

} // namespace

std::uint64_t FluidSolver::push_body(const Transform& pose, const Body& body, const StepConstants& step,
                                     SolverBody& b, const BodyStep& s) const {
    const Now now = now_of(pose, b, s);
    const Rotation turn = to_rotation(now.rotation);
    std::uint64_t clamped = 0;
    Shares shares;
    Rotation axes{}; // of the current part, and its position
    Vec3 origin{}, middle{};
    for (std::uint32_t k = body.first; k < body.first + body.count; ++k) {
        const Part& part = parts[k];
        const Fluid& fluid = fluids[part.fluid];
        if (part.is_first) {
            shares = {};
            axes = part.local.rotation == Quat::identity() ? turn
                                                           : to_rotation(now.rotation * part.local.rotation);
            origin = lockstone::mul<Real>(turn, part.local.position);
            middle = shapes::volume_center(*part.solid);
        }
        if (!part.is_equal) shares.next_priority();
        shapes::Submerged under{unit_one, middle};
        if (part.is_cut) {
            const Real height = dot<Real>(fluid.surface - (now.position + origin), fluid.up);
            under = shapes::submerged(*part.solid, lockstone::mul_transposed<Unit>(axes, fluid.up), height);
        }
        under = shares.take(under, middle);
        if (under.fraction < least_share) continue;
        const Real share = to<Real>(under.fraction);
        if (part.displaced != Real{}) {
            const Vec3 lift = body.pull * -(part.displaced * share);
            const Vec3 dv{per_substep(lift.x, step), per_substep(lift.y, step), per_substep(lift.z, step)};
            kick(b, dv, arm_of(s, origin + lockstone::mul<Real>(axes, under.center), dv));
        }
        // The centre of the shown area moves with the centre of the submerged volume.
        if (part.linear != Real{} || part.quadratic != Real{})
            drag(b, s, step, origin + lockstone::mul<Real>(axes, part.area_center + under.center - middle),
                 fluid.def.velocity, part.linear * share, part.quadratic * share);
        if (part.angular != Real{}) slow_turning(b, step, part.angular * share);
        clamped += solve::clamp_length(b.v, step.linear_speed_max) ? 1u : 0u;
        clamped += solve::clamp_length(b.u, step.tip_speed_max) ? 1u : 0u;
    }
    return clamped;
}

void FluidSolver::push(const Model& w, const StepConstants& step, solve::SolverBodies& bodies,
                       Tasks* tasks) const {
    if (wet.empty()) return;
    const std::span<const Transform> poses = w.state.rows(w.m.body_pose);
    constexpr std::uint32_t wet_per_chunk = 16;
    const auto count = static_cast<std::uint32_t>(wet.size());
    bodies.paths.take(base::is_shared(tasks, count, wet_per_chunk), base::Path::fluids_by_one,
                      base::Path::fluids_by_workers);
    base::for_chunks(tasks, count, wet_per_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         std::uint64_t clamped = 0;
                         for (std::uint32_t i = first; i < last; ++i) {
                             const Body& body = wet[i];
                             SolverBody& b = bodies.body[body.row];
                             clamped += push_body(poses[body.row], body, step, b, bodies.step[body.row]);
                         }
                         base::add_count(bodies.clamps.speed, clamped);
                     });
}

void FluidSolver::poison(std::byte with) {
    auto& [fluid_list, part_list, wet_list, float_list, volume_cache] = *this;
    base::poison(with, fluid_list, part_list, wet_list, float_list);
}

} // namespace lockstone::sim
