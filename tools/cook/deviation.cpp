#include "cook/deviation.h"

#include "cook/decompose.h"

namespace lockstone::cook {
namespace {

constexpr std::size_t vertices_asked_max = 50'000;

/// The sample points of a surface: its vertices, and points between them.
std::vector<Point> questions(const Soup& soup, std::size_t samples) {
    std::vector<Point> out;
    const std::size_t step = 1 + soup.vertices.size() / vertices_asked_max;
    for (std::size_t i = 0; i < soup.vertices.size(); i += step) out.push_back(soup.vertices[i]);
    const std::vector<Point> between = sample_surface(soup, samples);
    out.insert(out.end(), between.begin(), between.end());
    return out;
}

/// Checks a distance with another library: a slightly larger ball must touch the body, and a slightly smaller one must
/// not.
template <class Body>
Status confirm(const char* library, double distance, double size, const Body& ball_meets) {
    const double slack = 1e-3 * distance + 1e-5 * size; // error of the iterative methods
    const bool grown = ball_meets(distance + slack);
    const bool shrunk = distance > 2 * slack && ball_meets(distance - slack);
    if (grown && !shrunk) return {};
    return Error{"the check disagrees with itself: the nearest triangle is " + std::to_string(distance) +
                 " m away, " + library + " finds another distance"};
}

Status confirm(const Convex& hull, Point p, double distance) {
    return confirm("libccd", distance, bounds_of(hull.surface.vertices).largest(),
                   [&](double radius) { return ball_meets(hull, p, radius); });
}

Status confirm(const Surface& surface, Point p, double distance) {
    return confirm("FCL", distance, surface.bounds().largest(),
                   [&](double radius) { return surface.ball_meets(p, radius); });
}

/// The greatest distance of a series of points, and its point.
struct Farthest {
    double distance = 0;
    Point where;
    void add(double d, Point p) {
        if (d > distance) distance = d, where = p;
    }
};

Result<double> farthest(const std::vector<Point>& points, const Surface& from) {
    Farthest most;
    for (const Point& p : points) most.add(from.distance(p), p);
    if (const Status agreed = confirm(from, most.where, most.distance); most.distance > 0 && !agreed)
        return agreed.error();
    return most.distance;
}

/// The corner that is farthest from the body.
Result<double> farthest_corner(const std::vector<Point>& corners, const Convex& body) {
    Farthest most;
    for (const Point& p : corners) most.add(distance(body, p), p);
    if (const Status agreed = confirm(body, most.where, most.distance); most.distance > 0 && !agreed)
        return agreed.error();
    return most.distance;
}

double distance_to_any(const std::vector<Convex>& parts, Point p) {
    double nearest = 1e300;
    for (const Convex& part : parts)
        if (nearest > 0 && part.beyond(p) < nearest) nearest = std::min(nearest, distance(part, p));
    return nearest;
}

} // namespace

Result<Deviation> deviation_of_hulls(const Convex& source, const Convex& result) {
    const Result<double> there = farthest_corner(source.surface.vertices, result);
    const Result<double> back = farthest_corner(result.surface.vertices, source);
    if (!there) return there.error();
    if (!back) return back.error();
    return Deviation{*there, *back};
}

Result<Deviation> deviation_of_solids(const Soup& source, const Surface& surface,
                                      const std::vector<Convex>& parts, std::size_t samples) {
    Farthest there, back;
    for (const Point& p : questions(source, samples)) there.add(distance_to_any(parts, p), p);
    if (there.distance > 0) {
        const auto nearest =
            std::min_element(parts.begin(), parts.end(), [&](const Convex& a, const Convex& b) {
                return distance(a, there.where) < distance(b, there.where);
            });
        if (const Status agreed = confirm(*nearest, there.where, there.distance); !agreed)
            return agreed.error();
    }
    const auto ask = [&](Point p) {
        if (!surface.contains(p)) back.add(surface.distance(p), p);
    };
    const std::size_t each = std::max(samples / 25, samples / parts.size());
    for (const Convex& part : parts) {
        for (const Point& p : part.surface.vertices) ask(p);
        for (const Point& p : points_between(part, surface, back.distance)) ask(p);
        for (const Point& p : sample_surface(part.surface, each)) ask(p);
        const Box box = bounds_of(part.surface.vertices);
        for (std::uint64_t i = 0; i < each; ++i) {
            const Point u = even_point(i), size = box.size();
            const Point p = box.lower + Point{u.x * size.x, u.y * size.y, u.z * size.z};
            if (part.beyond(p) <= 0) ask(p);
        }
    }
    if (const Status agreed = confirm(surface, back.where, back.distance); back.distance > 0 && !agreed)
        return agreed.error();
    return Deviation{there.distance, back.distance};
}

Result<Deviation> deviation_of_surfaces(const Soup& source, const Surface& source_surface, const Soup& result,
                                        std::size_t samples) {
    const Result<double> there = farthest(questions(source, samples), Surface(result));
    const Result<double> back = farthest(questions(result, samples), source_surface);
    if (!there) return there.error();
    if (!back) return back.error();
    return Deviation{*there, *back};
}

Result<Deviation> deviation_from_above(const Soup& source, const Surface& source_surface, const Soup& result,
                                       std::size_t samples) {
    const Box box = source_surface.bounds();
    const double same = 1e-9 * box.largest();
    std::vector<Point> seen, within;
    const auto look = [&](double x, double z, const double* at) {
        double height = 0;
        if (source_surface.top(x, z, height) && (at == nullptr || height <= *at + same))
            seen.push_back({x, height, z});
    };
    const std::size_t step = 1 + source.vertices.size() / vertices_asked_max;
    for (std::size_t i = 0; i < source.vertices.size(); i += step)
        look(source.vertices[i].x, source.vertices[i].z, &source.vertices[i].y);
    for (std::uint64_t i = 0; i < samples; ++i) {
        const Point u = even_point(i);
        look(box.lower.x + u.x * box.size().x, box.lower.z + u.z * box.size().z, nullptr);
    }
    for (const Point& p : questions(result, samples))
        if (p.x >= box.lower.x && p.x <= box.upper.x && p.z >= box.lower.z && p.z <= box.upper.z)
            within.push_back(p);
    const Result<double> there = farthest(seen, Surface(result));
    const Result<double> back = farthest(within, source_surface);
    if (!there) return there.error();
    if (!back) return back.error();
    return Deviation{*there, *back};
}

} // namespace lockstone::cook
