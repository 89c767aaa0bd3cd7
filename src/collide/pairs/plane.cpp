// A plane against a convex shape: up to four corners of the shape's lowest face.
#include "collide/core.h"
#include "collide/pairs/box_box.h"
#include "collide/pairs/pairs.h"

#include <algorithm>
#include <limits>

namespace lockstone::collide {

namespace {

/// The hull's lowest corner may be inside the outline of a patch, and then is no corner of the face. Adds it,
/// in place of the nearest point when there are four.
void add_furthest(const SupportPoint& furthest, SupportingFace& face, std::int64_t height_30,
                  ClipPoint (&points)[SupportingFace::corners_max], int& count) {
    if (std::find(face.ids, face.ids + face.count, furthest.id) != face.ids + face.count) return;
    const int at = face.count < SupportingFace::corners_max ? face.count : face.count - 1;
    const Long3& c = furthest.at_30;
    int nearest = 0;
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (int k = 0; k < count; ++k) {
        const std::int64_t off = absolute(points[k].p - c[0]) + absolute(points[k].q - c[2]);
        if (off < least || points[k].line_in == at) nearest = k, least = points[k].line_in == at ? -1 : off;
    }
    if (count < 4 && least >= 0) nearest = count++;
    face.corners_30[at] = c, face.ids[at] = furthest.id;
    points[nearest] = {c[0], c[2], height_30 + c[1], static_cast<std::uint8_t>(at), 0};
}

} // namespace

void collide_plane(const shapes::Solid& b, const RelativePose& pose, Length margin, Manifold& out) {
    // In axes of the plane, from the shape's own origin.
    const Convex shape = convex_of(b, pose.rotation, CoordinateVec3{});
    constexpr Long3 down{0, -(std::int64_t{1} << 30), 0};
    const std::int64_t height_30 = up(pose.position.y.raw - shape.radius.raw, 6);
    out.normal = {Unit{}, unit_one, Unit{}};
    out.on_face = has_discs(shape) ? 0 : 1;
    const bool is_ball = shape.core == Convex::Core::point;
    const SupportPoint furthest = is_ball ? SupportPoint{} : support(shape, down);
    if (height_30 + furthest.at_30[1] > up(margin.raw, 6)) return;
    if (is_ball)
        return add_point(out, {0, -up(shape.radius.raw, 6) - (height_30 >> 1), 0}, height_30, margin, 1);
    SupportingFace face = supporting_face(shape, down);
    ClipPoint points[SupportingFace::corners_max];
    int count = 0;
    for (int k = 0; k < face.count; ++k) {
        const Long3& c = face.corners_30[k];
        const std::int64_t separation = height_30 + c[1];
        if (separation <= up(margin.raw, 6))
            points[count++] = {c[0], c[2], separation, static_cast<std::uint8_t>(k), 0};
    }
    count = reduce_points(points, count);
    if (shape.core == Convex::Core::hull) add_furthest(furthest, face, height_30, points, count);
    for (int k = 0; k < count; ++k) {
        const ClipPoint& p = points[k];
        const std::int64_t lowest = face.corners_30[p.line_in][1] - up(shape.radius.raw, 6);
        add_point(out, {p.p, lowest - (p.height >> 1), p.q}, p.height, margin, 1 + face.ids[p.line_in]);
    }
}

} // namespace lockstone::collide
