#include "cook/decompose.h"

#include "cook/soundness.h"

#include <iterator>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <tuple>

namespace lockstone::cook {
namespace {

using Corners = std::array<Point, 3>;

constexpr std::size_t samples_per_hull = 160;

/// A solid that the surface encloses. Cuts are chosen with the coarse triangles; the final parts use all triangles.
struct Solid {
    Solid(const Soup& whole, std::size_t triangles_max)
        : soup(whole), coarse(coarsened(whole, triangles_max)), surface(whole) {
        // The coarse copy is flat although the model is not.
        if (!convex_hull(coarse.vertices)) coarse = soup;
    }
    Soup soup, coarse;
    Surface surface;
};

struct Piece {
    const Solid* of;
    Box cell;
    std::vector<Corners> clipped{};
    std::optional<Convex> hull{}; ///< empty: flat or without volume, so nothing can collide with it
    double beyond = 0;            ///< `excess` of the hull
    /// Triangles of the solid that may overlap the cell.
    std::shared_ptr<const std::vector<std::uint32_t>> candidates{};
    bool is_refined = false; ///< the hull is made of all triangles
};

/// The plane at the coordinate `at` of `axis`.
struct Cut {
    int axis;
    double at;
};

/// Appends the part of the triangle on one side of the plane. Source: Sutherland, Hodgman, 1974.
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
        // A part that only touches the plane does not belong to this side.
        if (std::any_of(part.begin(), part.end(), [&](Point p) { return p[cut.axis] != cut.at; }))
            out.push_back(part);
    }
}

Point corner_of(const Box& box, unsigned bits) {
    return {(bits & 1u) != 0 ? box.upper.x : box.lower.x, (bits & 2u) != 0 ? box.upper.y : box.lower.y,
            (bits & 4u) != 0 ? box.upper.z : box.lower.z};
}

void make_hull(Piece& piece) {
    std::vector<Point> points;
    for (const Corners& t : piece.clipped) points.insert(points.end(), t.begin(), t.end());
    // Corners of the cell often lie on the surface. The test point is therefore moved a little into the cell, where it
    // is clearly inside or outside.
    const Point middle = (piece.cell.lower + piece.cell.upper) * 0.5;
    for (unsigned bits = 0; bits < 8; ++bits)
        if (const Point p = corner_of(piece.cell, bits); piece.of->surface.contains(p + (middle - p) * 1e-3))
            points.push_back(p);
    const auto key = [](Point p) { return std::array<double, 3>{p.x, p.y, p.z}; };
    std::sort(points.begin(), points.end(), [&](Point a, Point b) { return key(a) < key(b); });
    points.erase(std::unique(points.begin(), points.end()), points.end());
    piece.hull.reset();
    if (Result<Convex> hull = convex_hull(points)) piece.hull = std::move(*hull);
}

Piece side_of(const Piece& piece, Cut cut, bool above) {
    Piece side{.of = piece.of, .cell = piece.cell, .candidates = piece.candidates};
    (above ? side.cell.lower : side.cell.upper)[cut.axis] = cut.at;
    for (const Corners& t : piece.clipped) clip(t, cut, above, side.clipped);
    make_hull(side);
    return side;
}

/// The part of a triangle within a box, as triangles.
std::vector<Corners> within(const Corners& triangle, const Box& cell) {
    Box box;
    for (const Point& p : triangle) box.add(p);
    for (int axis = 0; axis < 3; ++axis)
        if (box.lower[axis] > cell.upper[axis] || box.upper[axis] < cell.lower[axis]) return {};
    std::vector<Corners> inside{triangle}, next;
    for (int axis = 0; axis < 3; ++axis)
        for (const bool above : {true, false}) {
            next.clear();
            const Cut cut{axis, (above ? cell.lower : cell.upper)[axis]};
            for (const Corners& t : inside) clip(t, cut, above, next);
            inside.swap(next);
        }
    return inside;
}

std::vector<Corners> coarsened(const std::vector<Corners>& triangles, std::size_t count_max) {
    if (triangles.size() <= count_max) return triangles;
    Soup soup;
    for (const Corners& t : triangles) {
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        soup.vertices.insert(soup.vertices.end(), t.begin(), t.end());
        soup.triangles.push_back({first, first + 1, first + 2});
    }
    soup = coarsened(compacted(welded(soup)), count_max);
    std::vector<Corners> out;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) out.push_back(soup.corners(i));
    return out;
}

/// Replaces the hull by that of all triangles within the piece's cell; returns false if it is that already. Keeps a
/// limited number of those triangles for further cuts.
bool refine(Piece& piece) {
    constexpr std::size_t triangles_kept = 300;
    const Solid& of = *piece.of;
    if (piece.is_refined || of.coarse.triangles.size() == of.soup.triangles.size()) return false;
    std::vector<std::uint32_t> found;
    piece.clipped.clear();
    for (const std::uint32_t i : *piece.candidates) {
        const std::vector<Corners> inside = within(of.soup.corners(i), piece.cell);
        if (!inside.empty()) found.push_back(i);
        piece.clipped.insert(piece.clipped.end(), inside.begin(), inside.end());
    }
    piece.candidates = std::make_shared<const std::vector<std::uint32_t>>(std::move(found));
    piece.is_refined = true;
    make_hull(piece);
    piece.clipped = coarsened(piece.clipped, triangles_kept);
    return true;
}

// ---- where to cut ---------------------------------------------------------------------------------------------

/// An edge at which the solid is concave. Only planes through such edges can remove the concavity.
struct Edge {
    Point from, to;
    double weight; ///< length times sine of the angle
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

/// The places with the greatest sums of weights. Places nearer together than `width` count as one.
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

/// Clips the edge to the box; false if no part is inside.
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

/// True if some of the piece's surface lies deeper in its hull than `limit`.
bool is_concave(const Piece& piece, double limit) {
    constexpr std::size_t asked_max = 150;
    const std::size_t step = 1 + piece.clipped.size() / asked_max;
    for (std::size_t i = 0; i < piece.clipped.size(); i += step) {
        const Corners& t = piece.clipped[i];
        for (const Point& p : t)
            if (piece.hull->beyond(p) < -limit) return true;
        if (piece.hull->beyond((t[0] + t[1] + t[2]) * (1.0 / 3)) < -limit) return true;
    }
    return false;
}

/// The cost of a side: the volume of its hull, doubled if the hull will be cut again. Less is better.
double cost(const Piece& side, double limit) {
    if (!side.hull) return 0;
    return side.hull->volume * (is_concave(side, limit) ? 2 : 1);
}

struct Sides {
    Piece below, above;
    double cost;
};

/// How far the hulls of both sides extend beyond the solid.
double beyond_of(Sides& sides, const Surface& solid) {
    double most = 0;
    for (Piece* side : {&sides.below, &sides.above})
        if (side->hull) most = std::max(most, side->beyond = excess(*side->hull, solid, samples_per_hull));
    return most;
}

/// Among the cuts that leave the least volume to hulls, the cut whose hulls extend least beyond the solid.
std::optional<Sides> best_cut(const Piece& piece, const std::vector<Edge>& edges, const Surface& solid,
                              const DecomposeOptions& options) {
    constexpr std::size_t measured = 4;
    std::vector<Sides> best;
    for (const Cut cut : candidates(piece, edges, options.width_min)) {
        Sides sides{side_of(piece, cut, false), side_of(piece, cut, true), 0};
        sides.cost = cost(sides.below, options.deviation) + cost(sides.above, options.deviation);
        if (best.size() == measured && sides.cost >= best.back().cost * (1 - 1e-9)) continue;
        if (best.size() == measured) best.pop_back();
        best.push_back(std::move(sides));
        std::stable_sort(best.begin(), best.end(),
                         [](auto& a, auto& b) { return a.cost * (1 + 1e-9) < b.cost; });
    }
    if (best.empty()) return std::nullopt;
    std::size_t chosen = 0;
    double least = 1e300;
    for (std::size_t i = 0; i < best.size(); ++i)
        // The product weighs both: a cut that leaves more volume must extend less by the same factor.
        if (const double now = beyond_of(best[i], solid) * best[i].cost; now < least * (1 - 1e-9))
            least = now, chosen = i;
    return std::move(best[chosen]);
}

// ---- joining --------------------------------------------------------------------------------------------------

/// Joins parts pairwise. The hull of a pair is computed once and kept.
class Joiner {
  public:
    Joiner(std::vector<Convex> from, const Surface& of, double allowed) : solid(of), deviation(allowed) {
        for (Convex& part : from) parts.push_back(part_of(std::move(part)));
    }

    /// Joins the first two parts whose common hull still follows the solid closely enough; false if there are none.
    bool join_two() {
        for (std::size_t i = 0; i < parts.size(); ++i)
            for (std::size_t j = i + 1; j < parts.size(); ++j) {
                if (!are_near(i, j)) continue;
                Together& both = together(i, j);
                if (!both.hull || both.hull->volume > 1.1 * (parts[i].hull.volume + parts[j].hull.volume))
                    continue;
                if (beyond_of(both) > deviation) continue;
                replace(i, j, std::move(*both.hull));
                return true;
            }
        return false;
    }

    /// Among the pairs whose common hull adds the least volume, joins the pair that extends least beyond the solid;
    /// false if no pair has a common hull.
    bool join_cheapest() {
        constexpr std::size_t measured = 60;
        std::vector<std::tuple<double, std::size_t, std::size_t>> pairs; // added volume, first, second
        for (const bool any : {false, true})
            for (std::size_t i = 0; i < parts.size() && (!any || pairs.empty()); ++i)
                for (std::size_t j = i + 1; j < parts.size(); ++j) {
                    if (!any && !are_near(i, j)) continue;
                    if (const Together& both = together(i, j); both.hull)
                        pairs.emplace_back(both.hull->volume - parts[i].hull.volume - parts[j].hull.volume, i,
                                           j);
                }
        if (pairs.empty()) return false;
        std::sort(pairs.begin(), pairs.end());
        pairs.resize(std::min(pairs.size(), measured));
        double least = 1e300;
        std::size_t first = 0, second = 0;
        for (const auto& [added, i, j] : pairs)
            if (const double beyond = beyond_of(together(i, j)); beyond < least)
                least = beyond, first = i, second = j;
        replace(first, second, std::move(*together(first, second).hull));
        return true;
    }

    std::size_t size() const { return parts.size(); }
    std::vector<Convex> take() && {
        std::vector<Convex> out;
        for (Part& part : parts) out.push_back(std::move(part.hull));
        return out;
    }

  private:
    struct Part {
        std::uint32_t id;
        Box box;
        Convex hull;
    };
    struct Together {
        std::optional<Convex> hull;
        std::optional<double> beyond; ///< `excess` of the hull
    };

    Part part_of(Convex hull) {
        const Box box = bounds_of(hull.surface.vertices);
        return {next_id++, box, std::move(hull)};
    }
    Together& together(std::size_t i, std::size_t j) {
        const auto [at, is_new] = made.try_emplace(std::pair(parts[i].id, parts[j].id));
        if (!is_new) return at->second;
        std::vector<Point> points = parts[i].hull.surface.vertices;
        const std::vector<Point>& more = parts[j].hull.surface.vertices;
        points.insert(points.end(), more.begin(), more.end());
        if (Result<Convex> hull = convex_hull(points)) at->second.hull = std::move(*hull);
        return at->second;
    }
    /// True if the boxes of the parts are no farther apart than twice the allowed deviation: only then a common hull
    /// can be allowed.
    bool are_near(std::size_t i, std::size_t j) const {
        for (int axis = 0; axis < 3; ++axis) {
            const double gap = std::max(parts[i].box.lower[axis] - parts[j].box.upper[axis],
                                        parts[j].box.lower[axis] - parts[i].box.upper[axis]);
            if (gap > 2 * deviation) return false;
        }
        return true;
    }
    double beyond_of(Together& both) const {
        if (!both.beyond) both.beyond = excess(*both.hull, solid, 2 * samples_per_hull);
        return *both.beyond;
    }
    void replace(std::size_t i, std::size_t j, Convex hull) {
        parts[i] = part_of(std::move(hull));
        parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(j));
    }

    const Surface& solid;
    double deviation;
    std::uint32_t next_id = 0;
    std::vector<Part> parts;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Together> made;
};

// ---- cutting --------------------------------------------------------------------------------------------------

/// One soup for each solid of the surface if it has a few of them; otherwise the whole surface.
std::vector<Soup> solids_of(const Soup& soup, std::size_t count_max) {
    std::vector<Soup> solids = components_of(soup);
    if (solids.size() > count_max) return {soup};
    for (const Soup& solid : solids)
        if (!soundness_of(solid).sound()) return {soup}; // open, or a hole in another solid
    return solids;
}

/// A hull covers concave places with its largest facets, so these are sampled.
constexpr std::size_t facets_asked_max = 200;

std::vector<std::size_t> largest_triangles(const Soup& soup, std::size_t count) {
    std::vector<std::pair<double, std::size_t>> areas; // negative, so that the largest come first
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const auto [a, b, c] = soup.corners(i);
        areas.emplace_back(-length(cross(b - a, c - a)), i);
    }
    count = std::min(count, areas.size());
    std::partial_sort(areas.begin(), areas.begin() + static_cast<std::ptrdiff_t>(count), areas.end());
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < count; ++i) out.push_back(areas[i].second);
    std::sort(out.begin(), out.end());
    return out;
}

} // namespace

double excess(const Convex& hull, const Surface& solid, std::size_t samples) {
    double most = 0;
    const auto ask = [&](Point p) {
        // Near the surface `contains` may be wrong, but there the distance is close to zero.
        if (!solid.contains(p)) most = std::max(most, solid.distance(p));
    };
    for (const std::size_t i : largest_triangles(hull.surface, facets_asked_max)) {
        const auto [a, b, c] = hull.surface.corners(i);
        ask((a + b + c) * (1.0 / 3));
        ask((a + b) * 0.5);
        ask((b + c) * 0.5);
        ask((c + a) * 0.5);
    }
    for (const Point& p : sample_surface(hull.surface, samples)) ask(p);
    for (const Point& p : points_between(hull, solid, most)) ask(p);
    const Box box = bounds_of(hull.surface.vertices);
    for (std::uint64_t i = 0; i < samples; ++i) {
        const Point u = even_point(i), size = box.size();
        const Point p = box.lower + Point{u.x * size.x, u.y * size.y, u.z * size.z};
        if (hull.holds(p, 0)) ask(p);
    }
    return most;
}

std::vector<Point> points_between(const Convex& hull, const Surface& solid, double distance) {
    std::vector<Point> out;
    const Box box = bounds_of(hull.surface.vertices);
    for (const SurfacePoint& point : solid.spread()) {
        bool is_within = true;
        for (int axis = 0; axis < 3; ++axis)
            is_within = is_within && point.at[axis] >= box.lower[axis] && point.at[axis] <= box.upper[axis];
        if (!is_within || !hull.holds(point.at, distance)) continue;
        for (const double side : {1.0, -1.0}) {
            const Point way = point.normal * side;
            double far = hull.way_out(point.at, way);
            for (int halved = 0; halved < 6 && far > distance; ++halved, far /= 2)
                out.push_back(point.at + way * far);
        }
    }
    return out;
}

namespace {

/// Cuts pieces: first with the coarse triangles of each solid, then with few triangles of each piece.
class Cutter {
  public:
    Cutter(const Soup& soup, const Surface& of, const DecomposeOptions& wanted)
        : surface(of), options(wanted) {
        for (const Soup& part : solids_of(soup, options.parts_max)) {
            const std::size_t share =
                200 + triangles_searched * part.triangles.size() / soup.triangles.size();
            solids.push_back(std::make_unique<Solid>(part, share));
            const Solid& solid = *solids.back();
            std::vector<std::uint32_t> all(part.triangles.size());
            std::iota(all.begin(), all.end(), 0u);
            Piece piece{.of = &solid,
                        .cell = bounds_of(part.vertices),
                        .candidates = std::make_shared<const std::vector<std::uint32_t>>(std::move(all))};
            for (std::size_t i = 0; i < solid.coarse.triangles.size(); ++i)
                piece.clipped.push_back(solid.coarse.corners(i));
            edges[&solid] = concave_edges(solid.coarse);
            make_hull(piece);
            measure(piece);
            pieces.push_back(std::move(piece));
        }
    }

    /// Cuts the piece that extends farthest beyond the solid, until there are `count` pieces or all pieces are close
    /// enough.
    void cut(std::size_t count) {
        while (!pieces.empty() && pieces.size() + whole.size() < count) {
            const auto worst = std::max_element(pieces.begin(), pieces.end(),
                                                [](auto& a, auto& b) { return a.beyond < b.beyond; });
            if (worst->beyond <= options.deviation) break;
            std::optional<Sides> sides = best_cut(*worst, edges[worst->of], surface, options);
            if (!sides) whole.push_back(std::move(*worst));
            pieces.erase(worst);
            if (!sides) continue;
            for (Piece* side : {&sides->below, &sides->above})
                (side->hull ? pieces : flat).push_back(std::move(*side));
        }
    }

    /// Rebuilds all pieces from all triangles.
    void refine_all() {
        std::vector<Piece> before;
        for (std::vector<Piece>* some : {&pieces, &whole, &flat}) {
            std::move(some->begin(), some->end(), std::back_inserter(before));
            some->clear();
        }
        for (Piece& piece : before) {
            if (refine(piece)) measure(piece);
            if (piece.hull) pieces.push_back(std::move(piece));
        }
        if (is_fine) return;
        is_fine = true;
        for (const auto& solid : solids)
            if (solid->coarse.triangles.size() != solid->soup.triangles.size())
                edges[solid.get()] = concave_edges(solid->soup);
    }

    std::vector<Convex> take() && {
        std::vector<Convex> out;
        for (std::vector<Piece>* some : {&pieces, &whole})
            for (Piece& piece : *some) out.push_back(std::move(*piece.hull));
        return out;
    }

  private:
    // More triangles take more time and hardly change the first cuts.
    static constexpr std::size_t triangles_searched = 3'000;

    void measure(Piece& piece) const {
        if (piece.hull) piece.beyond = excess(*piece.hull, surface, samples_per_hull);
    }

    const Surface& surface;
    const DecomposeOptions& options;
    bool is_fine = false; ///< the edges are those of all triangles
    std::vector<std::unique_ptr<Solid>> solids;
    std::map<const Solid*, std::vector<Edge>> edges;
    std::vector<Piece> pieces;
    std::vector<Piece> whole; ///< no plane cuts them
    /// Pieces of few triangles without a volume, which may get one from all triangles.
    std::vector<Piece> flat;
};

} // namespace

Result<std::vector<Convex>> decompose(const Soup& soup, const Surface& solid,
                                      const DecomposeOptions& options) {
    if (const Result<Convex> whole = convex_hull(soup.vertices); !whole) return whole.error();
    constexpr std::size_t triangles_cut = 40'000; // more triangles take much longer and improve little
    Cutter cutter(coarsened(soup, triangles_cut), solid, options);
    cutter.cut(options.parts_max);
    cutter.refine_all();
    // Joining reduces the number of parts again, so the cuts may exceed it meanwhile. After each round the hulls are
    // rebuilt from all triangles, which shows errors of the coarse ones.
    constexpr std::size_t rounds = 6;
    for (std::size_t round = 1; round <= rounds && options.parts_max > 1; ++round) {
        cutter.cut(options.parts_max + (options.parts_max + 1) * round / rounds);
        cutter.refine_all();
    }
    Joiner joiner(std::move(cutter).take(), solid, options.deviation);
    while (joiner.join_two()) {}
    while (joiner.size() > options.parts_max && joiner.join_cheapest()) {}
    if (joiner.size() == 0) return Error{"the model has no volume (--as mesh --two-sided keeps a surface)"};
    return std::move(joiner).take();
}

} // namespace lockstone::cook
