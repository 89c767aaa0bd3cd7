#include "lockstone/session.h"

namespace lockstone {

void WorldSimulation::save(Image& image) const { world.save(image); }
void WorldSimulation::restore(const Image& image) { world.restore(image); }
void WorldSimulation::advance(std::span<const PlayerInput> inputs) { game.advance(world, inputs); }
std::uint64_t WorldSimulation::hash() const { return world.hash(); }
std::span<const Event> WorldSimulation::events() const { return world.events(); }
State& WorldSimulation::state() { return world.state_for_tests(); }

} // namespace lockstone
