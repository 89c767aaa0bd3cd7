// Builds the parts of a joint from its table of axes.
#include "solve/joints/joint_work.h"

namespace lockstone::solve {

namespace {

constexpr std::uint8_t limits = has_lower | has_upper;

/// Adds the parts of one joint.
struct Assembly {
    JointTick& tick;
    JointWork& work;
    const StepConstants& step;
    const JointMemory& memory;

    const JointAxis& axis(int i) const { return work.def->axis[static_cast<std::size_t>(i)]; }

    /// Force or torque as impulse per substep over the reduced mass.
    Real impulse_of(Real force) const {
        return force == Real{} ? force : force / work.mass / Real(step.substeps_per_second);
    }

    JointBlock& add_block() {
        ++work.block_count;
        make_room(tick.blocks);
        tick.blocks.emplace_back();
        return tick.blocks.back();
    }
    /// A lock at `at`. The impulse of the last tick stays unscaled in `sum` until the rows are made.
    void add_lock(JointBlock& block, RowKind kind, int slot, Real at = {}) const {
        const int i = block.count++;
        block.kind[i] = kind;
        block.slot[i] = static_cast<std::uint8_t>(slot);
        block.at[i] = at;
        block.sum[i] = memory.axis[static_cast<std::size_t>(slot)].spring;
    }
    std::uint8_t features_of(int i) const;
    void add_axis(RowKind kind, int slot, std::uint8_t features, Real target);
    void add_swing();

    void add_linear();
    void add_angular();
    void add_line(RowKind kind);
    void add_ratio(RowKind kind);
};

bool rigid(const JointAxis& a) { return a.mode == AxisMode::locked && a.frequency == Real{}; }

std::uint8_t Assembly::features_of(int i) const {
    const JointAxis& a = axis(i);
    std::uint8_t f = 0;
    if (a.frequency > Real{} && (a.spring != 0 || a.mode == AxisMode::locked)) f |= has_spring;
    if (a.mode != AxisMode::locked && (a.motor_force > Real{} || a.friction > Real{})) f |= has_motor;
    if (a.mode == AxisMode::limited) f |= limits;
    return f;
}

void Assembly::add_axis(RowKind kind, int slot, std::uint8_t features, Real target) {
    if (features == 0) return;
    const JointAxis& a = axis(slot);
    ++work.axis_count;
    tick.axes.emplace_back();
    JointAxisPart& part = tick.axes.back();
    part.kind = kind;
    part.slot = static_cast<std::uint8_t>(slot);
    part.features = features;
    part.target = target;
    part.motor_speed = a.motor_force > Real{} ? a.motor_speed : Real{};
    part.motor_max = impulse_of(a.motor_force > Real{} ? a.motor_force : a.friction);
    part.spring_max = a.spring_force > Real{} ? impulse_of(a.spring_force) : Real::max();
    part.lower_at = a.lower, part.upper_at = a.upper;
    if (features & has_spring) {
        const SpringSoftness soft = spring_softness(a.frequency, a.damping_ratio, step);
        part.rate = soft.rate;
        part.mass_scale = soft.mass_scale, part.impulse_scale = soft.impulse_scale;
    }
}

void Assembly::add_swing() {
    if (work.def->kind != JointKind::ball || work.def->swing <= Real{}) return;
    ++work.axis_count;
    tick.axes.emplace_back();
    JointAxisPart& part = tick.axes.back();
    part.kind = RowKind::swing;
    part.features = has_upper | is_swing;
    part.upper_at = work.def->swing;
}

void Assembly::add_linear() {
    int locked = 0;
    for (int i = 0; i < 3; ++i) locked += rigid(axis(i)) ? 1 : 0;
    if (locked == 3) {
        work.point = true;
        return;
    }
    JointBlock* block = locked == 0 ? nullptr : &add_block();
    for (int i = 0; i < 3; ++i) {
        const RowKind kind = static_cast<RowKind>(static_cast<int>(RowKind::along_x) + i);
        if (rigid(axis(i)))
            add_lock(*block, kind, i);
        else
            add_axis(kind, i, features_of(i), axis(i).mode == AxisMode::locked ? Real{} : axis(i).target);
    }
}

void Assembly::add_angular() {
    int locked = 0, springs = 0;
    std::uint8_t all[3], any = 0;
    for (int i = 0; i < 3; ++i) {
        const int slot = i + static_cast<int>(about_x);
        all[i] = features_of(slot), any |= all[i];
        locked += rigid(axis(slot)) ? 1 : 0;
        springs += all[i] & has_spring ? 1 : 0;
    }
    if (locked == 0 && any == 0) return add_swing();
    work.needs_orientation = locked == 3;
    work.needs_target = springs == 3;
    const bool wheel = work.def->kind == JointKind::wheel;
    const RowKind lock_kinds[3] = {RowKind::twist, RowKind::lock_y, RowKind::lock_z};
    const RowKind kinds[3] = {wheel ? RowKind::spin : RowKind::twist, RowKind::angle_y, RowKind::angle_z};
    const RowKind targets[3] = {RowKind::target_x, RowKind::target_y, RowKind::target_z};
    const RowKind orientation[3] = {RowKind::orientation_x, RowKind::orientation_y, RowKind::orientation_z};
    JointBlock* block = locked == 0 ? nullptr : &add_block();
    for (int i = 0; i < 3; ++i) {
        const int slot = i + static_cast<int>(about_x);
        const std::uint8_t features = all[i];
        if (rigid(axis(slot))) {
            add_lock(*block, locked == 3 ? orientation[i] : lock_kinds[i], slot);
        } else if (springs == 3) {
            add_axis(targets[i], slot, features & (has_spring | has_motor), Real{});
            add_axis(kinds[i], slot, features & limits, Real{});
        } else {
            add_axis(kinds[i], slot, features,
                     axis(slot).mode == AxisMode::locked ? Real{} : axis(slot).target);
        }
    }
    add_swing();
}

/// Distance and pulley: axis[0] measures a length.
void Assembly::add_line(RowKind kind) {
    std::uint8_t features = features_of(0);
    if (axis(0).lower <= Real{}) features &= static_cast<std::uint8_t>(~has_lower);
    if (rigid(axis(0)))
        add_lock(add_block(), kind, 0, axis(0).target);
    else
        add_axis(kind, 0, features, axis(0).target);
}

void Assembly::add_ratio(RowKind kind) {
    work.needs_travel = true;
    add_lock(add_block(), kind, 0);
}

} // namespace

void assemble(JointTick& tick, JointWork& work, const StepConstants& step, const JointMemory& memory) {
    work.first_block = static_cast<std::uint32_t>(tick.blocks.size());
    work.first_axis = static_cast<std::uint32_t>(tick.axes.size());
    work.block_count = work.axis_count = 0;
    work.point = false;
    work.needs_twist = work.needs_target = work.needs_orientation = work.needs_travel = work.needs_slip =
        work.needs_lever = false;
    if (work.mass == Real{}) return; // no impulse can move either body
    Assembly assembly{tick, work, step, memory};
    switch (work.def->kind) {
    case JointKind::distance:
        assembly.add_line(RowKind::line);
        break;
    case JointKind::pulley:
        assembly.add_line(RowKind::pulley);
        break;
    case JointKind::gear:
        assembly.add_ratio(RowKind::gear);
        break;
    case JointKind::rack_and_pinion:
        assembly.add_ratio(RowKind::rack);
        break;
    default:
        assembly.add_angular();
        assembly.add_linear();
    }
    const auto note = [&](RowKind k) {
        work.needs_twist = work.needs_twist || k == RowKind::twist || k == RowKind::spin;
        work.needs_slip = work.needs_slip || (k >= RowKind::along_x && k <= RowKind::along_z);
        work.needs_lever = work.needs_lever || !only_turns(k);
    };
    for (std::size_t i = work.first_axis; i < tick.axes.size(); ++i) note(tick.axes[i].kind);
    for (std::size_t i = work.first_block; i < tick.blocks.size(); ++i)
        for (int r = 0; r < tick.blocks[i].count; ++r) note(tick.blocks[i].kind[r]);
}

JointAxisImpulses impulses_of(const JointAxisPart& part, const JointMemory& memory) {
    const std::uint8_t features = part.features;
    if (features & is_swing) return {Real{}, Real{}, Real{}, memory.swing};
    const JointAxisImpulses& last = memory.axis[part.slot];
    return {features & has_spring ? last.spring : Real{}, features & has_motor ? last.motor : Real{},
            features & has_lower ? last.lower : Real{}, features & has_upper ? last.upper : Real{}};
}

void restart_block(JointBlock& block, const JointMemory& memory) {
    for (int r = 0; r < block.count; ++r)
        block.sum[r] = memory.axis[block.slot[r]].spring, block.impulse[r] = 0;
}

void reassemble(JointTick& tick, const JointWork& work) {
    for (std::uint32_t i = 0; i < work.block_count && !work.hinge; ++i)
        restart_block(tick.blocks[work.first_block + i], tick.memory[work.memory]);
    for (std::uint32_t i = 0; i < work.axis_count; ++i) {
        JointAxisPart& part = tick.axes[work.first_axis + i];
        part.spring = part.motor = part.lower = part.upper = part.exponent = 0;
        part.sum = Real{};
        part.idle = part.unmade = false;
    }
}

void add_point_block(JointTick& tick, JointWork& work) {
    const std::uint32_t before = work.first_block, count = work.block_count;
    work.first_block = static_cast<std::uint32_t>(tick.blocks.size());
    for (std::uint32_t i = 0; i < count; ++i) {
        make_room(tick.blocks);
        tick.blocks.push_back(tick.blocks[before + i]); // the blocks of a joint are contiguous
    }
    make_room(tick.blocks);
    JointBlock& block = tick.blocks.emplace_back();
    for (int i = 0; i < 3; ++i) {
        block.kind[i] = static_cast<RowKind>(static_cast<int>(RowKind::point_x) + i);
        block.slot[i] = static_cast<std::uint8_t>(i);
        block.sum[i] = tick.memory[work.memory].axis[static_cast<std::size_t>(i)].spring;
    }
    block.count = 3;
    ++work.block_count;
    work.needs_lever = true;
}

bool counts_turns(const JointDef& def) {
    return def.kind == JointKind::wheel ||
           (def.axis[about_y].mode == AxisMode::locked && def.axis[about_z].mode == AxisMode::locked);
}

/// True for kinds whose rows depend on turns alone, and change slowly.
static bool may_stay(RowKind kind) {
    return kind <= RowKind::point_z || (kind >= RowKind::orientation_x && kind <= RowKind::swing);
}

bool may_stay(const JointTick& tick, const JointWork& work) {
    for (std::uint32_t i = 0; i < work.axis_count; ++i) {
        const JointAxisPart& part = tick.axes[work.first_axis + i];
        if (!may_stay(part.kind)) return false;
        // The direction of a small cone turns by more than the bodies do.
        if (part.kind == RowKind::swing && part.upper_at < decimal<Real>("0.25")) return false;
    }
    for (std::uint32_t i = 0; i < work.block_count; ++i)
        for (int r = 0; r < tick.blocks[work.first_block + i].count; ++r)
            if (!may_stay(tick.blocks[work.first_block + i].kind[r])) return false;
    return true;
}

} // namespace lockstone::solve
