// Finds the edge or corner of a convex core that is furthest along a direction.
#include "collide/manifold.h"

#include <algorithm>

namespace lockstone::collide {
namespace {

/// An edge counts as perpendicular to the direction when the sine of its slope is below this, 30 fraction bits.
constexpr std::int64_t sine_max_30 = std::int64_t{1} << 24; // 1/64

/// Sine of the slope from `from` down to `to`, measured against the direction; 30 fraction bits.
std::int64_t drop_sine(Long3 from, Long3 to, Long3 direction) {
    const Direction d = direction_of_30(from - to);
    return shift_right_rounded(dot(d.unit, direction), 30);
}

void add(SupportingFace& face, Long3 at, std::uint32_t id) {
    face.corners_30[face.count] = at;
    face.ids[face.count++] = id;
}

/// The furthest corner, and the neighbour whose edge has the least slope, if that is below the limit.
class BestEdge {
  public:
    BestEdge(const SupportPoint& corner, Long3 direction)
        : corner_30(corner.at_30), direction_30(direction), id(corner.id) {}
    void consider(Long3 neighbour, std::uint32_t neighbour_id) {
        if (drops_far(neighbour)) return;
        const std::int64_t sine = drop_sine(corner_30, neighbour, direction_30);
        within += sine < sine_max_30 ? 1 : 0;
        if (sine >= least) return;
        least = sine, best_30 = neighbour, best_id = neighbour_id, found = true;
    }
    // The lower id first, so that the result does not depend on which end was found first.
    void finish(SupportingFace& face) const {
        const bool swapped = found && best_id < id;
        if (swapped) add(face, best_30, best_id);
        add(face, corner_30, id);
        if (found && !swapped) add(face, best_30, best_id);
        face.flat = within > 1;
    }

  private:
    /// True when the slope is certainly above the limit, as for most neighbours. Needs no root: a length is at
    /// most the widest component plus half of the others.
    bool drops_far(Long3 neighbour) const {
        const Long3 d = shifted(corner_30 - neighbour, 6); // 24 fraction bits
        const std::int64_t wide = widest(d);
        if (wide >= std::int64_t{1} << 31) return false;
        const std::int64_t most = (wide + absolute(d[0]) + absolute(d[1]) + absolute(d[2]) + 1) >> 1;
        return dot(d, direction_30) >> 30 > (most >> 6) + 2;
    }

    Long3 corner_30, direction_30, best_30{};
    std::uint32_t id, best_id = 0;
    std::int64_t least = sine_max_30;
    int within = 0;
    bool found = false;
};

void polytope_edge(const Convex& shape, Long3 direction, std::uint32_t corner, SupportingFace& face) {
    const bool is_found = shape.core == Convex::Core::hull && corner != unknown_corner;
    const SupportPoint top =
        is_found ? SupportPoint{corner_of(shape, corner), corner} : support(shape, direction);
    BestEdge best(top, direction);
    if (shape.core == Convex::Core::box)
        for (int i = 0; i < 3; ++i) {
            const std::uint32_t id = top.id ^ (1u << i);
            const Long3 along = along_30(shape.axes_30[i], 2 * shape.half_24[i]);
            best.consider((id >> i & 1u) != 0 ? top.at_30 + along : top.at_30 - along, id);
        }
    if (shape.core == Convex::Core::triangle)
        for (std::uint32_t k = 0; k < 3; ++k)
            if (k != top.id) best.consider(up(shape.corners_24[k], 6), k);
    if (shape.core == Convex::Core::hull) {
        const shapes::Hull& hull = *shape.hull;
        for (std::uint32_t k = hull.first_neighbour[top.id]; k < hull.first_neighbour[top.id + 1]; ++k)
            best.consider(corner_of(shape, hull.neighbours[k]), hull.neighbours[k]);
    }
    best.finish(face);
}

void round_edge(const Convex& shape, Long3 direction, SupportingFace& face) {
    const SupportingFace whole = supporting_face(shape, direction);
    if (whole.count == 2 &&
        absolute(drop_sine(whole.corners_30[0], whole.corners_30[1], direction)) < sine_max_30) {
        face = whole;
        return;
    }
    const SupportPoint top = support(shape, direction);
    const bool is_top = Wide::from(0) < wide_dot(top.at_30 - up(shape.center_24, 6), shape.axes_30[1]);
    add(face, top.at_30, is_top ? 24 : 8);
    const Long3 local{shift_right_rounded(dot(shape.axes_30[0], direction), 30), 0,
                      shift_right_rounded(dot(shape.axes_30[2], direction), 30)};
    face.flat = whole.count > 2 && direction_of_30(local).length < sine_max_30;
}

} // namespace

SupportingFace supporting_edge(const Convex& shape, Long3 direction, std::uint32_t corner) {
    SupportingFace face;
    face.count = 0;
    face.normal_30 = direction;
    face.id = 0;
    face.flat = false;
    switch (shape.core) {
    case Convex::Core::point:
        add(face, up(shape.center_24, 6), 0);
        break;
    case Convex::Core::segment:
        if (absolute(dot(shape.axes_30[1], direction)) >> 30 < sine_max_30)
            return supporting_face(shape, direction);
        {
            const SupportPoint end = support(shape, direction);
            add(face, end.at_30, end.id);
        }
        break;
    case Convex::Core::cylinder:
    case Convex::Core::cone:
        round_edge(shape, direction, face);
        break;
    default:
        polytope_edge(shape, direction, corner, face);
    }
    return face;
}

} // namespace lockstone::collide
