// Convex shapes that move along a line without rotation.
//
// The distance of two convex shapes is a convex function of their relative position. Newton's method along the
// line, with the normal of the closest points as gradient, never steps past the first contact and converges
// quadratically.
//
// source: van den Bergen, Ray Casting against General Convex Objects, 2004
#include "collide/core.h"
#include "collide/query/cast_pieces.h"

#include <algorithm>
#include <array>

namespace lockstone::collide {
namespace {

constexpr std::int64_t close_30 = 1024; ///< 1 um: shapes nearer than this count as touching
constexpr int steps_max = 64;

struct Caster {
    const Line& line;    ///< path of the shape's origin, in the solid's frame
    const Convex& shape; ///< with its origin at the origin of the working frame
    std::int64_t reach_24;
    Box box{}; ///< of the shape; set where the solid has triangles or parts
};

/// Where along its path a shape may touch triangles. Separating axes decide this: the axes of the frame and the
/// normal of the triangle.
class TriangleSpans {
  public:
    explicit TriangleSpans(const Caster& caster) : c(caster) {
        for (int i = 0; i < 3; ++i) {
            const std::int64_t u = c.line.unit_60[i];
            moves[i] = absolute(u) >= slow_60;
            if (moves[i]) inverse_44[i] = divide_shifted(one_60, u, 44);
            const std::int64_t way = moves[i] ? 0 : absolute(c.line.way_24[i]);
            // The box meets the triangle while the triangle, seen from the start, is between these.
            low_24[i] = c.line.from_24[i] + c.box.lower_24[i] - guard_24 - way;
            high_24[i] = c.line.from_24[i] + c.box.upper_24[i] + guard_24 + way;
        }
    }
    /// A superset of the part of the line on which the shape may touch the triangle.
    Span of(const shapes::Face& t) const {
        Span span{0, c.line.length_30};
        for (int i = 0; i < 3; ++i) {
            const std::int64_t p = t.corner[0][i].raw, q = t.corner[1][i].raw, r = t.corner[2][i].raw;
            const std::int64_t before = smaller(p, smaller(q, r)) - high_24[i],
                               behind = larger(p, larger(q, r)) - low_24[i];
            if (!moves[i]) {
                if (before > 0 || behind < 0) return {1, 0};
                continue;
            }
            const std::int64_t first = place_30(before, i), last = place_30(behind, i);
            span.enter_30 = larger(span.enter_30, smaller(first, last));
            span.exit_30 = smaller(span.exit_30, larger(first, last));
        }
        if (!span.empty()) cut_at_plane(t, span);
        return span;
    }

  private:
    static constexpr std::int64_t one_60 = std::int64_t{1} << 60;
    /// Along axes on which it moves less than this part of its path, the shape counts as larger instead.
    static constexpr std::int64_t slow_60 = std::int64_t{1} << 48;
    static constexpr std::int64_t guard_24 = 256; ///< more than close_30 and the errors of place_30()
    /// More than close_30, and than the roundings of a normal over a triangle.
    static constexpr std::int64_t gap_guard_30 = 8192;

    std::int64_t place_30(std::int64_t way_24, int axis) const {
        return static_cast<std::int64_t>((Wide::product(way_24, inverse_44[axis]) >> 38).low_bits());
    }
    /// Removes the part before the shape touches the triangle's plane. All is removed when it never does.
    void cut_at_plane(const shapes::Face& t, Span& span) const {
        const Long3 plane = raw(t.normal);
        const std::int64_t above = dot_dropped(c.line.from_24 - raw(t.corner[0]), plane, 24);
        const Long3 n = above < 0 ? -plane : plane;
        const std::int64_t lowest = dot_dropped(support(c.shape, -n).at_30, n, 30);
        const std::int64_t gap =
            absolute(above) + lowest - up(std::int64_t{c.shape.radius.raw}, 6) - gap_guard_30;
        if (gap <= 0) return;
        const std::int64_t towards = -slope_60(n, c.line.unit_60);
        if (towards <= 0) {
            span = {1, 0};
            return;
        }
        const std::int64_t enter =
            (gap >> 33) == 0 ? (gap << 30) / ((towards >> 30) + 1) : divide_shifted(gap, towards, 60) - 1;
        span.enter_30 = larger(span.enter_30, enter);
    }

    const Caster& c;
    bool moves[3];
    std::int64_t inverse_44[3] = {};
    std::int64_t low_24[3], high_24[3];
};

Long3 position_24(const Line& line, std::int64_t at_30) {
    return at_30 == 0 ? line.from_24 : shifted(point_30(line, at_30), 6);
}

/// A ball that moves towards triangles.
struct BallPath {
    const Line& line;
    std::int64_t radius_24;

    /// Within 32 m on each axis: products fit 64 bits.
    static bool is_near(Long3 x) { return ((absolute(x[0]) | absolute(x[1]) | absolute(x[2])) >> 29) == 0; }
    /// Within 16 m on each axis: the difference of two such points is near.
    static bool is_close(Long3 x) {
        constexpr std::int64_t most = std::int64_t{1} << 28;
        return static_cast<std::uint64_t>((x[0] + most) | (x[1] + most) | (x[2] + most)) >> 29 == 0;
    }
    /// Finds the first distance after `from_30` at which the ball touches the plane from the front, with half
    /// of the touching distance left. The ball's centre is at `from_24` at the start. Returns false, with no
    /// result, when the ball already touches the plane or is far away.
    bool find_plane(const shapes::FacePlane& plane, std::int64_t from_30, Long3 from_24,
                    std::int64_t slope_60, std::int64_t& at_30) const {
        const Long3 off = from_24 - raw(plane.on);
        if (!is_near(off)) return false;
        const std::int64_t gap = shift_right_rounded(dot(raw(plane.normal), off), 24) - up(radius_24, 6);
        if (gap <= close_30) return false;
        // Except at grazing angles, and within 8 m, 30 bits of the slope give a billionth of the distance.
        constexpr std::int64_t steep_60 = std::int64_t{1} << 55;
        const std::int64_t way = gap - close_30 / 2;
        at_30 = add_saturated(from_30, -slope_60 >= steep_60 && (way >> 33) == 0
                                           ? (way << 30) / (-slope_60 >> 30)
                                           : divide_shifted(way, -slope_60, 60));
        return true;
    }
    /// True when the ball's centre is above the triangle.
    static bool is_above(const shapes::Face& triangle, Long3 at_24) {
        const Long3 normal = raw(triangle.normal);
        const Long3 off[3] = {at_24 - raw(triangle.corner[0]), at_24 - raw(triangle.corner[1]),
                              at_24 - raw(triangle.corner[2])};
        const bool all_close = is_close(off[0]) && is_close(off[1]) && is_close(off[2]);
        for (int k = 0; k < 3; ++k) {
            const Long3 edge = off[k] - off[(k + 1) % 3];
            if (!all_close && (!is_near(off[k]) || !is_near(edge))) return false;
            if (dot(shifted(cross(edge, normal), 31), off[k]) > 0) return false;
        }
        return true;
    }
    /// The hit of a ball on a triangle's face, at a distance within the line.
    CastHit hit_on_face(const shapes::Face& triangle, std::int64_t at_30, Long3 at_24) const {
        CastHit hit;
        hit.distance = distance_at(at_30);
        hit.fraction = fraction_of(line, at_30);
        hit.point = coordinates(at_24 - shifted(raw(triangle.normal) * (radius_24 + (close_30 >> 7)), 30));
        hit.normal = triangle.normal;
        hit.feature = triangle.index;
        return hit;
    }
    static Coordinate distance_at(std::int64_t at_30) {
        return Coordinate::from_raw(shift_right_rounded(at_30, 6));
    }
};

/// Finds the first contact with an obstacle in a range of the line. Sets `hit` when the result is true.
bool cast_at(const Caster& c, const Obstacle& o, Span span, CastHit& hit) {
    constexpr std::int64_t no_limit = std::int64_t{1} << 60;
    std::int64_t at = span.enter_30;
    Between last{};
    Long3 seen_from{};
    for (int i = 0; i < steps_max; ++i) {
        const Long3 position = position_24(c.line, at);
        const Between b = between(o, c.shape, position, no_limit);
        if (b.overlap && at == 0) {
            hit = hit_at_start(c.line, o.feature);
            return true;
        }
        const std::int64_t slope = dot_dropped(b.normal_30, c.line.unit_60, 30);
        if (!b.overlap && slope >= 0) return false;
        if (!b.overlap) last = b, seen_from = position;
        if (b.overlap || b.distance_30 <= close_30 || i + 1 == steps_max) {
            hit = hit_at(c.line, at, last.normal_30, o.feature);
            hit.point = coordinates(seen_from + shifted(last.on_obstacle_30, 6));
            return true;
        }
        // Step to half of the touching distance: any closer, rounding could turn it into an overlap, which has
        // no normal.
        at = add_saturated(at, larger(1, divide_shifted(b.distance_30 - close_30 / 2, -slope, 60)));
        if (at > span.exit_30) return false;
    }
    return false;
}

/// True for a one-sided triangle from which the shape moves away: only an overlap at the start can hit it.
bool faces_away(const Obstacle& o, const Line& line) {
    return o.kind == Obstacle::Kind::triangle && o.one_sided &&
           dot_dropped(raw(o.triangle->normal), line.unit_60, 30) >= 0;
}

bool overlaps_at_start(const Caster& c, const Obstacle& o) {
    return between(o, c.shape, c.line.from_24, close_30).overlap;
}

void try_obstacle(const Caster& c, const Obstacle& o, Span span, CastHit& hit, bool& found) {
    CastHit at{};
    if (faces_away(o, c.line)) {
        if (span.enter_30 != 0 || !overlaps_at_start(c, o)) return;
        at = hit_at_start(c.line, o.feature);
    } else {
        if (found) span.exit_30 = smaller(span.exit_30, up(hit.distance.raw, 6) + close_30);
        if (span.empty() || !cast_at(c, o, span, at)) return;
    }
    if (!found || comes_first(at, hit)) hit = at;
    found = true;
}

/// A ball at the origin. Its axes stay zero: no computation reads them.
Convex ball_of(std::int64_t radius_24) {
    Convex ball{};
    ball.core = Convex::Core::point;
    ball.radius = Coordinate::from_raw(radius_24);
    return ball;
}

/// Casts a ball against triangles. Contacts with faces come first, because each one ends the search for edge
/// contacts beyond it. The order changes speed only.
class BallCaster {
  public:
    /// For the part `where` of a path. `at_24`: the ball's centre at its start. `first` and `any` receive the
    /// hit.
    BallCaster(const shapes::Solid& of, const BallPath& way, Span where, Long3 at_24, CastHit& first,
               bool& any)
        : solid(of), path(way), span(where), from_24(at_24), hit(first), found(any) {}

    /// Tests one triangle by its plane. face() returns the triangle of the plane.
    template <class MakeFace> void visit(const shapes::FacePlane& plane, MakeFace&& face) {
        const std::int64_t slope = slope_60(raw(plane.normal), path.line.unit_60);
        std::int64_t at = 0;
        if (slope >= 0 || !path.find_plane(plane, span.enter_30, from_24, slope, at))
            return touch(face(), span);
        if (at > span.exit_30) return;
        // Skips a triangle beyond the face already hit. At equal distance the lower index comes first, and was
        // visited before.
        if (at >= face_30 && BallPath::distance_at(at) >= hit.distance) return;
        const shapes::Face& triangle = face();
        const Long3 at_24 = position_24(path.line, at);
        if (!BallPath::is_above(triangle, at_24)) {
            if (count < waiting_max)
                waiting[count++] = {triangle, at};
            else
                touch(triangle, {at, span.exit_30});
            return;
        }
        const CastHit on_face = path.hit_on_face(triangle, at, at_24);
        if (!found || comes_first(on_face, hit)) hit = on_face;
        found = true;
        face_30 = smaller(face_30, at);
    }
    void finish() {
        for (std::size_t i = 0; i < count; ++i) {
            const Waiting& last = waiting[i];
            // The ball touches this triangle later than the face. Among adjacent faces in one plane rounding would
            // decide the order.
            if (last.at_30 >= face_30 - close_30 || (found && last.at_30 >= up(hit.distance.raw, 6)))
                continue;
            touch(last.triangle, {last.at_30, span.exit_30});
        }
    }

  private:
    [[gnu::noinline]] void touch(const shapes::Face& triangle, Span where) {
        const Convex ball = ball_of(path.radius_24);
        const Obstacle o{Obstacle::Kind::triangle,    triangle.index, nullptr, nullptr, &triangle,
                         !shapes::is_two_sided(solid)};
        try_obstacle({path.line, ball, path.radius_24}, o, where, hit, found);
    }

    static constexpr std::size_t waiting_max = 12;
    struct Waiting {
        shapes::Face triangle;
        std::int64_t at_30; ///< the ball does not touch it earlier
    };
    const shapes::Solid& solid;
    const BallPath& path;
    Span span;
    Long3 from_24;
    CastHit& hit;
    bool& found;
    std::int64_t face_30 = std::int64_t{1} << 60; ///< distance at which the ball touches a face first
    std::size_t count = 0;
    std::array<Waiting, waiting_max> waiting;
};

/// Searches along the line in pieces of a few times the shape's size, so that few obstacles are tested twice.
/// Stops when a hit lies before the next piece. look(span, at_24, where) takes the rest of the line, its start
/// and the box of the piece, and returns how many obstacles it tested.
template <class Look>
void look_in_pieces(const shapes::Solid& solid, const Line& line, std::int64_t reach_24, const Box& box,
                    const bool& found, const CastHit& hit, Look&& look) {
    const std::int64_t first_piece = larger(up(reach_24, 6) * 8, std::int64_t{1} << 26);
    Span span{0, line.length_30};
    if (line.length_30 > first_piece) {
        const shapes::Extent e = shapes::extent_of(solid);
        span = span_of_box(line, swept_extent(raw(e.lower), raw(e.upper), reach_24));
    }
    std::int64_t piece = first_piece;
    for (std::int64_t from = span.enter_30; from <= span.exit_30;) {
        if (found && up(hit.distance.raw, 6) <= from) break;
        const std::int64_t end = smaller(from + piece, span.exit_30);
        const Long3 from_24 = position_24(line, from);
        const std::size_t seen =
            look(Span{from, span.exit_30}, from_24, swept_extent(from_24, position_24(line, end), box, 256));
        from = end + 1;
        piece = seen == 0   ? smaller(piece * 2, first_piece * 64)
                : seen > 64 ? larger(piece / 2, first_piece / 8)
                            : piece;
    }
}

/// Tests triangles in the order in which the shape may touch them, so that the first hit ends the search for most
/// others. The order changes speed only.
class TriangleCaster {
  public:
    TriangleCaster(const shapes::Solid& of, const Caster& caster, CastHit& first, bool& any)
        : solid(of), c(caster), spans(caster), hit(first), found(any) {}

    /// Tests the triangles in a box, on the part `rest` of the line. Returns their number.
    std::size_t look(Span rest, const shapes::Extent& where, NarrowScratch& scratch) {
        scratch.triangles.clear();
        shapes::find_triangles(solid, where, scratch.triangles);
        std::size_t count = 0;
        for (const std::uint32_t index : scratch.triangles) {
            const Span may = spans.of(shapes::face_at(solid, index));
            if (may.empty() || may.enter_30 > rest.exit_30 || may.exit_30 < rest.enter_30 ||
                is_late(may.enter_30))
                continue;
            waiting[count++] = {may.enter_30, index};
            if (count == waiting_max) finish(rest, count), count = 0;
        }
        finish(rest, count);
        return scratch.triangles.size();
    }

  private:
    static constexpr std::size_t waiting_max = 64;
    struct Waiting {
        std::int64_t enter_30; ///< the shape does not touch it earlier
        std::uint32_t index;
    };
    bool is_late(std::int64_t at_30) const { return found && at_30 > up(hit.distance.raw, 6) + close_30; }
    void finish(Span rest, std::size_t count) {
        std::sort(waiting.begin(), waiting.begin() + static_cast<std::ptrdiff_t>(count),
                  [](const Waiting& a, const Waiting& b) {
                      return a.enter_30 != b.enter_30 ? a.enter_30 < b.enter_30
                                                      : a.index < b.index; // no order of equals
                  });
        for (std::size_t i = 0; i < count && !is_late(waiting[i].enter_30); ++i) {
            const shapes::Face triangle = shapes::face_at(solid, waiting[i].index);
            const Obstacle o{Obstacle::Kind::triangle,    triangle.index, nullptr, nullptr, &triangle,
                             !shapes::is_two_sided(solid)};
            try_obstacle(c, o, rest, hit, found);
        }
    }

    const shapes::Solid& solid;
    const Caster& c;
    TriangleSpans spans;
    CastHit& hit;
    bool& found;
    std::array<Waiting, waiting_max> waiting;
};

bool cast_in_pieces(const shapes::Solid& solid, const Caster& c, NarrowScratch& scratch, CastHit& hit) {
    bool found = false;
    if (has_triangles(solid)) {
        TriangleCaster triangles(solid, c, hit, found);
        look_in_pieces(solid, c.line, c.reach_24, c.box, found, hit,
                       [&](Span rest, Long3, const shapes::Extent& where) {
                           return triangles.look(rest, where, scratch);
                       });
        return found;
    }
    look_in_pieces(solid, c.line, c.reach_24, c.box, found, hit,
                   [&](Span rest, Long3, const shapes::Extent& where) {
                       std::size_t seen = 0;
                       for_each_obstacle(solid, where, scratch, [&](const Obstacle& o) {
                           ++seen;
                           try_obstacle(c, o, rest, hit, found);
                       });
                       return seen;
                   });
    return found;
}

bool holds(const shapes::Extent& all, const shapes::Extent& part) {
    for (int i = 0; i < 3; ++i)
        if (part.lower[i] < all.lower[i] || part.upper[i] > all.upper[i]) return false;
    return true;
}

/// Returns true when the cache holds all triangles whose boxes meet `where`. When it does not cover `where`, it is
/// first filled again with the triangles around `where`; if they are many, it stays empty and the result is false.
bool keeps(NearFaces& near, const shapes::Solid& solid, const shapes::Extent& where, std::int64_t radius_24,
           NarrowScratch& scratch) {
    if (near.of == solid.geometry && holds(near.within, where)) return !near.too_many;
    constexpr std::size_t few = 64; // every cast of a ball tests each of them
    near.of = solid.geometry;
    near.within = swept_extent(raw(where.lower), raw(where.upper), 2 * radius_24);
    near.faces.clear();
    scratch.triangles.clear();
    shapes::find_triangles(solid, near.within, scratch.triangles);
    near.too_many = scratch.triangles.size() > few;
    for (std::size_t i = 0; i < scratch.triangles.size() && !near.too_many; ++i) {
        const shapes::Face face = shapes::face_at(solid, scratch.triangles[i]);
        const CoordinateVec3(&c)[3] = face.corner;
        near.faces.push_back({{min(c[0], min(c[1], c[2])), max(c[0], max(c[1], c[2]))}, face});
    }
    return !near.too_many;
}

/// True when the bounds of a shape along its path are apart from those of a convex solid. False when this is unknown, for
/// shapes whose bounds take long to compute.
bool passes_beside(const Caster& c, const shapes::Solid& solid) {
    constexpr std::int64_t guard_24 = 256; // more than close_30
    const Convex& shape = c.shape;
    const bool is_box = shape.core == Convex::Core::box, is_segment = shape.core == Convex::Core::segment;
    if (!is_box && !is_segment && shape.core != Convex::Core::point) return false;
    const shapes::Extent extent = shapes::extent_of(solid);
    for (int i = 0; i < 3; ++i) {
        std::int64_t reach = shape.radius.raw + guard_24;
        if (is_box || is_segment) reach += absolute(shape.axes_30[1][i]) * shape.half_24[1] >> 30;
        if (is_box)
            reach += (absolute(shape.axes_30[0][i]) * shape.half_24[0] +
                      absolute(shape.axes_30[2][i]) * shape.half_24[2]) >>
                     30;
        const std::int64_t from = c.line.from_24[i], to = from + c.line.way_24[i];
        if (smaller(from, to) - reach > extent.upper[i].raw || larger(from, to) + reach < extent.lower[i].raw)
            return true;
    }
    return false;
}

bool cast_convex(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                 const Line& way, NarrowScratch& scratch, CastHit& hit) {
    // Above a plane only the height counts: a position far beside the plane's origin would leave the range.
    const CoordinateVec3 from = solid.geometry.kind == ShapeKind::plane
                                    ? CoordinateVec3{Coordinate{}, pose.position.y, Coordinate{}}
                                    : pose.position;
    Line line = way;
    if (!move_line(from, line)) return false;
    const bool is_ball = moving.geometry.kind == ShapeKind::sphere;
    const std::int64_t reach = reach_24(moving);
    if (is_ball && has_triangles(solid)) return cast_ball(solid, line, reach, nullptr, scratch, hit);
    const Convex shape = is_ball ? ball_of(reach) : convex_of(moving, pose.rotation, CoordinateVec3{});
    Caster c{line, shape, reach};
    if (has_triangles(solid) || solid.geometry.kind == ShapeKind::compound) {
        c.box = box_of(shape);
        return cast_in_pieces(solid, c, scratch, hit);
    }
    const Obstacle whole{solid.geometry.kind == ShapeKind::plane ? Obstacle::Kind::plane
                                                                 : Obstacle::Kind::convex,
                         0,
                         &solid,
                         nullptr,
                         nullptr,
                         false};
    Span span{0, line.length_30};
    if (whole.kind != Obstacle::Kind::plane && passes_beside(c, solid)) return false;
    if (whole.kind != Obstacle::Kind::plane)
        span = span_of_ball(line, Long3{}, reach_24(solid) + c.reach_24 + 256);
    if (span.empty() || !cast_at(c, whole, span, hit)) return false;
    if (whole.kind == Obstacle::Kind::plane) hit.point.x += pose.position.x, hit.point.z += pose.position.z;
    return true;
}

} // namespace

bool cast_ball(const shapes::Solid& solid, const Line& line, std::int64_t radius_24, NearFaces* near,
               NarrowScratch& scratch, CastHit& hit) {
    const BallPath path{line, radius_24};
    const Box box{{-radius_24, -radius_24, -radius_24}, {radius_24, radius_24, radius_24}};
    bool found = false;
    look_in_pieces(solid, line, radius_24, box, found, hit,
                   [&](Span rest, Long3 from_24, const shapes::Extent& where) {
                       BallCaster balls(solid, path, rest, from_24, hit, found);
                       std::size_t seen = 0;
                       if (near != nullptr && keeps(*near, solid, where, radius_24, scratch)) {
                           for (const NearFaces::Entry& e : near->faces) {
                               if (!shapes::overlap(e.box, where)) continue;
                               ++seen;
                               balls.visit({e.face.corner[0], e.face.normal},
                                           [&e]() -> const shapes::Face& { return e.face; });
                           }
                       } else {
                           scratch.triangles.clear();
                           shapes::find_triangles(solid, where, scratch.triangles);
                           seen = scratch.triangles.size();
                           for (const std::uint32_t index : scratch.triangles)
                               balls.visit(shapes::plane_at(solid, index),
                                           [&] { return shapes::face_at(solid, index); });
                       }
                       balls.finish();
                       return seen;
                   });
    return found;
}

bool cast_shape(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                CoordinateVec3 translation, NarrowScratch& scratch, CastHit& hit) {
    Line way{};
    return make_line(CoordinateVec3{}, translation, way) &&
           cast_shape(solid, moving, pose, way, scratch, hit);
}

bool cast_shape(const shapes::Solid& solid, const shapes::Solid& moving, const RelativePose& pose,
                const Line& way, NarrowScratch& scratch, CastHit& hit) {
    bool found = false;
    if (has_triangles(moving) || moving.geometry.kind == ShapeKind::plane) return false;
    for_each_part(moving, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        CastHit at{};
        const RelativePose where = place == nullptr ? pose : part_pose(pose, *place);
        if (!cast_convex(solid, part, where, way, scratch, at)) return;
        if (!found || comes_first(at, hit)) hit = at;
        found = true;
    });
    return found;
}

} // namespace lockstone::collide
