// Fluids in the tick: buoyancy and drag, once a substep after the velocities were integrated.
//
//   f        share of a part's volume that is in the fluid, and not in one of higher priority
//   buoyancy a = -g f M / m            M: mass of the fluid that the whole part displaces, m: mass of the body
//   drag     s' (1 + a1 + a2 s') = s   speed along the stream at the centre of the shown area, before s and after s';
//            a1 = c1 A f h k / m, a2 = c2 A f h k / m, k = |d|^2 + |K^-1 (r x d)|^2: implicit, so drag never turns a
//            motion round and terminal speeds are exact
//   turning  u' = u / (1 + c3 A f h / m)
//
// Buoyancy is taken at the pose of the substep and moves the body in the same substep: a symplectic scheme, so that a body
// bobs without gaining energy. Which part is in which fluid, and shown areas, change little within a tick: they are found once.
// There is no added mass: a body in water starts as lightly as in air.
#pragma once

#include "base/parallel.h"
#include "scene/placed_shapes.h"
#include "solve/bodies/solver_body.h"

#include <vector>

namespace lockstone::sim {

/// Fields of acceleration, as the integrator takes them.
struct FieldsOfTick {
    std::vector<FieldRow> pulls; ///< in order of their ids
    /// By row of what is awake, of its shapes; empty while no pull looks at them
    std::vector<std::uint32_t> categories;
};
void list_fields(const Model& w, FieldsOfTick& out);

class FluidSolver {
  public:
    /// Finds what is in a fluid, when bodies are in solver form. Once a tick.
    void prepare(const Model& w, PlacedShapes& placed, const FieldsOfTick& fields,
                 const solve::StepConstants& step, const solve::SolverBodies& bodies);
    /// In a substep.
    void push(const Model& w, const solve::StepConstants& step, solve::SolverBodies& bodies,
              Tasks* tasks) const;
    /// Rows of the bodies that cross the surface of a fluid, ascending. Valid until the next prepare().
    std::span<const std::uint32_t> afloat() const { return floating; }
    /// Fills what prepare() makes anew with a byte.
    void poison(std::byte with);

  private:
    struct Fluid {
        FieldId id;
        FieldDef def;
        UnitVec3 up;  ///< across its surface
        Vec3 surface; ///< a point of it
    };
    /// A convex part of a shape in a fluid.
    struct Part {
        const shapes::Solid* solid;
        Transform local;     ///< in the body's axes, from its centre of mass
        std::uint32_t fluid; ///< entry of `fluids`
        bool is_first;       ///< of its part
        bool is_equal;       ///< its priority is that of the entry before
        bool is_cut;         ///< the surface cuts it, or may do so within the tick; else it is wholly under
        Real displaced;      ///< M / m
        Real linear, quadratic, angular; ///< c1 A / m [1/s], c2 A / m [1/m], c3 A / m [1/s]
        Vec3 area_center;                ///< in the part's frame
    };
    struct Body {
        std::uint32_t row, first, count; ///< its entries of `parts`
        Vec3 pull;                       ///< gravity and fields at its centre [m/s^2]
    };
    /// Volumes of shapes do not change: kept by geometry, in scratch.
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

    std::vector<Fluid> fluids; ///< the highest priority first
    std::vector<Part> parts;
    std::vector<Body> wet;
    std::vector<std::uint32_t> floating;
    std::vector<Volume> volumes; ///< by shape slot
};

} // namespace lockstone::sim
