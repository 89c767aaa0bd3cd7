// Merges the exact triangles of a hull into faces for contact manifolds.
//
// Triangles in exactly one plane form a facet, a convex polygon. In a quantised or scanned shape, the facets of
// one intended face differ by roundings. They are merged, the largest first, as long as the outline stays
// convex.
#include "shapes/hull/hull.h"

#include "lockstone/math/math.h"
#include "shapes/hull/support_kernel.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace lockstone::shapes {
namespace {

constexpr std::uint16_t no_index = 0xffff;
// The angle between two facets of one face is below acos of this, about 8 degrees. Slivers may have any
// direction.
constexpr Unit same_way = decimal<Unit>("0.99");

struct Facet {
    std::uint16_t first, count; // range of its triangles in `by_facet`
    WideVec3 normal{};          // exact; its length is twice the area
    Scaled area{};
    UnitVec3 unit{};
    bool sliver = false;
};

class FaceFinder {
  public:
    FaceFinder(Hull& of, Length thickness) : hull(of), tolerance(face_tolerance(of, thickness)) {}

    void run() {
        find_adjacency();
        find_facets();
        std::vector<std::uint16_t> order(facets.size());
        std::iota(order.begin(), order.end(), std::uint16_t{0});
        std::ranges::stable_sort(order, [&](auto a, auto b) { return facets[b].area < facets[a].area; });
        face_of.assign(facets.size(), no_index);
        for (std::uint16_t seed : order) {
            if (face_of[seed] != no_index) continue;
            reach_from(seed);
            if (members.size() > 1 && !(trace() && is_convex(normal_of_members()))) members.assign(1, seed);
            if (members.size() == 1) trace();
            add_face();
        }
        find_edges();
        hull.face_of.clear();
        for (const std::uint16_t facet : facet_of) hull.face_of.push_back(face_of[facet]);
    }

  private:
    void find_adjacency() {
        const std::size_t n = hull.vertices.size();
        triangle_at.assign(n * n, no_index);
        for (std::size_t t = 0; t < hull.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) at(t, k) = static_cast<std::uint16_t>(t);
    }
    /// The triangle of a directed edge: `at(t, k)` for edge k of t, `across(t, k)` for the opposite direction,
    /// which is the neighbour.
    std::uint16_t& at(std::size_t t, std::size_t k) {
        return triangle_at[hull.triangles[t][k] * hull.vertices.size() + hull.triangles[t][(k + 1) % 3]];
    }
    std::uint16_t across(std::size_t t, std::size_t k) const {
        return triangle_at[hull.triangles[t][(k + 1) % 3] * hull.vertices.size() + hull.triangles[t][k]];
    }
    WideVec3 triangle_normal(std::size_t t) const {
        const auto& [a, b, c] = hull.triangles[t];
        return exact_normal(hull.vertices[a], hull.vertices[b], hull.vertices[c]);
    }
    bool is_flat(std::size_t t, std::uint16_t other) const {
        const WideVec3 n = triangle_normal(t);
        for (std::uint8_t v : hull.triangles[other])
            if (!(exact_height(n, hull.vertices[hull.triangles[t][0]], hull.vertices[v]) == Wide::from(0)))
                return false;
        return true;
    }

    void find_facets() {
        facet_of.assign(hull.triangles.size(), no_index);
        for (std::size_t first = 0; first < hull.triangles.size(); ++first) {
            if (facet_of[first] != no_index) continue;
            const std::uint16_t id = static_cast<std::uint16_t>(facets.size());
            Facet facet{};
            facet.first = static_cast<std::uint16_t>(by_facet.size());
            by_facet.push_back(static_cast<std::uint16_t>(first));
            facet_of[first] = id;
            for (std::size_t i = facet.first; i < by_facet.size(); ++i) {
                const std::uint16_t t = by_facet[i];
                const WideVec3 n = triangle_normal(t);
                facet.normal = {facet.normal.x + n.x, facet.normal.y + n.y, facet.normal.z + n.z};
                for (std::size_t k = 0; k < 3; ++k)
                    if (const std::uint16_t next = across(t, k);
                        facet_of[next] == no_index && is_flat(first, next)) {
                        facet_of[next] = id;
                        by_facet.push_back(next);
                    }
            }
            facet.count = static_cast<std::uint16_t>(by_facet.size() - facet.first);
            facet.area = length_of(facet.normal);
            facet.unit = unit_of(facet.normal);
            facet.sliver = facet.area < scaled(tolerance) * scaled(span_of(facet));
            facets.push_back(facet);
        }
    }
    std::span<const std::uint16_t> triangles_of(const Facet& facet) const {
        return std::span(by_facet).subspan(facet.first, facet.count);
    }
    /// The greatest extent along a coordinate axis.
    Length span_of(const Facet& facet) const {
        LengthVec3 low = hull.vertices[hull.triangles[by_facet[facet.first]][0]], high = low;
        for (std::uint16_t t : triangles_of(facet))
            for (std::uint8_t v : hull.triangles[t])
                low = min(low, hull.vertices[v]), high = max(high, hull.vertices[v]);
        const LengthVec3 size = high - low;
        return max(size.x, max(size.y, size.z));
    }

    bool belongs(const Facet& facet, const Facet& seed) const {
        if (!facet.sliver && dot(facet.unit, seed.unit) < same_way) return false;
        // n . (v - origin): |v - origin| is below 2^9 m, so 63 bits suffice.
        const LengthVec3 origin = hull.vertices[hull.triangles[by_facet[seed.first]][0]];
        const std::int64_t lowest = -(std::int64_t{tolerance.raw} << 30);
        for (std::uint16_t t : triangles_of(facet))
            for (std::uint8_t v : hull.triangles[t]) {
                std::int64_t along = 0;
                for (int i = 0; i < 3; ++i)
                    along += seed.unit[i].raw * (std::int64_t{hull.vertices[v][i].raw} - origin[i].raw);
                if (along < lowest) return false;
            }
        return true;
    }
    /// Fills `members` with the seed and the connected facets that belong to it.
    void reach_from(std::uint16_t seed) {
        members.assign(1, seed);
        looked_at.assign(facets.size(), 0);
        looked_at[seed] = 1;
        for (std::size_t i = 0; i < members.size(); ++i)
            for (std::uint16_t t : triangles_of(facets[members[i]]))
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint16_t next = facet_of[across(t, k)];
                    if (looked_at[next] != 0 || face_of[next] != no_index) continue;
                    looked_at[next] = 1;
                    if (belongs(facets[next], facets[seed])) members.push_back(next);
                }
    }
    UnitVec3 normal_of_members() const {
        WideVec3 sum{};
        for (std::uint16_t m : members) {
            const WideVec3& n = facets[m].normal;
            sum = {sum.x + n.x, sum.y + n.y, sum.z + n.z};
        }
        return unit_of(sum);
    }

    /// Fills `outline` from the members, which are connected. Returns false unless it is one loop that visits
    /// no vertex twice.
    bool trace() {
        is_member.assign(facets.size(), 0);
        for (std::uint16_t m : members) is_member[m] = 1;
        after.assign(hull.vertices.size(), no_index);
        std::size_t edges = 0;
        std::uint8_t first = 0xff;
        for (std::uint16_t m : members)
            for (std::uint16_t t : triangles_of(facets[m]))
                for (std::size_t k = 0; k < 3; ++k) {
                    if (is_member[facet_of[across(t, k)]] != 0) continue;
                    const std::uint8_t from = hull.triangles[t][k];
                    if (after[from] != no_index) return false;
                    after[from] = hull.triangles[t][(k + 1) % 3];
                    first = std::min(first, from);
                    ++edges;
                }
        outline.clear();
        if (edges < 3) return false;
        std::uint16_t v = first;
        do {
            outline.push_back(static_cast<std::uint8_t>(v));
            v = after[v];
        } while (v != first && v != no_index && outline.size() <= edges);
        return outline.size() == edges;
    }
    /// True when, seen along the normal, no corner is outside of an edge by more than the tolerance.
    bool is_convex(UnitVec3 normal) const {
        for (std::size_t i = 0; i < outline.size(); ++i) {
            const CoordinateVec3 from = to<Coordinate>(hull.vertices[outline[i]]);
            const CoordinateVec3 to_next =
                to<Coordinate>(hull.vertices[outline[(i + 1) % outline.size()]]) - from;
            const UnitVec3 inward = normalized(cross<Coordinate>(normal, to_next));
            for (std::uint8_t v : outline)
                if (dot<Coordinate>(inward, to<Coordinate>(hull.vertices[v]) - from) <
                    -to<Coordinate>(tolerance))
                    return false;
        }
        return true;
    }

    void add_face() {
        const std::uint16_t id = static_cast<std::uint16_t>(hull.faces.size());
        for (std::uint16_t m : members) face_of[m] = id;
        Hull::Face face{};
        face.normal = normal_of_members();
        face.first = static_cast<std::uint16_t>(hull.loops.size());
        face.count = static_cast<std::uint16_t>(outline.size());
        // Rounded up, so that all of the hull is below.
        const std::int64_t furthest = reach_along(hull.vertices, face.normal).high_54;
        face.offset = Coordinate::from_raw((furthest + ((std::int64_t{1} << 30) - 1)) >> 30);
        hull.faces.push_back(face);
        hull.loops.insert(hull.loops.end(), outline.begin(), outline.end());
    }

    void find_edges() {
        for (std::size_t t = 0; t < hull.triangles.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint8_t from = hull.triangles[t][k], to = hull.triangles[t][(k + 1) % 3];
                const std::uint16_t left = face_of[facet_of[t]], right = face_of[facet_of[across(t, k)]];
                if (from < to && left != right) hull.edges.push_back({from, to, left, right});
            }
        std::ranges::sort(hull.edges, [](const Hull::Edge& a, const Hull::Edge& b) {
            return a.from != b.from ? a.from < b.from : a.to < b.to;
        });
    }

    Hull& hull;
    Length tolerance;
    std::vector<std::uint16_t> triangle_at; // by from * vertices + to
    std::vector<Facet> facets;
    std::vector<std::uint16_t> by_facet;          // triangles
    std::vector<std::uint16_t> facet_of, face_of; // by triangle; by facet
    // The face under construction: its facets and its corners; and scratch.
    std::vector<std::uint16_t> members, after; // `after`: for each vertex the next corner of the outline
    std::vector<std::uint8_t> outline, looked_at, is_member;
};

} // namespace

void find_faces(Hull& hull, Length thickness) { FaceFinder(hull, thickness).run(); }

Length patch_depth(const Hull& hull) {
    return Length::from_raw(std::min(hull.inner_radius.raw >> 5, 1 << 13));
}

namespace {

/// The outline of corners seen along a normal, counter-clockwise: the 2D convex hull without the normal's
/// longest axis.
std::vector<std::uint8_t> outline_of(const Hull& hull, UnitVec3 normal, std::vector<std::uint8_t> corners) {
    int drop = 0;
    for (int i = 1; i < 3; ++i)
        if (abs(normal[i]) > abs(normal[drop])) drop = i;
    int u = (drop + 1) % 3, v = (drop + 2) % 3;
    if (normal[drop] < Unit{}) std::swap(u, v);
    const auto at = [&](std::uint8_t corner, int axis) {
        return std::int64_t{hull.vertices[corner][axis].raw};
    };
    std::ranges::sort(corners, [&](std::uint8_t a, std::uint8_t b) {
        return std::tuple(at(a, u), at(a, v), a) < std::tuple(at(b, u), at(b, v), b);
    });
    const auto turns_left = [&](std::uint8_t a, std::uint8_t b, std::uint8_t c) {
        const Wide cross = Wide::product(at(b, u) - at(a, u), at(c, v) - at(a, v)) -
                           Wide::product(at(b, v) - at(a, v), at(c, u) - at(a, u));
        return !cross.is_negative() && !(cross == Wide::from(0));
    };
    std::vector<std::uint8_t> outline;
    for (int side = 0; side < 2; ++side) {
        const std::size_t begin = outline.size();
        for (const std::uint8_t corner : corners) {
            while (outline.size() >= begin + 2 &&
                   !turns_left(outline[outline.size() - 2], outline.back(), corner))
                outline.pop_back();
            outline.push_back(corner);
        }
        outline.pop_back(); // the next side begins with it
        std::ranges::reverse(corners);
    }
    return outline;
}

} // namespace

void find_patches(Hull& hull) {
    const std::int64_t depth_54 = std::int64_t{patch_depth(hull).raw} << Unit::fraction_bits;
    hull.patches.clear();
    for (Hull::Face& face : hull.faces) {
        face.patch_first = face.patch_count = 0;
        const std::int64_t least = reach_along(hull.vertices, face.normal).high_54 - depth_54;
        const auto own = std::span(hull.loops).subspan(face.first, face.count);
        const auto is_own = [&](std::size_t v) { return std::ranges::find(own, v) != own.end(); };
        // The corners of the face belong to its patch at any depth: else the deepest corner of a less flat face
        // could be missing.
        std::vector<std::uint8_t> corners;
        for (std::size_t v = 0; v < hull.vertices.size(); ++v)
            if (is_own(v) || reach_along(std::span(&hull.vertices[v], 1), face.normal).high_54 >= least)
                corners.push_back(static_cast<std::uint8_t>(v));
        if (std::ranges::all_of(corners, is_own)) continue;
        const std::vector<std::uint8_t> outline = outline_of(hull, face.normal, std::move(corners));
        if (outline.size() < 3) continue;
        face.patch_first = static_cast<std::uint32_t>(hull.patches.size());
        face.patch_count = static_cast<std::uint32_t>(outline.size());
        hull.patches.insert(hull.patches.end(), outline.begin(), outline.end());
    }
}

void index_corners(Hull& hull) {
    const std::size_t count = hull.vertices.size(),
                      stride = (count + corner_block - 1) / corner_block * corner_block;
    hull.lanes.clear(), hull.faces_at.clear();
    for (int axis = 0; axis < 3; ++axis)
        for (std::size_t v = 0; v < stride; ++v)
            hull.lanes.push_back(hull.vertices[v < count ? v : 0][axis].raw);
    // Uses the triangles, not the outlines: a corner inside a merged face is in no outline, but may be the
    // furthest corner.
    hull.first_face_at.assign(1, 0);
    std::vector<std::uint8_t> is_at(hull.faces.size());
    for (std::size_t v = 0; v < count; ++v) {
        is_at.assign(hull.faces.size(), 0);
        for (std::size_t t = 0; t < hull.triangles.size(); ++t)
            if (std::ranges::find(hull.triangles[t], v) != hull.triangles[t].end())
                is_at[hull.face_of[t]] = 1;
        for (std::size_t f = 0; f < hull.faces.size(); ++f)
            if (is_at[f] != 0) hull.faces_at.push_back(static_cast<std::uint16_t>(f));
        hull.first_face_at.push_back(static_cast<std::uint16_t>(hull.faces_at.size()));
    }
}

} // namespace lockstone::shapes
