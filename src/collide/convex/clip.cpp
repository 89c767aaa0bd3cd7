// A face, edge or corner clipped by the sides of a reference face.
//
// source: Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974.
#include "collide/manifold.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

constexpr int corners_max = SupportingFace::corners_max;
constexpr int points_max = 2 * corners_max;
constexpr std::uint8_t side_lines =
    corners_max; ///< lines below are incident edges, from here on reference sides

/// Corners outside of a side by at most this are kept, so that roundings do not cut the corners of equal faces.
constexpr std::int64_t slack_30 = std::int64_t{1} << 10; // 1 um

/// The reference plane: coordinates in the plane, and heights above it along the contact's normal.
class Plane {
  public:
    Plane(const SupportingFace& face, Long3 direction)
        : origin(face.corners_30[0]), normal(face.normal_30), along(direction) {
        int least = 0;
        for (int i = 1; i < 3; ++i)
            if (absolute(normal[i]) < absolute(normal[least])) least = i;
        Long3 axis{};
        axis[least] = 1;
        p = direction_of_30(cross(normal, axis)).unit;
        q = shifted(cross(normal, p), 30);
        slope = dot(normal, along) >> 30;
        is_straight = is_same(normal, along);
    }
    ClipPoint point(Long3 x) const {
        Long3 d = x - origin;
        std::int64_t height = dot_unit(d, normal);
        if (!is_straight) height = divide_shifted(height, slope, 30);
        d = d - times_unit(along, height);
        return {dot_unit(d, p), dot_unit(d, q), height, 0, 0};
    }
    /// A point of the plane in the working frame.
    Long3 place(std::int64_t x, std::int64_t y) const {
        const auto part = [&](int i) {
            return origin[i] + narrow_rounded(Wide::product(p[i], x) + Wide::product(q[i], y), 30);
        };
        return {part(0), part(1), part(2)};
    }

  private:
    Long3 origin, normal, along, p{}, q{};
    std::int64_t slope;
    bool is_straight;
};

/// A polygon, or a segment of two points when it is open. Coordinates are in steps of 2^shift.
struct Polygon {
    ClipPoint points[points_max];
    int count;
    bool is_open;
};

ClipPoint between(const ClipPoint& a, const ClipPoint& b, std::int64_t part_30) {
    const auto mix = [&](std::int64_t x, std::int64_t y) {
        return x + narrow_rounded(Wide::product(y - x, part_30), 30);
    };
    return {mix(a.p, b.p), mix(a.q, b.q), mix(a.height, b.height), 0, 0};
}

/// Keeps the part to the left of the side from `from` to `to`. Coordinates are within 2^29.
void clip_side(Polygon& polygon, const ClipPoint& from, const ClipPoint& to, std::uint8_t line,
               std::int64_t slack) {
    const std::int64_t ep = to.p - from.p, eq = to.q - from.q;
    const std::int64_t allowed = -larger(absolute(ep), absolute(eq)) * slack;
    std::int64_t inside[points_max], least = 0;
    for (int k = 0; k < polygon.count; ++k) {
        const ClipPoint& x = polygon.points[k];
        inside[k] = ep * (x.q - from.q) - eq * (x.p - from.p);
        least = smaller(least, inside[k]);
    }
    if (least >= allowed) return;
    ClipPoint whole[points_max];
    const int count = polygon.count;
    std::copy_n(polygon.points, count, whole);
    int n = 0;
    for (int k = 0; k < count && n < points_max; ++k) {
        const int next = k + 1 == count ? 0 : k + 1;
        const ClipPoint &a = whole[k], &b = whole[next];
        const bool a_stays = inside[k] >= allowed, b_stays = inside[next] >= allowed;
        if (a_stays) polygon.points[n++] = a;
        if (a_stays == b_stays || n == points_max || (polygon.is_open && next == 0)) continue;
        const std::int64_t part =
            clamped(divide_shifted(inside[k], inside[k] - inside[next], 30), 0, std::int64_t{1} << 30);
        ClipPoint cut = between(a, b, part);
        cut.line_in = a_stays ? a.line_out : line;
        cut.line_out = a_stays ? line : a.line_out;
        polygon.points[n++] = cut;
    }
    polygon.count = n;
}

/// Scales the coordinates of two polygons down to at most 2^29 and returns the number of bits dropped.
int scale_down(Polygon& one, Polygon& other) {
    std::int64_t most = 0;
    const auto each = [&](auto&& visit) {
        for (Polygon* polygon : {&one, &other})
            for (int k = 0; k < polygon->count; ++k) visit(polygon->points[k]);
    };
    each([&](const ClipPoint& x) { most = larger(most, larger(absolute(x.p), absolute(x.q))); });
    const int excess = bit_length(static_cast<std::uint64_t>(most)) - 29;
    if (excess <= 0) return 0;
    each([&](ClipPoint& x) {
        x.p = shift_right_rounded(x.p, excess), x.q = shift_right_rounded(x.q, excess);
    });
    return excess;
}

/// The name of the features that meet in a corner of the clipped polygon.
std::uint32_t name_of(const ClipPoint& x, bool reference_is_b, const SupportingFace& reference,
                      const SupportingFace& incident) {
    const auto edge = [](const SupportingFace& f, int k) {
        return edge_of(f.ids[k], f.ids[(k + 1) % f.count]);
    };
    const int low = x.line_in < x.line_out ? x.line_in : x.line_out,
              high = x.line_in < x.line_out ? x.line_out : x.line_in;
    if (high < side_lines) {
        const std::uint32_t id = incident.ids[x.line_out];
        return reference_is_b ? corner_of_a(id) : corner_of_b(id);
    }
    // Two adjacent sides name their corner; other sides meet where a corner was cut off.
    if (low >= side_lines) {
        const int first = low - side_lines, second = high - side_lines;
        const int corner = second == first + 1 ? second : first;
        const std::uint32_t id = reference.ids[corner];
        return reference_is_b ? corner_of_b(id) : corner_of_a(id);
    }
    const std::uint32_t mine = edge(incident, low), other = edge(reference, high - side_lines);
    return reference_is_b ? edges_of(mine, other) : edges_of(other, mine);
}

Polygon polygon_of(const Plane& plane, const SupportingFace& face) {
    Polygon out;
    out.count = face.count;
    out.is_open = face.count == 2;
    for (int k = 0; k < face.count; ++k) {
        out.points[k] = plane.point(face.corners_30[k]);
        out.points[k].line_in = static_cast<std::uint8_t>((k + face.count - 1) % face.count);
        out.points[k].line_out = static_cast<std::uint8_t>(k);
    }
    return out;
}

} // namespace

void clip_to_face(Contact& c, bool reference_is_b, const SupportingFace& reference,
                  const SupportingFace& incident) {
    const Plane plane(reference, reference_is_b ? -c.normal_30 : c.normal_30);
    Polygon polygon = polygon_of(plane, incident), sides = polygon_of(plane, reference);
    const int dropped = scale_down(polygon, sides);
    for (int k = 0; k < sides.count && polygon.count > 0; ++k)
        clip_side(polygon, sides.points[k], sides.points[(k + 1) % sides.count],
                  static_cast<std::uint8_t>(side_lines + k), slack_30 >> dropped);

    const std::int64_t radii = c.radius_a_30() + c.radius_b_30();
    int count = 0;
    for (int k = 0; k < polygon.count; ++k) {
        ClipPoint& x = polygon.points[k];
        x.height -= radii;
        if (x.height <= up(c.margin.raw, 6)) polygon.points[count++] = x;
    }
    count = reduce_points(polygon.points, count);
    c.out.on_face = has_discs(c.a) || has_discs(c.b) ? 0 : 1;
    for (int k = 0; k < count; ++k) {
        const ClipPoint& x = polygon.points[k];
        const Long3 at = plane.place(up(x.p, dropped), up(x.q, dropped));
        const std::uint32_t name = name_of(x, reference_is_b, reference, incident);
        if (reference_is_b)
            c.add_below_b(at, x.height, name);
        else
            c.add_above_a(at, x.height, name);
    }
}

} // namespace lockstone::collide
