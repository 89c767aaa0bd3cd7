#include "cook/soundness.h"

#include <map>
#include <numeric>

namespace lockstone::cook {
namespace {

/// An edge with the direction in which a triangle passes along it.
struct Side {
    std::uint32_t low, high;
    bool forward; ///< from low to high
};

std::vector<Side> sides_of(const Soup& soup) {
    std::vector<Side> sides;
    for (const Indices& t : soup.triangles)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t from = t[k], to = t[(k + 1) % 3];
            sides.push_back({std::min(from, to), std::max(from, to), from < to});
        }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
        return std::pair(a.low, a.high) < std::pair(b.low, b.high);
    });
    return sides;
}

double volume_of(const Soup& soup) {
    const Box box = bounds_of(soup.vertices);
    const Point middle = (box.lower + box.upper) * 0.5; // far from the origin digits are lost
    double six = 0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const auto [a, b, c] = soup.corners(i);
        six += dot(a - middle, cross(b - middle, c - middle));
    }
    return six / 6;
}

} // namespace

Soundness soundness_of(const Soup& soup) {
    Soundness found;
    const std::vector<Side> sides = sides_of(soup);
    for (std::size_t first = 0; first < sides.size();) {
        std::size_t last = first, forward = 0;
        for (; last < sides.size() && sides[last].low == sides[first].low &&
               sides[last].high == sides[first].high;
             ++last)
            forward += sides[last].forward ? 1u : 0u;
        const std::size_t count = last - first, back = count - forward;
        if (count % 2 != 0)
            ++found.edges_open;
        else if (forward != back)
            ++found.edges_disputed;
        first = last;
    }
    if (!soup.triangles.empty()) found.volume = volume_of(soup);
    return found;
}

std::vector<Soup> components_of(const Soup& soup) {
    std::vector<std::uint32_t> parent(soup.vertices.size());
    std::iota(parent.begin(), parent.end(), 0u);
    const auto root = [&](std::uint32_t v) {
        while (parent[v] != v) v = parent[v] = parent[parent[v]];
        return v;
    };
    for (const Indices& t : soup.triangles)
        for (const std::uint32_t v : {t[1], t[2]}) parent[root(v)] = root(t[0]);
    std::map<std::uint32_t, std::size_t> place; // of a root
    std::vector<Soup> out;
    for (const Indices& t : soup.triangles) {
        const auto [at, is_new] = place.try_emplace(root(t[0]), out.size());
        if (is_new) out.emplace_back();
        out[at->second].triangles.push_back(t);
    }
    for (Soup& part : out) {
        const Soup indexed{soup.vertices, std::move(part.triangles)};
        part = compacted(indexed);
    }
    return out;
}

Soup coarsened(const Soup& soup, std::size_t triangles_max) {
    if (soup.triangles.size() <= triangles_max) return soup;
    const Box box = bounds_of(soup.vertices);
    Soup out;
    for (double cells = 256; cells >= 4; cells *= 0.75) {
        const double cell = box.largest() / cells;
        std::map<std::array<int, 3>, std::uint32_t> first;
        std::vector<std::uint32_t> index;
        for (std::uint32_t i = 0; i < soup.vertices.size(); ++i) {
            const Point p = (soup.vertices[i] - box.lower) * (1 / cell);
            const std::array<int, 3> key{static_cast<int>(p.x), static_cast<int>(p.y), static_cast<int>(p.z)};
            index.push_back(first.try_emplace(key, i).first->second);
        }
        out = {soup.vertices, {}};
        for (const Indices& t : soup.triangles) {
            const Indices now{index[t[0]], index[t[1]], index[t[2]]};
            if (now[0] != now[1] && now[1] != now[2] && now[2] != now[0]) out.triangles.push_back(now);
        }
        if (out.triangles.size() <= triangles_max) break;
    }
    out = compacted(welded(out));
    return out.triangles.empty() ? soup : out;
}

} // namespace lockstone::cook
