// The part of a body below the surfaces of fluids, as a reading.
#include "play/fluids/fluids.h"

#include "lockstone/math/math.h"
#include "scene/parts.h"
#include "shapes/submerged.h"
#include "solve/bodies/region.h"

namespace lockstone::sim {
namespace {

/// The part of a convex solid at a pose in one fluid: fraction 0 outside.
shapes::Submerged part_in(const Region& region, const shapes::Solid& solid, const Transform& pose) {
    const Vec3 middle = shapes::volume_center(solid);
    if (!is_between_walls(region, pose * middle)) return {Unit{}, middle};
    if (region.kind != RegionKind::box) return {unit_one, middle};
    const UnitVec3 up = up_of(region);
    return shapes::submerged(solid, lockstone::mul_transposed<Unit>(to_rotation(pose.rotation), up),
                             dot<Real>(surface_of(region, up) - pose.position, up));
}

/// Volumes, and the sum of submerged volumes times their centres.
struct Below {
    shapes::Scaled all{}, under{}; ///< [m^3]
    shapes::Scaled moment[3]{};    ///< [m^4], relative to the centre of mass, world axes

    void add(shapes::Scaled volume, Unit fraction, Vec3 center) {
        all = all + volume;
        if (fraction == Unit{}) return;
        const shapes::Scaled wet = volume * shapes::scaled(fraction);
        under = under + wet;
        for (int i = 0; i < 3; ++i) moment[i] = moment[i] + wet * shapes::scaled(center[i]);
    }
};

} // namespace

bool is_between_walls(const Region& region, Vec3 center) {
    if (region.kind != RegionKind::box) return solve::contains(region, center);
    const Vec3 p = rotate_inverse(region.pose.rotation, center - region.pose.position),
               h = region.half_extent;
    return abs(p.x) <= h.x && abs(p.z) <= h.z && p.y >= -h.y;
}

Submersion submersion(const Model& w, PlacedShapes& placed, std::uint32_t body_row) {
    // Once the caches match the state, solid_of() writes nothing that a query on another thread reads.
    if (placed.structure_stale || !placed.is_current) update_bounds(w, placed, nullptr);
    const Transform& pose = w.state.rows(w.m.body_pose)[body_row];
    const Vec3 center = w.mass_of(body_row).center;
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Below below;
    std::uint32_t slot = w.state.rows(w.m.body_info)[body_row].first_shape;
    for (; slot != 0; slot = shapes[slots[slot - 1].row].next_shape) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        const ShapeTraits& traits = w.traits_of(shape);
        if (traits.sensor != 0) continue;
        const Transform local{traits.local.position - center, traits.local.rotation};
        const auto visit = [&](const shapes::Solid& part, const Transform& place, std::size_t) {
            shapes::Submerged most{};
            for (const FieldRow& field : w.state.rows(w.m.field)) {
                const FieldDef& def = field.def;
                if (def.kind != FieldKind::fluid || def.density == Real{} ||
                    (def.mask & traits.category) == 0)
                    continue;
                const shapes::Submerged here = part_in(def.region, part, pose * place);
                if (here.fraction > most.fraction) most = here;
            }
            below.add(shapes::volume_of(part), most.fraction, rotate(pose.rotation, place * most.center));
        };
        for_each_part(solid_of(w, placed, shape), local, visit);
    }
    Submersion out{Unit{}, pose.position, Real{}};
    if (below.under.mantissa == 0) return out;
    out.fraction = min(shapes::unscaled<Unit>(below.under / below.all), unit_one);
    out.volume = shapes::unscaled<Real>(below.under);
    for (int i = 0; i < 3; ++i) out.center[i] += shapes::unscaled<Real>(below.moment[i] / below.under);
    return out;
}

} // namespace lockstone::sim
