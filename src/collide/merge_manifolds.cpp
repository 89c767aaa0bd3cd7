#include "collide/merge_manifolds.h"

#include "collide/mesh/triangle_contact.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

constexpr std::int64_t parallel_60 = 1150670148478107000; // cos 3.6 degrees
// Cos 0.5 degrees: the limit documented at Manifold::on_face.
constexpr std::int64_t same_60 = 1152877604888700544;
constexpr std::int32_t noise_27 = 1 << 14;       // 0.12 mm
constexpr std::int64_t place_noise_20 = 1 << 11; // 2 mm

std::int32_t deepest_of(const Manifold& m) {
    std::int32_t least = m.points[0].separation.raw;
    for (std::uint32_t k = 1; k < m.count; ++k) least = std::min(least, m.points[k].separation.raw);
    return least;
}

/// The manifolds that are merged into one: pieces[order[0 .. count)].
struct Cluster {
    std::span<const Manifold> pieces;
    std::span<const std::uint32_t> order;
    Long3 normal_30;

    template <class Visit> void for_each_point(Visit&& visit) const {
        for (const std::uint32_t i : order)
            for (std::uint32_t k = 0; k < pieces[i].count; ++k) visit(pieces[i].points[k]);
    }
};

/// From one point to another; 20 fraction bits, below 2^28.
Long3 between_20(const ManifoldPoint& from, const ManifoldPoint& to) {
    const Long3 d = raw(to.position) - raw(from.position);
    return {d[0] >> 4, d[1] >> 4, d[2] >> 4};
}

ManifoldPoint deepest_point(const Cluster& c, bool exact) {
    std::int32_t least = std::numeric_limits<std::int32_t>::max();
    c.for_each_point([&](const ManifoldPoint& p) { least = std::min(least, p.separation.raw); });
    const std::int64_t limit = std::int64_t{least} + (exact ? 0 : noise_27);
    const ManifoldPoint* first = nullptr;
    c.for_each_point([&](const ManifoldPoint& p) {
        if (first == nullptr && p.separation.raw <= limit) first = &p;
    });
    const ManifoldPoint* best = first; // the deepest point measured at the same place
    c.for_each_point([&](const ManifoldPoint& p) {
        const Long3 d = between_20(*first, p);
        if (p.separation < best->separation && dot(d, d) <= place_noise_20 * place_noise_20) best = &p;
    });
    return *best;
}

/// Computes twice the signed area of the triangle a, b, p, seen against the normal: positive when p is to the
/// left. 40 fraction bits.
struct Side {
    Side(const Cluster& c, const ManifoldPoint& a, const ManifoldPoint& b) : from(a) {
        const Long3 line = between_20(a, b), n = c.normal_30;
        across = shifted(Long3{n[1] * line[2] - n[2] * line[1], n[2] * line[0] - n[0] * line[2],
                               n[0] * line[1] - n[1] * line[0]},
                         30);
    }
    std::int64_t area(const ManifoldPoint& p) const { return dot(across, between_20(from, p)); }

    const ManifoldPoint& from;
    Long3 across;
};

/// The point with the greatest measure above `least`, among the touching points if any exceeds it, else among
/// all. If position alone decided, a deep point would be dropped in one tick and return in the next, and
/// compounds would jitter. A measure must be greater by a sixteenth to count as greater.
template <class Measure>
const ManifoldPoint* find_most(const Cluster& c, std::int64_t least, const Measure& measure) {
    const ManifoldPoint *touching = nullptr, *any = nullptr;
    std::int64_t most_touching = least, most = least;
    c.for_each_point([&](const ManifoldPoint& p) {
        const std::int64_t x = measure(p);
        if (x > most + (most >> 4)) any = &p, most = x;
        if (p.separation <= Separation{} && x > most_touching + (most_touching >> 4))
            touching = &p, most_touching = x;
    });
    return touching != nullptr ? touching : any;
}

/// Appends the point furthest from the first, the point furthest from the line of both, and the point that adds
/// most area to the triangle of the three.
void add_spread(const Cluster& c, Manifold& out) {
    const ManifoldPoint first = out.points[0];
    const ManifoldPoint* second = find_most(c, place_noise_20 * place_noise_20, [&](const ManifoldPoint& p) {
        const Long3 d = between_20(first, p);
        return dot(d, d);
    });
    if (second == nullptr) return;
    out.points[out.count++] = *second;
    const Side base(c, first, *second);
    const std::int64_t least =
        isqrt(static_cast<std::uint64_t>(dot(base.across, base.across))) * place_noise_20;
    const ManifoldPoint* third =
        find_most(c, least, [&](const ManifoldPoint& p) { return absolute(base.area(p)); });
    if (third == nullptr) return;
    out.points[out.count++] = *third;
    // Outside is to the right when the triangle turns left.
    const std::int64_t turn = base.area(*third) > 0 ? -1 : 1;
    const Side sides[3] = {base, Side(c, *second, *third), Side(c, *third, first)};
    const ManifoldPoint* fourth = find_most(c, least, [&](const ManifoldPoint& p) {
        std::int64_t most = 0;
        for (const Side& side : sides) most = larger(most, turn * side.area(p));
        return most;
    });
    if (fourth != nullptr) out.points[out.count++] = *fourth;
}

/// Sorts by depth, the deepest first; equal ones keep their order. In place, because std::stable_sort
/// allocates.
void sort_by_depth(Manifolds& out) {
    for (std::uint32_t i = 1; i < out.count; ++i) {
        std::uint32_t place = i;
        while (place > 0 && deepest_of(out.items[i]) < deepest_of(out.items[place - 1])) --place;
        std::rotate(out.items + place, out.items + i, out.items + i + 1);
    }
}

void make_features_unique(Manifolds& out) {
    std::uint32_t used[Manifolds::max * 4];
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < out.count; ++i) {
        for (std::uint32_t k = 0; k < out.items[i].count; ++k) {
            std::uint32_t& feature = out.items[i].points[k].feature;
            for (std::uint32_t salt = 1; std::find(used, used + count, feature) != used + count; ++salt)
                feature = feature_of(5, feature, i, salt);
            used[count++] = feature;
        }
    }
}

} // namespace

void merge_manifolds(std::span<const Manifold> pieces, bool one_point, std::vector<std::uint32_t>& order,
                     Manifolds& out) {
    out.count = 0;
    if (pieces.empty()) return;
    if (pieces.size() == 1 && pieces[0].count == 1) { // the usual case of a ball on a mesh
        out.items[out.count++] = pieces[0];
        return;
    }
    order.clear();
    for (std::uint32_t i = 0; i < pieces.size(); ++i)
        if (pieces[i].count > 0) order.push_back(i);
    std::span<std::uint32_t> rest(order);
    while (!rest.empty() && out.count < Manifolds::max) {
        std::int64_t least = std::numeric_limits<std::int64_t>::max();
        for (const std::uint32_t i : rest) least = std::min<std::int64_t>(least, deepest_of(pieces[i]));
        const std::int64_t limit = least + (one_point ? 0 : noise_27);
        const auto leader =
            std::find_if(rest.begin(), rest.end(), [&](auto i) { return deepest_of(pieces[i]) <= limit; });
        const Manifold& deepest = pieces[*leader];
        const Long3 normal = raw(deepest.normal);
        Manifold& m = out.items[out.count++];
        m = Manifold{};
        m.normal = deepest.normal;
        m.on_face = deepest.on_face;
        m.piece_a = deepest.piece_a, m.piece_b = deepest.piece_b, m.surface = deepest.surface;
        // Moves the members to the front, in their order: a stable partition in place, without extra memory.
        std::size_t members = 0;
        for (std::size_t k = 0; k < rest.size(); ++k) {
            const Manifold& piece = pieces[rest[k]];
            const std::int64_t cosine_60 = dot(raw(piece.normal), normal);
            if (piece.surface != deepest.surface || cosine_60 < parallel_60) continue;
            if (cosine_60 < same_60) m.on_face = 0;
            std::rotate(rest.begin() + static_cast<std::ptrdiff_t>(members),
                        rest.begin() + static_cast<std::ptrdiff_t>(k),
                        rest.begin() + static_cast<std::ptrdiff_t>(k) + 1);
            ++members;
        }
        const Cluster cluster{pieces, rest.first(members), normal};
        m.points[m.count++] = deepest_point(cluster, one_point);
        if (!one_point) add_spread(cluster, m);
        rest = rest.subspan(members);
    }
    sort_by_depth(out);
    make_features_unique(out);
}

} // namespace lockstone::collide
