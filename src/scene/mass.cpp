// The mass of a body, computed from its shapes.
#include "lockstone/math/math.h"
#include "model/checks.h"
#include "scene/placed_shapes.h"

#include <algorithm>

namespace lockstone::sim {

/// The greatest distance of a body's shapes from its origin. Used as the gyration radius of a body that no torque
/// turns, so that the solver's rows of its contacts stay within their number format.
static Real reach_of(const Model& w, PlacedShapes& s, const BodyInfo& info) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Real reach = Real(1);
    for (std::uint32_t slot = info.first_shape; slot != 0; slot = shapes[slots[slot - 1].row].next_shape) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        if (w.traits_of(shape).geometry.kind == ShapeKind::plane) continue;
        const shapes::Extent e = shapes::extent_of(solid_of(w, s, shape));
        reach = max(reach, to<Real>(length(max(abs(e.lower), abs(e.upper)))) +
                               length(w.traits_of(shape).local.position));
    }
    return reach;
}

void update_mass(Model& w, PlacedShapes& s, std::uint32_t row) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const BodyInfo& info = w.state.rows(w.m.body_info)[row];
    const BodyTraits& traits = w.traits_of(info);
    if (traits.mass_fixed != 0) return;
    std::vector<MassPart>& parts = w.mass_parts;
    parts.clear();
    for (std::uint32_t slot = info.first_shape; slot != 0; slot = shapes[slots[slot - 1].row].next_shape) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        if (w.traits_of(shape).sensor == 0)
            parts.push_back({shapes::mass_properties(solid_of(w, s, shape), w.traits_of(shape).density),
                             w.traits_of(shape).local});
    }
    std::reverse(parts.begin(), parts.end()); // into the order of creation
    const MassProperties total = combine(parts);
    BodyMass mass{};
    mass.center = total.center;
    // Without shapes: a ball of 1 kg with a gyration radius of 1 m.
    if (total.mass == Real{}) {
        const Real radius = info.kind == BodyKind::dynamic ? Real(1) : reach_of(w, s, info);
        mass.gyration = {radius, radius, radius};
        mass.principal = Quat::identity();
    } else {
        const PrincipalGyration principal = principal_gyration(total);
        for (int i = 0; i < 3; ++i) mass.gyration[i] = max(principal.radii[i], gyration_min);
        mass.principal = principal.axes;
    }
    if (info.kind == BodyKind::dynamic) {
        const Real from_shapes = total.mass == Real{} ? Real(1) : clamp(total.mass, mass_min, mass_max);
        mass.mass = traits.mass_override != Real{} ? traits.mass_override : from_shapes;
    }
    set_mass(w, row, mass);
}

} // namespace lockstone::sim
