// Planning of packs in the order of solving, and transfer of data to and from their lanes.
#include "solve/joints/pack/joint_point.h"

#include "solve/joints/joint_strands.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// True if a pack takes the point of a joint.
bool is_packed(const JointWork& w, const SolverBodies& bodies) {
    return w.point && w.tree == no_tree && fits_pack(w.a.body, bodies) && fits_pack(w.b.body, bodies);
}

void find_stage(JointTick& tick, JointWork& w, const SolverBodies& bodies) {
    for (JointWorkSide* side : {&w.a, &w.b}) side->moved = !side->world && bodies.step[side->body].movable;
    const auto last = [&](const JointWorkSide& side) -> std::uint32_t* {
        return side.moved ? &tick.last_stage[side.cache] : nullptr;
    };
    std::uint32_t *a = last(w.a), *b = last(w.b);
    w.stage = std::max(a != nullptr ? *a : 0, b != nullptr ? *b : 0);
    if (a != nullptr) *a = w.stage + 1;
    if (b != nullptr) *b = w.stage + 1;
}

std::uint32_t place_of(std::uint32_t body) { return body * static_cast<std::uint32_t>(sizeof(SolverBody)); }

void set_share(PackSide& side, unsigned lane, Share share, const JointWorkSide& own) {
    side.place[lane] = place_of(own.body);
    side.moved |= (own.moved ? 1u : 0u) << lane;
    side.share[lane] = share.mantissa;
    side.shift[lane] = share.shift;
    side.half[lane] = share.shift != 0 ? std::int64_t{1} << (share.shift - 1) : 0;
    side.shifts = side.shifts || share.shift != 0;
}

/// Kinds of packs: 0 to 3 rows without linear part, hinges, or no pack.
constexpr std::uint32_t pack_kinds = 6, hinge_kind = 4, no_kind = 5;
std::uint32_t kind_of(const JointTick& tick, const JointWork& w) {
    if (w.pack == no_pack) return no_kind;
    if (w.hinge) return hinge_kind;
    return w.turns_packed ? tick.blocks[w.first_block].count : 0;
}

/// True if x of B is locked to x of A. Wheels are excluded.
bool is_hinge(const JointDef& def, const JointBlock& block) {
    return def.kind != JointKind::wheel && block.count == 2 && block.kind[0] == RowKind::lock_y &&
           block.kind[1] == RowKind::lock_z; // the impulses of these rows are stored in about_y and about_z
}

/// Reserves exactly the packs that `counts` requires (number of joints by kind, from the second entry on), because
/// packs are large.
void reserve_packs(JointTick& tick) {
    std::size_t packs = 0, turns = 0;
    for (std::uint32_t key = 0; key + 1 < tick.counts.size(); ++key) {
        const std::uint32_t kind = key % pack_kinds,
                            some = (tick.counts[key + 1] + pack_lanes - 1) / pack_lanes;
        if (kind != no_kind) packs += some;
        if (kind != no_kind && kind != 0) turns += some;
    }
    tick.packs.reserve(packs), tick.turn_packs.reserve(turns);
}

void add_to_pack(JointTick& tick, JointWork& w, std::uint32_t kind, bool fresh, const SolverBodies& bodies) {
    if (fresh) {
        tick.packs.emplace_back();
        JointPack& pack = tick.packs.back();
        pack.hinges = kind == hinge_kind;
        pack.turn_rows = pack.hinges ? 2 : kind;
        for (PackSide* side : {&pack.a, &pack.b})
            for (std::uint32_t& place : side->place) place = place_of(bodies.still());
        if (kind != 0) {
            pack.turn = static_cast<std::uint32_t>(tick.turn_packs.size());
            tick.turn_packs.emplace_back();
            for (std::uint32_t lane = 0; lane < pack_lanes; ++lane) {
                TurnPack& turn = tick.turn_packs.back();
                turn.generic[lane] = pack.hinges ? 0 : -1;
                turn.shift_a[lane] = turn.shift_b[lane] = turn.bias_shift[lane] = 1;
            }
        }
    }
    JointPack& pack = tick.packs.back();
    w.pack = static_cast<std::uint32_t>(tick.packs.size() - 1);
    w.lane = static_cast<std::uint8_t>(pack.count++);
    pack.stale[w.lane] = -1;
    pack.memory[w.lane] = w.memory, pack.mass[w.lane] = w.mass.raw;
    set_share(pack.a, w.lane, w.shares.a, w.a);
    set_share(pack.b, w.lane, w.shares.b, w.b);
    const auto set_held = [&](PackSide& side, const JointWorkSide& s, const JointFrame& frame) {
        if (s.world) return; // entry 0 is the world
        side.held[w.lane] = s.cache * static_cast<std::uint32_t>(sizeof(JointBody));
        side.turned[w.lane] = (s.cache + 1) * static_cast<std::uint32_t>(sizeof(TurnedBody));
        for (int i = 0; i < 3; ++i) side.own_lever[i][w.lane] = frame.lever[i].raw;
    };
    set_held(pack.a, w.a, w.frame_a), set_held(pack.b, w.b, w.frame_b);
    if (w.hinge) plan_hinge(tick, w);
}

} // namespace

void set_inverse(PackInverse& to, std::uint32_t lane, const Inverse& inverse) {
    for (int i = 0; i < 6; ++i) to.m[i][lane] = inverse.m[i];
    const bool odd = inverse.shift < 1 || inverse.shift > 62;
    to.odd = (to.odd & ~(1u << lane)) | (odd ? 1u << lane : 0u);
    to.shift[lane] = inverse.shift;
    to.half[lane] = odd ? 0 : std::int64_t{1} << (inverse.shift - 1);
}

std::int32_t pack_rate(const StepConstants& step) {
    return saturate_to_int32(step.joint.rate.raw >> (Real::fraction_bits - joint_rate_bits));
}

JointPassData pass_data(JointTick& tick, const StepConstants& step, SolverBody* bodies) {
    return {bodies,
            tick.packs.data(),
            tick.turn_packs.data(),
            tick.axis_packs.data(),
            tick.held.data(),
            tick.turned.data(),
            tick.seen.data(),
            pack_rate(step),
            step.joint.mass_scale.raw,
            step.joint.impulse_scale.raw,
            step.substep_time.raw};
}

/// Finds the stage of each joint, and the joints that go into packs. Returns the number of stages.
static std::uint32_t plan_stages(JointTick& tick, const StepConstants& step, const SolverBodies& bodies) {
    tick.last_stage.assign(tick.bodies.size(), 0);
    const bool packs = pack_rate(step) < 1 << 27; // above that its products overflow
    std::uint32_t stage_count = 0;
    for (JointWork& w : tick.joints) {
        find_stage(tick, w, bodies);
        stage_count = std::max(stage_count, w.stage + 1);
        if (!packs || !is_packed(w, bodies)) {
            if (w.point) add_point_block(tick, w);
            continue;
        }
        w.pack = 0; // the index is assigned later
        w.turns_packed = w.block_count == 1 && only_turns(tick.blocks[w.first_block].kind[0]);
        w.hinge = w.turns_packed && is_hinge(*w.def, tick.blocks[w.first_block]);
    }
    return stage_count;
}

/// Sets tick.counts[k + 1] to the number of joints with key k.
template <class Key> static void count_by(JointTick& tick, std::uint32_t keys, const Key& key) {
    tick.counts.assign(keys + 1, 0);
    for (const JointWork& w : tick.joints) ++tick.counts[key(w) + 1];
}
/// Sorts joints by key; joints with equal keys keep their order. Then tick.counts[k] is the end of key k.
template <class Key> static void sort_by(JointTick& tick, const Key& key) {
    for (std::size_t i = 1; i < tick.counts.size(); ++i) tick.counts[i] += tick.counts[i - 1];
    tick.before_sort.swap(tick.in_order);
    tick.in_order.resize(tick.joints.size());
    for (const std::uint32_t i : tick.before_sort) tick.in_order[tick.counts[key(tick.joints[i])]++] = i;
}

/// Sorts joints by stage, strand and kind, and returns the number of strands. Packs must contain the same joints for
/// every number of strands, since joint_close.cpp processes whole packs. A pack therefore gets the strand of its
/// first joint.
static std::uint32_t sort_joints(JointTick& tick, std::uint32_t stage_count, std::uint32_t workers) {
    tick.in_order.resize(tick.joints.size());
    for (std::uint32_t i = 0; i < tick.joints.size(); ++i) tick.in_order[i] = i;
    const auto plain_key = [&](const JointWork& w) { return w.stage * pack_kinds + kind_of(tick, w); };
    count_by(tick, stage_count * pack_kinds, plain_key);
    reserve_packs(tick);
    sort_by(tick, plain_key);
    const std::uint32_t strands = share_out(tick, stage_count, workers);
    if (strands == 1) return 1;
    find_borders(tick);
    for (std::uint32_t at = 0, key = 0; key < stage_count * pack_kinds; ++key)
        for (const std::uint32_t end = tick.counts[key]; at < end;) {
            const std::uint32_t size = key % pack_kinds == no_kind ? 1 : std::min(pack_lanes, end - at);
            const auto pack = std::span(tick.in_order).subspan(at, size);
            const std::uint32_t strand = tick.joints[pack[0]].strand;
            bool is_inner = true;
            for (const std::uint32_t i : pack)
                is_inner = is_inner && tick.joints[i].is_inner && tick.joints[i].strand == strand;
            for (const std::uint32_t i : pack)
                tick.joints[i].strand = strand, tick.joints[i].is_inner = is_inner;
            at += size;
        }
    const auto key = [&](const JointWork& w) {
        return ((w.stage * strands + w.strand) * 2 + (w.is_inner ? 1 : 0)) * pack_kinds + kind_of(tick, w);
    };
    count_by(tick, stage_count * strands * 2 * pack_kinds, key);
    sort_by(tick, key);
    return strands;
}

/// Adds entries for the axes of each pack. Lanes without an axis have acts = 0.
static void plan_axes(JointTick& tick) {
    for (std::uint32_t p = 0; p < tick.packs.size(); ++p) {
        JointPack& pack = tick.packs[p];
        pack.first_axis = static_cast<std::uint32_t>(tick.axis_packs.size());
        for (std::uint32_t lane = 0; lane < pack.count; ++lane)
            pack.axis_count = std::max<std::uint32_t>(
                pack.axis_count, tick.joints[tick.packed[p * pack_lanes + lane]].axis_count);
        for (std::uint32_t k = 0; k < pack.axis_count; ++k) {
            make_room(tick.axis_packs);
            AxisPack& axis = tick.axis_packs.emplace_back();
            for (std::uint32_t lane = 0; lane < pack_lanes; ++lane)
                axis.shift[lane] = axis.lead_shift[lane] = 1;
        }
    }
}

void plan_packs(JointTick& tick, const StepConstants& step, const SolverBodies& bodies,
                std::uint32_t workers) {
    tick.packed.clear(), tick.packs.clear(), tick.turn_packs.clear(), tick.axis_packs.clear(),
        tick.steps.clear(), tick.singles.clear();
    const std::uint32_t stage_count = plan_stages(tick, step, bodies),
                        strands = sort_joints(tick, stage_count, workers);
    std::uint32_t at = 0;
    const std::uint32_t steps_of_stage = strands == 1 ? 1 : 2 * strands;
    for (std::uint32_t s = 0; s < stage_count * steps_of_stage; ++s) {
        JointStep now{};
        now.strand = s % steps_of_stage / 2;
        now.first_joint = at;
        now.first_pack = static_cast<std::uint32_t>(tick.packs.size());
        now.first_single = static_cast<std::uint32_t>(tick.singles.size());
        for (std::uint32_t kind = 0; kind < pack_kinds; ++kind) {
            const std::uint32_t first = at, end = tick.counts[s * pack_kinds + kind];
            for (; at < end; ++at) {
                JointWork& w = tick.joints[tick.in_order[at]];
                if (kind != no_kind) {
                    add_to_pack(tick, w, kind, (at - first) % pack_lanes == 0, bodies);
                    tick.packed.resize(tick.packs.size() * pack_lanes);
                    tick.packed[w.pack * pack_lanes + w.lane] = tick.in_order[at];
                }
                if (kind == no_kind && w.axis_count + w.block_count != 0)
                    tick.singles.push_back(tick.in_order[at]);
            }
        }
        now.last_joint = at;
        now.last_pack = static_cast<std::uint32_t>(tick.packs.size());
        now.last_single = static_cast<std::uint32_t>(tick.singles.size());
        tick.steps.push_back(now);
    }
    tick.acts.resize(tick.joints.size());
    plan_axes(tick);
    plan_strands(tick, strands);
}

void restart_pack(JointTick& tick, JointPack& pack) {
    const auto fill = [](auto& lanes, auto with) { std::fill(std::begin(lanes), std::end(lanes), with); };
    for (std::uint32_t lane = 0; lane < pack.count; ++lane) pack.stale[lane] = -1;
    for (std::uint32_t k = 0; k < pack.axis_count; ++k) fill(tick.axis_packs[pack.first_axis + k].sum, 0);
    if (pack.turn_rows == 0) return;
    TurnPack& turn = tick.turn_packs[pack.turn];
    fill(turn.generic, pack.hinges ? 0 : -1);
    for (auto& lanes : turn.sum) fill(lanes, 0);
}

void start_points(JointTick& tick, std::uint32_t p) {
    constexpr std::int64_t far = std::int64_t{1} << 58; // leaves room for levers and for the motion of bodies
    JointPack& pack = tick.packs[p];
    for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
        const auto centre = [&](const PackSide& side, JointFrame JointWork::*own) {
            if (side.turned[lane] == 0) return (tick.joints[tick.packed[p * pack_lanes + lane]].*own).anchor;
            return tick.pose[side.place[lane] / sizeof(SolverBody)].position;
        };
        const Vec3 apart = centre(pack.b, &JointWork::frame_b) - centre(pack.a, &JointWork::frame_a);
        const JointMemory& last = tick.memory[pack.memory[lane]];
        for (int i = 0; i < 3; ++i) {
            pack.apart[i][lane] = std::clamp(apart[i].raw, -far, far);
            pack.sum[i][lane] = last.axis[static_cast<std::size_t>(i)].spring.raw;
        }
        for (std::size_t r = 0; r < 2 && pack.hinges; ++r)
            tick.turn_packs[pack.turn].sum[r][lane] = last.axis[about_y + r].spring.raw;
    }
}

void put_turn(const JointBlock& block, TurnPack& pack, std::uint32_t lane) {
    for (int r = 0; r < block.count; ++r) {
        const Row& row = block.row[r];
        for (int i = 0; i < 3; ++i) {
            pack.ja[r][i][lane] = row.ja[i + 3], pack.jb[r][i][lane] = row.jb[i + 3];
        }
        pack.impulse[r][lane] = block.impulse[r];
    }
    set_inverse(pack.inverse, lane, block.inverse);
    put_bias(block, pack, lane);
}

void put_bias(const JointBlock& block, TurnPack& pack, std::uint32_t lane) {
    for (int r = 0; r < block.count; ++r) pack.bias[r][lane] = block.bias[r];
}

void take_impulses(JointBlock& block, TurnPack& pack, std::uint32_t lane) {
    for (int r = 0; r < block.count; ++r) {
        block.impulse[r] = pack.impulse[r][lane];
        block.sum[r] += unscaled_impulse(pack.sum[r][lane], block.exponent);
        pack.sum[r][lane] = 0;
    }
}

} // namespace lockstone::solve
