// Moves one character through one tick; see character.cpp for the steps.
#pragma once

#include "play/character/character_space.h"

namespace lockstone::sim {

class Mover {
  public:
    Mover(Model& model, PlacedShapes& placed, CharacterScratch& scratch, std::uint32_t character_row);
    void run();

  private:
    // character.cpp: the order of the steps, and the final position
    void ride();
    void slide(Vec3 way, BodyId ignored);
    void unstick();
    bool part_from_neighbours(Vec3& correction);
    void change_posture();
    void start_jump();
    void finish();
    // character_push.cpp: forces between the character and dynamic bodies
    void shove(Vec3& away);
    void take_impact(const SpaceContact& contact);
    void note_push(const SpaceHit& hit);
    void apply_pushes();
    void weigh();
    void push_at(BodyId body, Vec3 point, Vec3 force);
    // character_walk.cpp: the character's own motion
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
    /// v, moved towards `wanted` by at most `rate_of_change` times the length of a tick.
    Vec3 approached(Vec3 v, Vec3 wanted, Real rate_of_change) const;
    Vec3 velocity_of(BodyId body, Vec3 point) const; ///< [m/s], of a body that exists
    Vec3 belt_below() const;    ///< velocity of the conveyor under it, relative to the conveyor's body [m/s]
    BodyId ground_body() const; ///< null if it stands on no body, or if the body was destroyed
    bool is_dynamic(BodyId body) const;

    Model& w;
    PlacedShapes& placed;
    CharacterScratch& scratch;
    CharacterRow row; ///< written back in finish()
    std::uint32_t index;
    UnitVec3 up;
    Unit slope_cos;
    std::uint32_t rate;
    CharacterSpace space;
    Vec3 begin, feet;   ///< position of the feet when the tick began, and now
    BodyId stood_on;    ///< ground body when the tick began
    bool was_in_air;    ///< when the tick began
    Vec3 carried{};     ///< motion by the ground in this tick [m]
    Vec3 belt_ridden{}; ///< belt_below() when the tick began, or of ground that it has reached since
    Vec3 ground_point{};
    Real spin{};             ///< angular velocity of the ground about `up` [rad/s]
    bool is_kept_up = false; ///< wedged between walls; may jump as if it stood
};

} // namespace lockstone::sim
