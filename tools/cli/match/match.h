// A whole match in one process: peers with a world, a session and a recorder each, over a simulated network.
#pragma once

#include "lockstone/session.h"
#include "replay/recorder.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace lockstone::cli {

/// Half a year at 60 Hz. The number of frames of such a match does not overflow.
inline constexpr std::uint64_t match_ticks_max = 1'000'000'000;

enum class MatchMode { rollback, lockstep };

struct MatchDef {
    std::uint64_t seed = 1;
    std::uint64_t ticks = 600; ///< that every peer has to confirm, 1..match_ticks_max
    MatchMode mode = MatchMode::rollback;
    LinkDef link;
    std::vector<LinkDef> links; ///< if not empty, in place of `link`: by from * machines + to
    /// By machine: how much faster its clock runs [1/1000]; empty: all run alike.
    std::vector<std::int32_t> clock_permille;
    /// Number of watchers of peer 0. The first joins at the start, each next one some seconds later.
    std::uint32_t watchers = 0;
    /// The watchers join a relay, to which peers 0 and 1 show the match, and not peer 0.
    bool relayed = false;
    /// Relayed only: frame from which peer 0 cannot show the match any more; 0: never.
    std::uint64_t show_lost = 0;
    /// The last `late` machines join some seconds after the start.
    std::uint32_t late = 0;
    /// How often a machine other than peer 0 loses its whole state and joins again two seconds later.
    std::uint32_t rejoins = 0;
    /// The first machine that loses its state is peer 0; peer 1 then shows the match.
    bool host_crashes = false;
    std::uint32_t run_ahead = 0;   ///< by which every machine shows its player a predicted state [ticks]
    std::uint32_t input_delay = 0; ///< [ticks]; 0: the default of the session
    std::uint64_t first_late = 200,
                  first_crash = 300; ///< frames of the first late join and of the first crash
    bool sleeps = false;             ///< machines pause for up to half a second
    bool cuts = false;               ///< links lose all packets for up to two seconds
    /// Fault on purpose: the last of the machines that start the match flips a bit of its state after tick `ticks` / 2.
    bool planted = false;
    /// A machine that differs from most others (of two machines: the second) drops its state and joins again.
    bool recovers = false;
};

/// The ticks that one peer confirmed, and its recording.
class ConfirmedLog final : public ConfirmedSink {
  public:
    explicit ConfirmedLog(std::uint64_t ticks) : ticks_max(ticks) {}
    /// Begins the recording. A peer that joins later calls this when it has received a state, since its recording
    /// begins there.
    void record(Result<replay::InputRecorder> to);
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    Status close();

    std::uint64_t first = 0;                 ///< first tick that was confirmed
    std::vector<std::uint64_t> hashes;       ///< one per confirmed tick, from `first`
    std::vector<std::byte> inputs_confirmed; ///< tick by tick, of all players: status, then bytes

  private:
    std::optional<replay::InputRecorder> recorder;
    std::uint64_t ticks_max;
    Status state;
};

struct PeerOutcome {
    /// The file; empty if the peer confirmed no tick. The recording of a late peer begins with the state that it
    /// received.
    std::vector<std::byte> recording;
    std::uint64_t first; ///< first tick that it confirmed
    std::vector<std::uint64_t> hashes;
    std::vector<std::byte> inputs;
    SessionStats stats;
};

/// A machine that dropped another one from its session and played on without it.
struct Departure {
    /// `told_by` reported that `gone` has left.
    PeerId told_by, gone;
    std::uint64_t tick; ///< from this tick on the inputs of `gone` are zero
};

struct MatchOutcome {
    std::vector<PeerOutcome> peers;
    std::vector<std::vector<std::uint64_t>> watched; ///< by watcher, then by tick: hashes
    std::vector<std::string> broken; ///< errors that sessions reported, and broken rules of sessions
    std::uint32_t recoveries = 0;    ///< how many machines dropped a differing state and joined again
    std::vector<std::string> notes;  ///< who left, and whose match stopped
    std::vector<Departure> departures;
    std::uint64_t milliseconds = 0; ///< simulated time
};

/// Plays a match with one peer per player of the game. Returns an error if the match does not end within a generous
/// time. Calls `progress` with the number of ticks that all peers have confirmed.
Result<MatchOutcome> play_match(const Game& game, const MatchDef& def,
                                const std::function<void(std::uint64_t)>& progress = {});

} // namespace lockstone::cli
