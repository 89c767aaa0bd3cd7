// What a character's mover sees: the shapes around it, each where it will be at the end of the tick, and casts,
// contacts and rays among them. The cost depends on how many shapes are near, not on the size of the world.
#pragma once

#include "play/character/character.h"

#include <span>

namespace lockstone::sim {

/// A character keeps this far from what it does not overlap [m]; contact events see it as touching.
inline constexpr Real skin = 0.004_r;
/// A gap that differs from the skin by less than this is left as it is, so a character that stands does not move at all [m].
inline constexpr Real skin_slack = 0.00005_r;

/// What stops a capsule or a ray.
struct SpaceHit {
    std::uint32_t neighbour; ///< index
    Real allowed;            ///< a capsule may go this far [m]; a ray's distance
    Vec3 point;              ///< on the neighbour's surface, world [m]
    UnitVec3 normal;         ///< of the surface, world
    std::uint32_t piece;     ///< triangle or part of the neighbour
};

/// Where the capsule is near or in a neighbour.
struct SpaceContact {
    std::uint32_t neighbour;
    Real gap;            ///< [m], negative: overlap
    Vec3 point;          ///< midway between the surfaces, world [m]
    UnitVec3 normal;     ///< from the neighbour to the capsule, world
    std::uint32_t piece; ///< triangle or part of the neighbour
};

/// One character's surroundings. `feet` are where the capsule is asked about.
class CharacterSpace {
  public:
    CharacterSpace(const Model& model, PlacedShapes& placed, CharacterScratch& scratch,
                   const CharacterRow& character);

    /// The shapes within `range` of the feet's capsule that stop this character, in slot order.
    void collect(Vec3 feet, Real range);
    /// The capsule from now on.
    void set_height(Real height);
    /// Brings neighbours up to date whose body's velocity was changed.
    void update_body(BodyId body);

    /// The first thing in the way of the capsule, or nothing. Shapes of the body `ignored` do not count.
    bool cast(Vec3 feet, Vec3 way, SpaceHit& hit, BodyId ignored = {}) const;
    /// Moves the feet as far as they may go; true when something is in the way. `part` is how much of the way was gone.
    bool advance(Vec3& feet, Vec3 way, SpaceHit& hit, Real& part, BodyId ignored = {}) const;
    bool ray(Vec3 from, Vec3 way, SpaceHit& hit) const;
    /// How fast the conveyor that was hit goes along its surface, besides its body's motion, world [m/s].
    Vec3 conveyor(const SpaceHit& hit) const;
    /// True if any surface of a neighbour is a conveyor.
    bool has_conveyor(const Neighbour& n) const;
    /// visit(contact) for the manifolds of one neighbour within `margin`, where it is at the end or the begin of the
    /// tick. `visit` must not ask for contacts itself.
    template <class Visit>
    void for_each_contact(Vec3 feet, std::uint32_t neighbour, Real margin, bool at_end, Visit&& visit) const;
    template <class Visit> void for_each_contact(Vec3 feet, Real margin, Visit&& visit) const {
        for (std::uint32_t i = 0; i < scratch.neighbours.size(); ++i)
            for_each_contact(feet, i, margin, true, visit);
    }

    const Neighbour& neighbour(std::uint32_t index) const { return scratch.neighbours[index]; }
    std::span<const Neighbour> neighbours() const { return scratch.neighbours; }

    const Model& w;
    const CharacterRow& row;
    UnitVec3 up;
    Quat rotation; ///< of the capsule

  private:
    bool sees(const ShapeRow& own, const ShapeRow& other) const;
    void place(Neighbour& n, const ShapeRow& shape) const;
    Vec3 center_of(Vec3 feet) const { return feet + lift; }
    bool is_far(const Neighbour& n, const Transform& frame, Vec3 center, Real range) const;
    bool cast_one(Vec3 center, Vec3 way, UnitVec3 direction, Real length, std::uint32_t index,
                  SpaceHit& hit) const;
    bool hit_at_start(Vec3 center, UnitVec3 direction, std::uint32_t index, SpaceHit& hit) const;
    /// False when they are too far apart to touch.
    bool collide_with(Vec3 center, const Neighbour& n, const Transform& frame, Real margin) const;

    PlacedShapes& placed;
    CharacterScratch& scratch;
    shapes::Solid capsule;
    Coordinate capsule_reach{};
    Vec3 lift{}; ///< from the feet to the capsule's middle
};

template <class Visit>
void CharacterSpace::for_each_contact(Vec3 feet, std::uint32_t index, Real margin, bool at_end,
                                      Visit&& visit) const {
    const Neighbour& n = scratch.neighbours[index];
    const Transform& frame = at_end ? n.end : n.begin;
    const Vec3 center = center_of(feet);
    if (!collide_with(center, n, frame, margin)) return;
    const collide::Manifolds& found = scratch.manifolds;
    const Rotation axes = to_rotation(frame.rotation);
    for (std::uint32_t i = 0; i < found.count; ++i) {
        const collide::Manifold& m = found.items[i];
        std::uint32_t deepest = 0;
        for (std::uint32_t k = 1; k < m.count; ++k)
            if (m.points[k].separation < m.points[deepest].separation) deepest = k;
        if (m.count == 0) continue;
        const SpaceContact contact{index, to<Real>(m.points[deepest].separation),
                                   center + lockstone::mul<Real>(axes, m.points[deepest].position),
                                   lockstone::mul<Unit>(axes, m.normal), m.piece_a};
        // A character below a one-way surface, or half through it, does not see it.
        if (n.one_way && (dot<Unit>(axes.y, contact.normal) < half(unit_one) || contact.gap < -skin))
            continue;
        visit(contact);
    }
}

/// The displacement nearest to `wanted` that goes into none of the planes, which are given by at most 8 normals.
Vec3 clipped(Vec3 wanted, std::span<const UnitVec3> planes);
/// n without its part along `up`, of unit length; zero when nothing is left.
UnitVec3 flat(UnitVec3 n, UnitVec3 up);

} // namespace lockstone::sim
