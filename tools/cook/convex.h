// Convex hulls in double precision, by qhull; and hulls of fewer corners with little deviation.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

#include <span>

namespace lockstone::cook {

/// A closed convex surface. Every vertex is a corner.
struct Convex {
    struct Plane {
        Point normal;  ///< of length 1, outward
        double offset; ///< all of the hull is at normal . x <= offset
    };
    Soup surface;
    std::vector<Plane> planes; ///< those of triangles with area
    double volume = 0;         ///< [m^3]

    /// How far the point is beyond the plane that it is farthest beyond; negative inside [m].
    double beyond(Point p) const;
    /// True if the point is inside, and at least so far from every plane.
    bool holds(Point p, double depth) const;
    /// How far it is from a point inside along a direction of length 1 to where the hull ends [m].
    double way_out(Point p, Point direction) const;
};

/// Error when fewer than four points remain, or all lie in one plane to within qhull's precision.
Result<Convex> convex_hull(std::span<const Point> points);

/// A hull of at most `corners_max` (>= 4) of the hull's corners: again and again the corner that is farthest outside
/// is added to what is there. The result lies inside the hull.
Result<Convex> reduced(const Convex& hull, std::uint32_t corners_max);

/// Distance to the convex body, by its nearest triangle; 0 inside [m].
double distance(const Convex& hull, Point p);
/// Whether a ball touches the convex body, by libccd: the second opinion on `distance`.
bool ball_meets(const Convex& hull, Point centre, double radius);

} // namespace lockstone::cook
