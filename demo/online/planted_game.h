#pragma once
/// A game with a fault on purpose. In one tick it gives the players a push that is not in the rules. A machine that
/// plays it diverges from the others, and the session must report a desync.

#include "scenes/scenes.h"

#include <memory>

namespace lockstone::demo {

class PlantedGame final : public Game {
  public:
    PlantedGame(std::unique_ptr<Game> rules, std::uint64_t tick) : rules_(std::move(rules)), tick_(tick) {}
    std::string name() const override { return rules_->name(); }
    std::uint64_t content_id() const override { return rules_->content_id(); }
    std::uint32_t player_count() const override { return rules_->player_count(); }
    std::uint32_t input_size() const override { return rules_->input_size(); }
    Result<World> start() const override { return rules_->start(); }
    Status check(const World& world) const override { return rules_->check(world); }
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        for (const BodyId body : world.tick_count() == tick_ ? world.bodies() : std::vector<BodyId>{})
            if (look_of(world.user_key(body)).role == Role::player)
                if (const Status pushed = world.add_impulse(body, {0_r, world.mass(body), 0_r}); !pushed)
                    return pushed;
        return rules_->advance(world, inputs);
    }

  private:
    std::unique_ptr<Game> rules_;
    std::uint64_t tick_;
};

} // namespace lockstone::demo
