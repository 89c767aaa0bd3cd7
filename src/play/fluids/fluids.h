// Fluids in the tick: buoyancy and drag, once per substep after the integration of velocities.
//
//   f        share of a part's volume that is in the fluid, and not in one of higher priority
//   buoyancy a = -g f M / m            M: mass of the fluid that the whole part displaces, m: mass of the body
//   drag     s' (1 + a1 + a2 s') = s   speed along the stream at the centre of the shown area, before s and after s';
//            a1 = c1 A f h k / m, a2 = c2 A f h k / m, k = |d|^2 + |K^-1 (r x d)|^2: the implicit form never
//            reverses a motion, and its terminal speeds are exact
//   turning  u' = u / (1 + c3 A f h / m)
//
// Buoyancy uses the pose of the substep and moves the body in the same substep. This scheme is symplectic, so a body
// bobs without gaining energy. The assignment of parts to fluids and the shown areas change little within a tick, so
// they are computed once per tick. There is no added mass: a body in water starts to move as easily as in air.
#pragma once

#include "base/parallel.h"
#include "scene/placed_shapes.h"
#include "solve/bodies/solver_body.h"

#include <vector>

namespace lockstone::sim {

/// Acceleration fields, in the form that the integrator reads.
struct FieldsOfTick {
    std::vector<FieldRow> pulls; ///< in order of their ids
    /// By row of awake bodies: categories of the body's shapes. Empty if no field filters by category.
    std::vector<std::uint32_t> categories;
};
void list_fields(const Model& w, FieldsOfTick& out);

/// Normal of the surface of a box region.
inline UnitVec3 up_of(const Region& region) { return to_rotation(region.pose.rotation).y; }
/// A point of the surface of a box region: the middle of its top.
inline Vec3 surface_of(const Region& region, UnitVec3 up) {
    return region.pose.position + lockstone::scale<Real>(up, region.half_extent.y);
}
/// True if a centre of volume is in the region; a box has no top here.
bool is_between_walls(const Region& region, Vec3 center);

/// World::submersion() of the body in a row. Updates `placed` to the state.
Submersion submersion(const Model& w, PlacedShapes& placed, std::uint32_t body_row);

class FluidSolver {
  public:
    /// Finds the bodies in fluids. Call once a tick, when bodies are in solver form.
    void prepare(const Model& w, PlacedShapes& placed, const FieldsOfTick& fields,
                 const solve::StepConstants& step, const solve::SolverBodies& bodies);
    /// Applies buoyancy and drag. Call in each substep.
    void push(const Model& w, const solve::StepConstants& step, solve::SolverBodies& bodies,
              Tasks* tasks) const;
    /// Rows of the bodies that cross the surface of a fluid, ascending. Valid until the next prepare().
    std::span<const std::uint32_t> afloat() const { return floating; }
    /// Fills all data that prepare() writes with a byte, to expose reads of stale data.
    void poison(std::byte with);

  private:
    struct Fluid {
        FieldId id;
        FieldDef def;
        UnitVec3 up;  ///< normal of its surface
        Vec3 surface; ///< a point of its surface
    };
    /// A convex part of a shape in a fluid.
    struct Part {
        const shapes::Solid* solid;
        Transform local;     ///< in the body's axes, from its centre of mass
        std::uint32_t fluid; ///< entry of `fluids`
        bool is_first;       ///< the first entry of this part of the shape
        bool is_equal;       ///< same priority as the previous entry
        bool is_cut;         ///< the surface may cut it within the tick; if not set, it is wholly under
        Real displaced;      ///< M / m
        Real linear, quadratic, angular; ///< c1 A / m [1/s], c2 A / m [1/m], c3 A / m [1/s]
        Vec3 area_center;                ///< in the part's frame
    };
    struct Body {
        std::uint32_t row, first, count; ///< its entries of `parts`
        Vec3 pull;                       ///< gravity and fields at its position [m/s^2]
    };
    /// Volumes of the parts of a shape, cached by geometry.
    struct Volume {
        Geometry geometry{};
        std::vector<shapes::Scaled> parts;
    };

    void gather(const Model& w);
    void find_parts(const Model& w, PlacedShapes& placed, const solve::StepConstants& step,
                    std::uint32_t body_row);
    void add_part(const Model& w, const solve::StepConstants& step, std::uint32_t body_row,
                  const shapes::Solid& solid, const Transform& local, shapes::Scaled volume,
                  std::uint32_t category);
    bool reaches(const Model& w, const solve::StepConstants& step, const Fluid& fluid, Vec3 center,
                 Real reach, std::uint32_t body_row, bool& is_cut) const;
    /// Returns how many velocities were clamped.
    std::uint64_t push_body(const Transform& pose, const Body& body, const solve::StepConstants& step,
                            solve::SolverBody& b, const solve::BodyStep& s) const;

    std::vector<Fluid> fluids; ///< highest priority first
    std::vector<Part> parts;
    std::vector<Body> wet;
    std::vector<std::uint32_t> floating;
    std::vector<Volume> volumes; ///< by shape slot
};

} // namespace lockstone::sim
