// A triangle surface that computes the distance of a point and whether the point is inside.
#pragma once

#include "cook/soup.h"

#include <memory>

namespace lockstone::cook {

/// The point of a triangle that is nearest to `p`. Source: Ericson, Real-Time Collision Detection, 5.1.5.
Point nearest_of_triangle(const std::array<Point, 3>& corners, Point p);

class Surface {
  public:
    /// Requires a soup that passes `check` and has at least one triangle.
    explicit Surface(const Soup& soup);
    Surface(Surface&&) noexcept;
    ~Surface();

    const Box& bounds() const { return box; }
    /// Points spread evenly over the surface.
    const std::vector<SurfacePoint>& spread() const { return points; }
    /// The distance to the nearest triangle [m].
    double distance(Point p) const;
    /// True if a ball touches a triangle, by FCL. It checks the result of `distance` independently.
    bool ball_meets(Point centre, double radius) const;
    /// True if the point is inside. Rays along the three axes count crossings, and two of three rays decide, so that a
    /// few missing triangles do no harm. If neighbouring triangles have consistent orientation, a point is inside where
    /// the winding number is not zero, so solids may overlap. Otherwise it is inside if the number of crossings is odd.
    /// Points on the surface may count as either.
    bool contains(Point p) const;
    /// Sets `height` to the greatest height of the surface at (x, z); false if the surface has none there.
    bool top(double x, double z, double& height) const;

  private:
    struct SecondOpinion; ///< FCL's own tree
    /// A node of a tree over the triangles. Children come before their parents.
    struct Node {
        Box box;
        std::uint32_t first, count; ///< a leaf if count > 0: triangles order[first .. first + count)
        std::uint32_t left, right;  ///< children of an inner node
    };
    std::uint32_t make_node(std::uint32_t first, std::uint32_t last);
    /// A square grid across one axis. Each cell lists the triangles that may cover it.
    struct Grid {
        int axis;                                    ///< the direction of the rays
        Point lower, cell;                           ///< of the other two axes
        int side;                                    ///< cells along each axis
        std::vector<std::uint32_t> first, triangles; ///< side * side + 1 offsets
    };
    static Grid make_grid(const Soup& soup, const Box& box, int axis);
    template <class Visit> void crossings(const Grid& grid, double u, double v, Visit&& visit) const;

    Soup soup;
    Box box;
    std::vector<SurfacePoint> points;
    bool is_oriented; ///< no two neighbours have opposite orientations
    std::array<Grid, 3> grids;
    std::vector<std::uint32_t> order;
    std::vector<Node> nodes;                       ///< the last node is the root
    mutable std::unique_ptr<SecondOpinion> second; ///< created at the first use
};

} // namespace lockstone::cook
