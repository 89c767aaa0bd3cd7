// A triangle surface that answers how far a point is and whether it is inside.
#pragma once

#include "cook/soup.h"

#include <memory>

namespace lockstone::cook {

/// Source: Ericson, Real-Time Collision Detection, 5.1.5.
Point nearest_of_triangle(const std::array<Point, 3>& corners, Point p);

class Surface {
  public:
    /// Needs a soup that `check` finds good, with at least one triangle.
    explicit Surface(const Soup& soup);
    Surface(Surface&&) noexcept;
    ~Surface();

    const Box& bounds() const { return box; }
    /// Points spread evenly over the surface.
    const std::vector<SurfacePoint>& spread() const { return points; }
    /// To the nearest triangle [m].
    double distance(Point p) const;
    /// Whether a ball touches a triangle, by FCL: the second opinion on `distance`.
    bool ball_meets(Point centre, double radius) const;
    /// True if the point is inside, by crossings along the three axes; two of three decide, so that a few missing triangles do no harm. Where
    /// neighbours face the same way, solids may overlap: inside is where the surface winds round the point. Elsewhere the number of crossings is
    /// odd. Points on the surface may go either way.
    bool contains(Point p) const;
    /// The greatest height of the surface above or below (x, z) of `p`; false when there is none.
    bool top(double x, double z, double& height) const;

  private:
    struct SecondOpinion; ///< FCL's own tree
    /// Of a tree over the triangles; children are made before their parents.
    struct Node {
        Box box;
        std::uint32_t first, count; ///< count > 0: triangles order[first .. first + count)
        std::uint32_t left, right;  ///< else
    };
    std::uint32_t make_node(std::uint32_t first, std::uint32_t last);
    /// Triangles by the cell of a square grid that they may cover, seen along one axis.
    struct Grid {
        int axis;                                    ///< along which rays run
        Point lower, cell;                           ///< of the other two axes
        int side;                                    ///< cells along each
        std::vector<std::uint32_t> first, triangles; ///< side * side + 1 offsets
    };
    static Grid make_grid(const Soup& soup, const Box& box, int axis);
    template <class Visit> void crossings(const Grid& grid, double u, double v, Visit&& visit) const;

    Soup soup;
    Box box;
    std::vector<SurfacePoint> points;
    bool is_oriented; ///< no two neighbours face opposite ways
    std::array<Grid, 3> grids;
    std::vector<std::uint32_t> order;
    std::vector<Node> nodes;                       ///< the last is the root
    mutable std::unique_ptr<SecondOpinion> second; ///< made when it is first asked
};

} // namespace lockstone::cook
