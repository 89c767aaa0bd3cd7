#include "cook/decompose.h"

#include <map>
#include <optional>

namespace lockstone::cook {
namespace {

using Corners = std::array<Point, 3>;

struct Piece {
    Box cell;
    std::vector<Corners> clipped;
    std::optional<Convex> hull; ///< none: flat or empty, nothing to collide with
    double beyond = 0;          ///< `excess` of the hull
};

/// The plane at `at` across `axis`.
struct Cut {
    int axis;
    double at;
};

/// Appends the part of the triangle on one side. Source: Sutherland, Hodgman, 1974.
void clip(const Corners& t, Cut cut, bool above, std::vector<Corners>& out) {
    std::array<Point, 4> kept;
    std::size_t count = 0;
    const auto inside = [&](Point p) { return above ? p[cut.axis] >= cut.at : p[cut.axis] <= cut.at; };
    for (std::size_t k = 0; k < 3; ++k) {
        const Point &a = t[k], &b = t[(k + 1) % 3];
        if (inside(a)) kept[count++] = a;
        if (inside(a) == inside(b)) continue;
        const double share = (cut.at - a[cut.axis]) / (b[cut.axis] - a[cut.axis]);
        Point p = a + (b - a) * share;
        p[cut.axis] = cut.at;
        if (count < kept.size()) kept[count++] = p;
    }
    for (std::size_t k = 2; k < count; ++k) {
        const Corners part{kept[0], kept[k - 1], kept[k]};
        // What only touches the plane, from the other side maybe, is no part of this side.
        if (std::any_of(part.begin(), part.end(), [&](Point p) { return p[cut.axis] != cut.at; }))
            out.push_back(part);
    }
}

Point corner_of(const Box& box, unsigned bits) {
    return {(bits & 1u) != 0 ? box.upper.x : box.lower.x, (bits & 2u) != 0 ? box.upper.y : box.lower.y,
            (bits & 4u) != 0 ? box.upper.z : box.lower.z};
}

void make_hull(Piece& piece, const Surface& solid) {
    std::vector<Point> points;
    for (const Corners& t : piece.clipped) points.insert(points.end(), t.begin(), t.end());
    // Asked a little within the cell: corners often lie on the surface, with the solid on the cell's side or not.
    const Point middle = (piece.cell.lower + piece.cell.upper) * 0.5;
    for (unsigned bits = 0; bits < 8; ++bits)
        if (const Point p = corner_of(piece.cell, bits); solid.contains(p + (middle - p) * 1e-3))
            points.push_back(p);
    const auto key = [](Point p) { return std::array<double, 3>{p.x, p.y, p.z}; };
    std::sort(points.begin(), points.end(), [&](Point a, Point b) { return key(a) < key(b); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    Result<Convex> hull = convex_hull(points);
    if (hull) piece.hull = std::move(*hull);
}

Piece side_of(const Piece& piece, Cut cut, bool above, const Surface& solid) {
    Piece side;
    side.cell = piece.cell;
    (above ? side.cell.lower : side.cell.upper)[cut.axis] = cut.at;
    for (const Corners& t : piece.clipped) clip(t, cut, above, side.clipped);
    make_hull(side, solid);
    return side;
}

// ---- where to cut ---------------------------------------------------------------------------------------------

/// Edges at which the solid is concave: only planes through them can end the concavity.
struct Edge {
    Point from, to;
    double weight; ///< length times sine
};

std::vector<Edge> concave_edges(const Soup& solid) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> open; // directed edge to its triangle
    std::vector<Edge> edges;
    const auto normal_of = [&](std::uint32_t t) {
        const auto [a, b, c] = solid.corners(t);
        const Point n = cross(b - a, c - a);
        const double size = length(n);
        return size > 0 ? n * (1 / size) : Point{};
    };
    for (std::uint32_t t = 0; t < solid.triangles.size(); ++t)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = solid.triangles[t][k], to = solid.triangles[t][(k + 1) % 3];
            const auto other = open.find({to, from});
            if (other == open.end()) {
                open.emplace(std::pair(from, to), t);
                continue;
            }
            const Point a = solid.vertices[from], b = solid.vertices[to];
            const double turn = dot(cross(normal_of(t), normal_of(other->second)), b - a);
            if (turn < -1e-3 * length(b - a)) edges.push_back({a, b, -turn});
        }
    return edges;
}

/// The places with the greatest sums of weights, nearer together than `width` counted once.
std::vector<double> heaviest(std::vector<std::pair<double, double>> places, double width, std::size_t count) {
    std::sort(places.begin(), places.end());
    std::vector<std::pair<double, double>> sums; // weight, place
    double last = -1e300;
    for (const auto& [at, weight] : places) {
        if (at - last > width)
            sums.emplace_back(weight, last = at);
        else
            sums.back().first += weight;
    }
    std::stable_sort(sums.begin(), sums.end(), [](auto& a, auto& b) { return a.first > b.first; });
    std::vector<double> out;
    for (std::size_t i = 0; i < std::min(count, sums.size()); ++i) out.push_back(sums[i].second);
    return out;
}

/// The part of the edge within the box; false when there is none.
bool clip(Edge& edge, const Box& box) {
    double enter = 0, leave = 1;
    const Point way = edge.to - edge.from;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = box.lower[axis] - edge.from[axis], high = box.upper[axis] - edge.from[axis];
        if (way[axis] == 0 && (low > 0 || high < 0)) return false;
        if (way[axis] == 0) continue;
        enter = std::max(enter, std::min(low / way[axis], high / way[axis]));
        leave = std::min(leave, std::max(low / way[axis], high / way[axis]));
    }
    if (enter > leave) return false;
    edge = {edge.from + way * enter, edge.from + way * leave, edge.weight * (leave - enter)};
    return true;
}

std::vector<Cut> candidates(const Piece& piece, const std::vector<Edge>& edges, double width) {
    constexpr std::size_t per_axis = 10;
    constexpr int even = 4;
    const Box box = bounds_of(piece.hull->surface.vertices);
    std::vector<Edge> within;
    for (Edge edge : edges)
        if (clip(edge, piece.cell)) within.push_back(edge);
    std::vector<Cut> cuts;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = box.lower[axis] + width, high = box.upper[axis] - width;
        if (low >= high) continue;
        std::vector<std::pair<double, double>> places;
        for (const Edge& edge : within)
            for (const Point& p : {edge.from, edge.to})
                if (p[axis] > low && p[axis] < high) places.emplace_back(p[axis], edge.weight);
        for (const double at : heaviest(std::move(places), 0.1 * width, per_axis)) cuts.push_back({axis, at});
        for (int i = 1; i <= even; ++i)
            cuts.push_back({axis, box.lower[axis] + box.size()[axis] * i / (even + 1)});
        std::erase_if(cuts, [&](Cut cut) { return cut.axis == axis && (cut.at < low || cut.at > high); });
    }
    return cuts;
}

/// Whether some of the piece's surface lies deeper in its hull than `limit`.
bool is_concave(const Piece& piece, double limit) {
    for (const Corners& t : piece.clipped) {
        for (const Point& p : t)
            if (piece.hull->beyond(p) < -limit) return true;
        if (piece.hull->beyond((t[0] + t[1] + t[2]) * (1.0 / 3)) < -limit) return true;
    }
    return false;
}

/// Volume that hulls take, that of hulls which will be cut again counted twice: less is better.
double cost(const Piece& side, double limit) {
    if (!side.hull) return 0;
    return side.hull->volume * (is_concave(side, limit) ? 2 : 1);
}

std::optional<std::pair<Piece, Piece>> best_cut(const Piece& piece, const std::vector<Edge>& edges,
                                                const Surface& solid, const DecomposeOptions& options) {
    std::optional<std::pair<Piece, Piece>> best;
    double best_cost = 1e300;
    for (const Cut cut : candidates(piece, edges, options.width_min)) {
        std::pair<Piece, Piece> sides{side_of(piece, cut, false, solid), side_of(piece, cut, true, solid)};
        const double now = cost(sides.first, options.deviation) + cost(sides.second, options.deviation);
        if (now >= best_cost * (1 - 1e-9)) continue;
        best_cost = now;
        best = std::move(sides);
    }
    return best;
}

// ---- joining --------------------------------------------------------------------------------------------------

constexpr std::size_t samples_per_hull = 160;

/// Joins the first two parts that together are still near enough to the solid; false when there are none.
bool join_two(std::vector<Convex>& parts, const Surface& solid, double deviation) {
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (std::size_t j = i + 1; j < parts.size(); ++j) {
            std::vector<Point> points = parts[i].surface.vertices;
            points.insert(points.end(), parts[j].surface.vertices.begin(), parts[j].surface.vertices.end());
            Result<Convex> both = convex_hull(points);
            if (!both || both->volume > 1.1 * (parts[i].volume + parts[j].volume)) continue;
            if (excess(*both, solid, 2 * samples_per_hull) > deviation) continue;
            parts[i] = std::move(*both);
            parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(j));
            return true;
        }
    return false;
}

/// Joins the two parts whose common hull adds the least volume.
bool join_cheapest(std::vector<Convex>& parts) {
    double least = 1e300;
    std::size_t first = 0, second = 0;
    std::optional<Convex> joined;
    for (std::size_t i = 0; i < parts.size(); ++i)
        for (std::size_t j = i + 1; j < parts.size(); ++j) {
            std::vector<Point> points = parts[i].surface.vertices;
            points.insert(points.end(), parts[j].surface.vertices.begin(), parts[j].surface.vertices.end());
            Result<Convex> both = convex_hull(points);
            if (!both || both->volume - parts[i].volume - parts[j].volume >= least) continue;
            least = both->volume - parts[i].volume - parts[j].volume;
            first = i, second = j;
            joined = std::move(*both);
        }
    if (!joined) return false;
    parts[first] = std::move(*joined);
    parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(second));
    return true;
}

} // namespace

double excess(const Convex& hull, const Surface& solid, std::size_t samples) {
    double most = 0;
    const auto ask = [&](Point p) {
        // Near the surface `contains` may go either way; there the distance is as good as none.
        if (!solid.contains(p)) most = std::max(most, solid.distance(p));
    };
    for (std::size_t i = 0; i < hull.surface.triangles.size(); ++i) {
        const auto [a, b, c] = hull.surface.corners(i);
        ask((a + b + c) * (1.0 / 3));
        ask((a + b) * 0.5);
        ask((b + c) * 0.5);
        ask((c + a) * 0.5);
    }
    for (const Point& p : sample_surface(hull.surface, samples)) ask(p);
    const Box box = bounds_of(hull.surface.vertices);
    for (std::uint64_t i = 0; i < samples; ++i) {
        const Point u = even_point(i), size = box.size();
        const Point p = box.lower + Point{u.x * size.x, u.y * size.y, u.z * size.z};
        if (hull.beyond(p) <= 0) ask(p);
    }
    return most;
}

Result<std::vector<Convex>> decompose(const Soup& soup, const Surface& solid,
                                      const DecomposeOptions& options) {
    const std::vector<Edge> edges = concave_edges(soup);
    std::vector<Piece> pieces(1);
    pieces[0].cell = bounds_of(soup.vertices);
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) pieces[0].clipped.push_back(soup.corners(i));
    const Result<Convex> whole = convex_hull(soup.vertices);
    if (!whole) return whole.error();
    pieces[0].hull = *whole;
    pieces[0].beyond = excess(*whole, solid, samples_per_hull);
    std::vector<Convex> done;
    // Joining brings the number down again, so some more are allowed meanwhile.
    const std::size_t meanwhile = options.parts_max == 1 ? 1 : options.parts_max + 1 + options.parts_max / 4;
    while (!pieces.empty() && pieces.size() + done.size() < meanwhile) {
        const auto worst = std::max_element(pieces.begin(), pieces.end(),
                                            [](auto& a, auto& b) { return a.beyond < b.beyond; });
        if (worst->beyond <= options.deviation) break;
        std::optional<std::pair<Piece, Piece>> sides = best_cut(*worst, edges, solid, options);
        if (!sides) done.push_back(*worst->hull);
        pieces.erase(worst);
        if (!sides) continue;
        for (Piece* side : {&sides->first, &sides->second}) {
            if (!side->hull) continue;
            side->beyond = excess(*side->hull, solid, samples_per_hull);
            pieces.push_back(std::move(*side));
        }
    }
    for (Piece& piece : pieces) done.push_back(std::move(*piece.hull));
    while (join_two(done, solid, options.deviation)) {}
    while (done.size() > options.parts_max && join_cheapest(done)) {}
    if (done.empty()) return Error{"the model has no volume"};
    return done;
}

} // namespace lockstone::cook
