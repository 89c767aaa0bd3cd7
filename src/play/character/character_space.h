// The surroundings of one character: nearby shapes at their predicted poses at the end of the tick, with casts,
// contacts and rays against them. The cost depends on the number of nearby shapes, not on the size of the world.
#pragma once

#include "play/character/character.h"

#include <span>

namespace lockstone::sim {

/// Distance that a character keeps from shapes [m]. Contact events count it as touching.
inline constexpr Real skin = 0.004_r;
/// Tolerance of the skin [m]. Smaller deviations are not corrected, so that a standing character does not move at
/// all.
inline constexpr Real skin_slack = 0.00005_r;

/// First hit of a cast capsule or a ray.
struct SpaceHit {
    std::uint32_t neighbour; ///< index
    Real allowed;            ///< allowed motion of the capsule [m]; distance of a ray
    Vec3 point;              ///< on the neighbour's surface, world [m]
    UnitVec3 normal;         ///< of the surface, world
    std::uint32_t piece;     ///< triangle or part of the neighbour
};

/// Contact between the capsule and a neighbour.
struct SpaceContact {
    std::uint32_t neighbour;
    Real gap;            ///< [m], negative: overlap
    Vec3 point;          ///< midway between the surfaces, world [m]
    UnitVec3 normal;     ///< from the neighbour to the capsule, world
    std::uint32_t piece; ///< triangle or part of the neighbour
};

/// The surroundings of one character. `feet` is the position of the feet for which a function tests the capsule.
class CharacterSpace {
  public:
    CharacterSpace(const Model& model, PlacedShapes& placed, CharacterScratch& scratch,
                   const CharacterRow& character);

    /// Lists the shapes within `range` of the capsule that stop this character, in slot order.
    void collect(Vec3 feet, Real range);
    /// Sets the height of the capsule for all later calls.
    void set_height(Real height);
    /// Updates the neighbours of a body whose velocity has changed.
    void update_body(BodyId body);

    /// Finds the first obstacle on the way of the capsule. Returns false if there is none. Skips shapes of the body
    /// `ignored`.
    bool cast(Vec3 feet, Vec3 way, SpaceHit& hit, BodyId ignored = {}) const;
    /// Moves the feet up to the first obstacle. Returns true if there is one. `part`: fraction of the way that was
    /// moved.
    bool advance(Vec3& feet, Vec3 way, SpaceHit& hit, Real& part, BodyId ignored = {}) const;
    bool ray(Vec3 from, Vec3 way, SpaceHit& hit) const;
    /// Velocity of the conveyor at the hit, along its surface and relative to its body, world [m/s].
    Vec3 conveyor(const SpaceHit& hit) const;
    /// True if any surface of a neighbour is a conveyor.
    bool has_conveyor(const Neighbour& n) const;
    /// Calls visit(contact) for the manifolds of one neighbour within `margin`, with its pose at the end or at the
    /// start of the tick. `visit` must not call for_each_contact() itself.
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
    /// Fills scratch.manifolds. Returns false if there is no contact within `margin`.
    bool collide_with(Vec3 center, const Neighbour& n, const Transform& frame, Real margin) const;

    PlacedShapes& placed;
    CharacterScratch& scratch;
    shapes::Solid capsule;
    Coordinate capsule_reach{};
    Vec3 lift{}; ///< from the feet to the middle of the capsule
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
        // A character below a one-way surface, or half through it, has no contact with it.
        if (n.one_way && (dot<Unit>(axes.y, contact.normal) < half(unit_one) || contact.gap < -skin))
            continue;
        visit(contact);
    }
}

/// The displacement nearest to `wanted` that moves into none of the planes, given by at most 8 normals.
Vec3 clipped(Vec3 wanted, std::span<const UnitVec3> planes);
/// The component of n perpendicular to `up`, normalized; zero if only rounding is left.
UnitVec3 flat(UnitVec3 n, UnitVec3 up);

} // namespace lockstone::sim
