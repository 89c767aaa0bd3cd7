// Compounds against all shapes: collides each nearby part with the other shape or its parts, then merges the
// manifolds.
#include "collide/merge_manifolds.h"
#include "collide/mesh/triangle_contact.h"
#include "collide/mesh/triangles.h"
#include "collide/pairs/pairs.h"

namespace lockstone::collide {
namespace {

/// A part's frame, in its compound's frame.
struct Place {
    Rotation rotation;
    CoordinateVec3 position;
};
Place place_of(const shapes::Compound::Part& part) {
    return {to_rotation(part.local.rotation), to<Coordinate>(part.local.position)};
}
/// The pose in A of a frame that is at `place` in B.
RelativePose part_of_b(const RelativePose& b, const Place& place) {
    return {mul<Unit>(b.rotation, place.rotation), b.position + mul<Coordinate>(b.rotation, place.position)};
}
/// The pose of B in a frame that is at `place` in A.
RelativePose seen_from_part(const RelativePose& b, const Place& place) {
    return {mul_transposed<Unit>(place.rotation, b.rotation),
            mul_transposed<Coordinate>(place.rotation, b.position - place.position)};
}
RelativePose inverse(const RelativePose& p) {
    return {transpose(p.rotation), mul_transposed<Coordinate>(p.rotation, -p.position)};
}

/// Adds the parts to the features of a manifold, and moves its points from the part's origin to B's.
void finish(Manifold& m, std::uint32_t part_a, std::uint32_t part_b, const CoordinateVec3& offset) {
    m.piece_b = part_b;
    for (std::uint32_t k = 0; k < m.count; ++k) {
        ManifoldPoint& p = m.points[k];
        p.position = to<Length>(to<Coordinate>(p.position) + offset);
        p.feature = feature_of(7, part_a, part_b, p.feature);
    }
}

void turn(Manifold& m, const Rotation& r) {
    m.normal = mul<Unit>(r, m.normal);
    for (std::uint32_t k = 0; k < m.count; ++k) m.points[k].position = mul<Length>(r, m.points[k].position);
}

class CompoundCollision {
  public:
    CompoundCollision(const shapes::Solid& first, const shapes::Solid& second, const RelativePose& relative,
                      Length reach, NarrowScratch& memory)
        : a(first), b(second), pose(relative), margin(reach), scratch(memory) {}

    void run() {
        if (a.compound == nullptr) return parts_of_b();
        scratch.parts.clear();
        a.compound->find(extent_in(b, pose, margin), scratch.parts);
        for (const std::uint32_t i : scratch.parts) {
            const Place place = place_of(a.compound->parts[i]);
            if (b.compound != nullptr)
                part_and_compound(i, place);
            else
                pair(i, place, 0, b, pose, CoordinateVec3{});
        }
    }

  private:
    /// A is a plane, height field or mesh.
    void parts_of_b() {
        const std::vector<shapes::Compound::Part>& parts = b.compound->parts;
        for (std::uint32_t j = 0; j < parts.size(); ++j) {
            RelativePose part = part_of_b(pose, place_of(parts[j]));
            const CoordinateVec3 offset = part.position - pose.position;
            const std::size_t first = scratch.pieces.size();
            if (a.geometry.kind == ShapeKind::plane) {
                part.position = {Coordinate{}, part.position.y, Coordinate{}};
                Manifold m{};
                collide_plane(parts[j].solid, part, margin, m);
                scratch.pieces.push_back(m);
            } else {
                append_triangle_pieces(a, parts[j].solid, part, margin, scratch);
            }
            for (std::size_t k = first; k < scratch.pieces.size(); ++k)
                finish(scratch.pieces[k], 0, j, offset);
        }
    }

    void part_and_compound(std::uint32_t i, const Place& place) {
        const RelativePose part_in_b = inverse(seen_from_part(pose, place));
        std::vector<std::uint32_t>& near = scratch.order;
        near.clear();
        b.compound->find(extent_in(a.compound->parts[i].solid, part_in_b, margin), near);
        for (const std::uint32_t j : near) {
            const RelativePose other = part_of_b(pose, place_of(b.compound->parts[j]));
            pair(i, place, j, b.compound->parts[j].solid, other, other.position - pose.position);
        }
    }

    /// Part i of A against a convex shape of B. `other`: the shape's pose in A; `offset`: its origin from B's
    /// origin.
    void pair(std::uint32_t i, const Place& place, std::uint32_t j, const shapes::Solid& shape,
              const RelativePose& other, const CoordinateVec3& offset) {
        Manifold m;
        const shapes::Solid& part = a.compound->parts[i].solid;
        const RelativePose seen = seen_from_part(other, place);
        if (part.geometry.kind >= shape.geometry.kind) {
            collide_pair(part, shape, seen, margin, m);
            turn(m, place.rotation);
        } else { // the routines take the greater kind first
            collide_pair(shape, part, inverse(seen), margin, m);
            m.normal = -m.normal;
            turn(m, other.rotation);
            // From the part's origin to the shape's.
            const CoordinateVec3 between = place.position - other.position;
            for (std::uint32_t k = 0; k < m.count; ++k)
                m.points[k].position = to<Length>(to<Coordinate>(m.points[k].position) + between);
        }
        if (m.count == 0) return;
        m.piece_a = i, m.surface = 0;
        finish(m, i, j, offset);
        scratch.pieces.push_back(m);
    }

    const shapes::Solid &a, &b;
    const RelativePose& pose;
    Length margin;
    NarrowScratch& scratch;
};

} // namespace

void collide_compound(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
                      NarrowScratch& scratch, Manifolds& out) {
    scratch.pieces.clear();
    CompoundCollision(a, b, pose, margin, scratch).run();
    merge_manifolds(scratch.pieces, b.geometry.kind == ShapeKind::sphere, scratch.order, out);
}

} // namespace lockstone::collide
