// Finds the face, edge or generator of a convex core along a direction, from which manifolds are made.
#include "collide/core.h"

#include <algorithm>
#include <limits>
#include <span>

namespace lockstone::collide {
namespace {

/// sin of 0, 45, 90, .. degrees, 30 fraction bits.
constexpr std::int64_t diagonal = 759250125;
constexpr std::int64_t sine[8] = {0, diagonal, one_30, diagonal, 0, -diagonal, -one_30, -diagonal};
constexpr std::int64_t cosine(int k) { return sine[(k + 2) % 8]; }
/// A disc that slopes by at most this over its radius (15 um) counts as flat: its eight corners are then within
/// 1.2 um of its rim.
constexpr std::int64_t lean_24 = 256;
// Names of the points of cylinders and cones: corners 0..7 at the bottom and 16..23 at the top; the lowest
// point of a rim; the ends of a generator.
constexpr std::uint32_t top_corners = 16, rim_bottom = 8, rim_top = 24, end_bottom = 9, end_top = 25;

/// Adds a corner of a face; `at_24` in the shape's axes.
void add_corner(const Convex& shape, SupportingFace& face, Long3 at_24, std::uint32_t id) {
    Long3 p = up(shape.center_24, 6);
    for (int i = 0; i < 3; ++i) p = p + along_30(shape.axes_30[i], at_24[i]);
    face.corners_30[face.count] = p;
    face.ids[face.count++] = id;
}

Facing facing_of_box(const Convex& shape, const Long3& direction) {
    std::int64_t along[3];
    int axis = 0;
    for (int i = 0; i < 3; ++i) {
        along[i] = dot(shape.axes_30[i], direction);
        if (absolute(along[i]) > absolute(along[axis])) axis = i;
    }
    const bool positive = along[axis] >= 0;
    return {positive ? shape.axes_30[axis] : -shape.axes_30[axis],
            static_cast<std::uint32_t>(1 + 2 * axis + (positive ? 1 : 0)), true};
}

void fill_box_face(const Convex& shape, SupportingFace& face) {
    const int axis = static_cast<int>(face.id - 1) / 2;
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    const bool positive = (face.id - 1) % 2 != 0;
    constexpr bool high_u[4] = {false, true, true, false}, high_v[4] = {false, false, true, true};
    for (int k = 0; k < 4; ++k) {
        const int corner = positive ? k : 3 - k; // counter-clockwise from either side
        Long3 at{};
        at[axis] = positive ? shape.half_24[axis] : -shape.half_24[axis];
        at[u] = high_u[corner] ? shape.half_24[u] : -shape.half_24[u];
        at[v] = high_v[corner] ? shape.half_24[v] : -shape.half_24[v];
        add_corner(shape, face, at, (at[0] > 0 ? 1u : 0u) | (at[1] > 0 ? 2u : 0u) | (at[2] > 0 ? 4u : 0u));
    }
}

void triangle_face(const Convex& shape, Long3 direction, SupportingFace& face) {
    const Long3* c = shape.corners_24;
    const Long3 normal = direction_of_30(cross_with_bits(c[1] - c[0], c[2] - c[0], 39)).unit;
    const bool front = dot(normal, direction) >= 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const std::uint32_t corner = front ? k : 2 - k;
        face.corners_30[k] = up(c[corner], 6);
        face.ids[k] = corner;
    }
    face.count = 3;
    face.normal_30 = front ? normal : -normal;
    face.id = front ? 1 : 2;
    face.flat = !is_zero(normal);
}

/// Among the faces at the furthest corner, the face whose normal is nearest to the direction.
Facing facing_of_hull(const Convex& shape, const Long3& direction, std::uint32_t furthest) {
    const shapes::Hull& hull = *shape.hull;
    const Long3 local{shift_right_rounded(dot(shape.axes_30[0], direction), 30),
                      shift_right_rounded(dot(shape.axes_30[1], direction), 30),
                      shift_right_rounded(dot(shape.axes_30[2], direction), 30)};
    if (furthest == unknown_corner) furthest = support(shape, direction).id;
    std::size_t best = 0;
    std::int64_t most = std::numeric_limits<std::int64_t>::min();
    for (std::size_t k = hull.first_face_at[furthest]; k < hull.first_face_at[furthest + 1]; ++k)
        if (const std::int64_t x = dot(local, raw(hull.faces[hull.faces_at[k]].normal)); x > most)
            best = hull.faces_at[k], most = x;
    const Long3 n = raw(hull.faces[best].normal);
    Facing found{n, static_cast<std::uint32_t>(best + 1), true, furthest};
    if (!shape.upright)
        for (int i = 0; i < 3; ++i)
            found.normal_30[i] = shift_right_rounded(
                shape.axes_30[0][i] * n[0] + shape.axes_30[1][i] * n[1] + shape.axes_30[2][i] * n[2], 30);
    return found;
}

void fill_hull_face(const Convex& shape, SupportingFace& face) {
    const shapes::Hull& hull = *shape.hull;
    const shapes::Hull::Face& f = hull.faces[face.id - 1];
    // Uses the patch of nearly coplanar faces, not the face alone: on single facets the body would tip from one
    // to the next, and sink.
    const auto outline = f.patch_count == 0 ? std::span(hull.loops).subspan(f.first, f.count)
                                            : std::span(hull.patches).subspan(f.patch_first, f.patch_count);
    const std::size_t count = outline.size(),
                      kept = std::min(count, std::size_t{SupportingFace::corners_max});
    for (std::size_t k = 0; k < kept; ++k) { // of a face with too many corners, keep some at even steps
        const std::uint32_t id = outline[k * count / kept];
        face.corners_30[face.count] = corner_of(shape, id);
        face.ids[face.count++] = id;
    }
}

/// The components of a direction across the y axis (unit x, z, and length) and along it (height), in the
/// shape's axes. A direction along the axis has x = 1 and z = 0.
struct Flat {
    std::int64_t x, z, length, height;
};
Flat across(const Convex& shape, Long3 direction) {
    const Long3 local{shift_right_rounded(dot(shape.axes_30[0], direction), 30), 0,
                      shift_right_rounded(dot(shape.axes_30[2], direction), 30)};
    const Direction d = direction_of_30(local);
    return {is_zero(local) ? one_30 : d.unit[0], d.unit[2], d.length,
            shift_right_rounded(dot(shape.axes_30[1], direction), 30)};
}

Long3 rim_24(const Convex& shape, std::int64_t x_30, std::int64_t z_30, std::int64_t y_24) {
    const auto scaled = [&](std::int64_t c) {
        return narrow_rounded(Wide::product(c, shape.half_24[0]), 30);
    };
    return {scaled(x_30), y_24, scaled(z_30)};
}

/// A disc: eight corners that turn with the shape, named by position. If the disc is inclined, it also has the
/// point of its rim furthest along the direction, so that it rolls on a circle.
void disc_face(const Convex& shape, const Flat& flat, bool top, SupportingFace& face) {
    const std::int64_t y = top ? shape.half_24[1] : -shape.half_24[1];
    const bool leans = narrow_rounded(Wide::product(flat.length, shape.half_24[0]), 30) > lean_24;
    const auto ahead = [&](int k) {
        return cosine(k) * flat.x - sine[k] * flat.z;
    }; // of corner k, turning from z to x
    for (int i = 0; i < 8; ++i) {
        const int k = top ? i : 7 - i; // counter-clockwise about the outward normal
        const int next = top ? (k + 1) % 8 : (k + 7) % 8;
        add_corner(shape, face, rim_24(shape, sine[k], cosine(k), y),
                   static_cast<std::uint32_t>(k) + (top ? top_corners : 0u));
        const bool between = top ? ahead(k) > 0 && ahead(next) < 0 : ahead(k) < 0 && ahead(next) > 0;
        if (leans && between)
            add_corner(shape, face, rim_24(shape, flat.x, flat.z, y), top ? rim_top : rim_bottom);
    }
    face.normal_30 = top ? shape.axes_30[1] : -shape.axes_30[1];
    face.id = top ? 2 : 1;
    face.flat = true;
}

/// The straight line on the side of a cylinder or cone that is furthest along the direction.
void generator_face(const Convex& shape, const Flat& flat, SupportingFace& face) {
    const std::int64_t h = shape.half_24[1];
    const bool is_cone = shape.core == Convex::Core::cone;
    add_corner(shape, face, rim_24(shape, flat.x, flat.z, -h), end_bottom);
    add_corner(shape, face, is_cone ? Long3{0, h, 0} : rim_24(shape, flat.x, flat.z, h), end_top);
    face.id = 3;
}

void cylinder_face(const Convex& shape, Long3 direction, SupportingFace& face) {
    const Flat flat = across(shape, direction);
    if (absolute(flat.height) >= flat.length) return disc_face(shape, flat, flat.height > 0, face);
    generator_face(shape, flat, face);
}

/// The base, if the direction is nearer to the base's normal than to the side's; else the generator. The side's
/// normal is (2 h, r) / |(2 h, r)|.
void cone_face(const Convex& shape, Long3 direction, SupportingFace& face) {
    const Flat flat = across(shape, direction);
    const Direction side = direction_of_30({2 * shape.half_24[1], shape.half_24[0], 0});
    const std::int64_t towards_side =
        shift_right_rounded(flat.length * side.unit[0] + flat.height * side.unit[1], 30);
    if (-flat.height >= towards_side) return disc_face(shape, flat, false, face);
    generator_face(shape, flat, face);
}

} // namespace

SupportingFace supporting_face(const Convex& shape, Long3 direction, std::uint32_t corner) {
    SupportingFace face; // corners from `count` on stay uninitialized, which saves writing 1 KiB per call
    face.count = 0;
    face.normal_30 = direction;
    face.id = 0;
    face.flat = false;
    switch (shape.core) {
    case Convex::Core::point:
        add_corner(shape, face, Long3{}, 0);
        break;
    case Convex::Core::segment:
        add_corner(shape, face, {0, -shape.half_24[1], 0}, 0);
        if (shape.half_24[1] != 0) add_corner(shape, face, {0, shape.half_24[1], 0}, 2);
        face.id = face.count == 2 ? 1 : 0;
        break;
    case Convex::Core::triangle:
        triangle_face(shape, direction, face);
        break;
    case Convex::Core::cylinder:
        cylinder_face(shape, direction, face);
        break;
    case Convex::Core::cone:
        cone_face(shape, direction, face);
        break;
    case Convex::Core::box:
    case Convex::Core::hull:
        return face_at(shape, facing(shape, direction, corner), direction);
    }
    return face;
}

Facing facing(const Convex& shape, const Long3& direction, std::uint32_t corner) {
    if (shape.core == Convex::Core::box) return facing_of_box(shape, direction);
    if (shape.core == Convex::Core::hull) return facing_of_hull(shape, direction, corner);
    const SupportingFace face = supporting_face(shape, direction);
    return {face.normal_30, face.id, face.flat};
}

SupportingFace face_at(const Convex& shape, const Facing& at, const Long3& direction) {
    if (shape.core != Convex::Core::box && shape.core != Convex::Core::hull)
        return supporting_face(shape, direction);
    SupportingFace face;
    face.count = 0;
    face.normal_30 = at.normal_30;
    face.id = at.id;
    face.flat = at.flat;
    if (shape.core == Convex::Core::box)
        fill_box_face(shape, face);
    else
        fill_hull_face(shape, face);
    return face;
}

} // namespace lockstone::collide
