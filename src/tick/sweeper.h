// The paths of the shapes of awake bodies through a tick, and the shapes near them.
#pragma once

#include "collide/query/cast.h"
#include "collide/swept_box.h"
#include "lockstone/math/math.h"
#include "tick/sweep.h"

#include <algorithm>

namespace lockstone::sim {

using collide::Sweep;

/// A view of the state and of the poses before the tick. Valid while no table grows.
struct Sweeper {
    const Model& w;
    const PlacedShapes& placed;
    std::span<const Transform> before; ///< poses when the tick began, of the bodies that were awake then
    std::span<const Transform> pose;
    std::span<const BodyInfo> info;
    solve::MassView mass;
    std::span<const ShapeRow> shapes;
    std::span<const ShapeTraits> shape_traits;
    std::span<const Slot> slots;
    std::span<const std::uint32_t> driven; ///< shapes of awake bodies that are not dynamic
    Real kinematic_motion_max{},
        motion_max{}; ///< greatest motion in this tick of any point of a kinematic body, and of any moving body [m]

    Sweeper(const Model& model, const PlacedShapes& shapes_placed, const PosesBefore& poses_before)
        : w(model), placed(shapes_placed), before(poses_before.list), pose(w.state.rows(w.m.body_pose)),
          info(w.state.rows(w.m.body_info)), mass(w.masses()), shapes(w.state.rows(w.m.shape)),
          shape_traits(w.state.rows(w.m.shape_traits.row)), slots(w.state.rows(w.m.shape_slot)) {}

    const PlacedShapes::Shape& at(const ShapeRow& shape) const { return placed.shape[shape.id.index - 1]; }
    const Transform& pose_before(std::uint32_t row) const {
        return row < before.size() ? before[row] : pose[row]; // a body that rests has not moved
    }
    const shapes::Solid& solid(const ShapeRow& shape) const { return at(shape).solid; }
    const ShapeTraits& traits(const ShapeRow& shape) const { return shape_traits[shape.traits]; }
    bool is_bullet(std::uint32_t row) const { return mass.traits[info[row].traits].bullet != 0; }
    std::uint32_t row_of(std::uint32_t slot) const { return w.row_of(shapes[slots[slot].row].body); }
    bool stands_still(std::uint32_t row) const {
        return info[row].kind != BodyKind::dynamic && pose_before(row) == pose[row];
    }
    Sweep sweep(std::uint32_t row, const ShapeRow& shape) const {
        return {pose_before(row),
                pose[row],
                {traits(shape).local.position - mass[row].center, traits(shape).local.rotation}};
    }
    /// The greatest distance of the points that rotation moves from the centre of mass.
    Real reach(std::uint32_t row, const ShapeRow& shape) const {
        const Real offset = length(traits(shape).local.position - mass[row].center);
        if (traits(shape).geometry.kind == ShapeKind::sphere) return offset;
        return offset + to<Real>(at(shape).reach);
    }
    template <class Visit> void for_each_shape(std::uint32_t row, Visit&& visit) const {
        for (std::uint32_t slot = info[row].first_shape; slot != 0;) {
            const ShapeRow& shape = shapes[slots[slot - 1].row];
            slot = shape.next_shape;
            if (traits(shape).sensor == 0 && traits(shape).geometry.kind != ShapeKind::plane) visit(shape);
        }
    }
};

inline constexpr Sweep still{Transform::identity(), Transform::identity(), Transform::identity()};

inline Real motion_of(const Sweeper& s, std::uint32_t row) {
    if (s.pose_before(row) == s.pose[row]) return Real{};
    Real most{};
    s.for_each_shape(row, [&](const ShapeRow& shape) {
        const Real motion = collide::relative_motion(still, s.sweep(row, shape), s.reach(row, shape));
        most = max(most, motion);
    });
    return most;
}

/// The path of the body in a row, or a later part of it: then the paths of the other bodies begin at that time too.
struct Way {
    std::uint32_t row;
    Transform from, to; ///< of the centre of mass
    Unit begin;
    std::uint32_t except; ///< row of a body that is skipped
    Vec3 moved;           ///< motion in the tick as far as it is known, for one-way surfaces
};

/// Returns true if a path stays above a motionless plane by more than `around`, the reach of the shape. Then the
/// plane neither stops nor touches the shape, like any shape whose box does not meet the box of the path.
inline bool stays_above(const Sweeper& s, std::uint32_t plane, const Sweep& way, Real around) {
    if (s.info[s.row_of(plane)].kind != BodyKind::static_) return false;
    const PlacedShapes::Shape& at = s.placed.shape[plane];
    const UnitVec3 n = axes_of(at).y;
    const auto height = [&](Vec3 p) { return dot<Real>(n, p - at.pose.position); };
    return height(way.from.position) > around && height(way.to.position) > around;
}

/// Up to this number, each driven shape is compared with each path; beyond, the trees are searched.
inline constexpr std::size_t driven_max = 64;

/// Appends the driven shapes whose bounds the box may meet, in order, as queries of the trees do.
inline void add_driven(const Sweeper& s, const collide::SweptBox& box, std::vector<std::uint32_t>& near) {
    const std::size_t before = near.size();
    for (const std::uint32_t proxy : s.driven)
        if (box.may_meet(s.placed.broad_phase.bounds(proxy))) near.push_back(proxy);
    if (near.size() != before) std::sort(near.begin(), near.end());
}

enum class Among { all, driven }; ///< which shapes a search returns

/// Stores in `near` the shapes that may be near a path. Returns the path of this shape.
inline Sweep find_near(const Sweeper& s, const Way& whole, const ShapeRow& shape, Among among,
                       collide::BroadPhase::Asker& near) {
    const std::uint32_t row = whole.row;
    Sweep way = s.sweep(row, shape);
    way.from = whole.from, way.to = whole.to;
    const PlacedShapes& placed = s.placed;
    const int shift = static_cast<int>(s.w.state.rows(s.w.m.config)[0].bounds_shift);
    const Real others = s.is_bullet(row) ? s.motion_max : s.kinematic_motion_max;
    const Real around = length(way.local.position) + to<Real>(placed.shape[shape.id.index - 1].reach) +
                        others + to<Real>(collide::stop_gap) * 2;
    const auto box = [&](Vec3 p) {
        constexpr int drop = Real::fraction_bits - Bound::fraction_bits;
        const auto low = [&](Real x) {
            return Bound::from_raw(saturate_to_int32((x - around).raw >> (drop + shift)));
        };
        const auto high = [&](Real x) {
            return Bound::from_raw(saturate_to_int32(((x + around).raw >> (drop + shift)) + 1));
        };
        return collide::Bounds{{low(p.x), low(p.y), low(p.z)}, {high(p.x), high(p.y), high(p.z)}};
    };
    const collide::SweptBox swept(box(way.from.position), box(way.to.position));
    near.proxies.clear();
    if (s.is_bullet(row) || s.driven.size() > driven_max)
        placed.broad_phase.query(swept, near);
    else { // the caller would skip dynamic shapes anyway
        if (among == Among::all) placed.broad_phase.query_static(swept, near);
        add_driven(s, swept, near.proxies);
    }
    for (const std::uint32_t plane : placed.planes) {
        const bool is_meant = among == Among::all || !s.stands_still(s.row_of(plane));
        if (is_meant && !stays_above(s, plane, way, around)) near.proxies.push_back(plane);
    }
    return way;
}

} // namespace lockstone::sim
