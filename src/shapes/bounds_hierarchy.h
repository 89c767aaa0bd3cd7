// A tree over boxes that never change: the triangles of a mesh or the parts of a compound. Only the number of
// boxes decides its shape: eight neighbours in the given order make one box of the next level. The result is
// correct for any order; queries are fast when the caller orders the boxes by position. For boxes that move
// there is a tree that changes leaf by leaf: collide/broad/tree.h.
#pragma once

#include "shapes/asset/asset.h"

#include <bit>

namespace lockstone::shapes {

class BoundsHierarchy {
  public:
    static constexpr std::uint32_t width = 8; ///< number of boxes in a group

    /// Builds the tree. `all` must bound every box_of(0) .. box_of(count - 1). All boxes must be within 2^14 m
    /// of the origin, and count in 1 .. 2^24.
    template <class BoxOf> BoundsHierarchy(std::uint32_t count, const Extent& all, BoxOf&& box_of) {
        start(count, all);
        for (std::uint32_t i = 0; i < count; ++i) put(groups[i / width], i % width, box_of(i));
        finish(count);
    }

    /// Calls each(index), in ascending order, for all boxes that overlap `where`, and for a few others when not
    /// `is_exact`.
    template <class Each> void visit(const Extent& where, Each&& each) const {
        const Query q = query_of(where);
        walk([&q](const Group& group) { return overlaps(group, q); }, each);
    }
    /// Calls each(index), in ascending order, for all boxes for which may_meet(box) is true, for the box and
    /// all its ancestors. The boxes passed to may_meet are a little larger when not `is_exact`.
    template <class MayMeet, class Each> void visit_if(MayMeet&& may_meet, Each&& each) const {
        const auto hits_of = [&](const Group& group) {
            std::uint32_t hits = 0;
            for (std::uint32_t k = 0; k < width; ++k)
                if (group.lower[0][k] <= group.upper[0][k] && may_meet(box_of(group, k))) hits |= 1u << k;
            return hits;
        };
        walk(hits_of, each);
    }
    bool is_exact() const { return shift == 0; }

  private:
    static constexpr std::size_t levels_max = 9;
    /// Eight boxes in steps of 2^shift from `middle`. Coordinates are rounded down, which keeps their order.
    struct alignas(32) Group {
        std::int32_t lower[3][width], upper[3][width];
    };
    struct Query {
        std::int32_t lower[3], upper[3];
    };

    /// hits_of(group) returns one bit for each box of the group to visit.
    template <class HitsOf, class Each> void walk(HitsOf&& hits_of, Each&& each) const {
        struct {
            std::uint32_t group, hits;
        } path[levels_max];
        const std::size_t top = level_start.size() - 1;
        std::size_t level = top;
        std::uint32_t group = 0;
        while (true) {
            std::uint32_t hits = hits_of(groups[level_start[level] + group]);
            if (level == 0)
                for (; hits != 0; hits &= hits - 1)
                    each(group * width + static_cast<std::uint32_t>(std::countr_zero(hits)));
            path[level] = {group, hits};
            while (path[level].hits == 0)
                if (level++ == top) return;
            auto& at = path[level--];
            group = at.group * width + static_cast<std::uint32_t>(std::countr_zero(at.hits));
            at.hits &= at.hits - 1;
        }
    }

    void start(std::uint32_t count, const Extent& all);
    void put(Group& group, std::uint32_t slot, const Extent& box) const;
    void finish(std::uint32_t count);
    std::int32_t quantised(Coordinate x, int axis) const;
    Query query_of(const Extent& where) const;
    Extent box_of(const Group& group, std::uint32_t slot) const; ///< of a slot in use

    /// Returns bit k when box k overlaps.
    [[gnu::noinline]] static std::uint32_t overlaps(const Group& g, const Query& q);

    CoordinateVec3 middle{};
    int shift = 0;
    std::vector<Group> groups;              ///< level 0 (the given boxes), then level 1, ...
    std::vector<std::uint32_t> level_start; ///< first group of each level; the last level has one group
};

} // namespace lockstone::shapes
