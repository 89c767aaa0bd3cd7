// Sessions: several machines run one game, from inputs alone.
//
//   auto session = make_rollback_session(session_def(game, /*self=*/0, /*players=*/{0, 1}), transport).value();
//   WorldSimulation simulation(world, game);
//   SessionRunner runner(*session, simulation);
//   each frame:
//     session->add_local_input(0, encode_input(pad));
//     const Frame frame = runner.frame(now_ms);              // receives, sends, rolls back, runs one tick or stalls
//     for (const SessionEvent& e : runner.events()) ...      // predicted, then confirmed or cancelled
//     while (auto notice = session->next_notice()) ...       // who joined, who left, who desynced
//
// A session owns no world, no clock and no socket. It answers with requests; SessionRunner executes them, or the
// caller does. Ticks count from 0: Save(t) and Load(t) mean the state before tick t runs.
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

// ---- what a session is made of -----------------------------------------------------------------------------------

inline constexpr std::uint32_t players_max = 16;
inline constexpr std::uint32_t input_bytes_max = 64;
inline constexpr std::uint32_t prediction_limit = 64; ///< of SessionDef::prediction_max
inline constexpr std::uint32_t input_delay_limit = 32;
inline constexpr std::uint32_t run_ahead_limit = 4;
inline constexpr std::uint64_t disconnect_ms_limit = 120'000; ///< of SessionDef::disconnect_ms
/// What one poll reads: packets of each peer, and of all senders. Of a peer's, more are dropped unread; the rest waits.
inline constexpr std::uint32_t packets_per_peer_max = 64;
inline constexpr std::uint32_t packets_per_poll_max = 4096;

/// Guesses a remote player's input until the true one is here. Wrong guesses cost a rollback, never correctness, so
/// a predictor may use anything at hand.
class InputPredictor {
  public:
    virtual ~InputPredictor() = default;
    /// `last` is the player's newest true input (zeros before the first), `ticks_ahead` >= 1 how far `out` lies after
    /// it. `out` has the size of `last`.
    virtual void predict(std::uint32_t player, std::span<const std::byte> last, std::uint64_t ticks_ahead,
                         std::span<std::byte> out) const = 0;
};
/// The default: a held button stays held.
const InputPredictor& repeat_last_input();

struct SessionDef {
    std::uint64_t match_id =
        0; ///< agreed outside, the same on every machine; other matches' packets are refused
    std::uint64_t content_id = 0; ///< Game::content_id
    std::uint32_t input_size = 0; ///< bytes, 0..64
    PeerId self = 0;              ///< this machine
    std::vector<PeerId> players; ///< by player: the machine where they play; 1..16, the same on every machine
    /// Bit p: player p's machine is not there from the start but may come (lockstone/session/join.h); till then the inputs are zero and
    /// `disconnected`. All players of a machine or none; not self. The same on every machine.
    std::uint32_t absent = 0;
    std::uint32_t input_delay = 2; ///< [ticks], 0..32; lockstep needs at least 1; machines may differ
    /// [ticks] that may run on guesses, 1..64; lockstep ignores it. Among three machines or more one that leaves may take back up to
    /// 2 * prediction_max + 8.
    std::uint32_t prediction_max = 8;
    /// Patience with a peer: how long it may be silent, and how long the match may wait for its inputs, hashes and
    /// acknowledgements (for the last two half as long among three machines or more); every tick that runs makes up for a
    /// tenth of a second, or a sixtieth of it if that is more.
    /// Then this machine wants it to leave. At most two minutes: packets are numbered by 16 bits, and a link that loses 32,768 packets in a row,
    /// those of two minutes at 270 polls a second, is dead. So lockstep needs an input delay that covers the way from the slowest machine, less
    /// a tenth of a second: a match that is slower than that throws it out.
    std::uint64_t disconnect_ms = 5000;
    std::uint64_t connect_ms = 30'000; ///< from the first poll: how long a peer may take to appear
    const InputPredictor* predictor = &repeat_last_input(); ///< not owned
    /// How many ticks ahead of what is played the world is shown after each frame, 0..4, as if the newest local inputs were held and
    /// others' guesses came true: it answers the player so much sooner. Costs so many ticks and a restore a frame, and changes
    /// nothing of what is confirmed, recorded or told of events. A sync test takes 0.
    std::uint32_t run_ahead = 0;
};
/// match_id stays 0: set it where several matches share a network.
SessionDef session_def(const Game& game, PeerId self, std::vector<PeerId> players);

// ---- what a session asks for -------------------------------------------------------------------------------------

/// Make the state before tick `tick` the current one; it was saved earlier.
struct Load {
    std::uint64_t tick;
    bool verify; ///< sync tests: the state's hash must be what it was at Save(tick)
};
/// Keep the state before tick `tick`; the newest save of a tick replaces older ones. A tick before which
/// nothing can change any more is not saved: nothing will roll back to it.
struct Save {
    std::uint64_t tick;
};
/// Run tick `tick`, then call report_hash.
struct Advance {
    std::uint64_t tick;
    std::span<const PlayerInput> inputs; ///< one per player; valid until the session's next poll or advance
    bool resimulated;                    ///< this tick has run before
};
/// Make this state, which another machine has sent, the one before tick `tick`, then call report_adopted. All that was known of
/// states and events before is void. Only of sessions that begin in the middle of a match.
struct Adopt {
    std::uint64_t tick;
    std::span<const std::byte> image; ///< portable; valid until the session's next poll or advance
};
using Request = std::variant<Load, Save, Advance, Adopt>;

/// Why no new tick was run. Call again next frame.
enum class Stall {
    none,                ///< the tick was run
    connecting,          ///< a peer has not been heard of yet
    inputs_missing,      ///< prediction_max ticks rest on guesses already (lockstep: an input is not here)
    local_input_missing, ///< add_local_input was not called for a local player
    peer_behind, ///< a peer does not say what it has: what it lacks must be kept, and the memory is bounded
    finished,    ///< tick or poll 2^32 - 4096: two years at 60 Hz
    stopped,     ///< for good; the notice MatchStopped says why
};
const char* name_of(Stall stall);

struct Step {
    Stall stall;
    /// Execute all, in order, also when stalled; valid until the next advance
    std::span<const Request> requests;
    /// How many frames to skip (poll without advance) so that slower peers catch up; asked for once a second or so,
    /// never more than prediction_max (lockstep: the input delay), whatever peers say.
    std::uint32_t wait_ticks;
};

/// A tick that can no longer change. Only these have hashes that may be compared or recorded.
struct ConfirmedTick {
    std::uint64_t tick;
    std::span<const PlayerInput> inputs; ///< valid until the session's next call
    std::uint64_t hash;                  ///< of the state after the tick
};

enum class HashCheck {
    accepted,
    differs, ///< the same tick with the same inputs gave another hash before (sync tests)
};

// ---- what a session has to tell ----------------------------------------------------------------------------------

struct PeerConnected {
    PeerId peer;
};
/// The player's inputs are zero and `disconnected` from `tick` on, on every machine that remains.
struct PlayerDisconnected {
    std::uint32_t player;
    PeerId peer;
    std::uint64_t tick;
};
/// The first confirmed tick after which this machine and `peer` hold different states. Told once per peer. Recovery: of a
/// machine that more than half of the others differ from, or of two the one that is not the host, the game makes a join session
/// (lockstone/session/join.h) in place of this one; the others play on.
struct Desync {
    std::uint64_t tick;
    std::uint32_t local, remote; ///< lower halves of the root hashes after the tick
    PeerId peer;
};
inline constexpr std::size_t desync_differences_max = 8;
inline constexpr std::uint64_t desync_log_ticks = 120; ///< two seconds at 60 Hz

/// Where two states part, as far as both machines have told each other.
struct DesyncReport {
    PeerId peer = 0;
    std::uint64_t tick = 0;              ///< the first after which the states differ
    std::uint64_t local = 0, remote = 0; ///< root hashes after it; remote: 0 where not told
    std::string phase; ///< of the tick, run again: the first that both leave differently; empty: not known
    std::vector<std::string> columns; ///< that differ, in manifest order
    /// Row counts, then of the first page of the first column; ours left
    std::vector<Difference> differences;
    bool complete = false;      ///< the other side has answered all
    bool local_repeats = false; ///< the tick, run again here, leads to the same state as it did
    bool remote_repeats =
        false; ///< and there. Whose does not has a fault that its state and inputs do not explain
    std::uint64_t bytes_exchanged = 0; ///< both ways, of questions and answers; at most 128 kB
    struct Tick {
        std::uint64_t tick;
        std::uint32_t local, remote;                ///< lower halves of the root hashes
        std::vector<std::vector<std::byte>> inputs; ///< by player
    };
    std::vector<Tick> log; ///< the last desync_log_ticks up to `tick`
};
/// Follows a Desync where the session has somebody to ask (Session::set_inspector), at both machines: once all is told, or the
/// other one has been silent about it for some seconds.
struct DesyncNamed {
    std::shared_ptr<const DesyncReport> report; ///< never null
};
/// Machines are counted from 1.
/// "tick 118, machine 2: phase solve, column body.velocity, row 7, linear.x: 1 (raw 0x80000) against 2 (raw 0x100000)"
std::string to_string(const DesyncReport& report);
/// The sentence above, then a line for each difference, column and tick: for a file.
std::string log_text(const DesyncReport& report);

/// A state that `peer` has sent is not begun with; another machine is asked. What was run is untouched.
struct StateRefused {
    PeerId peer;
    std::string reason; ///< a sentence
};
/// The player's inputs count again, or for the first time, from `tick` on, on every machine.
struct PlayerJoined {
    std::uint32_t player;
    PeerId peer;
    std::uint64_t tick;
};

/// Packets arrive from `peer` that are well formed but of another version or match. Told once per peer.
struct PeerIncompatible {
    PeerId peer;
    const char* reason;
};
/// The match has ended at this machine: the other machines have dropped it, they cannot agree on a departure, or no machine holds its next ticks any
/// more. The session reports it once; every later step stalls. Confirmed ticks stay valid.
struct MatchStopped {
    std::string reason; ///< a sentence
};
using Notice = std::variant<PeerConnected, PlayerDisconnected, PlayerJoined, Desync, DesyncNamed,
                            StateRefused, PeerIncompatible, MatchStopped>;

/// Why a packet was dropped. Dropped packets change nothing but these counts.
enum class PacketFault : std::uint32_t {
    stranger,    ///< from nobody in this match, or from a peer that is gone
    damaged,     ///< not a session packet, or the checksum is wrong
    version,     ///< another version of the format
    match,       ///< another match, game or line-up
    malformed,   ///< a field contradicts the format
    implausible, ///< well formed, but claims what the sender cannot know or do
    flood,       ///< more than packets_per_peer_max of one peer in a poll: not even read
};
inline constexpr std::uint32_t packet_fault_count = 7;
const char* name_of(PacketFault fault);

struct SessionStats {
    std::uint64_t ticks = 0; ///< run for the first time
    std::uint64_t rollbacks = 0;
    std::uint64_t resimulated = 0; ///< ticks run again
    std::uint64_t depth_max = 0;   ///< of a rollback [ticks]
    std::uint64_t stalls = 0;      ///< calls of advance that ran no new tick
    std::uint64_t hashes_compared = 0;
    std::uint64_t packets_sent = 0, packets_received = 0, packets_dropped = 0;
    std::uint64_t bytes_sent = 0, bytes_received = 0;        ///< without transport headers
    std::array<std::uint64_t, packet_fault_count> dropped{}; ///< by PacketFault
    std::uint64_t first_poll_ms = 0, last_poll_ms = 0;
    std::uint32_t local_players = 0;

    /// Sent per local player and second of polling.
    std::uint64_t bytes_per_player_second() const;
};

/// How a peer is doing, for display.
struct PeerQuality {
    bool connected = false;
    std::uint32_t ping_ms = 0;    ///< round trip
    std::int32_t ticks_ahead = 0; ///< of this machine, by both sides' own counts; negative: the peer is ahead
    std::uint64_t hashes_agreed = 0; ///< ticks [0, n) compared and equal
};

// ---- where two states part -----------------------------------------------------------------------------------------

/// A tick that was run again, from the state before it.
struct Rerun {
    std::vector<PhaseHash> phases; ///< empty: the simulation has none
    std::uint64_t hash = 0;        ///< after the tick, as Simulation::hash gives it
};

/// Shows a session what this machine held, so that it and a peer can find out where they part. SessionRunner brings one.
class StateInspector {
  public:
    virtual ~StateInspector() = default;
    /// The state after tick `tick`; null where it is not kept any more. Valid until the next call.
    virtual const State* state_after(std::uint64_t tick) = 0;
    /// Runs the tick again and comes back to the present. Without the state before it: empty.
    virtual Rerun run_again(std::uint64_t tick, std::span<const PlayerInput> inputs) = 0;
};

// ---- the session -------------------------------------------------------------------------------------------------

class Session {
  public:
    virtual ~Session() = default;
    /// Receives packets, then sends every peer one packet with what it lacks. Call each frame, also when waiting. Time
    /// comes from outside, in milliseconds from any origin; an earlier time than before counts as the same.
    virtual void poll(std::uint64_t now_ms) = 0;
    /// The input of a local player at tick current_tick() + input_delay. A sync test has no delay. Once per tick: repeated before the tick has run
    /// (a stall), the first stands. Another size, or a player of another machine or of none, asserts.
    virtual void add_local_input(std::uint32_t player, std::span<const std::byte> input) = 0;
    /// Corrects the past if inputs have arrived that differ from the guesses, then runs the next tick if it may.
    virtual Step advance() = 0;
    /// The same without a new tick, for the end of a match: only what ran on wrong guesses runs again. Never stalls.
    virtual Step settle() = 0;
    /// After each Advance: the hash of the state after tick `tick`. Required, all else rests on it. A tick that was not
    /// asked for asserts.
    virtual HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) = 0;
    /// After each Adopt: whether the state was taken, and its hash.
    virtual void report_adopted(const Status& taken, std::uint64_t hash) { (void)taken, (void)hash; }
    /// In order, each tick exactly once. Take all of them before the next advance (asserted).
    virtual std::optional<ConfirmedTick> next_confirmed() = 0;
    virtual std::optional<Notice> next_notice() = 0;

    /// This machine wants a peer to leave. Between two machines it has left at the next poll; among more it leaves when most of
    /// the others want it too, see src/session/README.md. Refuses a machine that is not a peer of this match.
    virtual Status drop_peer(PeerId peer) = 0;

    /// Whom to ask when a peer holds another state; not owned, null: nobody. False: this session never asks.
    virtual bool set_inspector(StateInspector*) { return false; }
    /// Asks this one no more. Where another one has been set since, nothing changes.
    virtual void drop_inspector(const StateInspector&) {}

    virtual std::uint64_t current_tick() const = 0; ///< the next new tick
    /// What tick current_tick() + `offset` would run on by what is known now; `offset` below SessionDef::run_ahead. Empty: nothing is
    /// shown ahead. Valid until the session's next call.
    virtual std::span<const PlayerInput> look_ahead(std::uint32_t offset) {
        (void)offset;
        return {};
    }
    virtual std::uint32_t
    images_max() const = 0; ///< saved states alive at once: ticks t and t + images_max() may share a slot
    virtual void
    set_input_delay(std::uint32_t ticks) = 0; ///< 0..32, at any time; lockstep: at least 1 (asserted)
    virtual PeerQuality quality(PeerId peer) const = 0; ///< of nobody in this match: not connected, all zero
    virtual const SessionStats& stats() const = 0;

    /// Expires when the session is destroyed. A runner compares it before each call.
    std::weak_ptr<const void> lifetime() const { return alive; }

  private:
    std::shared_ptr<const void> alive = std::make_shared<std::byte>();
};

/// Predicts remote inputs, rolls back when it was wrong. Errors name the field of `def` that is out of range.
Result<std::unique_ptr<Session>> make_rollback_session(const SessionDef& def, Transport& transport);
/// Runs a tick only when all its inputs are here: never loads, never saves. The input delay hides the latency; among three
/// or more machines the way there and back, since a tick is run only when all others are known to have its inputs too.
Result<std::unique_ptr<Session>> make_lockstep_session(const SessionDef& def, Transport& transport);
/// One machine, all players local: every tick, rolls back `depth` ticks (1..64), runs them again and compares hashes.
/// A tick is confirmed after `depth` re-runs. First runs have status `predicted`, so that a game whose rules read the
/// status is caught.
Result<std::unique_ptr<Session>> make_sync_test_session(const SessionDef& def, std::uint32_t depth);

// ---- executing requests ------------------------------------------------------------------------------------------

/// What sessions drive: a world and its rules, or a test's stand-in.
class Simulation {
  public:
    virtual ~Simulation() = default;
    virtual void save(Image& image) const = 0;
    virtual void restore(const Image& image) = 0;
    virtual void advance(std::span<const PlayerInput> inputs) = 0; ///< one tick
    virtual std::uint64_t hash() const = 0;
    /// Events of the last tick. A session sorts those that are not in the order of `precedes`, and of equal ones it takes the first.
    virtual std::span<const Event> events() const = 0;
    virtual State& state() = 0; ///< for diagnosis: naming a difference, planting a fault
    /// Takes a state from outside. On an error, a sentence, the present one stays.
    virtual Status adopt(std::span<const std::byte> portable_image) {
        return state().restore_portable(portable_image);
    }
    /// Takes the state before tick `tick` of the session: a simulation that counts its ticks refuses a state of another tick. Runners call
    /// this function.
    virtual Status adopt_at(std::uint64_t tick, std::span<const std::byte> portable_image) {
        (void)tick;
        return adopt(portable_image);
    }
    /// Runs a tick from the state of `before`, with the hashes of its phases, and leaves the present state and all that listens to
    /// it alone. Nothing: it cannot, and is driven there and back instead.
    virtual std::optional<Rerun> run_aside(const Image& before, std::span<const PlayerInput> inputs) {
        (void)before, (void)inputs;
        return {};
    }
    /// Whether ticks from now on note a hash after each of their phases, and those of the last tick.
    virtual void record_phase_hashes(bool) {}
    virtual std::span<const PhaseHash> phase_hashes() const { return {}; }
};

/// The world outlives it and stays where it is: to use it afterwards ends the program with a sentence.
class WorldSimulation final : public Simulation {
  public:
    WorldSimulation(World& driven, const Game& rules)
        : world(driven), lifetime(driven.lifetime()), game(rules) {}
    void save(Image& image) const override;
    void restore(const Image& image) override;
    void advance(std::span<const PlayerInput> inputs) override;
    std::uint64_t hash() const override;
    std::span<const Event> events() const override;
    State& state() override;
    Status adopt(std::span<const std::byte> portable_image) override; ///< World's checks, then Game::check
    /// Also refuses a state whose tick_count() is not that of Game::start() and `tick` more.
    Status adopt_at(std::uint64_t tick, std::span<const std::byte> portable_image) override;
    std::optional<Rerun> run_aside(const Image& before, std::span<const PlayerInput> inputs) override;
    void record_phase_hashes(bool on) override;
    std::span<const PhaseHash> phase_hashes() const override;
    /// The first error of the rules, for display. The tick was run all the same, on every machine alike; it may have
    /// rested on a guess that did not come true.
    const Status& failure() const { return first_failure; }

  private:
    World& living() const;
    Status adopt_if(std::span<const std::byte> portable_image, std::optional<std::uint64_t> tick_count);
    World& world;
    std::weak_ptr<const void> lifetime;
    const Game& game;
    Status first_failure;
};

/// Sees the confirmed timeline: every tick once, in order, however often it was run. A replay recorder's place.
class ConfirmedSink {
  public:
    virtual ~ConfirmedSink() = default;
    virtual void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs,
                              std::uint64_t hash) = 0;
};

enum class EventStatus : std::uint8_t {
    predicted, ///< seen in a tick that may run again: play the sound, spawn the particles
    confirmed, ///< it happened: count the score. Events first seen in a confirmed tick come with this status only
    cancelled, ///< it did not happen after all: fade the sound out
};
/// Every predicted event is confirmed or cancelled later, exactly once, under the same id. Two runs of a tick show the
/// same event when kind, shapes and bodies agree; point and speed may differ, the confirmed ones are true.
struct SessionEvent {
    Event event;
    EventStatus status;
    std::uint64_t id; ///< of this machine, never used again
};

/// The first difference between two runs of the same tick with the same inputs.
struct SyncTestFailure {
    enum class When {
        restored,    ///< loading a state did not bring back what was saved
        resimulated, ///< running the tick again gave another state
    } when;
    std::uint64_t tick; ///< restored: before which the state was saved; resimulated: which ran again
    std::uint64_t first_hash, second_hash;
    std::vector<Difference> differences; ///< first run left, second run right; at most 8
};
/// "tick 118, resimulated: column body.velocity, row 7, linear.x: 1 (raw 0x80000) against 2 (raw 0x100000)"
std::string to_string(const SyncTestFailure& failure);

struct RunnerDef {
    ConfirmedSink* sink = nullptr; ///< not owned
    /// How many of the newest states are kept beside what rollbacks need, so that a desync can be named whose first tick lies
    /// that far back: the round trip, and what lost packets add. Each takes the memory of an image. 0: desyncs name a tick, and
    /// this machine has no state for those who come (lockstone/session/join.h) or watch from one: they ask another one.
    std::uint32_t inspected_ticks = 64;
};

struct Frame {
    Stall stall;              ///< none: one tick further
    std::uint32_t wait_ticks; ///< Step::wait_ticks
};

/// Executes a session's requests on a simulation with a ring of images allocated once, and reconciles events. The simulation outlives the
/// runner. After the session was destroyed, the runner may be destroyed, and any other call ends the program with a sentence. Where
/// SessionDef::run_ahead is set, the simulation is that far ahead between two calls, and at the present tick when the sink is called, in drain()
/// and when the runner is destroyed. A call of a runner that was moved from ends the program with a sentence.
class SessionRunner {
  public:
    SessionRunner(Session& session, Simulation& simulation, RunnerDef def = {});
    SessionRunner(SessionRunner&&) noexcept;
    SessionRunner& operator=(SessionRunner&&) noexcept;
    ~SessionRunner();

    Frame frame(std::uint64_t now_ms); ///< poll, advance, execute, confirm
    /// A frame without a new tick, when wait_ticks asks for it: poll only.
    void wait(std::uint64_t now_ms);
    /// The end of a match: instead of frame(), each frame, until it returns true. No new tick is run; what was run is
    /// settled, confirmed and handed to the sink. Every machine goes on to the same tick first (Session::current_tick),
    /// and gives inputs up to there: what is not given is never confirmed.
    bool drain(std::uint64_t now_ms);
    /// Of the last frame: by tick, then in the order of the tick's events.
    std::span<const SessionEvent> events() const;
    /// What the session asks where states part.
    StateInspector& inspector();
    /// The first failure of a sync test; null while there is none.
    const SyncTestFailure* sync_failure() const;

  private:
    struct Impl;
    Impl& inside() const;
    std::unique_ptr<Impl> impl;
};

} // namespace lockstone
