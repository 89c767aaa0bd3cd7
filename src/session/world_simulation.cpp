#include "lockstone/session.h"

#include "base/text.h"

namespace lockstone {

void WorldSimulation::save(Image& image) const { world.save(image); }
void WorldSimulation::restore(const Image& image) { world.restore(image); }
void WorldSimulation::advance(std::span<const PlayerInput> inputs) {
    const std::uint64_t tick = world.tick_count();
    const Status status = game.advance(world, inputs);
    if (!status && first_failure)
        first_failure = Error{base::join("tick ", tick, ": the game's rules fail: ", status.error().message)};
    if (world.tick_count() == tick) world.tick(); // the session counts it
}
std::uint64_t WorldSimulation::hash() const { return world.hash(); }
std::span<const Event> WorldSimulation::events() const { return world.events(); }
State& WorldSimulation::state() { return world.state_for_tests(); }

} // namespace lockstone
