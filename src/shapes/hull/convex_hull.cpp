#include "shapes/hull/convex_hull.h"

#include "lockstone/math/math.h"

#include <algorithm>
#include <tuple>

namespace lockstone::shapes {
namespace {

constexpr std::uint32_t none = 0xffffffffu;

constexpr bool before(LengthVec3 a, LengthVec3 b) {
    return std::tuple(a.x.raw, a.y.raw, a.z.raw) < std::tuple(b.x.raw, b.y.raw, b.z.raw);
}

struct Difference {
    std::int64_t x, y, z; // |component| <= 2^32
};
Difference difference(LengthVec3 a, LengthVec3 b) {
    return {std::int64_t{a.x.raw} - b.x.raw, std::int64_t{a.y.raw} - b.y.raw,
            std::int64_t{a.z.raw} - b.z.raw};
}

/// c d for |c| < 2^66 and |d| <= 2^32.
Wide times(Wide c, std::int64_t d) {
    const std::int64_t high = static_cast<std::int64_t>((c >> 32).low_bits());
    const std::int64_t low = static_cast<std::int64_t>(c.low_bits() & 0xffffffffu);
    return (Wide::product(high, d) << 32) + Wide::product(low, d);
}

int sign_of(Wide w) { return w.is_negative() ? -1 : w == Wide::from(0) ? 0 : 1; }
bool is_zero(const WideVec3& n) { return sign_of(n.x) == 0 && sign_of(n.y) == 0 && sign_of(n.z) == 0; }

struct HullFace {
    std::array<std::uint32_t, 3> corner;
    std::array<std::uint32_t, 3> across; ///< the face across the edge corner[k], corner[k + 1]
    WideVec3 normal;
    std::uint32_t seen_by; ///< 1 + the last point tested against it; `none` when the face is removed
    bool visible;
};

/// The hull while points are added.
class Growing {
  public:
    explicit Growing(std::span<const LengthVec3> sorted)
        : points(sorted), begins_at(sorted.size(), none), added(sorted.size(), 0) {
        faces.reserve(2 * sorted.size());
    }

    HullFault grow() {
        const HullFault fault = start();
        if (fault != HullFault::none) return fault;
        // start() skipped some points before the last corner of the first tetrahedron; they may be anywhere.
        // Each later point comes after all added ones in the order, so it is above a face at the point added
        // last.
        const std::uint32_t last = newest;
        for (std::uint32_t p = 0; p < last; ++p)
            if (added[p] == 0) add(p, any_visible(p));
        if (last + 1 < points.size()) add(last + 1, any_visible(last + 1));
        for (std::uint32_t p = last + 2; p < points.size(); ++p) add(p, visible_beside_last(p));
        return HullFault::none;
    }

    /// The points where at least three planes meet.
    std::vector<LengthVec3> corners() const {
        std::vector<std::uint32_t> creases(points.size(), 0);
        for (const HullFace& f : faces)
            for (std::size_t k = 0; f.seen_by != none && k < 3; ++k)
                if (height(f, opposite(f, k)) != 0) ++creases[f.corner[k]];
        std::vector<LengthVec3> out;
        for (std::size_t p = 0; p < points.size(); ++p)
            if (creases[p] >= 3) out.push_back(points[p]);
        return out;
    }

    std::vector<std::array<std::uint32_t, 3>> triangles() const {
        std::vector<std::array<std::uint32_t, 3>> out;
        for (const HullFace& f : faces) {
            if (f.seen_by == none) continue;
            out.push_back(f.corner);
            std::rotate(out.back().begin(), std::ranges::min_element(out.back()), out.back().end());
        }
        std::ranges::sort(out);
        return out;
    }

  private:
    struct RimEdge {
        std::uint32_t from, to, outer;
    };

    int height(const HullFace& f, std::uint32_t p) const {
        return sign_of(exact_height(f.normal, points[f.corner[0]], points[p]));
    }
    /// The corner of the face across edge k that is not on the edge.
    std::uint32_t opposite(const HullFace& f, std::size_t k) const {
        const HullFace& other = faces[f.across[k]];
        for (std::uint32_t corner : other.corner)
            if (corner != f.corner[k] && corner != f.corner[(k + 1) % 3]) return corner;
        return none;
    }

    std::uint32_t new_face(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        std::uint32_t at = static_cast<std::uint32_t>(faces.size());
        if (gone.empty()) {
            faces.emplace_back();
        } else {
            at = gone.back();
            gone.pop_back();
        }
        faces[at] = {{a, b, c}, {none, none, none}, exact_normal(points[a], points[b], points[c]), 0, false};
        return at;
    }

    HullFault start() {
        const std::uint32_t n = static_cast<std::uint32_t>(points.size());
        if (n < 2) return n == 0 ? HullFault::too_few_points : HullFault::one_point;
        std::uint32_t c = 2, d = 3;
        while (c < n && is_zero(exact_normal(points[0], points[1], points[c]))) ++c;
        if (c >= n) return HullFault::one_line;
        const WideVec3 normal = exact_normal(points[0], points[1], points[c]);
        d = c + 1;
        while (d < n && sign_of(exact_height(normal, points[0], points[d])) == 0) ++d;
        if (d >= n) return HullFault::one_plane;
        std::uint32_t a = 0, b = 1;
        if (sign_of(exact_height(normal, points[0], points[d])) > 0) std::swap(a, b); // d below a b c
        new_face(a, b, c);
        new_face(b, a, d);
        new_face(c, b, d);
        new_face(a, c, d);
        faces[0].across = {1, 2, 3};
        faces[1].across = {0, 3, 2};
        faces[2].across = {0, 1, 3};
        faces[3].across = {0, 2, 1};
        for (std::uint32_t corner : {a, b, c, d}) added[corner] = 1;
        newest = d;
        fan = {1, 2, 3};
        return HullFault::none;
    }

    std::uint32_t any_visible(std::uint32_t p) const {
        for (std::uint32_t f = 0; f < faces.size(); ++f)
            if (faces[f].seen_by != none && height(faces[f], p) > 0) return f;
        return none;
    }
    std::uint32_t visible_beside_last(std::uint32_t p) const {
        for (std::uint32_t f : fan)
            if (height(faces[f], p) > 0) return f;
        return none;
    }

    bool sees(std::uint32_t p, std::uint32_t f) {
        HullFace& face = faces[f];
        if (face.seen_by != p + 1) {
            face.seen_by = p + 1;
            face.visible = height(face, p) > 0;
        }
        return face.visible;
    }

    /// Removes the faces that p is above, which are connected, and adds a fan from p to their rim. Faces in p's
    /// plane stay, so no triangle of the fan is degenerate. Does nothing when p is above no face: p is then
    /// inside.
    void add(std::uint32_t p, std::uint32_t first_visible) {
        if (first_visible == none) return;
        rim.clear();
        doomed.assign(1, first_visible);
        sees(p, first_visible);
        taken.resize(faces.size(), 0);
        taken[first_visible] = 1;
        for (std::size_t i = 0; i < doomed.size(); ++i) {
            const HullFace face = faces[doomed[i]];
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t next = face.across[k];
                if (!sees(p, next)) {
                    rim.push_back({face.corner[k], face.corner[(k + 1) % 3], next});
                } else if (taken[next] == 0) {
                    taken[next] = 1;
                    doomed.push_back(next);
                }
            }
        }
        for (std::uint32_t f : doomed) {
            taken[f] = 0;
            faces[f].seen_by = none;
            gone.push_back(f);
        }
        fan.clear();
        for (const RimEdge& e : rim) {
            const std::uint32_t f = new_face(e.from, e.to, p);
            faces[f].across[0] = e.outer;
            HullFace& outer = faces[e.outer];
            for (std::size_t k = 0; k < 3; ++k)
                if (outer.corner[k] == e.to && outer.corner[(k + 1) % 3] == e.from) outer.across[k] = f;
            begins_at[e.from] = f;
            fan.push_back(f);
        }
        for (std::uint32_t f : fan) {
            const std::uint32_t next = begins_at[faces[f].corner[1]];
            faces[f].across[1] = next;
            faces[next].across[2] = f;
        }
    }

    std::span<const LengthVec3> points;
    std::vector<HullFace> faces;
    std::vector<std::uint32_t> gone, fan; ///< indices of removed faces; the faces at the point added last
    std::vector<std::uint32_t> begins_at; ///< for each point: the face of the fan whose rim edge begins there
    std::vector<std::uint8_t> added;
    std::vector<RimEdge> rim; ///< scratch of `add`
    std::vector<std::uint32_t> doomed;
    std::vector<std::uint8_t> taken; ///< for each face: it is in `doomed`
    std::uint32_t newest = 0;
};

} // namespace

WideVec3 exact_normal(LengthVec3 a, LengthVec3 b, LengthVec3 c) {
    const Difference u = difference(b, a), v = difference(c, a);
    return {Wide::product(u.y, v.z) - Wide::product(u.z, v.y),
            Wide::product(u.z, v.x) - Wide::product(u.x, v.z),
            Wide::product(u.x, v.y) - Wide::product(u.y, v.x)};
}

Wide exact_height(const WideVec3& n, LengthVec3 a, LengthVec3 p) {
    const Difference d = difference(p, a);
    return times(n.x, d.x) + times(n.y, d.y) + times(n.z, d.z);
}

namespace {

struct Shortened {
    Vec3 v; // the wide vector's leading bits: |component| < 2^60
    int dropped;
};
Shortened shortened(const WideVec3& n) {
    int length = 0;
    for (const Wide& w : {n.x, n.y, n.z}) {
        const Wide positive = w.is_negative() ? Wide::from(0) - w : w;
        const std::uint64_t high = static_cast<std::uint64_t>(positive.high_bits());
        length = std::max(length, high != 0 ? 64 + bit_length(high) : bit_length(positive.low_bits()));
    }
    const int drop = length > 60 ? length - 60 : 0;
    const auto raw = [drop](Wide w) { return Real::from_raw(narrow_rounded(w, drop)); };
    return {{raw(n.x), raw(n.y), raw(n.z)}, drop};
}

} // namespace

UnitVec3 unit_of(const WideVec3& n) { return normalized(shortened(n).v); }

Scaled length_of(const WideVec3& n) {
    const Shortened s = shortened(n);
    return {length(s.v).raw, s.dropped - 48};
}

HullFault convex_hull(std::span<const LengthVec3> points, ConvexSurface& out) {
    if (points.size() < 4) return HullFault::too_few_points;
    std::vector<LengthVec3> sorted(points.begin(), points.end());
    std::ranges::sort(sorted, before);
    sorted.erase(std::unique(sorted.begin(), sorted.end()),
                 sorted.end()); // clang 14 does not compile ranges::unique
    for (;;) {
        Growing hull(sorted);
        if (const HullFault fault = hull.grow(); fault != HullFault::none) return fault;
        // Repeats with the corners only, until no vertex is inside a face or an edge.
        std::vector<LengthVec3> corners = hull.corners();
        if (corners.size() == sorted.size()) {
            out.triangles = hull.triangles();
            out.vertices = std::move(sorted);
            return HullFault::none;
        }
        sorted = std::move(corners);
    }
}

} // namespace lockstone::shapes
