#include "cook/surface.h"

#include "cook/soundness.h"

#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/geometry/shape/sphere.h>
#include <fcl/narrowphase/collision.h>

#include <numeric>

namespace lockstone::cook {

Point nearest_of_triangle(const std::array<Point, 3>& corners, Point p) {
    const auto& [a, b, c] = corners;
    const Point ab = b - a, ac = c - a;
    const double d1 = dot(ab, p - a), d2 = dot(ac, p - a);
    if (d1 <= 0 && d2 <= 0) return a;
    const double d3 = dot(ab, p - b), d4 = dot(ac, p - b);
    if (d3 >= 0 && d4 <= d3) return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 > d3) return a + ab * (d1 / (d1 - d3));
    const double d5 = dot(ab, p - c), d6 = dot(ac, p - c);
    if (d6 >= 0 && d5 <= d6) return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 > d6) return a + ac * (d2 / (d2 - d6));
    const double va = d3 * d6 - d5 * d4, on_bc = (d4 - d3) + (d5 - d6);
    if (va <= 0 && d4 >= d3 && d5 >= d6 && on_bc > 0) return b + (c - b) * ((d4 - d3) / on_bc);
    const double sum = va + vb + vc;
    if (sum == 0) return a;
    return a + ab * (vb / sum) + ac * (vc / sum);
}

// ---- distance -------------------------------------------------------------------------------------------------

struct Surface::SecondOpinion {
    explicit SecondOpinion(const Soup& soup) {
        const auto to_fcl = [](Point p) { return fcl::Vector3d(p.x, p.y, p.z); };
        model.beginModel(static_cast<int>(soup.triangles.size()));
        for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
            const auto [a, b, c] = soup.corners(i);
            model.addTriangle(to_fcl(a), to_fcl(b), to_fcl(c));
        }
        model.endModel();
    }
    fcl::BVHModel<fcl::OBBRSSd> model;
};

constexpr std::size_t spread_count = 4'000;

Surface::Surface(const Soup& all)
    : soup(all), box(bounds_of(all.vertices)), points(sample_surface_points(all, spread_count)),
      is_oriented(soundness_of(all).oriented()), grids{make_grid(all, box, 0), make_grid(all, box, 1),
                                                       make_grid(all, box, 2)} {
    order.resize(soup.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    make_node(0, static_cast<std::uint32_t>(order.size()));
}

Surface::Surface(Surface&&) noexcept = default;
Surface::~Surface() = default;

/// Builds a tree node: splits the triangles at the median along the longest side of their centres' bounds, down to a
/// few triangles.
std::uint32_t Surface::make_node(std::uint32_t first, std::uint32_t last) {
    constexpr std::uint32_t leaf_size = 4;
    Node node{{}, first, last - first, 0, 0};
    Box middles;
    const auto middle = [&](std::uint32_t t) {
        const auto [a, b, c] = soup.corners(t);
        return a + b + c;
    };
    for (std::uint32_t i = first; i < last; ++i) {
        for (const Point& p : soup.corners(order[i])) node.box.add(p);
        middles.add(middle(order[i]));
    }
    if (node.count > leaf_size) {
        const Point size = middles.size();
        const int axis = size.x >= std::max(size.y, size.z) ? 0 : size.y >= size.z ? 1 : 2;
        const std::uint32_t half = first + node.count / 2;
        std::nth_element(order.begin() + first, order.begin() + half, order.begin() + last,
                         [&](auto a, auto b) { return middle(a)[axis] < middle(b)[axis]; });
        node.count = 0;
        node.left = make_node(first, half);
        node.right = make_node(half, last);
    }
    nodes.push_back(node);
    return static_cast<std::uint32_t>(nodes.size() - 1);
}

double Surface::distance(Point p) const {
    double nearest = 1e300; // squared
    const auto to_box = [&](const Box& b) {
        double sum = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double d = std::max({b.lower[axis] - p[axis], 0.0, p[axis] - b.upper[axis]});
            sum += d * d;
        }
        return sum;
    };
    std::array<std::uint32_t, 64> stack; // the tree is balanced: 24 levels for 2^24 triangles
    std::size_t depth = 0;
    stack[depth++] = static_cast<std::uint32_t>(nodes.size() - 1);
    while (depth > 0) {
        const Node& node = nodes[stack[--depth]];
        if (to_box(node.box) >= nearest) continue;
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const Point way = p - nearest_of_triangle(soup.corners(order[i]), p);
            nearest = std::min(nearest, dot(way, way));
        }
        if (node.count > 0) continue;
        const bool left_first = to_box(nodes[node.left].box) <= to_box(nodes[node.right].box);
        stack[depth++] = left_first ? node.right : node.left;
        stack[depth++] = left_first ? node.left : node.right;
    }
    return std::sqrt(nearest);
}

bool Surface::ball_meets(Point centre, double radius) const {
    if (second == nullptr) second = std::make_unique<SecondOpinion>(soup);
    const fcl::Sphered ball(radius);
    fcl::Transform3d at = fcl::Transform3d::Identity();
    at.translation() = fcl::Vector3d(centre.x, centre.y, centre.z);
    const fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    return fcl::collide(&second->model, fcl::Transform3d(fcl::Transform3d::Identity()), &ball, at, request,
                        result) > 0;
}

// ---- inside: rays along the axes ------------------------------------------------------------------------------

Surface::Grid Surface::make_grid(const Soup& soup, const Box& box, int axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    Grid grid;
    grid.axis = axis;
    grid.side =
        std::clamp(static_cast<int>(2 * std::sqrt(static_cast<double>(soup.triangles.size()))), 1, 1024);
    grid.lower = box.lower;
    for (const int i : {u, v}) grid.cell[i] = std::max(box.size()[i] / grid.side, 1e-300);
    const auto column = [&](double at, int i) {
        return std::clamp(static_cast<int>((at - grid.lower[i]) / grid.cell[i]), 0, grid.side - 1);
    };
    std::vector<std::array<int, 4>> ranges;
    grid.first.assign(static_cast<std::size_t>(grid.side * grid.side) + 1, 0);
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        Box around;
        for (const Point& p : soup.corners(t)) around.add(p);
        ranges.push_back({column(around.lower[u], u), column(around.upper[u], u), column(around.lower[v], v),
                          column(around.upper[v], v)});
    }
    const auto for_each_cell = [&](auto&& visit) {
        for (std::size_t t = 0; t < ranges.size(); ++t)
            for (int j = ranges[t][2]; j <= ranges[t][3]; ++j)
                for (int i = ranges[t][0]; i <= ranges[t][1]; ++i)
                    visit(static_cast<std::size_t>(j * grid.side + i), static_cast<std::uint32_t>(t));
    };
    for_each_cell([&](std::size_t cell, std::uint32_t) { ++grid.first[cell + 1]; });
    for (std::size_t cell = 1; cell < grid.first.size(); ++cell) grid.first[cell] += grid.first[cell - 1];
    grid.triangles.resize(grid.first.back());
    std::vector<std::uint32_t> next(grid.first.begin(), grid.first.end() - 1);
    for_each_cell([&](std::size_t cell, std::uint32_t t) { grid.triangles[next[cell]++] = t; });
    return grid;
}

/// Calls visit(coordinate along the axis, 1 or -1 by the orientation of the triangle) for every triangle that the line
/// through (u, v) along the axis crosses.
template <class Visit> void Surface::crossings(const Grid& grid, double u, double v, Visit&& visit) const {
    const int ui = (grid.axis + 1) % 3, vi = (grid.axis + 2) % 3;
    if (u < box.lower[ui] || u > box.upper[ui] || v < box.lower[vi] || v > box.upper[vi]) return;
    const auto column = [&](double at, int i) {
        return std::clamp(static_cast<int>((at - grid.lower[i]) / grid.cell[i]), 0, grid.side - 1);
    };
    const auto cell = static_cast<std::size_t>(column(v, vi) * grid.side + column(u, ui));
    for (std::uint32_t at = grid.first[cell]; at < grid.first[cell + 1]; ++at) {
        const auto corners = soup.corners(grid.triangles[at]);
        // Twice the signed areas of the triangles between (u, v) and the edges. Inside they have equal signs.
        std::array<double, 3> area{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Point &a = corners[k], &b = corners[(k + 1) % 3];
            area[k] = (a[ui] - u) * (b[vi] - v) - (a[vi] - v) * (b[ui] - u);
        }
        const bool left = area[0] >= 0 && area[1] >= 0 && area[2] >= 0;
        const bool right = area[0] <= 0 && area[1] <= 0 && area[2] <= 0;
        const double sum = area[0] + area[1] + area[2];
        if ((!left && !right) || sum == 0) continue;
        visit((corners[2][grid.axis] * area[0] + corners[0][grid.axis] * area[1] +
               corners[1][grid.axis] * area[2]) /
                  sum,
              sum > 0 ? 1 : -1);
    }
}

bool Surface::contains(Point p) const {
    int votes = 0;
    for (const Grid& grid : grids) {
        const int u = (grid.axis + 1) % 3, v = (grid.axis + 2) % 3;
        // The ray is moved off round coordinates, on which the edges of designed models lie: a ray through an edge
        // would count twice.
        const double du = 1.37e-7 * box.size()[u], dv = 2.11e-7 * box.size()[v];
        int above = 0, turns = 0;
        crossings(grid, p[u] + du, p[v] + dv, [&](double at, int side) {
            if (at <= p[grid.axis]) return;
            ++above;
            turns += side;
        });
        votes += (is_oriented ? turns != 0 : above % 2 != 0) ? 1 : 0;
    }
    return votes >= 2;
}

bool Surface::top(double x, double z, double& height) const {
    bool any = false;
    // For the axis y the other two axes are z and x, in this order.
    crossings(grids[1], z, x, [&](double at, int) {
        height = any ? std::max(height, at) : at;
        any = true;
    });
    return any;
}

} // namespace lockstone::cook
