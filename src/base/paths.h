// The execution paths that a tick took, for tests.
//
// A tick chooses between paths by sizes, workers, lanes and caches: one strand or several, kept packs or new packs.
// All paths give equal bits, so no hash shows which path ran. Each place that chooses adds the name of its path to a
// set, and tests read the set to check which paths their worlds reach. The set is not part of the state, and no
// result depends on it.
// Long: a line for each choice.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <string_view>

// clang-format off
/// X(name) for each path. The alternatives of one choice are on one line.
#define LOCKSTONE_PATHS(X)                                                                                   \
    /* the whole tick */                                                                                     \
    X(one_worker) X(many_workers)                                                                            \
    X(lanes_scalar) X(lanes_wide)                                                                            \
    X(step_kept) X(step_new)                                                                                 \
    X(solvers_in_turn) X(solvers_at_once)                                                                    \
    X(shared_rows_all_compared) X(shared_rows_beyond)                                                        \
    X(nothing_woken) X(islands_woken)                                                                        \
    X(nothing_falls_asleep) X(islands_fall_asleep)                                                           \
    /* where shapes are, and which of them are near */                                                       \
    X(resting_kept) X(resting_looked_at)                                                                     \
    X(bounds_by_one) X(bounds_by_workers)                                                                    \
    X(shapes_in_lanes) X(shapes_one_by_one)                                                                  \
    X(shapes_none_left) X(shapes_left_by_lanes)                                                              \
    X(leaves_kept) X(leaves_left)                                                                            \
    X(tree_updated) X(tree_rebuilt)                                                                          \
    X(leaves_moved_one_by_one) X(leaves_refit_at_once)                                                       \
    X(leaf_pairs_kept) X(leaf_pairs_found)                                                                   \
    X(pairs_listed) X(pairs_in_crowd)                                                                        \
    X(pair_filter_kept) X(pair_filter_new)                                                                   \
    X(fresh_pairs_by_one) X(fresh_pairs_by_workers)                                                          \
    X(overlaps_by_one) X(overlaps_by_workers)                                                                \
    X(keys_by_one) X(keys_by_workers)                                                                        \
    X(near_by_one) X(near_by_workers)                                                                        \
    X(near_all) X(near_cut)                                                                                  \
    /* manifolds, and the table of contacts */                                                               \
    X(collide_by_one) X(collide_by_workers)                                                                  \
    X(window_partial) X(window_full)                                                                         \
    X(manifold_kept) X(manifold_made)                                                                        \
    X(pair_looked_at) X(pair_still_parted)                                                                   \
    X(contact_rows_in_place) X(contact_rows_moved)                                                           \
    X(chunks_copied_by_one) X(chunks_copied_by_workers)                                                      \
    X(contacts_all_fit) X(contacts_dropped)                                                                  \
    X(results_by_one) X(results_by_workers)                                                                  \
    X(table_by_one) X(table_by_workers)                                                                      \
    /* bodies */                                                                                             \
    X(bodies_by_one) X(bodies_by_workers)                                                                    \
    X(moves_by_one) X(moves_by_workers)                                                                      \
    X(ends_in_lanes) X(ends_left_by_lanes)                                                                   \
    X(starts_shared) X(starts_alone)                                                                         \
    X(turn_by_midpoint) X(turn_far)                                                                          \
    X(turns_not_followed) X(turns_followed)                                                                  \
    X(followed_by_one) X(followed_by_workers)                                                                \
    X(fluids_by_one) X(fluids_by_workers)                                                                    \
    /* contacts */                                                                                           \
    X(order_kept) X(order_found)                                                                             \
    X(packs_kept) X(packs_made)                                                                              \
    X(contacts_one_strand) X(contacts_many_strands)                                                          \
    X(strands_by_island) X(strands_by_order) X(strands_by_place)                                             \
    X(packs_without_grace) X(packs_with_grace)                                                               \
    X(packs_in_cache) X(packs_beyond_cache)                                                                  \
    X(passes_one_by_one) X(passes_in_one_run) X(passes_by_island)                                            \
    X(packs_by_one) X(packs_by_workers)                                                                      \
    X(contacts_do_not_bounce) X(contacts_bounce)                                                             \
    X(contacts_do_not_roll) X(contacts_roll)                                                                 \
    X(none_pressed) X(some_pressed)                                                                          \
    /* joints */                                                                                             \
    X(joint_plan_kept) X(joint_plan_made)                                                                    \
    X(joints_one_strand) X(joints_many_strands)                                                              \
    X(joint_strands_by_island) X(joint_strands_by_place)                                                     \
    X(joints_without_trees) X(joints_with_trees)                                                             \
    X(tree_solved_at_once) X(tree_solved_in_passes)                                                          \
    X(trees_by_one) X(trees_by_workers)                                                                      \
    X(joint_in_pack) X(joint_one_by_one)                                                                     \
    X(joint_rows_kept) X(joint_rows_remade)                                                                  \
    X(joint_points_left) X(joint_points_closed)                                                              \
    X(joints_by_one) X(joints_by_workers)                                                                    \
    X(joint_packs_by_one) X(joint_packs_by_workers)                                                          \
    X(held_by_one) X(held_by_workers)                                                                        \
    X(stiffness_by_one) X(stiffness_by_workers)                                                              \
    /* vehicles, and what moves fast */                                                                      \
    X(vehicles_alone) X(vehicles_in_convoy)                                                                  \
    X(wheel_small) X(wheel_real)                                                                             \
    X(sweep_by_one) X(sweep_by_workers)                                                                      \
    X(driven_compared) X(driven_in_trees)                                                                    \
    X(sweep_stops_none) X(sweep_stops_some)                                                                  \
    X(sweep_without_bullets) X(sweep_with_bullets)
// clang-format on

namespace lockstone::base {

#define LOCKSTONE_PATH(name) name,
enum class Path : std::uint8_t { LOCKSTONE_PATHS(LOCKSTONE_PATH) };
#undef LOCKSTONE_PATH

/// Names of the paths, indexed by Path.
#define LOCKSTONE_PATH(name) #name,
inline constexpr std::string_view path_names[] = {LOCKSTONE_PATHS(LOCKSTONE_PATH)};
#undef LOCKSTONE_PATH

inline constexpr std::size_t path_count = std::size(path_names);

/// A set of paths. It adds bits by atomic operations, so workers may share a set.
class Paths {
  public:
    void take(Path path) const {
        const auto number = static_cast<std::size_t>(path);
        const std::uint64_t bit = std::uint64_t{1} << number % 64;
        const std::atomic_ref<std::uint64_t> word(words[number / 64]);
        if ((word.load(std::memory_order_relaxed) & bit) == 0) word.fetch_or(bit, std::memory_order_relaxed);
    }
    /// Adds `second` if `is_second` is true, else `first`.
    void take(bool is_second, Path first, Path second) const { take(is_second ? second : first); }
    bool has(Path path) const {
        const auto number = static_cast<std::size_t>(path);
        return ((words[number / 64] >> number % 64) & 1u) != 0;
    }
    void add(const Paths& more) {
        for (std::size_t i = 0; i < words.size(); ++i) words[i] |= more.words[i];
    }
    void clear() { words = {}; }

  private:
    /// Mutable, because functions that change no state of their own record paths too. No result depends on it.
    mutable std::array<std::uint64_t, (path_count + 63) / 64> words{};
};

} // namespace lockstone::base
