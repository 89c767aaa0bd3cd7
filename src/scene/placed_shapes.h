// Where shapes are: the solid, pose and bounds of each, by shape slot, and the broad phase over them. Derived from the state, and
// no part of it: what is kept from tick to tick changes speed only.
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
    /// Makes room for so many shape slots, where there is less.
    void fit(std::uint32_t shape_slots);
    void reserve(std::uint32_t shape_slots); ///< ahead of need

    shapes::SolidCache solids;
    collide::BroadPhase broad_phase;
    const collide::BoundsKernel* kernel = nullptr; ///< null: shape by shape, to the same bits
    bool structure_stale = true; ///< objects came, went or were restored since the last update_bounds()
    /// Whether poses and bounds are those of the state. update_bounds() sets it, whoever changes the state clears it.
    bool is_current = false;

    /// What pairs ask of the row and the traits of a shape.
    struct Filter {
        std::uint32_t generation; ///< of the shape's id
        std::uint32_t body;       ///< its slot
        std::uint32_t traits;     ///< row of the table of ShapeTraits
        std::uint32_t category, mask;
        ShapeKind kind;
        bool is_plain; ///< neither a sensor nor in a group
    };
    /// The first cache line is what most pairs look at.
    struct alignas(64) Shape {
        Filter filter;
        Length margin;    ///< how far its contacts reach ahead at most
        Coordinate reach; ///< of its points from its origin [m]
        Length inner;     ///< shapes::inner_radius() of the solid
        bool has_pieces;  ///< the solid has: a mesh or a height field
        bool has_axes;    ///< a ball that nothing is near needs none
        bool is_placed;   ///< while bounds are updated: pose, margin and bounds are those of this tick
        bool rests;       ///< the broad phase has it as resting, placed by: resting_local...
        collide::Bounds bounds;
        Transform pose; ///< world
        Rotation axes;  ///< of the pose, once has_axes
        shapes::Solid solid;
        Transform resting_local, resting_at;
        Vec3 resting_center;
    };
    std::vector<Shape> shape;          ///< by shape slot, of living shapes
    std::vector<std::uint32_t> planes; ///< shape slots, sorted

    // What filters and the proxies of resting shapes were made of, so that only what changed since is looked at.
    /// By shape slot: the generation of the shape that the broad phase holds, 0: none
    std::vector<std::uint32_t> proxy_generation;
    ChangeMark proxies_of;
    std::uint32_t awake_before = 0;             ///< bodies, when bounds were last updated
    std::vector<std::uint32_t> solids_replaced; ///< shape slots that rested when another solid was put there
    std::vector<RowRange> changed;
    /// By row of an awake body: 1 when all of its shapes stay within their leaves.
    std::vector<std::uint8_t> is_told;
    base::Paths paths; ///< of the tick
};

inline constexpr Length margin_base =
    decimal<Length>("0.005"); ///< [m]: contacts are made this far ahead of touching

inline constexpr Length margin_least = margin_base + margin_base; ///< of two shapes

/// For those that read `axes` later. Several threads may do it at once: the axes are there when all have come back.
inline void make_axes(PlacedShapes::Shape& at) {
    const std::atomic_ref<bool> has_axes(at.has_axes);
    if (!has_axes.load(std::memory_order_relaxed) && !has_axes.exchange(true, std::memory_order_relaxed))
        at.axes = to_rotation(at.pose.rotation);
}
/// For those that share shapes with other threads.
inline Rotation axes_of(const PlacedShapes::Shape& at) {
    return at.has_axes ? at.axes : to_rotation(at.pose.rotation);
}

/// How far ahead of touching contacts are made for a velocity, a body's own or that of two against each other: no less than it goes
/// in a tick, in steps of `margin_base`, and of an eighth of itself where that is more, so that it seldom grows while they near each
/// other; 0 for what goes less than half of `margin_base` in a tick.
Length ahead_of(SpeedVec3 velocity, std::uint32_t tick_rate);
/// Reach over inner radius, above which a shape is a plate or a pole.
inline constexpr std::int64_t thin_reach = 4;
/// True for plates and poles: the reach is more than thin_reach times the inner radius. Their ends go farther by turning than their inner radius.
inline bool is_thin(const PlacedShapes::Shape& at) {
    const ShapeKind kind = at.filter.kind;
    return at.reach.raw > thin_reach * at.inner.raw && kind != ShapeKind::sphere && kind <= ShapeKind::hull;
}
/// Like ahead_of(), how far the ends of a thin shape go by turning, at most its reach; 0 for all other shapes.
Length turn_ahead_of(const PlacedShapes::Shape& at, SpeedVec3 angular, std::uint32_t tick_rate);

/// Poses, margins and bounds of the shapes that may have moved since the last call, in the broad phase too.   (bounds.cpp)
void update_bounds(const Model& w, PlacedShapes& s, Tasks* tasks);
/// What collision sees of a shape. Its asset was found when the shape was made, so it is there.             (bounds.cpp)
const shapes::Solid& solid_of(const Model& w, PlacedShapes& s, const ShapeRow& shape);

/// Sums up the shapes of a body. The body's origin stays where it is, its centre of mass moves.               (mass.cpp)
void update_mass(Model& w, PlacedShapes& s, std::uint32_t body_row);

} // namespace lockstone::sim
