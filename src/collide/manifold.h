// The parts of `manifold_from_faces`: supporting edges, clipping, and the points of two edges.
#pragma once

#include "collide/core.h"
#include "collide/pairs/box_box.h"

namespace lockstone::collide {

/// The corner of a core that is furthest along a direction; or two corners, when an edge or generator is
/// furthest, to within 1/64 rad. `flat` when more than two corners are; the two returned are then some of them.
SupportingFace supporting_edge(const Convex& shape, Long3 direction_30,
                               std::uint32_t corner = unknown_corner);

/// The data that the points of a manifold are made from. `normal_30` leads from A to B.
struct Contact {
    const Convex &a, &b;
    Long3 normal_30;
    std::int64_t separation_30; ///< of the shapes, radii included
    Length margin;
    Manifold& out;

    std::int64_t radius_a_30() const { return up(a.radius.raw, 6); }
    std::int64_t radius_b_30() const { return up(b.radius.raw, 6); }
    /// The point at `offset` along the normal from `from`.
    Long3 moved(Long3 from, std::int64_t offset_30) const { return from + times_unit(normal_30, offset_30); }
    /// Adds a contact point midway in the gap above a point `on_a` of A's core.
    void add_above_a(Long3 on_a_30, std::int64_t separation, std::uint32_t feature) {
        add(moved(on_a_30, radius_a_30() + (separation >> 1)), separation, feature);
    }
    void add_below_b(Long3 on_b_30, std::int64_t separation, std::uint32_t feature) {
        add(moved(on_b_30, -radius_b_30() - (separation >> 1)), separation, feature);
    }

    /// Adds a contact point midway between the points of the cores.
    void add_between(Long3 on_a_30, Long3 on_b_30, std::uint32_t feature) {
        const Long3 middle{(on_a_30[0] + on_b_30[0]) >> 1, (on_a_30[1] + on_b_30[1]) >> 1,
                           (on_a_30[2] + on_b_30[2]) >> 1};
        add(moved(middle, (radius_a_30() - radius_b_30()) >> 1), separation_30, feature);
    }

  private:
    void add(Long3 at_30, std::int64_t separation, std::uint32_t feature) {
        add_point(out, at_30 - up(b.center_24, 6), separation, margin, feature);
    }
};

// Names: a corner of A, a corner of B, and two edges, each by its lower and higher corner. All names differ.
constexpr std::uint32_t corner_of_a(std::uint32_t id) { return 0xffff0000u | id; }
constexpr std::uint32_t corner_of_b(std::uint32_t id) { return 0xfffe0000u | id; }
constexpr std::uint32_t edge_of(std::uint32_t from, std::uint32_t to) {
    return from < to ? from << 8 | to : to << 8 | from;
}
constexpr std::uint32_t edges_of(std::uint32_t edge_a, std::uint32_t edge_b) { return edge_a << 16 | edge_b; }

/// Adds the points of the incident face, edge or corner that lie over the reference face; none when it lies
/// beside.
void clip_to_face(Contact& c, bool reference_is_b, const SupportingFace& reference,
                  const SupportingFace& incident);

/// Adds one or two points of the edges or corners that face each other. `touch`: where the cores touch or are
/// nearest, if known. `corner_a`, `corner_b`: the hull corners furthest along the normal, if known.
void touch_edges(Contact& c, const Touch& touch, std::uint32_t corner_a = unknown_corner,
                 std::uint32_t corner_b = unknown_corner);

} // namespace lockstone::collide
