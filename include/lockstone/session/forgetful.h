// For tests of sessions: a simulation with a faulty restore.
#pragma once

#include "lockstone/session.h"

#include <string>
#include <vector>

namespace lockstone::testing {

/// Wraps another simulation. A restore leaves one column unchanged, as if the image did not have it; a sync
/// test must detect this. The other simulation is not owned.
class ForgetfulSimulation final : public Simulation {
  public:
    /// `column`: name of a column; empty: none. An unknown column ends the program at the first restore.
    ForgetfulSimulation(Simulation& driven, std::string column) : real(driven), left_out(std::move(column)) {}
    void save(Image& image) const override { real.save(image); } ///< As the other simulation.
    void restore(const Image& image) override;                   ///< Leaves the column unchanged.
    /// As the other simulation.
    ///@{
    void advance(std::span<const PlayerInput> inputs) override { real.advance(inputs); }
    std::uint64_t hash() const override { return real.hash(); }
    std::span<const Event> events() const override { return real.events(); }
    State& state() override { return real.state(); }
    Status adopt(std::span<const std::byte> portable_image) override { return real.adopt(portable_image); }
    Status adopt_at(std::uint64_t tick, std::span<const std::byte> portable_image) override {
        return real.adopt_at(tick, portable_image);
    }
    void record_phase_hashes(bool on) override { real.record_phase_hashes(on); }
    std::span<const PhaseHash> phase_hashes() const override { return real.phase_hashes(); }
    ///@}

  private:
    Simulation& real;
    std::string left_out;
    std::vector<std::byte> kept;
};

} // namespace lockstone::testing
