// The solid, pose and bounds of each shape, by shape slot, and the broad phase over them. Derived from the state and
// not part of it: caches that persist between ticks change speed only.
#pragma once

#include "base/paths.h"
#include "collide/bounds_kernel.h"
#include "collide/broad/broad_phase.h"
#include "lockstone/math/math.h"
#include "model/model.h"

#include <atomic>
#include <memory>
#include <vector>

namespace lockstone::sim {

struct PlacedShapes {
    explicit PlacedShapes(std::shared_ptr<const AssetLibrary> assets)
        : solids(std::move(assets)), broad_phase(0) {
        changed.reserve(64);
    }
    /// Makes room for `shape_slots` shape slots, if there is less.
    void fit(std::uint32_t shape_slots);
    void reserve(std::uint32_t shape_slots); ///< like fit(), with room in all lists, ahead of need

    shapes::SolidCache solids;
    collide::BroadPhase broad_phase;
    const collide::BoundsKernel* kernel = nullptr; ///< null: scalar code computes the bounds, with equal bits
    bool structure_stale = true; ///< objects were created, removed or restored since the last update_bounds()
    /// True if poses and bounds match the state. update_bounds() sets it; code that changes the state clears it.
    bool is_current = false;

    /// Copies of the fields of a shape's row and traits that the filter of pairs reads.
    struct Filter {
        std::uint32_t generation; ///< of the shape's id
        std::uint32_t body;       ///< slot of its body
        std::uint32_t traits;     ///< row of the table of ShapeTraits
        std::uint32_t category, mask;
        ShapeKind kind;
        bool is_plain; ///< neither a sensor nor in a group
    };
    /// Most pairs read the first cache line only.
    struct alignas(64) Shape {
        Filter filter;
        Length margin;    ///< the greatest distance at which it gets contacts [m]
        Coordinate reach; ///< greatest distance of its points from its origin [m]
        Length inner;     ///< shapes::inner_radius() of the solid
        bool has_pieces;  ///< the solid has triangles or cells: a mesh or a height field
        bool has_axes;    ///< `axes` is computed; a ball with no other shape near needs none
        bool is_placed;   ///< while bounds are updated: pose, margin and bounds are those of this tick
        bool rests;       ///< the broad phase holds it as resting, at the place in resting_local...
        collide::Bounds bounds;
        Transform pose; ///< world
        Rotation axes;  ///< of the pose; valid if has_axes
        shapes::Solid solid;
        Transform resting_local, resting_at;
        Vec3 resting_center;
    };
    std::vector<Shape> shape;          ///< by shape slot; valid for living shapes
    std::vector<std::uint32_t> planes; ///< shape slots, sorted

    // State of the columns from which filters and resting proxies come, so that updates visit changed rows only.
    /// By shape slot: the generation of the shape that the broad phase holds, 0: none
    std::vector<std::uint32_t> proxy_generation;
    ChangeMark proxies_of;
    std::uint32_t awake_before = 0;             ///< awake bodies at the last update of bounds
    std::vector<std::uint32_t> solids_replaced; ///< slots of shapes that rested when their solid was replaced
    std::vector<RowRange> changed;
    /// By row of an awake body: 1 if all of its shapes stay within their leaves.
    std::vector<std::uint8_t> is_told;
    base::Paths paths; ///< of the tick
};

inline constexpr Length margin_base =
    decimal<Length>("0.005"); ///< [m]: contacts begin at this distance from each shape

inline constexpr Length margin_least = margin_base + margin_base; ///< of a pair of shapes

/// Computes the axes, for later readers of `axes`. Thread-safe for several callers on one shape; the axes are valid
/// once all callers have returned.
inline void make_axes(PlacedShapes::Shape& at) {
    const std::atomic_ref<bool> has_axes(at.has_axes);
    if (!has_axes.load(std::memory_order_relaxed) && !has_axes.exchange(true, std::memory_order_relaxed))
        at.axes = to_rotation(at.pose.rotation);
}
/// The axes of a shape, for readers that share shapes with other threads.
inline Rotation axes_of(const PlacedShapes::Shape& at) {
    return at.has_axes ? at.axes : to_rotation(at.pose.rotation);
}

/// The distance ahead of touching at which contacts begin for a velocity, either of one body or of two relative to
/// each other. It is at least the distance covered in a tick, rounded up to steps of `margin_base`, and to steps of
/// about an eighth of itself where it is large, so that it seldom grows while two bodies approach. 0 if the velocity
/// covers less than half of `margin_base` in a tick.
Length ahead_of(SpeedVec3 velocity, std::uint32_t tick_rate);
/// The ratio of reach to inner radius above which a shape is a plate or a pole.
inline constexpr std::int64_t thin_reach = 4;
/// Returns true for plates and poles: the reach is more than thin_reach times the inner radius. Rotation moves their
/// ends farther than their inner radius.
inline bool is_thin(const PlacedShapes::Shape& at) {
    const ShapeKind kind = at.filter.kind;
    return at.reach.raw > thin_reach * at.inner.raw && kind != ShapeKind::sphere && kind <= ShapeKind::hull;
}
/// Like ahead_of(), for the distance by which rotation moves the ends of a thin shape; at most its reach. 0 for all
/// other shapes.
Length turn_ahead_of(const PlacedShapes::Shape& at, SpeedVec3 angular, std::uint32_t tick_rate);

/// Updates the poses, margins and bounds of the shapes that may have moved since the last call, also in the broad
/// phase. (bounds.cpp)
void update_bounds(const Model& w, PlacedShapes& s, Tasks* tasks);
/// The solid of a shape. Its asset exists, as it was found when the shape was created. (bounds.cpp)
const shapes::Solid& solid_of(const Model& w, PlacedShapes& s, const ShapeRow& shape);

/// Computes the mass of a body from its shapes. The origin of the body stays in place, its centre of mass moves.
/// (mass.cpp)
void update_mass(Model& w, PlacedShapes& s, std::uint32_t body_row);

} // namespace lockstone::sim
