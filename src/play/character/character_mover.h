// One character through one tick; see character.cpp for the steps.
#pragma once

#include "play/character/character_space.h"

namespace lockstone::sim {

class Mover {
  public:
    Mover(Model& model, PlacedShapes& placed, CharacterScratch& scratch, std::uint32_t character_row);
    void run();

  private:
    // character.cpp: the order of the steps, and where a character is in the end
    void ride();
    void slide(Vec3 way, BodyId ignored);
    void unstick();
    bool part_from_neighbours(Vec3& correction);
    void change_posture();
    void start_jump();
    void finish();
    // character_push.cpp: what it does to dynamic bodies, and they to it
    void shove(Vec3& away);
    void take_impact(const SpaceContact& contact);
    void note_push(const SpaceHit& hit);
    void apply_pushes();
    void weigh();
    void push_at(BodyId body, Vec3 point, Vec3 force);
    // character_walk.cpp: its own motion
    void walk();
    bool try_step(Vec3 way, Real& gone);
    void settle();
    void fall();
    void rise(Real height);
    void glide(Vec3 way);
    void drop(Real height);
    bool stands_on(SpaceHit& hit, Vec3 landed) const;
    bool face_is_walkable(const SpaceHit& hit) const;
    void land(const SpaceHit& hit);
    void leave_ground();
    void report_landing(const SpaceHit& hit, Vec3 ground_velocity);

    Real along(Vec3 v) const { return dot<Real>(up, v); }
    Vec3 level(Vec3 v) const { return v - scale<Real>(up, along(v)); }
    bool is_walkable(UnitVec3 n) const { return dot<Unit>(n, up) >= slope_cos; }
    Vec3 per_tick(Vec3 v) const;
    /// v, changed towards `wanted` by at most `rate_of_change` for a tick.
    Vec3 approached(Vec3 v, Vec3 wanted, Real rate_of_change) const;
    Vec3 velocity_of(BodyId body, Vec3 point) const; ///< [m/s], of a living body
    Vec3 belt_below() const;    ///< velocity of the conveyor that it stands on, besides its body's [m/s]
    BodyId ground_body() const; ///< null when it stands on none, or that is gone
    bool is_dynamic(BodyId body) const;

    Model& w;
    PlacedShapes& placed;
    CharacterScratch& scratch;
    CharacterRow row; ///< written back at the end
    std::uint32_t index;
    UnitVec3 up;
    Unit slope_cos;
    std::uint32_t rate;
    CharacterSpace space;
    Vec3 begin, feet;   ///< where the feet were, and are by now
    BodyId stood_on;    ///< when the tick began
    bool was_in_air;    ///< then
    Vec3 carried{};     ///< by the ground in this tick [m]
    Vec3 belt_ridden{}; ///< belt_below() when the tick began, or of what it has come onto since
    Vec3 ground_point{};
    Real spin{};             ///< of the ground about `up` [rad/s]
    bool is_kept_up = false; ///< it is wedged in between walls, and may jump as if it stood
};

} // namespace lockstone::sim
