#include "cook/convex.h"

#include "cook/surface.h"

#include <ccd/ccd.h>

extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <cstdio>
#include <memory>

namespace lockstone::cook {
namespace {

/// One run of qhull with command-line options. Its errors leave by longjmp through C frames only; the run then has an
/// exit code.
class Run {
  public:
    Run(std::vector<double> coordinates, std::string options)
        : points(std::move(coordinates)), quiet(open_quiet()) {
        qh_zero(&qh, quiet.get());
        exit_code = qh_new_qhull(&qh, 3, static_cast<int>(points.size() / 3), points.data(), False,
                                 options.data(), quiet.get(), quiet.get());
    }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;
    ~Run() {
        qh_freeqhull(&qh, !qh_ALL);
        int left = 0, total = 0;
        qh_memfreeshort(&qh, &left, &total);
    }

    /// The indices of the corners, triangle by triangle, in the winding that qhull gives.
    std::vector<Indices> triangles() {
        std::vector<Indices> out;
        for (facetT* facet = qh.facet_list; facet != nullptr && facet->next != nullptr; facet = facet->next) {
            setT* corners = qh_facet3vertex(&qh, facet);
            if (qh_setsize(&qh, corners) == 3) {
                Indices t{};
                for (int k = 0; k < 3; ++k) {
                    auto* vertex = static_cast<vertexT*>(SETelem_(corners, k));
                    t[static_cast<std::size_t>(k)] =
                        static_cast<std::uint32_t>(qh_pointid(&qh, vertex->point));
                }
                out.push_back(t);
            }
            qh_settempfree(&qh, &corners);
        }
        return out;
    }
    /// qhull reports points that all have one x, y or z as wrong input.
    bool is_flat() const { return exit_code == qh_ERRsingular || exit_code == qh_ERRinput; }
    int exit_code = 0;

  private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    static std::unique_ptr<std::FILE, Close> open_quiet() {
        return std::unique_ptr<std::FILE, Close>(std::fopen("/dev/null", "w"));
    }
    std::vector<double> points;
    std::unique_ptr<std::FILE, Close> quiet;
    qhT qh{};
};

constexpr const char* no_hull = "qhull finds no hull of the points within double precision";

Error flat_error() {
    return Error{"the points lie in one plane: they have no hull (--as mesh --two-sided keeps a flat model)"};
}

double signed_volume(const Soup& surface, Point from) {
    double six = 0;
    for (std::size_t i = 0; i < surface.triangles.size(); ++i) {
        const auto [a, b, c] = surface.corners(i);
        six += dot(a - from, cross(b - from, c - from));
    }
    return six / 6;
}

void fill_planes(Convex& hull) {
    for (std::size_t i = 0; i < hull.surface.triangles.size(); ++i) {
        const auto [a, b, c] = hull.surface.corners(i);
        const Point n = cross(b - a, c - a);
        const double size = length(n), longest = std::max({length(b - a), length(c - b), length(a - c)});
        if (size <= 1e-9 * longest * longest) continue; // the normal of a needle is not accurate
        const Point unit = n * (1 / size);
        hull.planes.push_back({unit, std::max({dot(unit, a), dot(unit, b), dot(unit, c)})});
    }
}

Point middle(const std::vector<Point>& points) {
    const Box box = bounds_of(points);
    return (box.lower + box.upper) * 0.5;
}

// ---- libccd ---------------------------------------------------------------------------------------------------

void support_of_points(const void* object, const ccd_vec3_t* way, ccd_vec3_t* out) {
    const auto& points = *static_cast<const std::vector<Point>*>(object);
    const Point d{way->v[0], way->v[1], way->v[2]};
    const auto best = std::max_element(points.begin(), points.end(),
                                       [&](const Point& a, const Point& b) { return dot(a, d) < dot(b, d); });
    ccdVec3Set(out, best->x, best->y, best->z);
}

struct Ball {
    Point centre;
    double radius;
};
void support_of_ball(const void* object, const ccd_vec3_t* way, ccd_vec3_t* out) {
    const auto& ball = *static_cast<const Ball*>(object);
    ccdVec3Copy(out, way);
    const double size = std::sqrt(ccdVec3Len2(way));
    ccdVec3Scale(out, size > 0 ? ball.radius / size : 0);
    for (int axis = 0; axis < 3; ++axis) out->v[axis] += ball.centre[axis];
}
void centre_of_ball(const void* object, ccd_vec3_t* out) {
    const Point centre = static_cast<const Ball*>(object)->centre;
    ccdVec3Set(out, centre.x, centre.y, centre.z);
}

/// The mean of the points, which is certainly inside.
void centre_of_points(const void* object, ccd_vec3_t* out) {
    const auto& points = *static_cast<const std::vector<Point>*>(object);
    Point sum;
    for (const Point& p : points) sum = sum + p;
    const Point mean = sum * (1 / static_cast<double>(points.size()));
    ccdVec3Set(out, mean.x, mean.y, mean.z);
}

} // namespace

double Convex::beyond(Point p) const {
    double most = -1e300;
    for (const Plane& plane : planes) most = std::max(most, dot(plane.normal, p) - plane.offset);
    return most;
}

bool Convex::holds(Point p, double depth) const {
    return std::all_of(planes.begin(), planes.end(),
                       [&](const Plane& plane) { return dot(plane.normal, p) - plane.offset <= -depth; });
}

double Convex::way_out(Point p, Point direction) const {
    double least = 1e300;
    for (const Plane& plane : planes)
        if (const double slope = dot(plane.normal, direction); slope > 0)
            least = std::min(least, std::max(0.0, plane.offset - dot(plane.normal, p)) / slope);
    return least < 1e300 ? least : 0;
}

Result<Convex> convex_hull(std::span<const Point> points) {
    if (points.size() < 4) return flat_error();
    // The points are moved to the origin, because far from it digits would be lost.
    const std::vector<Point> all(points.begin(), points.end());
    const Point shift = middle(all);
    std::vector<double> coordinates;
    for (const Point& p : all)
        for (int axis = 0; axis < 3; ++axis) coordinates.push_back(p[axis] - shift[axis]);
    // The first run fails if qhull has facets that it cannot merge within its precision. The second run ("QJ") moves
    // the points by about 1e-13 of their extent.
    auto run = std::make_unique<Run>(coordinates, "qhull Qt Pp");
    if (run->exit_code != qh_ERRnone && !run->is_flat())
        run = std::make_unique<Run>(std::move(coordinates), "qhull QJ Pp");
    if (run->exit_code != qh_ERRnone) return run->is_flat() ? flat_error() : Error{no_hull};
    Soup indexed{all, run->triangles()};
    for (const Indices& t : indexed.triangles)
        for (const std::uint32_t v : t)
            if (v >= all.size()) return Error{"qhull named a point that is not there"};
    Convex hull;
    hull.surface = compacted(indexed);
    if (hull.surface.triangles.size() < 4) return flat_error();
    hull.volume = signed_volume(hull.surface, shift);
    if (hull.volume < 0) {
        for (Indices& t : hull.surface.triangles) std::swap(t[1], t[2]);
        hull.volume = -hull.volume;
    }
    fill_planes(hull);
    if (hull.planes.size() < 4) return flat_error();
    return hull;
}

namespace {

/// The first corners: the extreme points of the hull in some directions, which span a volume.
std::vector<Point> first_corners(const std::vector<Point>& corners) {
    std::vector<Point> out;
    const auto add_end = [&](Point way) {
        const auto end = std::max_element(corners.begin(), corners.end(),
                                          [&](Point a, Point b) { return dot(a, way) < dot(b, way); });
        if (std::find(out.begin(), out.end(), *end) == out.end()) out.push_back(*end);
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            Point way;
            way[axis] = sign;
            add_end(way);
        }
    for (std::uint64_t i = 0; out.size() < 4 && i < 64; ++i) add_end(even_point(i) - Point{0.5, 0.5, 0.5});
    return out;
}

/// A tetrahedron of corners: the two that are farthest apart, then the farthest from their line, then the farthest from
/// the plane of the three.
std::vector<Point> wide_tetrahedron(const std::vector<Point>& corners) {
    const auto best = [&](auto&& score) {
        return *std::max_element(corners.begin(), corners.end(),
                                 [&](Point a, Point b) { return score(a) < score(b); });
    };
    const Point start = corners.front();
    const Point a = best([&](Point p) { return length(p - start); });
    const Point b = best([&](Point p) { return length(p - a); });
    const Point c = best([&](Point p) { return length(cross(p - a, b - a)); });
    const Point d = best([&](Point p) { return std::abs(dot(p - a, cross(b - a, c - a))); });
    return {a, b, c, d};
}

} // namespace

Result<Convex> reduced(const Convex& hull, std::uint32_t corners_max) {
    const std::vector<Point>& corners = hull.surface.vertices;
    if (corners.size() <= corners_max) return hull;
    std::vector<Point> chosen = first_corners(corners);
    if (chosen.size() > corners_max) chosen = wide_tetrahedron(corners);
    Result<Convex> now = convex_hull(chosen);
    if (!now) now = convex_hull(chosen = wide_tetrahedron(corners));
    if (!now) return now;
    const double enough = 1e-9 * bounds_of(corners).largest();
    // The distance of each corner outside of the hull when it was last computed. It is an upper bound, since a larger
    // hull only comes nearer to the corners.
    std::vector<std::pair<double, std::size_t>> outside;
    for (std::size_t i = 0; i < corners.size(); ++i) outside.emplace_back(now->beyond(corners[i]), i);
    const auto is_nearer = [](const auto& a, const auto& b) {
        return a.first < b.first || (a.first == b.first && a.second > b.second);
    };
    std::make_heap(outside.begin(), outside.end(), is_nearer);
    while (chosen.size() < corners_max && !outside.empty()) {
        std::pop_heap(outside.begin(), outside.end(), is_nearer);
        auto farthest = outside.back();
        outside.pop_back();
        farthest.first = now->beyond(corners[farthest.second]);
        if (farthest.first <= enough) continue;
        if (!outside.empty() && is_nearer(farthest, outside.front())) {
            outside.push_back(farthest);
            std::push_heap(outside.begin(), outside.end(), is_nearer);
            continue;
        }
        chosen.push_back(corners[farthest.second]);
        now = convex_hull(chosen);
        if (!now) return now;
    }
    return now;
}

double distance(const Convex& hull, Point p) {
    if (hull.beyond(p) <= 0) return 0;
    double nearest = 1e300;
    for (std::size_t i = 0; i < hull.surface.triangles.size(); ++i)
        nearest = std::min(nearest, length(p - nearest_of_triangle(hull.surface.corners(i), p)));
    return nearest;
}

bool ball_meets(const Convex& hull, Point centre, double radius) {
    // Portal refinement, because libccd's GJK misses some contacts of a ball whose centre is near a corner.
    const Ball ball{centre, radius};
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = support_of_ball;
    ccd.support2 = support_of_points;
    ccd.center1 = centre_of_ball;
    ccd.center2 = centre_of_points;
    ccd.max_iterations = 1000;
    ccd.mpr_tolerance = 1e-9;
    return ccdMPRIntersect(&ball, &hull.surface.vertices, &ccd) != 0;
}

} // namespace lockstone::cook
