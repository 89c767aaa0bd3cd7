#include "lockstone/session.h"

#include "base/assert.h"

namespace lockstone {

World& WorldSimulation::living() const {
    LOCKSTONE_ASSERT(!lifetime.expired(), "the world was destroyed before what drives it");
    return world;
}

void WorldSimulation::save(Image& image) const { living().save(image); }
void WorldSimulation::restore(const Image& image) { living().restore(image); }
void WorldSimulation::advance(std::span<const PlayerInput> inputs) { game.advance(living(), inputs); }
std::uint64_t WorldSimulation::hash() const { return living().hash(); }
std::span<const Event> WorldSimulation::events() const { return living().events(); }
State& WorldSimulation::state() { return living().state_for_tests(); }

} // namespace lockstone
