// Balls that players roll. The arena and the scenes that players can enter share them.
#pragma once

#include "scenes/scene.h"

#include <array>

namespace lockstone::scenes_detail {

inline constexpr std::uint32_t players_max = 4;
/// [ticks] between two jumps, between two pushes.
inline constexpr std::uint32_t jump_pause = 45, push_pause = 30;
inline constexpr Real ball_radius = 0.6_r, ball_mass = 80_r; ///< [m], [kg]
inline constexpr Controls ball_controls{"roll", "jump", "push"};

BodyId build_ball(Builder& build, std::uint32_t player, Vec3 position);
/// Drives a ball in the direction of the stick. A drag always acts on it.
void roll(Turn& turn, BodyId ball, ArenaInput input);
/// Makes the ball jump, whatever it lies on.
void leap(Turn& turn, BodyId ball);
/// Throws a body away from a place, the harder the nearer it is. Beyond 4 m it does nothing.
void throw_away(Turn& turn, Vec3 from, BodyId body);
/// Scripted input: holds a direction for a third of a second, and jumps and pushes now and then.
ArenaInput wander(std::uint64_t seed, std::uint64_t tick, std::uint32_t player);

/// The state of the players in the rules.
struct Players {
    std::array<BodyId, players_max> balls;
    std::array<std::uint32_t, players_max> jump_ready; ///< the first tick at which the player may jump again
    std::array<std::uint32_t, players_max> push_ready;
    friend bool operator==(const Players&, const Players&) = default;
};
template <class V> constexpr void describe(Players& p, V&& v) {
    v("balls", p.balls), v("jump_ready", p.jump_ready), v("push_ready", p.push_ready);
}

/// A scene that up to four balls may enter. Without players it has no inputs, no balls and no column for them.
class BallScene : public Scene {
  public:
    using Scene::Scene;
    std::uint32_t input_size() const override { return options.players == 0 ? 0 : input_size_of<ArenaInput>; }
    Controls controls(std::uint32_t) const override { return ball_controls; }
    /// Checks the balls of the players, and other values of `column` that rules act on.
    Status check(const World& world) const override;
    void script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                std::span<std::byte> input) const override;

  protected:
    void add_players(GameSchema& schema) const;
    /// Creates a ball at the start for every player without a body.
    void build_players(Builder& build, Players players = {}) const;
    void play(Turn& turn, std::span<const PlayerInput> inputs) const override;

    virtual Vec3 start_of(std::uint32_t player) const = 0;
    virtual Column<Players> column() const { return {0}; }
    /// True if a push throws this body.
    virtual bool is_loose(const Look&) const { return true; }
    /// True if a ball at this place returns to the start.
    virtual bool is_out(Vec3) const { return false; }
    virtual void play_one(Turn& turn, Players& players, std::uint32_t player, ArenaInput input) const;

  private:
    void push(Turn& turn, BodyId ball) const;
};

} // namespace lockstone::scenes_detail
