// The inputs of one player: true inputs, predictions that ticks ran on, and the first tick where they differ.
//
//      forgotten |  confirmed, still needed  | predictions that ticks ran on | unused
//               oldest                      next                          used_end
//
// `next` is the first tick without a known true input. The cut of a departure may lie before `next`, because some
// remaining machines may lack the last inputs. The ring has a fixed size: nothing is allocated after the
// constructor, and no input beyond the ring is accepted.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

/// Capacity of a ring of inputs or hashes [ticks]. Half of it is for confirmed entries; the other half
/// always has space for the predictions after them (prediction_limit), whatever peers send.
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

    /// Number of further confirmed inputs that fit.
    std::uint64_t room() const { return history_confirmed_max - (first_unknown - first_kept); }
    /// Stores the true input of tick next(). Requires room() > 0. Ignored from the tick of a departure on.
    void confirm(std::span<const std::byte> input);
    /// The confirmed input of a tick in [oldest, next).
    std::span<const std::byte> confirmed(std::uint64_t tick) const { return slot(tick); }
    /// The confirmed input of the tick before `tick` <= next, zeros before tick 0: the reference of an
    /// input's code. Also for forgotten ticks, as long as the ring holds them; empty: too old.
    std::optional<std::span<const std::byte>> before(std::uint64_t tick) const;

    /// The input that tick `tick` runs on: the true one, else a prediction, which the queue stores; zeros
    /// from a departure on.
    PlayerInput use(std::uint64_t tick, const InputPredictor& predictor);
    /// Writes the input that tick `tick` >= oldest() would run on to `out`. An unknown input is the last
    /// true one if `held`, else a prediction. The queue does not change.
    InputStatus foresee(std::uint64_t tick, const InputPredictor& predictor, bool held,
                        std::span<std::byte> out) const;
    /// The input of a settled tick, as in the confirmed timeline.
    PlayerInput settled(std::uint64_t tick) const;

    /// The first tick since the last call that ran on a wrong prediction; `never`: none.
    std::uint64_t take_first_wrong();

    /// Sets the cut: the inputs of tick `tick` and later ones are zero and settled, also where true inputs
    /// are known. At most once. Ticks that ran on other inputs count as wrong.
    void disconnect_at(std::uint64_t tick);
    std::uint64_t disconnected_at() const { return cut; } ///< `never`: the player has not left
    bool disconnected() const { return cut != never; }

    /// For a machine that joins a match: the first input is that of `tick`.
    void begin_at(std::uint64_t tick);
    /// Sets the input of the tick before it, the reference of the first input's code.
    void set_before_begin(std::span<const std::byte> input);
    /// The player returns: its inputs count from tick `tick` on. No later tick may be confirmed yet.
    void return_at(std::uint64_t tick);
    /// True if the inputs of tick `tick` are zero because the player had left and had not returned.
    bool is_absent(std::uint64_t tick) const { return tick >= cut || (tick >= left_at && tick < begin); }

    /// Forgets inputs before `tick`, but not the newest confirmed one, which predictions need.
    void forget_before(std::uint64_t tick);

  private:
    std::span<std::byte> slot(std::uint64_t tick);
    std::span<const std::byte> slot(std::uint64_t tick) const;

    std::uint32_t player_index;
    std::uint32_t size; ///< length of an input [bytes]
    std::vector<std::byte> ring;
    std::uint64_t first_kept = 0;
    std::uint64_t first_unknown = 0;
    std::uint64_t used_end = 0; ///< ticks below have run
    std::uint64_t first_wrong = never;
    std::uint64_t cut = never;
    std::uint64_t left_at = never; ///< tick of the departure before the last return
    std::uint64_t begin = 0;       ///< the first tick with known inputs, or the tick of the last return
    bool has_before_begin = true;
};

} // namespace lockstone::session
