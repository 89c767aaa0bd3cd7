// Where packs of joints stand in the order of solving, and what goes in and out of their lanes.
#include "solve/joints/pack/joint_point.h"

#include "solve/joints/joint_work.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// Whether a pack takes a joint's point: no tree solves it.
bool is_packed(const JointWork& w, const SolverBodies& bodies) {
    return w.point && w.tree == no_tree && fits_pack(w.a.body, bodies) && fits_pack(w.b.body, bodies);
}

void find_stage(JointTick& tick, JointWork& w, const SolverBodies& bodies) {
    const auto last = [&](const JointWorkSide& side) -> std::uint32_t* {
        return !side.world && bodies.step[side.body].movable ? &tick.last_stage[side.cache] : nullptr;
    };
    std::uint32_t *a = last(w.a), *b = last(w.b);
    w.stage = std::max(a != nullptr ? *a : 0, b != nullptr ? *b : 0);
    if (a != nullptr) *a = w.stage + 1;
    if (b != nullptr) *b = w.stage + 1;
}

std::uint32_t place_of(std::uint32_t body) { return body * static_cast<std::uint32_t>(sizeof(SolverBody)); }

void set_share(PackSide& side, unsigned lane, Share share, std::uint32_t body) {
    side.place[lane] = place_of(body);
    side.share[lane] = share.mantissa;
    side.shift[lane] = share.shift;
    side.half[lane] = share.shift != 0 ? std::int64_t{1} << (share.shift - 1) : 0;
    side.shifts = side.shifts || share.shift != 0;
}

/// What kind of pack a joint goes into: rows that turn before its point, those of a hinge, or none.
constexpr std::uint32_t pack_kinds = 6, hinge_kind = 4, no_kind = 5;
std::uint32_t kind_of(const JointTick& tick, const JointWork& w) {
    if (w.pack == no_pack) return no_kind;
    if (w.hinge) return hinge_kind;
    return w.turns_packed ? tick.blocks[w.first_block].count : 0;
}

/// Whether x of B is locked to x of A.
bool is_hinge(const JointDef& def, const JointBlock& block) {
    return def.kind != JointKind::wheel && block.count == 2 && block.kind[0] == RowKind::lock_y &&
           block.kind[1] == RowKind::lock_z; // whose impulses are those of about_y and about_z
}

/// Room for the packs of `counts`, joints by kind from the second entry on, and for no more: they are large.
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
    pack.memory[w.lane] = w.memory, pack.mass_rate[w.lane] = w.mass_rate.raw;
    set_share(pack.a, w.lane, w.shares.a, w.a.body);
    set_share(pack.b, w.lane, w.shares.b, w.b.body);
    const auto set_held = [&](PackSide& side, const JointWorkSide& s, const JointFrame& frame) {
        if (s.world) return; // zero is the world's
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

void plan_packs(JointTick& tick, const StepConstants& step, const SolverBodies& bodies) {
    tick.packed.clear(), tick.packs.clear(), tick.turn_packs.clear(), tick.stages.clear(),
        tick.singles.clear();
    tick.last_stage.assign(tick.bodies.size(), 0);
    const bool packs = pack_rate(step) < 1 << 27; // its products have room for no more
    std::uint32_t stage_count = 0;
    for (JointWork& w : tick.joints) {
        find_stage(tick, w, bodies);
        stage_count = std::max(stage_count, w.stage + 1);
        if (!packs || !is_packed(w, bodies)) {
            if (w.point) add_point_block(tick, w);
            continue;
        }
        w.pack = 0; // which one follows
        w.turns_packed = w.block_count == 1 && only_turns(tick.blocks[w.first_block].kind[0]);
        w.hinge = w.turns_packed && is_hinge(*w.def, tick.blocks[w.first_block]);
    }
    tick.counts.assign(stage_count * pack_kinds + 1, 0);
    const auto key = [&](const JointWork& w) { return w.stage * pack_kinds + kind_of(tick, w); };
    for (const JointWork& w : tick.joints) ++tick.counts[key(w) + 1];
    reserve_packs(tick);
    for (std::size_t i = 1; i < tick.counts.size(); ++i) tick.counts[i] += tick.counts[i - 1];
    tick.in_order.resize(tick.joints.size());
    for (std::uint32_t i = 0; i < tick.joints.size(); ++i)
        tick.in_order[tick.counts[key(tick.joints[i])]++] = i;
    // counts[k] is now where the joints of key k end
    std::uint32_t at = 0;
    for (std::uint32_t s = 0; s < stage_count; ++s) {
        JointStage stage{};
        stage.first_pack = static_cast<std::uint32_t>(tick.packs.size());
        stage.first_single = static_cast<std::uint32_t>(tick.singles.size());
        for (std::uint32_t kind = 0; kind < pack_kinds; ++kind) {
            const std::uint32_t first = at, end = tick.counts[s * pack_kinds + kind];
            for (; at < end; ++at) {
                JointWork& w = tick.joints[tick.in_order[at]];
                if (kind != no_kind) {
                    add_to_pack(tick, w, kind, (at - first) % pack_lanes == 0, bodies);
                    tick.packed.resize(tick.packs.size() * pack_lanes);
                    tick.packed[w.pack * pack_lanes + w.lane] = tick.in_order[at];
                }
                if (w.axis_count != 0 || (w.block_count != 0 && !w.turns_packed))
                    tick.singles.push_back(tick.in_order[at]);
            }
        }
        stage.last_pack = static_cast<std::uint32_t>(tick.packs.size());
        stage.last_single = static_cast<std::uint32_t>(tick.singles.size());
        tick.stages.push_back(stage);
    }
    tick.acts.resize(tick.joints.size());
}

void restart_packs(JointTick& tick) {
    const auto fill = [](auto& lanes, auto with) { std::fill(std::begin(lanes), std::end(lanes), with); };
    for (JointPack& pack : tick.packs) {
        for (std::uint32_t lane = 0; lane < pack.count; ++lane) pack.stale[lane] = -1;
        if (pack.turn_rows == 0) continue;
        TurnPack& turn = tick.turn_packs[pack.turn];
        fill(turn.generic, pack.hinges ? 0 : -1);
        for (auto& lanes : turn.sum) fill(lanes, 0);
    }
}

void start_points(JointTick& tick, std::uint32_t p) {
    constexpr std::int64_t far = std::int64_t{1} << 58; // leaves room for levers and for what bodies move
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
