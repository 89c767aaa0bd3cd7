// One player's inputs over time: the true ones, the guesses that were run instead, and where they first differ.
//
//      forgotten |  confirmed, still needed  | guesses that ticks have run on | unused
//               oldest                      next                           used_end
//
// Where a player leaves may lie before `next`: not all machines that remain have the last inputs.
//
// `next` is the first tick whose true input is unknown. A ring of fixed size: nothing is allocated after the
// constructor, and nothing beyond the ring is ever accepted.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

/// Ticks that a ring of inputs or hashes holds. Half of it is for confirmed entries; the other half leaves room for
/// the guesses after them (prediction_limit) whatever peers send.
inline constexpr std::uint64_t history_ticks = 512;
inline constexpr std::uint64_t history_confirmed_max = history_ticks / 2;
inline constexpr std::uint64_t never = ~std::uint64_t{0};

class InputQueue {
  public:
    InputQueue(std::uint32_t player, std::uint32_t input_size);

    std::uint32_t player() const { return player_index; }
    std::uint64_t next() const { return first_unknown; }
    /// Ticks below are settled: their inputs are confirmed, or the player has left.
    std::uint64_t settled_through() const { return first_unknown >= cut ? never : first_unknown; }
    std::uint64_t oldest() const { return first_kept; }

    /// How many more confirmed inputs fit.
    std::uint64_t room() const { return history_confirmed_max - (first_unknown - first_kept); }
    /// The true input of tick next(). Needs room; ignored from the tick of a disconnection on.
    void confirm(std::span<const std::byte> input);
    /// The confirmed input of a tick in [oldest, next).
    std::span<const std::byte> confirmed(std::uint64_t tick) const { return slot(tick); }
    /// The confirmed input before tick `tick` <= next, zeros before tick 0: what inputs are told as the difference to. It
    /// outlives being forgotten for a while; nothing where it is too old.
    std::optional<std::span<const std::byte>> before(std::uint64_t tick) const;

    /// What tick `tick` runs on: the true input, else a guess, which is remembered; zeros from a disconnection on.
    PlayerInput use(std::uint64_t tick, const InputPredictor& predictor);
    /// What tick `tick` >= oldest() would run on by what is known, into `out`: the last true input is `held`, or else it is guessed.
    /// Changes nothing.
    InputStatus foresee(std::uint64_t tick, const InputPredictor& predictor, bool held,
                        std::span<std::byte> out) const;
    /// The input of a settled tick, as the confirmed timeline shows it.
    PlayerInput settled(std::uint64_t tick) const;

    /// The first tick that ran on a guess which proved wrong, since the last call; `never` when there is none.
    std::uint64_t take_first_wrong();

    /// The player's inputs end here: tick `tick` and all after it are zero and settled, true inputs among them too. At
    /// most once. Ticks that ran on something else are wrong.
    void disconnect_at(std::uint64_t tick);
    std::uint64_t disconnected_at() const { return cut; } ///< `never` while the player is there
    bool disconnected() const { return cut != never; }

    /// The queue of a match that this machine comes into: its first input is that of `tick`.
    void begin_at(std::uint64_t tick);
    /// And the one before it, which inputs are told as the difference to.
    void set_before_begin(std::span<const std::byte> input);
    /// The player, who has left, is back: its inputs count from tick `tick` on, which no other tick has been confirmed after.
    void return_at(std::uint64_t tick);
    /// Whether the inputs of tick `tick` are zero because the player had left by then and was not back.
    bool is_absent(std::uint64_t tick) const { return tick >= cut || (tick >= left_at && tick < begin); }

    /// Ticks before `tick` are needed no more. The newest confirmed one stays: guesses are made from it.
    void forget_before(std::uint64_t tick);

  private:
    std::span<std::byte> slot(std::uint64_t tick);
    std::span<const std::byte> slot(std::uint64_t tick) const;

    std::uint32_t player_index;
    std::uint32_t size; ///< bytes of an input
    std::vector<std::byte> ring;
    std::uint64_t first_kept = 0;
    std::uint64_t first_unknown = 0;
    std::uint64_t used_end = 0; ///< ticks below have run
    std::uint64_t first_wrong = never;
    std::uint64_t cut = never;
    std::uint64_t left_at = never; ///< where it had left before it came back
    std::uint64_t begin = 0;       ///< the first tick that inputs are known of, or where it came back
    bool has_before_begin = true;
};

} // namespace lockstone::session
