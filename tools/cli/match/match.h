// A whole match in one process: peers with a world, a session and a recorder each, over a simulated network.
#pragma once

#include "lockstone/session.h"
#include "replay/recorder.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lockstone::cli {

/// Half a year at 60 Hz; the number of its frames fits.
inline constexpr std::uint64_t match_ticks_max = 1'000'000'000;

enum class MatchMode { rollback, lockstep };

struct MatchDef {
    std::uint64_t seed = 1;
    std::uint64_t ticks = 600; ///< that every peer has to confirm, 1..match_ticks_max
    MatchMode mode = MatchMode::rollback;
    LinkDef link;
    std::vector<LinkDef> links; ///< in place of `link`, where it is not empty: by from * machines + to
    /// By machine: how much faster its clock goes; empty: all alike
    std::vector<std::int32_t> clock_permille;
    std::uint32_t watchers =
        0; ///< who watch peer 0; the first from the start, each next one some seconds later
    bool relayed =
        false; ///< they watch through a relay that peers 0 and 1 show the match to, not peer 0 itself
    std::uint64_t show_lost = 0; ///< frame at which peer 0 can show the match no more; 0: never
    std::uint32_t late = 0;      ///< how many of the last machines come in some seconds after the start
    std::uint32_t rejoins =
        0; ///< how often a machine, but not peer 0, loses all its state and comes back two seconds later
    bool host_crashes = false;     ///< the first of them is peer 0, after all; then peer 1 shows the match
    std::uint32_t run_ahead = 0;   ///< [ticks] that every machine is shown ahead
    std::uint32_t input_delay = 0; ///< [ticks]; 0: the session's own
    std::uint64_t first_late = 200, first_crash = 300; ///< frames
    bool sleeps = false;                               ///< machines sleep for up to half a second
    bool cuts = false;                                 ///< links are cut for up to two seconds
    /// The last machine that is there from the start changes a bit of its state after tick `ticks` / 2.
    bool planted = false;
    /// A machine that most others differ from, of two the second, takes the others' state and comes back.
    bool recovers = false;
};

/// One peer's view of what was confirmed, and its recording.
class ConfirmedLog final : public ConfirmedSink {
  public:
    explicit ConfirmedLog(std::uint64_t ticks) : ticks_max(ticks) {}
    /// Of one that comes later, whose match begins elsewhere: when it has a state.
    void record(Result<replay::InputRecorder> to);
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    Status close();

    std::uint64_t first = 0;                 ///< tick that was confirmed first
    std::vector<std::uint64_t> hashes;       ///< by tick, from there
    std::vector<std::byte> inputs_confirmed; ///< of all players, tick by tick: status, then bytes

  private:
    std::optional<replay::InputRecorder> recorder;
    std::uint64_t ticks_max;
    Status state;
};

struct PeerOutcome {
    std::vector<std::byte> recording; ///< the file; of one that came later, from the state that it took
    std::uint64_t first;              ///< tick that it confirmed first
    std::vector<std::uint64_t> hashes;
    std::vector<std::byte> inputs;
    SessionStats stats;
};

/// A machine that took another for gone, and played on without it.
struct Departure {
    PeerId told_by, gone;
    std::uint64_t tick; ///< from which on the other's inputs are zero
};

struct MatchOutcome {
    std::vector<PeerOutcome> peers;
    std::vector<std::vector<std::uint64_t>> watched; ///< by watcher: hashes, by tick
    std::vector<std::string> broken; ///< what sessions reported, and what they may not do and did
    std::uint32_t recoveries = 0;    ///< of machines that others differed from
    std::vector<std::string> notes;  ///< who left, and whose match stopped
    std::vector<Departure> departures;
    std::uint64_t milliseconds = 0; ///< of simulated time
};

/// One peer per player of the game. Errors: the match did not get through in a generous time.
/// `progress` hears how many ticks all have confirmed.
Result<MatchOutcome> play_match(const Game& game, const MatchDef& def,
                                const std::function<void(std::uint64_t)>& progress = {});

} // namespace lockstone::cli
