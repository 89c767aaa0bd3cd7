// WorldSimulation: a World with a Game as the simulation of a runner.
#include "lockstone/session.h"

#include "lockstone/testing.h"

#include "base/assert.h"
#include "base/text.h"

namespace lockstone {

World& WorldSimulation::living() const {
    LOCKSTONE_ASSERT(!lifetime.expired(), "the world was destroyed before what drives it");
    return world;
}

void WorldSimulation::save(Image& image) const { living().save(image); }
void WorldSimulation::restore(const Image& image) { living().restore(image); }
void WorldSimulation::advance(std::span<const PlayerInput> inputs) {
    World& driven = living();
    const std::uint64_t tick = driven.tick_count();
    const Status status = game.advance(driven, inputs);
    if (!status && first_failure)
        first_failure = Error{base::join("tick ", tick, ": the game's rules fail: ", status.error().message)};
    // Each call must run one tick, even after an error of the game.
    if (driven.tick_count() == tick) driven.tick();
}
/// Without `tick_count` the state may be of any tick.
Status WorldSimulation::adopt_if(std::span<const std::byte> portable_image,
                                 std::optional<std::uint64_t> tick_count) {
    World& driven = living();
    Image present;
    driven.save(present);
    if (Status taken = driven.restore_portable(portable_image); !taken) return taken;
    Status checked = game.check(driven);
    if (checked && tick_count && driven.tick_count() != *tick_count)
        checked = Error{
            base::join("the state is of tick ", driven.tick_count(), ", it should be of tick ", *tick_count)};
    if (!checked) driven.restore(present);
    return checked;
}
Status WorldSimulation::adopt(std::span<const std::byte> portable_image) {
    return adopt_if(portable_image, std::nullopt);
}
Status WorldSimulation::adopt_at(std::uint64_t tick, std::span<const std::byte> portable_image) {
    const Result<World> start = game.start();
    if (!start) return start.error();
    return adopt_if(portable_image, start->tick_count() + tick);
}
/// Runs in a clone, so a journal of the world records nothing of it.
std::optional<Rerun> WorldSimulation::run_aside(const Image& before, std::span<const PlayerInput> inputs) {
    World aside = living().clone();
    aside.restore(before);
    aside.record_phase_hashes(true);
    WorldSimulation(aside, game).advance(inputs);
    const std::span<const PhaseHash> phases = aside.phase_hashes();
    return Rerun{{phases.begin(), phases.end()}, aside.hash()};
}
std::uint64_t WorldSimulation::hash() const { return living().hash(); }
std::span<const Event> WorldSimulation::events() const { return living().events(); }
void WorldSimulation::record_phase_hashes(bool on) { living().record_phase_hashes(on); }
std::span<const PhaseHash> WorldSimulation::phase_hashes() const { return living().phase_hashes(); }
State& WorldSimulation::state() { return testing::state_of(living()); }

} // namespace lockstone
