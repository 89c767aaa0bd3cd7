// Convex hulls in double precision by qhull, and simplified hulls with fewer corners.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

#include <span>

namespace lockstone::cook {

/// A closed convex surface. Every vertex is a corner.
struct Convex {
    struct Plane {
        Point normal;  ///< unit length, points outwards
        double offset; ///< the whole hull is at normal . x <= offset
    };
    Soup surface;
    std::vector<Plane> planes; ///< planes of the triangles that have an area
    double volume = 0;         ///< [m^3]

    /// The largest distance of the point beyond a plane of the hull; negative inside [m].
    double beyond(Point p) const;
    /// True if the point is inside and at least `depth` away from every plane [m].
    bool holds(Point p, double depth) const;
    /// The distance from a point inside to the surface, in a direction of unit length [m].
    double way_out(Point p, Point direction) const;
};

/// The hull of the points. An error if fewer than four points remain, or if all lie in one plane within qhull's
/// precision.
Result<Convex> convex_hull(std::span<const Point> points);

/// A hull of at most `corners_max` (>= 4) corners of the hull. Repeatedly adds the corner that is farthest outside. The
/// result lies inside the hull.
Result<Convex> reduced(const Convex& hull, std::uint32_t corners_max);

/// The distance to the convex body, by its nearest triangle; 0 inside [m].
double distance(const Convex& hull, Point p);
/// True if a ball touches the convex body, by libccd. It checks the result of `distance` independently.
bool ball_meets(const Convex& hull, Point centre, double radius);

} // namespace lockstone::cook
