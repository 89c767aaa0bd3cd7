// Penetration depth: the expanding polytope, with exact planes.
//
// The polytope is the hull of some vertices of the difference A - B and contains the origin. Each step expands
// its face nearest to the origin to the difference's furthest vertex along the face's normal, until no vertex
// is beyond the face. The sign of an integer decides whether a vertex is beyond a face. So the polytope is
// convex at every step, a horizon is one closed loop, and no face is ever degenerate: each edge of the horizon
// belongs to a face that the vertex is strictly beyond. Only the order of the faces, by distance, is subject to
// rounding.
//
// source: van den Bergen, Proximity Queries and Penetration Depth Computation on 3D Game Objects, GDC 2001.
#include "collide/core.h"
#include "collide/pairs/point.h"

#include <limits>
#include <utility>

namespace lockstone::collide {
namespace {

constexpr int vertices_max = 128;
constexpr int faces_max = 2 * vertices_max;
constexpr std::int64_t clearance_24 = 1 << 8; ///< 15 um

struct Face {
    std::uint8_t corner[3]; ///< counter-clockwise from outside
    std::uint8_t beside[3]; ///< the face across the edge from corner k to corner k + 1
    bool alive;
    Long3 normal;          ///< exact
    Long3 direction;       ///< `normal` reduced to 31 bits
    std::int64_t length;   ///< of `direction`
    std::int64_t distance; ///< of the plane from the origin, `fraction` bits of a step
    static constexpr int fraction = 16;
};

class Polytope {
  public:
    /// Starts from a tetrahedron, which must not be flat.
    explicit Polytope(const Vertex (&v)[4]);

    const Face& face(int f) const { return faces[f]; }
    const Vertex& vertex(int v) const { return vertices[v]; }
    int nearest() const;
    /// True when w is beyond the plane of a face.
    bool is_beyond(const Face& f, const Long3& w) const {
        return Wide::from(0) < wide_dot(f.normal, w - vertices[f.corner[0]].w);
    }
    template <class Visit> void for_each_face(Visit&& visit) const {
        for (int f = 0; f < face_count; ++f)
            if (faces[f].alive) visit(faces[f]);
    }
    /// Adds a vertex beyond `face`. Returns false when the polytope is full.
    bool add(const Vertex& v, int face);

  private:
    struct HorizonEdge {
        std::uint8_t from, to; ///< in the order of the removed face
        std::uint8_t outer;    ///< the remaining face across the edge
        std::uint8_t side;     ///< the number of the edge in that face
    };
    void find_horizon(const Long3& w, int face);
    void set_plane(Face& f);
    int make_face(std::uint8_t a, std::uint8_t b, std::uint8_t c);

    Vertex vertices[vertices_max];
    Face faces[faces_max];
    std::uint8_t free_faces[faces_max];
    HorizonEdge horizon[faces_max];
    std::uint8_t stack[faces_max];
    int vertex_count = 0, face_count = 0, free_count = 0, horizon_count = 0;
};

void Polytope::set_plane(Face& f) {
    const Long3 &a = vertices[f.corner[0]].w, &b = vertices[f.corner[1]].w, &c = vertices[f.corner[2]].w;
    f.normal = cross(b - a, c - a);
    f.direction = with_bits(f.normal, 31);
    const auto square = [](std::int64_t x) { return static_cast<std::uint64_t>(x * x); };
    f.length = isqrt(square(f.direction[0]) + square(f.direction[1]) + square(f.direction[2]));
    f.distance = divide_shifted(dot(f.direction, a), f.length, Face::fraction); // 3 * 2^31 * 2^29 fit
}

int Polytope::make_face(std::uint8_t a, std::uint8_t b, std::uint8_t c) {
    const int f = free_count > 0 ? free_faces[--free_count] : face_count++;
    faces[f].corner[0] = a, faces[f].corner[1] = b, faces[f].corner[2] = c;
    faces[f].alive = true;
    set_plane(faces[f]);
    return f;
}

Polytope::Polytope(const Vertex (&v)[4]) {
    for (const Vertex& x : v) vertices[vertex_count++] = x;
    const Long3 &a = v[0].w, &b = v[1].w, &c = v[2].w, &d = v[3].w;
    if (!wide_dot(cross(b - a, c - a), d - a).is_negative()) std::swap(vertices[1], vertices[2]);
    // Now face 0 1 2 is turned away from vertex 3. Faces 1..3 share its edges.
    constexpr std::uint8_t corners[4][3] = {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}};
    constexpr std::uint8_t beside[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    for (int f = 0; f < 4; ++f) {
        make_face(corners[f][0], corners[f][1], corners[f][2]);
        for (int k = 0; k < 3; ++k) faces[f].beside[k] = beside[f][k];
    }
}

/// The face nearest to the origin; of several the one with the lowest number.
int Polytope::nearest() const {
    int best = -1;
    for (int f = 0; f < face_count; ++f)
        if (faces[f].alive && (best < 0 || faces[f].distance < faces[best].distance)) best = f;
    return best;
}

/// Removes the faces that w is beyond, and collects the edges around them.
void Polytope::find_horizon(const Long3& w, int first) {
    int open = 0;
    horizon_count = 0;
    stack[open++] = static_cast<std::uint8_t>(first);
    faces[first].alive = false;
    while (open > 0) {
        const int f = stack[--open];
        free_faces[free_count++] = static_cast<std::uint8_t>(f);
        for (int k = 0; k < 3; ++k) {
            const std::uint8_t g = faces[f].beside[k];
            if (!faces[g].alive) continue;
            if (is_beyond(faces[g], w)) {
                faces[g].alive = false;
                stack[open++] = g;
                continue;
            }
            int side = 0;
            while (faces[g].corner[side] != faces[f].corner[(k + 1) % 3]) ++side;
            horizon[horizon_count++] = {faces[f].corner[k], faces[f].corner[(k + 1) % 3], g,
                                        static_cast<std::uint8_t>(side)};
        }
    }
}

bool Polytope::add(const Vertex& v, int face) {
    // There is always room for the faces: a closed surface of n vertices has 2 n - 4 triangles, and find_horizon
    // frees faces before the new ones are made.
    if (vertex_count == vertices_max) return false;
    const std::uint8_t name = static_cast<std::uint8_t>(vertex_count);
    vertices[vertex_count++] = v;
    find_horizon(v.w, face);
    std::uint8_t starts_at[vertices_max];
    for (int i = 0; i < horizon_count; ++i) {
        const HorizonEdge& e = horizon[i];
        const auto f = static_cast<std::uint8_t>(make_face(e.from, e.to, name));
        faces[f].beside[0] = e.outer;
        faces[e.outer].beside[e.side] = f;
        starts_at[e.from] = f;
    }
    for (int i = 0; i < horizon_count; ++i) {
        const std::uint8_t f = starts_at[horizon[i].from], next = starts_at[horizon[i].to];
        faces[f].beside[1] = next;
        faces[next].beside[2] = f;
    }
    return true;
}

/// Adds vertices to a simplex that contains the origin until it is a tetrahedron that is not flat. Returns
/// false when the whole difference is flat: `normal` is then perpendicular to it.
class Grower {
  public:
    Grower(Difference& d, Simplex& simplex) : difference(d), s(simplex) {}

    bool grow(Long3& normal) {
        constexpr std::int64_t one = std::int64_t{1} << 30;
        normal = {0, one, 0};
        if (s.count == 1 && !try_both({one, 0, 0}) && !try_both({0, one, 0}) && !try_both({0, 0, one}))
            return false;
        if (s.count == 2) {
            const Long3 e = with_bits(s.v[1].w - s.v[0].w, 30);
            int least = 0;
            for (int i = 1; i < 3; ++i)
                if (absolute(e[i]) < absolute(e[least])) least = i;
            Long3 axis{};
            axis[least] = 1;
            normal = with_bits(cross(e, axis), 30);
            if (!try_both(normal) && !try_both(with_bits(cross(e, normal), 30))) return false;
        }
        if (s.count == 3) {
            normal = with_bits(cross(s.v[1].w - s.v[0].w, s.v[2].w - s.v[0].w), 30);
            return try_both(normal);
        }
        return true;
    }

  private:
    bool try_both(Long3 direction) { return try_one(direction) || try_one(-direction); }
    bool try_one(Long3 direction) {
        const Vertex v = difference.support(direction);
        if (!is_independent(v.w)) return false;
        s.v[s.count++] = v;
        return true;
    }
    bool is_independent(Long3 w) const {
        const Long3 u = w - s.v[0].w;
        if (s.count == 1) return !is_zero(u);
        const Long3 e = s.v[1].w - s.v[0].w;
        if (s.count == 2) return !is_zero(cross(e, u));
        return sign_of(wide_dot(cross(e, s.v[2].w - s.v[0].w), u)) != 0;
    }

    Difference& difference;
    Simplex& s;
};

/// The normal of a face, computed from its unscaled vertices.
Long3 exact_normal(const Polytope& polytope, const Face& face) {
    const auto corner = [&](int k) {
        const Vertex& v = polytope.vertex(face.corner[k]);
        return v.a_30 - v.b_30;
    };
    const Long3 exact = cross_with_bits(corner(1) - corner(0), corner(2) - corner(0), 31);
    return direction_of_30(is_zero(exact) ? face.direction : exact)
        .unit; // zero: the face is thinner than a step of the difference
}

/// The points whose difference is the face's point nearest to the origin. Unknown when that point is in another
/// triangle of the same plane.
Touch touch_of(const Polytope& polytope, const Face& face) {
    Simplex s;
    s.count = 3;
    for (int k = 0; k < 3; ++k) s.v[k] = polytope.vertex(face.corner[k]);
    for (int k = 0; k < 3; ++k)
        if (wide_dot(face.normal, cross(s.v[k].w, s.v[(k + 1) % 3].w)).is_negative()) return {};
    Gap gap;
    set_points(s, gap);
    return {true, gap.on_a_30, gap.on_b_30};
}

bool has_axis(const Convex& x) {
    return x.core == Convex::Core::segment || x.core == Convex::Core::cylinder ||
           x.core == Convex::Core::cone;
}

/// The shortest move found so far that separates the two cores.
class LeastMove {
  public:
    explicit LeastMove(Difference& d) : difference(d) {}

    std::int64_t least_30() const { return move.depth_30; }
    /// Tests a unit direction with the vertex furthest along it. Returns true when it is the best so far.
    bool consider(Long3 unit, const Vertex& v) {
        const std::int64_t m = dot_unit(v.a_30 - v.b_30, unit);
        if (m >= move.depth_30 || is_zero(unit)) return false;
        move = {unit, m};
        found.is_known = false;
        return true;
    }
    bool consider(Long3 direction) {
        const Long3 unit = direction_of_30(direction).unit;
        return consider(unit, difference.support(unit));
    }
    /// Tests the directions that are exact for round cores side by side, around one axis, or across each other.
    void guess();
    /// Turns the direction around the axis of a segment, cylinder or cone, through the normals of its side.
    void turn(const Convex& round, bool is_a);
    /// Moves b until it is clear of a, and takes the direction between the closest points, until that direction
    /// is stable. For shallow overlaps each round leaves depth / (radius of curvature) of the error. Returns
    /// true when it converged.
    bool settle();
    /// Tests the normals of the supporting faces of both cores along the direction.
    void try_faces() {
        const Long3 n = move.normal_30;
        const SupportingFace a = supporting_face(difference.a.convex(), n),
                             b = supporting_face(difference.b.convex(), -n);
        if (a.flat) consider(a.normal_30);
        if (b.flat) consider(-b.normal_30);
    }
    Penetration result() const { return {move.normal_30, larger(0, move.depth_30)}; }
    const Touch& touch() const { return found; }

  private:
    void consider_both(Long3 direction) { consider(direction), consider(-direction); }

    Difference& difference;
    Penetration move{{}, std::numeric_limits<std::int64_t>::max()};
    Touch found;
};

void LeastMove::guess() {
    const Convex &a = difference.a.convex(), &b = difference.b.convex();
    if (has_axis(a)) consider_both(a.axes_30[1]);
    if (has_axis(b)) consider_both(b.axes_30[1]);
    if (!has_axis(a) || !has_axis(b)) return;
    const Long3 u = a.axes_30[1], v = b.axes_30[1], d = up(b.center_24 - a.center_24, 6);
    const auto across = [&](Long3 axis) {
        const std::int64_t along_axis = dot_unit(d, axis);
        const auto part = [&](int i) {
            return d[i] - narrow_rounded(Wide::product(axis[i], along_axis), 30);
        };
        return Long3{part(0), part(1), part(2)};
    };
    consider_both(shifted(cross(u, v), 30));
    consider_both(across(u));
    consider_both(across(v));
    consider_both(a.axes_30[0]);
}

bool LeastMove::settle() {
    // 1/32 of the least radius or half height: each round leaves at most a thousandth of its gain.
    std::int64_t shallow_30 = std::numeric_limits<std::int64_t>::max();
    for (const Core* core : {&difference.a, &difference.b})
        if (core->is_smooth())
            shallow_30 =
                smaller(shallow_30, 2 * smaller(core->convex().half_24[0], core->convex().half_24[1]));
    for (int round = 0; round < 6; ++round) {
        const std::int64_t before = move.depth_30;
        const Convex& b = difference.b.convex();
        const Convex clear = moved_along(b, move.normal_30, (before >> 6) + (before >> 9) + clearance_24);
        Difference parted(difference.a.convex(), clear);
        Simplex simplex;
        const Gap gap = find_gap(parted, -1, -move.normal_30, simplex);
        if (gap.overlap) return false;
        consider(gap.normal_30);
        const std::int64_t gained = before - move.depth_30;
        if (gained > larger(2, before >> (before < shallow_30 ? 9 : 14))) continue;
        if (gained <= larger(2, before >> 20)) // else the points belong to another direction
            found = {true, gap.on_a_30, gap.on_b_30 - up(clear.center_24 - b.center_24, 6)};
        return true;
    }
    return false;
}

/// The normals of the side of a round core, by position on the circle: cosine and sine, 30 fraction bits.
class SideNormals {
  public:
    SideNormals(const Convex& round, bool is_a)
        : shape(round), sign(is_a ? 1 : -1),
          slope(direction_of_30(round.core == Convex::Core::cone
                                    ? Long3{2 * round.half_24[1], round.half_24[0], 0}
                                    : Long3{1, 0, 0})
                    .unit) {}
    Long3 at(Long3 place) const {
        const Long3 x = shifted(place * slope[0], 30);
        const auto part = [&](int i) {
            return sign * shift_right_rounded(shape.axes_30[0][i] * x[0] + shape.axes_30[1][i] * slope[1] +
                                                  shape.axes_30[2][i] * x[2],
                                              30);
        };
        return {part(0), part(1), part(2)};
    }
    /// The position of the normal nearest to a direction.
    Long3 place_of(Long3 direction) const {
        const auto local = [&](int i) {
            return sign * shift_right_rounded(dot(shape.axes_30[i], direction), 30);
        };
        const Long3 place = direction_of_30({local(0), 0, local(2)}).unit;
        return is_zero(place) ? Long3{std::int64_t{1} << 30, 0, 0} : place;
    }
    static Long3 turned(Long3 place, std::int64_t by_30) {
        return direction_of_30(up(place, 30) + Long3{place[2], 0, -place[0]} * by_30).unit;
    }

  private:
    const Convex& shape;
    std::int64_t sign;
    Long3 slope; ///< components of the normal across and along the axis
};

void LeastMove::turn(const Convex& round, bool is_a) {
    const SideNormals normals(round, is_a);
    constexpr std::int64_t coarse = 105'811'000; // tan of a 64th of a turn
    Long3 place = normals.place_of(move.normal_30);
    for (int k = 0; k < 64; ++k) {
        place = SideNormals::turned(place, coarse);
        consider(normals.at(place));
    }
    place = normals.place_of(move.normal_30);
    for (std::int64_t step = coarse; step > 1 << 9;) { // to 2^-21 rad
        const Long3 left = SideNormals::turned(place, step), right = SideNormals::turned(place, -step);
        if (consider(normals.at(left)))
            place = left;
        else if (consider(normals.at(right)))
            place = right;
        else
            step >>= 1;
    }
}

/// Expands the polytope until no vertex is beyond the nearest face. If it becomes full (round hulls with many
/// corners around one centre), the best of all face normals is the result; it may be a percent too deep. When a
/// step of the difference is more than 1.5e-8 m, thin faces may be inclined, so the faces of the cores are
/// tested too.
Penetration expand(Difference& difference, Polytope& polytope, Touch& touch) {
    while (true) {
        const int f = polytope.nearest();
        const Face& face = polytope.face(f);
        const Vertex v = difference.support(with_bits(face.direction, 30));
        const bool is_last = !polytope.is_beyond(face, v.w);
        if (!is_last && polytope.add(v, f)) continue;
        LeastMove best(difference);
        best.consider(exact_normal(polytope, face));
        if (!is_last) polytope.for_each_face([&](const Face& other) { best.consider(other.direction); });
        if (difference.shift() > 4) {
            best.consider(face.direction);
            best.try_faces();
        }
        if (is_last && difference.shift() <= 4) touch = touch_of(polytope, face);
        return best.result();
    }
}

/// Smooth cores have no last vertex. Each face's normal, with the vertex found along it, gives an upper bound
/// of the least move; the distance of the nearest face is a lower bound. Once the two are within 1/16, settle()
/// refines the move to a local minimum, and the expansion goes on until the bounds differ by at most 2^-12, or
/// 2^-24 when settle() does not converge. When the polytope becomes full, all directions of a circle are nearly
/// equal, and turn() searches the circle.
Penetration expand_smooth(Difference& difference, Polytope& polytope, Touch& touch) {
    LeastMove best(difference);
    best.guess();
    const int shift = difference.shift();
    int bits = 4; // how near the two bounds must be: 2^-bits of the depth
    while (true) {
        const int f = polytope.nearest();
        const Face& face = polytope.face(f);
        const Vertex v = difference.support(with_bits(face.direction, 30));
        best.consider(direction_of_30(face.direction).unit, v);
        const std::int64_t bound = up(face.distance >> 8, shift) >> (Face::fraction - 8);
        const auto is_near = [&] {
            return best.least_30() - bound <= larger(std::int64_t{8} << shift, best.least_30() >> bits);
        };
        if (bits == 4 && is_near()) bits = best.settle() ? 12 : 24;
        if (is_near() || !polytope.is_beyond(face, v.w)) break;
        if (polytope.add(v, f)) continue;
        for (const bool is_a : {true, false})
            if (const Convex& c = (is_a ? difference.a : difference.b).convex(); has_axis(c))
                best.turn(c, is_a);
        break;
    }
    best.try_faces();
    touch = best.touch();
    return best.result();
}

} // namespace

Penetration find_move(Difference& difference, Simplex& simplex, Touch& touch) {
    const Convex &a = difference.a.convex(), &b = difference.b.convex();
    if (has_point_form(a, b)) {
        const PointForm f = point_form(a, b);
        touch = {true, f.on_a_30, f.on_b_30};
        return {f.normal_30, larger(0, -f.distance_30)};
    }
    Long3 normal{};
    if (simplex.count < 4 && !Grower(difference, simplex).grow(normal)) {
        const Long3 unit = direction_of_30(normal).unit;
        return {dot(unit, with_bits(difference.between(), 30)) > 0 ? -unit : unit, 0};
    }
    Polytope polytope(simplex.v);
    return difference.is_smooth() ? expand_smooth(difference, polytope, touch)
                                  : expand(difference, polytope, touch);
}

Penetration penetration(const Convex& a, const Convex& b) {
    Difference difference(a, b);
    Simplex simplex;
    Touch touch;
    const Gap gap = find_gap(difference, -1, difference.between(), simplex);
    if (!gap.overlap) return {gap.normal_30, 0};
    return find_move(difference, simplex, touch);
}

} // namespace lockstone::collide
