// Sessions: several machines run one game and exchange inputs only.
//
//   const SessionDef def = session_def(game, /*self=*/0, /*players=*/{0, 1});
//   auto session = make_rollback_session(def, transport).value();
//   WorldSimulation simulation(world, game);
//   SessionRunner runner(*session, simulation);
//   each frame:
//     session->add_local_input(0, encode_input(pad));
//     const Frame frame = runner.frame(now_ms);              // receive, send, roll back, run a tick or stall
//     for (const SessionEvent& e : runner.events()) ...      // predicted, then confirmed or cancelled
//     while (auto notice = session->next_notice()) ...       // who joined, who left, who desynced
//
// A session has no world, no clock and no socket. It returns requests (load, save, advance) that
// SessionRunner or the caller executes. Ticks count from 0: Save(t) and Load(t) refer to the state before
// tick t.
//
// Threads: one thread at a time for a session with its transport, simulation and runner.
#pragma once

#include "lockstone/game.h"
#include "lockstone/session/transport.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace lockstone {

// ---- definition -----------------------------------------------------------------------------------

inline constexpr std::uint32_t players_max = 16;              ///< of a match
inline constexpr std::uint32_t input_bytes_max = 64;          ///< of SessionDef::input_size
inline constexpr std::uint32_t prediction_limit = 64;         ///< of SessionDef::prediction_max
inline constexpr std::uint32_t input_delay_limit = 32;        ///< of SessionDef::input_delay
inline constexpr std::uint32_t run_ahead_limit = 4;           ///< of SessionDef::run_ahead
inline constexpr std::uint64_t disconnect_ms_limit = 120'000; ///< of SessionDef::disconnect_ms
/// Packets of one peer that a poll reads; it drops further ones unread.
inline constexpr std::uint32_t packets_per_peer_max = 64;
/// Packets of all senders that a poll takes; the next poll takes the rest.
inline constexpr std::uint32_t packets_per_poll_max = 4096;

/// Predicts the input of a remote player until the true one arrives. A wrong prediction costs a rollback but
/// no correctness, so a predictor may use any data.
class InputPredictor {
  public:
    virtual ~InputPredictor() = default;
    /// Writes the predicted input to `out` [input_size bytes]. `last`: the player's newest true input, zeros
    /// before the first; `ticks_ahead`: distance of `out` from it, at least 1.
    virtual void predict(std::uint32_t player, std::span<const std::byte> last, std::uint64_t ticks_ahead,
                         std::span<std::byte> out) const = 0;
};
/// The default predictor: repeats the last input. Lives as long as the program.
const InputPredictor& repeat_last_input();

/// Definition of a session. The factory functions check the ranges.
struct SessionDef {
    /// Id of the match, equal on every machine. Packets of other matches are dropped.
    std::uint64_t match_id = 0;
    std::uint64_t content_id = 0; ///< Game::content_id()
    std::uint32_t input_size = 0; ///< bytes of an input, 0..64
    PeerId self = 0;              ///< this machine
    std::vector<PeerId> players;  ///< [players] the machine of each player, 1..16; equal on every machine
    /// Bit p: the machine of player p is absent at the start and may join later (lockstone/session/join.h).
    /// Until then the player's inputs are zero and `disconnected`. All players of a machine or none; not
    /// those of self. Equal on every machine.
    std::uint32_t absent = 0;
    /// Delay of local inputs [ticks], 0..32; lockstep: 1..32. Machines may differ.
    std::uint32_t input_delay = 2;
    /// Ticks that may run on predicted inputs, 1..64; lockstep ignores it. Among three or more machines the
    /// departure of one may roll back up to 2 * prediction_max + 8 ticks.
    std::uint32_t prediction_max = 8;
    /// Timeout of a peer [ms], 1..120,000: for silence, and for the total stall time that it causes by
    /// missing inputs, hashes and acknowledgements (half the time for the last two among three or more
    /// machines). Each tick that runs refills the stall budget by 100 ms, or by disconnect_ms / 60 if that is
    /// more. After the timeout this machine votes for the peer to leave. The upper limit follows from 16-bit
    /// packet numbers: a link that loses 32,768 packets in a row is dead. In lockstep the input delay must
    /// cover the latency of the slowest machine less 100 ms; a longer latency exhausts the budget.
    std::uint64_t disconnect_ms = 5000;
    /// Timeout for a peer's first packet, from the first poll [ms], at least 1.
    std::uint64_t connect_ms = 30'000;
    /// Predicts remote inputs. Not owned: it must outlive the session. Not null.
    const InputPredictor* predictor = &repeat_last_input();
    /// Ticks that the displayed world runs ahead after each frame, 0..4: with the newest local inputs held
    /// and predicted remote inputs. It hides so many ticks of input delay and costs as many ticks and a
    /// restore for each frame. Confirmed ticks, recordings and events do not change. A sync test requires 0.
    std::uint32_t run_ahead = 0;
};
/// A definition with the game's content_id and input_size. match_id is 0: set it if several matches share a
/// network.
SessionDef session_def(const Game& game, PeerId self, std::vector<PeerId> players);

// ---- requests -------------------------------------------------------------------------------------

/// Restore the state saved before tick `tick`.
struct Load {
    std::uint64_t tick; ///< of an earlier Save
    bool verify;        ///< sync tests: check that the state has the hash that it had at Save(tick)
};
/// Save the present state, that before tick `tick`, in place of an older save of the tick. Ticks that no
/// rollback can reach are not saved.
struct Save {
    std::uint64_t tick; ///< the next tick to run
};
/// Run tick `tick`, then call Session::report_hash().
struct Advance {
    std::uint64_t tick;                  ///< the tick to run
    std::span<const PlayerInput> inputs; ///< [players]; valid until the session's next call but report_hash()
    bool resimulated;                    ///< true: this tick ran before
};
/// Replace the state by this one from another machine, then call Session::report_adopted(). Earlier saves and
/// events are void. Only from sessions that begin in the middle of a match.
struct Adopt {
    std::uint64_t tick;               ///< the next tick to run
    std::span<const std::byte> image; ///< of save_portable(); valid until the session's next poll or advance
};
/// One instruction of a session to its caller.
using Request = std::variant<Load, Save, Advance, Adopt>;

/// Reason why no new tick ran. Call again in the next frame.
enum class Stall {
    none,                ///< no stall: a tick ran
    connecting,          ///< no packet of some peer has arrived yet
    inputs_missing,      ///< prediction_max ticks are predicted already (lockstep: an input is missing)
    local_input_missing, ///< add_local_input() was not called for a local player
    peer_behind,         ///< a peer acknowledges too little, and the memory for resending is full
    finished,            ///< tick or poll 2^32 - 4096 is reached: two years at 60 Hz
    stopped,             ///< the match has ended; see the notice MatchStopped
};
/// "inputs missing"; "unknown" for any other value. Static string.
const char* name_of(Stall stall);

/// Result of Session::advance() and settle().
struct Step {
    Stall stall; ///< none: a new tick ran
    /// Execute all in order, after a stall too. Valid until the next advance() or settle().
    std::span<const Request> requests;
    /// Number of frames to skip (poll without advance), so that slower peers catch up: mostly 0, about once a
    /// second more, at most prediction_max (lockstep: the input delay).
    std::uint32_t wait_ticks;
};

/// A tick that can no longer change. Compare and record only hashes of confirmed ticks.
struct ConfirmedTick {
    std::uint64_t tick;                  ///< number of the tick
    std::span<const PlayerInput> inputs; ///< [players]; valid until the session's next call
    std::uint64_t hash;                  ///< of the state after the tick
};

/// Result of Session::report_hash().
enum class HashCheck {
    accepted, ///< no contradiction
    differs,  ///< an earlier run of the tick with equal inputs had another hash (sync tests)
};

// ---- notices ----------------------------------------------------------------------------------

/// The first packet of a peer has arrived.
struct PeerConnected {
    PeerId peer; ///< the machine
};
/// A player has left. Its inputs are zero and `disconnected` from `tick` on, on every remaining machine.
struct PlayerDisconnected {
    std::uint32_t player; ///< the player
    PeerId peer;          ///< the player's machine
    std::uint64_t tick;   ///< first tick without the player
};
/// The states of this machine and a peer differ. Once for each peer. To recover, a machine replaces its
/// session by a join session (lockstone/session/join.h) if it differs from more than half of the others, or
/// if it is not the host of two; the others play on.
struct Desync {
    std::uint64_t tick;  ///< first confirmed tick after which the states differ
    std::uint32_t local, ///< low half of this machine's root hash after the tick
        remote;          ///< low half of the peer's root hash after the tick
    PeerId peer;         ///< the other machine
};
inline constexpr std::size_t desync_differences_max = 8; ///< of DesyncReport::differences
inline constexpr std::uint64_t desync_log_ticks = 120;   ///< of DesyncReport::log: two seconds at 60 Hz

/// First difference between the states of two machines, as far as they could exchange it.
struct DesyncReport {
    PeerId peer = 0;         ///< the other machine
    std::uint64_t tick = 0;  ///< first confirmed tick after which the states differ
    std::uint64_t local = 0, ///< this machine's root hash after the tick
        remote = 0;          ///< the peer's root hash after the tick; 0: unknown
    /// First phase of the tick with different hashes when it runs again; empty: unknown.
    std::string phase;
    std::vector<std::string> columns; ///< different columns, in manifest order
    /// At most 8: row counts, then rows of the first different page. Left: this machine.
    std::vector<Difference> differences;
    bool complete = false;      ///< true: the peer has answered all requests
    bool local_repeats = false; ///< true: the tick gives the same state again on this machine
    /// True: the tick gives the same state again on the peer. False on a machine: something besides state and
    /// inputs affects its ticks.
    bool remote_repeats = false;
    std::uint64_t bytes_exchanged = 0; ///< in both directions [bytes], at most 128 kB
    /// A tick of the log.
    struct Tick {
        std::uint64_t tick;                         ///< number of the tick
        std::uint32_t local,                        ///< low half of this machine's root hash
            remote;                                 ///< low half of the peer's root hash
        std::vector<std::vector<std::byte>> inputs; ///< [player][input_size]
    };
    std::vector<Tick> log; ///< the last desync_log_ticks ticks up to `tick`
};
/// The report of a Desync, on both machines: when the exchange is complete, or after some seconds without an
/// answer. Only of a session with a StateInspector.
struct DesyncNamed {
    std::shared_ptr<const DesyncReport> report; ///< never null
};
/// One line; machines are numbered from 1: "tick 118, machine 2: phase solve, column body.velocity, row 7,
/// linear.x: 1 (raw 0x80000) against 2 (raw 0x100000)"
std::string to_string(const DesyncReport& report);
/// The line above, then a line for each difference, column and tick: for a file.
std::string log_text(const DesyncReport& report);

/// The session refused a state from `peer` and requests one from another machine. The simulation is
/// unchanged.
struct StateRefused {
    PeerId peer;        ///< the sender
    std::string reason; ///< a sentence
};
/// A player has joined or returned. Its inputs count from `tick` on, on every machine.
struct PlayerJoined {
    std::uint32_t player; ///< the player
    PeerId peer;          ///< the player's machine
    std::uint64_t tick;   ///< first tick with the player
};

/// Packets of `peer` are well formed but belong to another version or match. Once for each peer.
struct PeerIncompatible {
    PeerId peer;        ///< the machine
    const char* reason; ///< name_of() the PacketFault. Static string
};
/// The match has ended on this machine: the other machines have dropped it, they cannot agree on a departure,
/// or no machine has its next ticks any more. Once; every later step stalls. Confirmed ticks remain valid.
struct MatchStopped {
    std::string reason; ///< a sentence
};
/// A message of a session to the game.
using Notice = std::variant<PeerConnected, PlayerDisconnected, PlayerJoined, Desync, DesyncNamed,
                            StateRefused, PeerIncompatible, MatchStopped>;

/// Reason why a packet was dropped. A dropped packet changes only these counts.
enum class PacketFault : std::uint32_t {
    stranger,    ///< the sender is not in the match, or has left
    damaged,     ///< not a session packet, or a wrong checksum
    version,     ///< another version of the format
    match,       ///< another match, game or list of players
    malformed,   ///< a field contradicts the format
    implausible, ///< well formed, but the sender cannot have this data
    flood,       ///< more than packets_per_peer_max packets of a peer in one poll
};
inline constexpr std::uint32_t packet_fault_count = 7; ///< number of reasons
/// A phrase such as "damaged"; "unknown" for any other value. Static string.
const char* name_of(PacketFault fault);

/// Counters of a session since its start.
struct SessionStats {
    std::uint64_t ticks = 0;                                 ///< ticks run for the first time
    std::uint64_t rollbacks = 0;                             ///< number of rollbacks
    std::uint64_t resimulated = 0;                           ///< ticks run again
    std::uint64_t depth_max = 0;                             ///< longest rollback [ticks]
    std::uint64_t stalls = 0;                                ///< calls of advance() that ran no new tick
    std::uint64_t hashes_compared = 0;                       ///< ticks compared with a peer
    std::uint64_t packets_sent = 0,                          ///< to all peers
        packets_received = 0,                                ///< from all senders, dropped ones too
        packets_dropped = 0;                                 ///< sum of `dropped`
    std::uint64_t bytes_sent = 0,                            ///< without transport headers
        bytes_received = 0;                                  ///< without transport headers
    std::array<std::uint64_t, packet_fault_count> dropped{}; ///< [PacketFault] packets
    std::uint64_t first_poll_ms = 0,                         ///< time of the first poll [ms]
        last_poll_ms = 0;                                    ///< time of the last poll [ms]
    std::uint32_t local_players = 0;                         ///< players of this machine

    /// Bytes sent for each local player and second between the first and the last poll; 0 before.
    std::uint64_t bytes_per_player_second() const;
};

/// Quality of the connection to a peer, for display.
struct PeerQuality {
    bool connected = false;          ///< false: not yet, or left
    std::uint32_t ping_ms = 0;       ///< round trip [ms]
    std::int32_t ticks_ahead = 0;    ///< lead of this machine [ticks]; negative: the peer leads
    std::uint64_t hashes_agreed = 0; ///< n: the hashes of ticks [0, n) are compared and equal
};

// ---- desync diagnosis -------------------------------------------------------------------------------------

/// Result of running a tick again from the state before it.
struct Rerun {
    std::vector<PhaseHash> phases; ///< empty: the simulation has no phases
    std::uint64_t hash = 0;        ///< Simulation::hash() after the tick
};

/// Gives a session access to old states, so that two machines can find their first difference. SessionRunner
/// has one.
class StateInspector {
  public:
    virtual ~StateInspector() = default;
    /// The state after tick `tick`; null: no longer stored. Valid until the next call.
    virtual const State* state_after(std::uint64_t tick) = 0;
    /// Runs a tick again from the stored state before it; the simulation is then as before. Empty: no such
    /// state.
    virtual Rerun run_again(std::uint64_t tick, std::span<const PlayerInput> inputs) = 0;
};

// ---- the session ------------------------------------------------------------------------------------------

/// One machine's part of a match. SessionRunner calls most of these functions.
class Session {
  public:
    virtual ~Session() = default;
    /// Receives packets, then sends each peer one packet with the inputs that it lacks. Call it once in each
    /// frame, also in frames without advance(). `now_ms`: time [ms] from any origin; a time before the last
    /// one counts as the last one.
    virtual void poll(std::uint64_t now_ms) = 0;
    /// Sets the input [input_size bytes] of a local player for tick current_tick() + input_delay; a sync test
    /// has no delay. Call it once before each tick; a repetition after a stall is ignored. A wrong size or a
    /// player of another machine ends the program.
    virtual void add_local_input(std::uint32_t player, std::span<const std::byte> input) = 0;
    /// Requests for one frame: a rollback if a prediction was wrong, then the next tick unless the session
    /// stalls. Confirmed ticks must have been taken by next_confirmed(); otherwise the program ends.
    virtual Step advance() = 0;
    /// advance() without a new tick, for the end of a match. Never stalls.
    virtual Step settle() = 0;
    /// Call it after each Advance with the hash of the state after tick `tick`. A tick that was not requested
    /// ends the program.
    virtual HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) = 0;
    /// Call it after each Adopt with the result and the hash of the state.
    virtual void report_adopted(const Status& taken, std::uint64_t hash) { (void)taken, (void)hash; }
    /// The next confirmed tick: each tick exactly once, in order; empty: none. Take all of them before the
    /// next advance().
    virtual std::optional<ConfirmedTick> next_confirmed() = 0;
    virtual std::optional<Notice> next_notice() = 0; ///< The next notice, oldest first; empty: none.

    /// Votes for a peer to leave. Between two machines it has left at the next poll; among more it leaves
    /// when most of the others vote so too (src/session/README.md). Errors: not a peer of this match, a
    /// spectator or sync test session.
    virtual Status drop_peer(PeerId peer) = 0;

    /// Sets the source of old states for desync reports. Not owned; null: no reports. False: this session
    /// makes no reports.
    virtual bool set_inspector(StateInspector*) { return false; }
    /// Removes this inspector, unless another one was set since.
    virtual void drop_inspector(const StateInspector&) {}

    virtual std::uint64_t current_tick() const = 0; ///< The next new tick.
    /// Predicted inputs [players] of tick current_tick() + `offset`, for SessionDef::run_ahead. Empty:
    /// `offset` is not below run_ahead, or there is no prediction. Valid until the session's next call.
    virtual std::span<const PlayerInput> look_ahead(std::uint32_t offset) {
        (void)offset;
        return {};
    }
    /// Number of saved states in use at a time: ticks t and t + images_max() may share a slot.
    virtual std::uint32_t images_max() const = 0;
    /// Changes SessionDef::input_delay at any time. A value out of its range ends the program. A longer delay
    /// repeats an input, a shorter one drops one.
    virtual void set_input_delay(std::uint32_t ticks) = 0;
    /// Connection to a peer; all zero for a machine that is not in the match.
    virtual PeerQuality quality(PeerId peer) const = 0;
    virtual const SessionStats& stats() const = 0; ///< Valid as long as the session.

    /// Expires when the session is destroyed. SessionRunner checks it before each call.
    std::weak_ptr<const void> lifetime() const { return alive; }

  private:
    std::shared_ptr<const void> alive = std::make_shared<std::byte>();
};

/// A session that predicts remote inputs and rolls back after a wrong prediction. The transport is not owned
/// and must outlive the session. Errors: a field of `def` out of range.
Result<std::unique_ptr<Session>> make_rollback_session(const SessionDef& def, Transport& transport);
/// A session that runs a tick only when all its inputs have arrived: no prediction, no Load, no Save. The
/// input delay hides the latency; among three or more machines the round trip, because all others must have
/// acknowledged the inputs. Transport and errors as above.
Result<std::unique_ptr<Session>> make_lockstep_session(const SessionDef& def, Transport& transport);
/// A test session on one machine, with local players only. In every tick it rolls back `depth` ticks (1..64),
/// runs them again and compares hashes. A tick is confirmed after `depth` repetitions. First runs have the
/// status `predicted`, so that the test detects rules that read the status. Errors: a field of `def` out of
/// range.
Result<std::unique_ptr<Session>> make_sync_test_session(const SessionDef& def, std::uint32_t depth);

// ---- executing requests -----------------------------------------------------------------------------------

/// The simulation that a runner drives: a world with a game's rules, or a replacement for tests.
class Simulation {
  public:
    virtual ~Simulation() = default;
    virtual void save(Image& image) const = 0;    ///< Saves the state.
    virtual void restore(const Image& image) = 0; ///< Restores a saved state.
    /// Runs one tick with the inputs [players].
    virtual void advance(std::span<const PlayerInput> inputs) = 0;
    virtual std::uint64_t hash() const = 0; ///< Hash of the state.
    /// Events of the last tick; valid until the next advance() or restore(). The runner sorts them by
    /// `precedes` if necessary and keeps the first of equal ones.
    virtual std::span<const Event> events() const = 0;
    virtual State& state() = 0; ///< The state, for memory, reports and tests.
    /// Replaces the state by a portable image from outside. After an error the state is as before.
    virtual Status adopt(std::span<const std::byte> portable_image) {
        return state().restore_portable(portable_image);
    }
    /// As adopt(), for the state before tick `tick` of the session. Override it to refuse a state of another
    /// tick. The runner calls this one.
    virtual Status adopt_at(std::uint64_t tick, std::span<const std::byte> portable_image) {
        (void)tick;
        return adopt(portable_image);
    }
    /// Runs a tick from the state `before` without effect on the present state, journals and observers. Empty
    /// (the default): not possible; the runner restores, advances and restores instead.
    virtual std::optional<Rerun> run_aside(const Image& before, std::span<const PlayerInput> inputs) {
        (void)before, (void)inputs;
        return {};
    }
    /// Enables hashes after each phase of later ticks.
    virtual void record_phase_hashes(bool) {}
    /// Hashes of the phases of the last tick; valid until the next call. Default: none.
    virtual std::span<const PhaseHash> phase_hashes() const { return {}; }
};

/// A World with the rules of a Game. Both must outlive it, and the World object must not be destroyed or
/// moved: later use ends the program.
class WorldSimulation final : public Simulation {
  public:
    /// Drives `driven` by `rules`.
    WorldSimulation(World& driven, const Game& rules)
        : world(driven), lifetime(driven.lifetime()), game(rules) {}
    void save(Image& image) const override;    ///< World::save()
    void restore(const Image& image) override; ///< World::restore()
    /// Calls Game::advance(), then World::tick() if the game did not.
    void advance(std::span<const PlayerInput> inputs) override;
    std::uint64_t hash() const override;            ///< World::hash()
    std::span<const Event> events() const override; ///< World::events()
    State& state() override;                        ///< The world's state.
    /// World::restore_portable(), then Game::check().
    Status adopt(std::span<const std::byte> portable_image) override;
    /// As adopt(). Error also: the state's tick_count() is not that of Game::start() plus `tick`.
    Status adopt_at(std::uint64_t tick, std::span<const std::byte> portable_image) override;
    /// Runs the tick in a clone of the world.
    std::optional<Rerun> run_aside(const Image& before, std::span<const PlayerInput> inputs) override;
    void record_phase_hashes(bool on) override;               ///< World::record_phase_hashes()
    std::span<const PhaseHash> phase_hashes() const override; ///< World::phase_hashes()
    /// The first error of Game::advance(), for display. The tick ran anyway, equally on every machine.
    /// It may come from a wrong prediction.
    const Status& failure() const { return first_failure; }

  private:
    World& living() const;
    Status adopt_if(std::span<const std::byte> portable_image, std::optional<std::uint64_t> tick_count);
    World& world;
    std::weak_ptr<const void> lifetime;
    const Game& game;
    Status first_failure;
};

/// Receives the confirmed timeline: every tick once, in order. A replay recorder implements it.
class ConfirmedSink {
  public:
    virtual ~ConfirmedSink() = default;
    /// Tick `tick` is confirmed: inputs [players], valid during the call, and the hash of the state after it.
    virtual void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs,
                              std::uint64_t hash) = 0;
};

/// Certainty of a SessionEvent.
enum class EventStatus : std::uint8_t {
    predicted, ///< its tick may run again: play the sound, spawn the particles
    confirmed, ///< final: count the score. The only status of an event first seen in a confirmed tick
    cancelled, ///< it did not happen: fade the sound out
};
/// An event of a tick. Each predicted event is later confirmed or cancelled exactly once, with the same id.
/// Two runs of a tick have the same event if its kind, shapes, joint and bodies are equal; point and speed
/// may differ, the confirmed values are final.
struct SessionEvent {
    Event event;        ///< the event
    EventStatus status; ///< predicted, confirmed or cancelled
    std::uint64_t id;   ///< unique on this machine
};

/// The first difference between two runs of the same tick with the same inputs.
struct SyncTestFailure {
    /// The failed comparison.
    enum class When {
        restored,    ///< the restored state differs from the saved one
        resimulated, ///< running the tick again gave another state
    } when;          ///< the failed comparison
    /// restored: the tick after the saved state; resimulated: the tick itself
    std::uint64_t tick;
    std::uint64_t first_hash,            ///< of the first run
        second_hash;                     ///< of the second run
    std::vector<Difference> differences; ///< at most 8; left: first run, right: second run
};
/// One line: "tick 118, resimulated: column body.velocity, row 7, linear.x: 1 (raw 0x80000) against 2 (raw
/// 0x100000)"
std::string to_string(const SyncTestFailure& failure);

/// Settings of a SessionRunner.
struct RunnerDef {
    ConfirmedSink* sink = nullptr; ///< receives confirmed ticks. Not owned; null: none
    /// Number of recent states stored in addition to those for rollbacks, for desync reports about ticks that
    /// far back (round trip and lost packets) and for machines that join or watch. Each takes the memory of
    /// an image. 0: a Desync has no report, and this machine has no state for machines that join.
    std::uint32_t inspected_ticks = 64;
};

/// Result of SessionRunner::frame().
struct Frame {
    Stall stall;              ///< none: a new tick ran
    std::uint32_t wait_ticks; ///< Step::wait_ticks
};

/// Executes the requests of a session on a simulation, with a ring of images allocated once, and tracks the
/// status of events. The simulation must outlive the runner. After the session was destroyed, or the runner
/// was moved from, any call except the destructor ends the program. With SessionDef::run_ahead the simulation
/// is ahead between two calls; it is at the present tick when the sink is called, in drain(), and after the
/// runner is destroyed.
class SessionRunner {
  public:
    /// Allocates the ring: Session::images_max() + inspected_ticks images.
    SessionRunner(Session& session, Simulation& simulation, RunnerDef def = {});
    SessionRunner(SessionRunner&&) noexcept;            ///< The other runner is unusable afterwards.
    SessionRunner& operator=(SessionRunner&&) noexcept; ///< The other runner is unusable afterwards.
    ~SessionRunner();

    /// One frame at time `now_ms` [ms]: poll, advance, execute the requests, pass confirmed ticks to the
    /// sink.
    Frame frame(std::uint64_t now_ms);
    /// A frame with a poll only: call it wait_ticks times in place of frame(). events() is then empty.
    void wait(std::uint64_t now_ms);
    /// Ends a match: call it in place of frame() in each frame until it returns true. It runs no new tick,
    /// and confirms those that ran. Every machine must have reached the same Session::current_tick() before,
    /// with inputs up to there; otherwise the last ticks are never confirmed.
    bool drain(std::uint64_t now_ms);
    /// Events that are new or changed their status in the last frame: by tick, then by `precedes`. Valid
    /// until the next frame(), wait() or drain().
    std::span<const SessionEvent> events() const;
    /// Access to old states, for SpectatorHost::set_states(). Valid as long as the runner.
    StateInspector& inspector();
    /// The first failure of a sync test; null: none. Valid as long as the runner.
    const SyncTestFailure* sync_failure() const;

  private:
    struct Impl;
    Impl& inside() const;
    std::unique_ptr<Impl> impl;
};

} // namespace lockstone
