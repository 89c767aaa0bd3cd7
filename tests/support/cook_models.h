// Small models for the tests of cooking.
#pragma once

#include "cook/soup.h"

#include <utility>

namespace cook_models {

using lockstone::cook::Indices;
using lockstone::cook::Point;
using lockstone::cook::Soup;

inline Soup box(Point lower, Point upper) {
    Soup soup;
    for (unsigned i = 0; i < 8; ++i)
        soup.vertices.push_back({(i & 1u) != 0 ? upper.x : lower.x, (i & 2u) != 0 ? upper.y : lower.y,
                                 (i & 4u) != 0 ? upper.z : lower.z});
    constexpr std::uint32_t quads[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                           {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (const auto& q : quads) {
        soup.triangles.push_back({q[0], q[1], q[2]});
        soup.triangles.push_back({q[0], q[2], q[3]});
    }
    return soup;
}

/// A box with a box-shaped hole inside.
inline Soup hollow_box() {
    Soup soup = box({-2, -2, -2}, {2, 2, 2}), hole = box({-1, -1, -1}, {1, 1, 1});
    for (Indices& t : hole.triangles) std::swap(t[1], t[2]);
    soup.append(hole);
    return soup;
}

/// An L with a volume of 4 m^3, 1 m deep.
inline Soup bracket() {
    constexpr double outline[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
    constexpr std::uint32_t cap[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 5}, {3, 4, 5}};
    Soup soup;
    for (const double z : {0.0, 1.0})
        for (const auto& p : outline) soup.vertices.push_back({p[0], p[1], z});
    for (const auto& t : cap) {
        soup.triangles.push_back({t[0], t[2], t[1]});
        soup.triangles.push_back({t[0] + 6, t[1] + 6, t[2] + 6});
    }
    for (std::uint32_t i = 0; i < 6; ++i) {
        const std::uint32_t j = (i + 1) % 6;
        soup.triangles.push_back({i, j, j + 6});
        soup.triangles.push_back({i, j + 6, i + 6});
    }
    return soup;
}

/// A torus about the y axis.
inline Soup torus(double radius, double thickness, std::uint32_t around, std::uint32_t across) {
    Soup soup;
    const auto index = [&](std::uint32_t i, std::uint32_t j) { return i % around * across + j % across; };
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < across; ++j) {
            const double a = 6.283185307179586 * i / around, b = 6.283185307179586 * j / across;
            const double r = radius + thickness * std::cos(b);
            soup.vertices.push_back({r * std::cos(a), thickness * std::sin(b), r * std::sin(a)});
            soup.triangles.push_back({index(i, j), index(i, j + 1), index(i + 1, j + 1)});
            soup.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i + 1, j)});
        }
    return soup;
}

/// Points spread evenly over a ball.
inline std::vector<Point> ball(double radius, std::size_t count) {
    std::vector<Point> out;
    for (std::size_t i = 0; i < count; ++i) {
        const double y = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
        const double turn = 2.399963229728653 * static_cast<double>(i), r = std::sqrt(1 - y * y);
        out.push_back({radius * r * std::cos(turn), radius * y, radius * r * std::sin(turn)});
    }
    return out;
}

/// cells x cells squares of 1 m with a bump, facing up.
inline Soup hill(std::uint32_t cells) {
    Soup soup;
    const std::uint32_t side = cells + 1;
    for (std::uint32_t z = 0; z < side; ++z)
        for (std::uint32_t x = 0; x < side; ++x)
            soup.vertices.push_back({double(x), 2 * std::sin(0.4 * x) * std::sin(0.3 * z), double(z)});
    for (std::uint32_t z = 0; z < cells; ++z)
        for (std::uint32_t x = 0; x < cells; ++x) {
            const std::uint32_t a = z * side + x;
            soup.triangles.push_back({a, a + side + 1, a + 1});
            soup.triangles.push_back({a, a + side, a + side + 1});
        }
    return soup;
}

} // namespace cook_models
