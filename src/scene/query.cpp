// The queries of a world. They update poses, bounds and the broad phase to the state, which changes nothing that a
// tick reads, and call src/collide.
#include "scene/query.h"

#include "collide/query/cast_line.h"
#include "lockstone/math/math.h"
#include "scene/surface.h"

#include <algorithm>
#include <array>
#include <tuple>

namespace lockstone::sim {

namespace {

void refresh(const Scene& scene) {
    if (scene.placed.structure_stale || !scene.placed.is_current)
        update_bounds(scene.model, scene.placed, scene.tasks);
    scene.placed.broad_phase.update_trees();
}

/// One query: updated caches, which do not change during its lifetime, and its own scratch memory.
class Asking {
  public:
    explicit Asking(const Scene& scene) : w(scene.model), placed(scene.placed), query(scene.query) {
        const base::Holds holds(query.lock);
        refresh(scene);
        wide = scene.placed.broad_phase.prepare_query();
        if (query.idle.empty()) query.idle.push_back(std::make_unique<QueryWork>());
        work = std::move(query.idle.back());
        query.idle.pop_back();
    }
    ~Asking() {
        const base::Holds holds(query.lock);
        query.idle.push_back(std::move(work));
    }
    Asking(const Asking&) = delete;
    Asking& operator=(const Asking&) = delete;

    const Model& w;
    const PlacedShapes& placed;
    QueryScratch& query;
    const collide::WideTree* wide; ///< may be null
    std::unique_ptr<QueryWork> work;
};

bool is_seen(const Model& w, const ShapeRow& shape, const QueryFilter& filter) {
    const ShapeTraits& traits = w.traits_of(shape);
    if (traits.sensor != 0 && filter.sensors == 0) return false;
    if ((filter.category & traits.mask) == 0 || (filter.mask & traits.category) == 0) return false;
    if (shape.body == filter.ignore) return false;
    const BodyKind kind = w.state.rows(w.m.body_info)[w.row_of(shape.body)].kind;
    return (filter.kinds >> static_cast<std::uint32_t>(kind) & 1u) != 0;
}

const ShapeRow& row_of_slot(const Model& w, std::uint32_t slot) {
    return w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[slot].row];
}

/// The moving object of a cast: a ray, or a solid at a pose.
struct Cast {
    Vec3 from, way;
    const shapes::Solid* solid; ///< null: a ray
    Quat rotation;
    Coordinate reach;
    collide::NearFaces* near; ///< the cache of a ball that is cast again and again, else null
    bool sees_overlaps; ///< a shape that overlaps the object at the start is a hit; if false, it is ignored
    collide::Line line; ///< from 0 along the path, world axes
};

bool make_cast(Vec3 from, Vec3 way, const QueryFilter& filter, Cast& out) {
    out.from = from;
    out.way = way;
    out.solid = nullptr;
    out.rotation = Quat::identity();
    out.reach = Coordinate{};
    out.near = nullptr;
    out.sees_overlaps = filter.overlaps != 0;
    for (int i = 0; i < 3; ++i)
        if (abs(way[i]) > query_length_max) return false;
    return collide::make_line(CoordinateVec3{}, to<Coordinate>(way), out.line) &&
           out.line.length_30 <= query_length_max.raw >> 2;
}

/// Makes a cast like `other` from another point, if the path is equal.
bool make_cast_beside(Vec3 from, Vec3 way, const QueryFilter& filter, const Cast& other, Cast& out) {
    if (way != other.way) return make_cast(from, way, filter, out);
    out = other;
    out.from = from;
    return true;
}

/// Resolves a geometry to a solid. Returns false if it cannot be cast or queried.
bool find_solid(const Scene& scene, const Geometry& geometry, shapes::Solid& out) {
    const base::Holds holds(scene.query.lock); // the solids are a cache, which keeps scaled hulls
    const Result<shapes::Solid> solid = scene.placed.solids.resolve(geometry);
    if (!solid || solid->geometry.kind >= ShapeKind::height_field) return false;
    out = *solid;
    return true;
}
///< A frame of the plane with its origin below a point.
/// Where a plane's frame is for something at a point: straight below it.
Transform plane_below(const Transform& plane, Vec3 point) {
    const UnitVec3 n = to_rotation(plane.rotation).y;
    const Real height = dot<Real>(n, point - plane.position);
    return {point - scale<Real>(n, height), plane.rotation};
}

/// Most shapes are not rotated; then vectors are equal in their frame and in the world.
bool is_turned(const Rotation& axes) { return axes != Rotation::identity(); }

/// A hit of a cast on a shape, in the shape's frame.
struct Met {
    const PlacedShapes::Shape* at;
    std::uint32_t slot;
    Vec3 origin; ///< of the frame; its axes are those of the shape
    collide::CastHit local;
    std::int64_t travelled_30;

    /// In the order of QueryHits.
    friend bool operator<(const Met& a, const Met& b) {
        return std::tie(a.travelled_30, a.slot, a.local.feature) <
               std::tie(b.travelled_30, b.slot, b.local.feature);
    }
};

FirstHit world_hit(const ShapeRow& shape, Vec3 origin, const Rotation& axes, const collide::CastHit& hit,
                   Real distance) {
    const bool turned = is_turned(axes);
    return {shape.id,
            shape.body,
            distance,
            origin + (turned ? lockstone::mul<Real>(axes, hit.point) : to<Real>(hit.point)),
            turned ? lockstone::mul<Unit>(axes, hit.normal) : hit.normal,
            hit.feature};
}
FirstHit world_hit(const Asking& asking, const Met& met) {
    return world_hit(row_of_slot(asking.w, met.slot), met.origin, axes_of(*met.at), met.local,
                     Real::from_raw(met.travelled_30 << 2));
}

QueryHit query_hit(const Asking& asking, const FirstHit& hit) {
    return {hit.shape, hit.body,   hit.distance, Unit{},
            hit.point, hit.normal, hit.feature,  part_of(asking.w, asking.placed, hit.shape, hit.feature)};
}
QueryHit query_hit(const Asking& asking, const Cast& cast, const Met& met) {
    QueryHit out = query_hit(asking, world_hit(asking, met));
    out.fraction = collide::fraction_of(cast.line, met.travelled_30);
    return out;
}

/// Converts only the part of the path near the shape to the shape's frame, so that the rounding of the rotation does
/// not grow with the path. Returns true if the cast hits the shape.
bool cast_at(const Asking& asking, const Cast& cast, std::uint32_t slot, collide::Span span, Met& out) {
    collide::NarrowScratch& narrow = asking.work->narrow;
    const PlacedShapes::Shape& at = asking.placed.shape[slot];
    out.at = &at;
    out.slot = slot;
    out.origin = at.solid.geometry.kind == ShapeKind::plane ? plane_below(at.pose, cast.from).position
                                                            : at.pose.position;
    collide::Line line = cast.line;
    if (!collide::move_line(to<Coordinate>(cast.from - out.origin), line)) return false;
    const bool turns = at.pose.rotation != Quat::identity(),
               is_whole = span.enter_30 <= 0 && span.exit_30 >= line.length_30 && !turns;
    if (is_whole && cast.solid != nullptr && cast.solid->geometry.kind == ShapeKind::sphere &&
        collide::has_triangles(at.solid)) {
        if (!collide::cast_ball(at.solid, line, collide::reach_24(*cast.solid), cast.near, narrow, out.local))
            return false;
    } else {
        const CoordinateVec3 begin = collide::coordinates(collide::place_24(line, span.enter_30));
        const CoordinateVec3 end = collide::coordinates(collide::place_24(line, span.exit_30));
        CoordinateVec3 from = begin, way = end - begin;
        if (turns) {
            const Rotation axes = axes_of(at);
            from = mul_transposed<Coordinate>(axes, from), way = mul_transposed<Coordinate>(axes, way);
        }
        if (cast.solid == nullptr) {
            if (!collide::cast_ray(at.solid, from, way, narrow, out.local)) return false;
        } else {
            collide::Line part = line;
            if (!is_whole && !collide::make_line(CoordinateVec3{}, way, part)) return false;
            const Rotation turned = cast.solid->geometry.kind == ShapeKind::sphere
                                        ? Rotation::identity()
                                        : to_rotation(conjugate(at.pose.rotation) * cast.rotation);
            if (!collide::cast_shape(at.solid, *cast.solid, {turned, from}, part, narrow, out.local))
                return false;
        }
    }
    out.travelled_30 = std::min(span.enter_30 + (out.local.distance.raw << 6), line.length_30);
    return true;
}

/// The place of a point in the broad phase, rounded down.
Vector3<Bound> bound_below(Vec3 p, int shift) {
    const auto low = [shift](Real x) {
        return Bound::from_raw(
            saturate_to_int32(x.raw >> (Real::fraction_bits - Bound::fraction_bits + shift)));
    };
    return {low(p.x), low(p.y), low(p.z)};
}

/// The bounds of a moving box at both ends of its path.
collide::SweptBox swept_box(const Model& w, const Cast& cast) {
    const int shift = static_cast<int>(w.state.rows(w.m.config)[0].bounds_shift);
    if (cast.solid != nullptr)
        return {collide::bounds_of(*cast.solid, {cast.from, cast.rotation}, Length{}, shift),
                collide::bounds_of(*cast.solid, {cast.from + cast.way, cast.rotation}, Length{}, shift)};
    const auto point = [shift](Vec3 p) {
        const Vector3<Bound> lower = bound_below(p, shift);
        return collide::expand({lower, lower}, Bound::from_raw(2));
    };
    return {point(cast.from), point(cast.from + cast.way)};
}

/// Adds all planes, as they have no bounds, and removes shapes that the filter excludes.
void add_planes(const Asking& asking, const QueryFilter& filter) {
    std::vector<std::uint32_t>& slots = asking.work->near.proxies;
    slots.insert(slots.end(), asking.placed.planes.begin(), asking.placed.planes.end());
    std::erase_if(
        slots, [&](std::uint32_t slot) { return !is_seen(asking.w, row_of_slot(asking.w, slot), filter); });
}

/// Stores the shapes whose bounds a cast may hit in `near`.
void find_near(const Asking& asking, const Cast& cast, const QueryFilter& filter) {
    asking.placed.broad_phase.query(swept_box(asking.w, cast), asking.wide, asking.work->near);
    add_planes(asking, filter);
}

/// Stores the shapes that the box around several casts of solids overlaps in `near`.
void find_near(const Asking& asking, std::span<const Cast> casts, const QueryFilter& filter) {
    const PlacedShapes& s = asking.placed;
    Vec3 lower = casts[0].from, upper = lower;
    for (const Cast& cast : casts) {
        const Real reach = to<Real>(cast.reach);
        const Vec3 end = cast.from + cast.way, wide{reach, reach, reach};
        lower = min(lower, min(cast.from, end) - wide);
        upper = max(upper, max(cast.from, end) + wide);
    }
    const int shift = static_cast<int>(asking.w.state.rows(asking.w.m.config)[0].bounds_shift);
    const collide::Bounds around{bound_below(lower, shift), bound_below(upper, shift)};
    s.broad_phase.query(collide::expand(around, Bound::from_raw(2)), asking.wide, asking.work->near);
    add_planes(asking, filter);
}

/// Lists the near shapes that a cast may hit, in the order in which it enters their bounding balls, then by slot.
void find_candidates(const Asking& asking, const Cast& cast) {
    const PlacedShapes& s = asking.placed;
    QueryWork& q = *asking.work;
    q.candidates.clear();
    for (const std::uint32_t slot : q.near.proxies) {
        std::int64_t enter = 0, exit = cast.line.length_30;
        const PlacedShapes::Shape& at = s.shape[slot];
        if (at.solid.geometry.kind != ShapeKind::plane) {
            const collide::Long3 center = collide::raw(to<Coordinate>(at.pose.position - cast.from));
            const collide::Span span =
                collide::span_of_ball(cast.line, center, at.reach.raw + cast.reach.raw);
            if (span.empty()) continue;
            enter = span.enter_30, exit = span.exit_30;
        }
        q.candidates.push_back({enter, exit, slot});
    }
    std::sort(q.candidates.begin(), q.candidates.end(),
              [](const QueryWork::Candidate& a, const QueryWork::Candidate& b) {
                  return std::tie(a.enter, a.slot) < std::tie(b.enter, b.slot);
              });
}

/// Calls visit(met) for the hits of a cast. `visit` returns the distance up to which further hits matter [m, 30
/// fraction bits]. Call find_near() first.
template <class Visit> void for_each_hit_near(const Asking& asking, const Cast& cast, Visit&& visit) {
    find_candidates(asking, cast);
    constexpr std::int64_t slack = 1 << 10; // the distance by which rounding can move a ball
    std::int64_t matters = std::int64_t{1} << 60;
    for (const QueryWork::Candidate& c : asking.work->candidates) {
        if (c.enter > matters + slack) break;
        Met met;
        if (!cast_at(asking, cast, c.slot, {c.enter, c.exit}, met)) continue;
        if (!cast.sees_overlaps && met.local.normal == UnitVec3{}) continue;
        matters = std::min(matters, visit(met));
    }
}

/// Call find_near() first.
bool first_hit(const Asking& asking, const Cast& cast, Met& first) {
    bool found = false;
    for_each_hit_near(asking, cast, [&](const Met& met) {
        if (!found || met < first) first = met;
        found = true;
        return first.travelled_30;
    });
    return found;
}
std::optional<QueryHit> first_hit(const Scene& scene, const Cast& cast, const QueryFilter& filter) {
    const Asking asking(scene);
    find_near(asking, cast, filter);
    Met first;
    if (!first_hit(asking, cast, first)) return std::nullopt;
    return query_hit(asking, cast, first);
}

bool any_hit(const Scene& scene, const Cast& cast, const QueryFilter& filter) {
    const Asking asking(scene);
    find_near(asking, cast, filter);
    bool found = false;
    for_each_hit_near(asking, cast, [&](const Met&) {
        found = true;
        return -(std::int64_t{1} << 60);
    });
    return found;
}

void all_hits(const Scene& scene, const Cast& cast, const QueryFilter& filter, std::vector<QueryHit>& hits) {
    const Asking asking(scene);
    find_near(asking, cast, filter);
    for_each_hit_near(asking, cast, [&](const Met& met) {
        hits.push_back(query_hit(asking, cast, met));
        return std::int64_t{1} << 60;
    });
    std::sort(hits.begin(), hits.end());
}

bool make_shape_cast(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 way,
                     const QueryFilter& filter, shapes::Solid& solid, Cast& out) {
    if (!find_solid(scene, geometry, solid) || !make_cast(pose.position, way, filter, out)) return false;
    out.solid = &solid;
    out.rotation = normalized(pose.rotation);
    out.reach = shapes::reach_of(solid);
    return true;
}

/// Computes the nearest points of a living shape and a solid without triangles at a pose.
bool nearest_of(const Asking& asking, const ShapeRow& shape, const shapes::Solid& solid,
                const Transform& pose, Real limit, QueryHit& hit, Vec3& on_other) {
    const PlacedShapes::Shape& at = asking.placed.shape[shape.id.index - 1];
    const bool is_plane = asking.w.traits_of(shape).geometry.kind == ShapeKind::plane;
    const Transform frame = is_plane ? plane_below(at.pose, pose.position) : at.pose;
    const collide::RelativePose relative =
        is_plane ? collide::plane_relative_pose(at.pose, pose) : collide::relative_pose(at.pose, pose);
    if (abs(relative.position.x) >= collide::relative_position_max ||
        abs(relative.position.y) >= collide::relative_position_max ||
        abs(relative.position.z) >= collide::relative_position_max)
        return false;
    collide::Nearest nearest{};
    if (!collide::nearest_points(at.solid, solid, relative, to<Coordinate>(limit), asking.work->narrow,
                                 nearest))
        return false;
    collide::CastHit local{};
    local.point = nearest.on_a;
    local.normal = nearest.normal;
    local.feature = nearest.feature_a;
    const Rotation axes = axes_of(at);
    hit = query_hit(asking, world_hit(shape, frame.position, axes, local, to<Real>(nearest.distance)));
    on_other = frame.position + lockstone::mul<Real>(axes, nearest.on_b);
    return true;
}

/// Calls visit(shape), by slot, for the shapes that pass the filter and whose bounds are within `limit` of the
/// solid's.
template <class Visit>
void for_each_near(const Asking& asking, const shapes::Solid& solid, const Transform& pose, Real limit,
                   const QueryFilter& filter, Visit&& visit) {
    const Model& w = asking.w;
    const PlacedShapes& s = asking.placed;
    std::vector<std::uint32_t>& slots = asking.work->near.proxies;
    const int shift = static_cast<int>(w.state.rows(w.m.config)[0].bounds_shift);
    const collide::Bounds tight = collide::bounds_of(solid, pose, Length{}, shift);
    const std::int64_t steps = (limit.raw >> (Real::fraction_bits - Bound::fraction_bits + shift)) + 1;
    s.broad_phase.query(collide::expand(tight, Bound::from_raw(saturate_to_int32(steps))), asking.wide,
                        asking.work->near);
    slots.insert(slots.end(), s.planes.begin(), s.planes.end());
    std::sort(slots.begin(), slots.end());
    for (const std::uint32_t slot : slots)
        if (const ShapeRow& shape = row_of_slot(w, slot); is_seen(w, shape, filter)) visit(shape);
}

/// Searches boxes of growing width until one contains a shape that is nearer than the width.
std::optional<QueryHit> nearest_shape(const Asking& asking, const shapes::Solid& solid, const Transform& pose,
                                      Real limit, const QueryFilter& filter) {
    std::optional<QueryHit> best;
    for (Real width = min(limit, Real(1));; width = min(limit, width * 8)) {
        for_each_near(asking, solid, pose, width, filter, [&](const ShapeRow& shape) {
            QueryHit hit{};
            Vec3 on_other{};
            if (!nearest_of(asking, shape, solid, pose, best ? best->distance : width, hit, on_other)) return;
            if (!best || hit < *best) best = hit;
        });
        if (best || width >= limit) return best;
    }
}

} // namespace

std::optional<QueryHit> cast_ray(const Scene& scene, const Ray& ray, const QueryFilter& filter) {
    Cast cast{};
    if (!make_cast(ray.from, ray.translation, filter, cast)) return std::nullopt;
    return first_hit(scene, cast, filter);
}

std::optional<QueryHit> cast_shape(const Scene& scene, const Geometry& geometry, const Transform& pose,
                                   Vec3 translation, const QueryFilter& filter) {
    Cast cast{};
    shapes::Solid solid{};
    if (!make_shape_cast(scene, geometry, pose, translation, filter, solid, cast)) return std::nullopt;
    return first_hit(scene, cast, filter);
}

void cast_balls(const Scene& scene, std::span<const BallCast> balls, const QueryFilter& filter,
                std::span<FirstHit> hits) {
    const Asking asking(scene);
    std::array<shapes::Solid, balls_max> solids;
    std::array<Cast, balls_max> casts;
    std::array<std::size_t, balls_max> index;
    std::size_t count = 0;
    for (std::size_t i = 0; i < balls.size(); ++i) {
        hits[i].shape = {};
        const BallCast& ball = balls[i];
        Cast& cast = casts[count];
        if (count == 0 ? !make_cast(ball.from, ball.way, filter, cast)
                       : !make_cast_beside(ball.from, ball.way, filter, casts[count - 1], cast))
            continue;
        if (count > 0 && ball.radius == balls[index[count - 1]].radius) {
            cast.solid = casts[count - 1].solid;
            cast.reach = casts[count - 1].reach;
        } else {
            QueryWork::KnownBall& known = asking.work->ball;
            if (known.radius != ball.radius || ball.radius <= Real{}) {
                if (!find_solid(scene, sphere(ball.radius), known.solid)) {
                    known.radius = Real{};
                    continue;
                }
                known.radius = ball.radius;
                known.reach = shapes::reach_of(known.solid);
            }
            solids[count] = known.solid;
            cast.solid = &solids[count];
            cast.reach = known.reach;
        }
        cast.near = ball.near;
        index[count++] = i;
    }
    if (count == 0) return;
    find_near(asking, std::span(casts).first(count), filter);
    for (std::size_t k = 0; k < count; ++k)
        if (Met first; first_hit(asking, casts[k], first)) hits[index[k]] = world_hit(asking, first);
}

bool cast_ray_any(const Scene& scene, const Ray& ray, const QueryFilter& filter) {
    Cast cast{};
    return make_cast(ray.from, ray.translation, filter, cast) && any_hit(scene, cast, filter);
}

void cast_ray_all(const Scene& scene, const Ray& ray, const QueryFilter& filter,
                  std::vector<QueryHit>& hits) {
    Cast cast{};
    if (make_cast(ray.from, ray.translation, filter, cast)) all_hits(scene, cast, filter, hits);
}

bool cast_shape_any(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 translation,
                    const QueryFilter& filter) {
    Cast cast{};
    shapes::Solid solid{};
    return make_shape_cast(scene, geometry, pose, translation, filter, solid, cast) &&
           any_hit(scene, cast, filter);
}

void cast_shape_all(const Scene& scene, const Geometry& geometry, const Transform& pose, Vec3 translation,
                    const QueryFilter& filter, std::vector<QueryHit>& hits) {
    Cast cast{};
    shapes::Solid solid{};
    if (make_shape_cast(scene, geometry, pose, translation, filter, solid, cast))
        all_hits(scene, cast, filter, hits);
}

void overlap(const Scene& scene, const Geometry& geometry, const Transform& pose, const QueryFilter& filter,
             std::vector<ShapeId>& shapes) {
    shapes::Solid solid{};
    if (!find_solid(scene, geometry, solid)) return;
    const Asking asking(scene);
    const Transform at{pose.position, normalized(pose.rotation)};
    for_each_near(asking, solid, at, Real{}, filter, [&](const ShapeRow& shape) {
        QueryHit hit{};
        Vec3 on_other{};
        if (nearest_of(asking, shape, solid, at, Real{}, hit, on_other)) shapes.push_back(shape.id);
    });
    std::sort(shapes.begin(), shapes.end());
}

std::optional<QueryHit> nearest(const Scene& scene, const Geometry& geometry, const Transform& pose,
                                Real limit, const QueryFilter& filter) {
    shapes::Solid solid{};
    if (limit < Real{} || !find_solid(scene, geometry, solid)) return std::nullopt;
    const Asking asking(scene);
    const Transform at{pose.position, normalized(pose.rotation)};
    return nearest_shape(asking, solid, at, min(limit, query_length_max), filter);
}

std::optional<ShapeDistance> distance(const Scene& scene, ShapeId a, ShapeId b) {
    const Model& w = scene.model;
    const std::uint32_t row_a = w.row_of(a), row_b = w.row_of(b);
    if (row_a == Model::dead || row_b == Model::dead) return std::nullopt;
    const Asking asking(scene);
    const std::span<const ShapeRow> rows = w.state.rows(w.m.shape);
    // A fixed order of the two, so that distance(a, b) and distance(b, a) give equal numbers.
    const bool swaps = std::pair(w.traits_of(rows[row_a]).geometry.kind, b) <
                       std::pair(w.traits_of(rows[row_b]).geometry.kind, a);
    const ShapeRow &first = rows[swaps ? row_b : row_a], &second = rows[swaps ? row_a : row_b];
    if (w.traits_of(second).geometry.kind >= ShapeKind::height_field) return std::nullopt;
    const PlacedShapes::Shape& other = scene.placed.shape[second.id.index - 1];
    QueryHit hit{};
    Vec3 on_other{};
    if (!nearest_of(asking, first, other.solid, other.pose, query_length_max, hit, on_other))
        return std::nullopt;
    if (swaps) return ShapeDistance{hit.distance, on_other, hit.point, -hit.normal};
    return ShapeDistance{hit.distance, hit.point, on_other, hit.normal};
}

} // namespace lockstone::sim
