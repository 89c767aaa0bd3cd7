#include "solve/joints/joint_strands.h"

#include "base/joined.h"
#include "base/text.h"
#include "solve/bodies/sides.h"

#include <algorithm>
#include <array>

namespace lockstone::solve {

namespace {

/// Least number of joints per strand, and of joints per stage, for which several workers pay off.
constexpr std::size_t strand_joints_least = 64, stage_joints_least = 16;
constexpr std::uint32_t joint_strands_max = 8;

/// Position of a body that the joint moves, or zero.
Vec3 place_of(const JointTick& tick, const JointWork& w) {
    const JointWorkSide& side = w.a.moved ? w.a : w.b;
    return side.moved ? tick.pose[side.body].position : Vec3{};
}

/// Builds the pieces of one pass. `step_at` maps the position in the pass to the step: forward or in reverse.
template <class StepAt>
void plan_pass(JointTick& tick, std::uint32_t strands, const StepAt& step_at, base::StrandPlan& plan) {
    plan.clear();
    plan.strands = strands;
    tick.last_piece.assign(tick.bodies.size(),
                           0); // by body: strand and number (from 1) of the last piece that moves it
    std::uint32_t seen[joint_strands_max][joint_strands_max] =
        {}; // [a][b]: number of pieces of strand b that strand a has waited for
    for (std::uint32_t k = 0; k < tick.steps.size(); ++k) {
        const std::uint32_t at = step_at(k);
        const JointStep& step = tick.steps[at];
        if (step.first_joint == step.last_joint) continue;
        std::uint32_t wanted[joint_strands_max] = {};
        const std::uint32_t number = plan.count(step.strand) + 1;
        for (std::uint32_t i = step.first_joint; i < step.last_joint; ++i) {
            const JointWork& w = tick.joints[tick.in_order[i]];
            for (const JointWorkSide* side : {&w.a, &w.b}) {
                if (!side->moved) continue;
                std::uint32_t& last = tick.last_piece[side->cache];
                std::uint32_t& before = wanted[last % joint_strands_max];
                before = std::max(before, last / joint_strands_max);
                last = number * joint_strands_max + step.strand;
            }
        }
        base::Piece piece{at, at + 1, static_cast<std::uint32_t>(plan.waits.size()), 0};
        for (std::uint32_t other = 0; other < strands; ++other) {
            if (other == step.strand || wanted[other] <= seen[step.strand][other]) continue;
            seen[step.strand][other] = wanted[other];
            plan.waits.push_back({other, wanted[other], false});
        }
        piece.last_wait = static_cast<std::uint32_t>(plan.waits.size());
        piece.order = k;
        plan.pieces[step.strand].push_back(piece);
    }
}

} // namespace

/// Assigns whole islands of joints to strands, in order, so that few packs contain joints of two strands. Returns
/// false if an island is so large that the strands would be unequal.
static bool share_out_islands(JointTick& tick, std::uint32_t strands) {
    std::vector<std::uint32_t>& parent = tick.last_piece;
    base::start_sets(parent, tick.bodies.size());
    for (const JointWork& w : tick.joints)
        if (w.a.moved && w.b.moved) base::join(parent, w.a.cache, w.b.cache);
    const auto island_of = [&](const JointWork& w) {
        return base::root_of(parent, w.a.moved ? w.a.cache : w.b.cache);
    };
    std::vector<std::uint32_t>& count_of = tick.last_stage; // by root: joints of the island; later its strand
    count_of.assign(tick.bodies.size(), 0);
    std::uint32_t most = 0;
    for (const JointWork& w : tick.joints)
        if (w.a.moved || w.b.moved) most = std::max(most, ++count_of[island_of(w)]);
    const auto joints = static_cast<std::uint32_t>(tick.joints.size());
    if (std::uint64_t{most} * strands * 4 > joints) return false;
    constexpr std::uint32_t is_placed = 1u << 31;
    std::uint32_t placed = 0;
    for (JointWork& w : tick.joints) {
        if (!w.a.moved && !w.b.moved) continue;
        std::uint32_t& island = count_of[island_of(w)];
        if ((island & is_placed) == 0) {
            const auto strand = static_cast<std::uint32_t>(std::uint64_t{placed} * strands / joints);
            placed += island;
            island = is_placed | strand;
        }
        w.strand = island & ~is_placed;
    }
    return true;
}

std::uint32_t share_out(JointTick& tick, std::uint32_t stage_count, std::uint32_t workers) {
    const std::size_t joints = tick.joints.size();
    const std::uint32_t most = std::min(workers, joint_strands_max);
    for (JointWork& w : tick.joints) w.strand = 0;
    if (most < 2 || joints < strand_joints_least * 2 || joints < stage_joints_least * stage_count) return 1;
    const std::uint32_t strands =
        static_cast<std::uint32_t>(std::min<std::size_t>(joints / strand_joints_least, most));
    const bool by_island = share_out_islands(tick, strands);
    tick.paths.take(by_island, base::Path::joint_strands_by_place, base::Path::joint_strands_by_island);
    if (by_island) return strands;
    std::array<Vec3, Sides::samples_max> sample;
    std::size_t samples = 0;
    for (std::size_t i = 0; i < joints; i += Sides::stride_of(joints))
        sample[samples++] = place_of(tick, tick.joints[tick.in_order[i]]);
    const Sides sides{std::span<const Vec3>(sample).first(samples), strands};
    for (JointWork& w : tick.joints) w.strand = sides.side_of(place_of(tick, w));
    return strands;
}

void find_borders(JointTick& tick) {
    constexpr std::uint32_t several = 0xffffffffu;
    std::vector<std::uint32_t>& strand_of =
        tick.last_piece; // by body: strand that moves it + 1, or `several`
    strand_of.assign(tick.bodies.size(), 0);
    const auto for_moved = [&](const JointWork& w, auto&& visit) {
        for (const JointWorkSide* side : {&w.a, &w.b})
            if (side->moved) visit(strand_of[side->cache]);
    };
    for (const JointWork& w : tick.joints)
        for_moved(w, [&](std::uint32_t& strand) {
            strand = strand == 0 || strand == w.strand + 1 ? w.strand + 1 : several;
        });
    for (JointWork& w : tick.joints) {
        w.is_inner = true;
        for_moved(w, [&](const std::uint32_t& strand) { w.is_inner = w.is_inner && strand != several; });
    }
}

void plan_strands(JointTick& tick, std::uint32_t strands) {
    tick.down.clear(), tick.up.clear();
    if (strands == 1) return;
    const std::uint32_t of_stage = 2 * strands,
                        stages = static_cast<std::uint32_t>(tick.steps.size()) / of_stage;
    plan_pass(
        tick, strands, [](std::uint32_t k) { return k; }, tick.down);
    // Stages in reverse order; within a stage, border steps come first here too.
    plan_pass(
        tick, strands, [&](std::uint32_t k) { return (stages - 1 - k / of_stage) * of_stage + k % of_stage; },
        tick.up);
}

namespace {

/// The joints of a step without duplicates, sorted: those of its packs and its singles.
CheckVector<std::uint32_t> joints_of(const JointTick& tick, const JointStep& step) {
    CheckVector<std::uint32_t> joints(tick.singles.begin() + step.first_single,
                                      tick.singles.begin() + step.last_single);
    for (std::uint32_t p = step.first_pack; p < step.last_pack; ++p)
        for (std::uint32_t lane = 0; lane < tick.packs[p].count; ++lane)
            joints.push_back(tick.packed[p * pack_lanes + lane]);
    std::ranges::sort(joints);
    joints.erase(std::unique(joints.begin(), joints.end()), joints.end());
    return joints;
}

std::uint32_t moved_body(const JointWorkSide& side) { return side.moved ? side.body : no_body; }

/// Joints as a pass solves them. In reverse the last joint of the list has rank 0. `item` returns the number of a
/// step.
template <class Item>
CheckVector<Solved> solved_in_steps(const JointTick& tick, bool forwards, const Item& item) {
    CheckVector<Solved> solved;
    const auto last = static_cast<std::uint32_t>(tick.joints.size()) - 1;
    for (std::uint32_t k = 0; k < tick.steps.size(); ++k)
        for (const std::uint32_t i : joints_of(tick, tick.steps[k]))
            solved.push_back({item(k),
                              forwards ? i : last - i,
                              {moved_body(tick.joints[i].a), moved_body(tick.joints[i].b)}});
    return solved;
}

/// Describes a body that belongs to two trees, which may not happen, since trees are solved in any order.
std::string tree_fault(const JointTick& tick) {
    const JointForest& f = tick.forest;
    CheckVector<std::uint32_t> bodies;
    for (const JointTree& tree : f.trees)
        for (std::uint32_t i = 0; i < tree.node_count; ++i)
            bodies.push_back(f.nodes[tree.first_node + i].body);
    std::ranges::sort(bodies);
    const auto twice = std::ranges::adjacent_find(bodies);
    return twice == bodies.end() ? std::string() : base::join("body ", *twice, " is in two trees");
}

} // namespace

void count_step(JointTick& tick, const JointStep& step, std::uint32_t pass, bool forwards) {
    if constexpr (checks_order) {
        const auto last = static_cast<std::uint32_t>(tick.joints.size()) - 1;
        for (const std::uint32_t i : joints_of(tick, step))
            for (const JointWorkSide* side : {&tick.joints[i].a, &tick.joints[i].b})
                tick.counter.move(pass, forwards ? i : last - i, moved_body(*side));
    }
}

std::string order_fault(const JointTick& tick) {
    const base::StrandPlan in_turn{};
    const auto count = static_cast<std::uint32_t>(tick.steps.size());
    const auto same = [](std::uint32_t k) { return k; };
    const auto backwards = [&](std::uint32_t k) { return count - 1 - k; };
    std::string fault = order_fault(in_turn, solved_in_steps(tick, true, same));
    if (fault.empty()) fault = order_fault(in_turn, solved_in_steps(tick, false, backwards));
    if (fault.empty() && tick.down.strands != 0)
        fault = order_fault(tick.down, solved_in_steps(tick, true, same));
    if (fault.empty() && tick.up.strands != 0)
        fault = order_fault(tick.up, solved_in_steps(tick, false, same));
    if (fault.empty()) fault = tree_fault(tick);
    return fault.empty() ? fault : "joints: " + fault;
}

void note_plan(const JointTick& tick, const Tasks* tasks) {
    using base::Path;
    const auto joints = static_cast<std::uint32_t>(tick.with_rows.size()),
               packs = static_cast<std::uint32_t>(tick.packs.size()),
               trees = static_cast<std::uint32_t>(tick.forest.trees.size());
    tick.paths.take(tick.down.strands != 0, Path::joints_one_strand, Path::joints_many_strands);
    tick.paths.take(trees != 0, Path::joints_without_trees, Path::joints_with_trees);
    if (packs != 0) tick.paths.take(Path::joint_in_pack);
    if (!tick.singles.empty()) tick.paths.take(Path::joint_one_by_one);
    tick.paths.take(base::is_shared(tasks, joints, joint_chunk), Path::joints_by_one,
                    Path::joints_by_workers);
    tick.paths.take(base::is_shared(tasks, packs, pack_chunk_of(packs)), Path::joint_packs_by_one,
                    Path::joint_packs_by_workers);
    tick.paths.take(base::is_shared(tasks, trees, tree_chunk), Path::trees_by_one, Path::trees_by_workers);
}

} // namespace lockstone::solve
