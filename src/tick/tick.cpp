// One tick, on one screen. Everything from outside came in as commands before it (apply.cpp); everything that leaves,
// leaves as event arrays at the bottom. Each phase is a pure function of the columns and of this tick's scratch.
// Where a phase takes w.tasks, workers share it: each writes what no other reads, and what they made is put together in order.
#include "solve/joints/followed_turn.h"
#include "solve/joints/joint_stiffness.h"
#include "tick/phases.h"

namespace lockstone::sim {

namespace {

#ifdef NDEBUG
constexpr bool poisons_scratch = false;
#else
/// What reads before it writes shows. In every second tick: poisoning forgets the hints of pairs, and the ways that they open are to
/// be walked under sanitizers too.
constexpr bool poisons_scratch = true;
#endif

/// For profilers: nothing but a name leaves, and nothing comes back.
void passed(const Data& w, const char* phase) {
    if (w.observer != nullptr) w.observer->on_phase(phase);
}

/// The hash of the whole state between phases, for finding where two runs part. Off by default.
void checkpoint(Data& w, const char* phase) {
    passed(w, phase);
    if (w.phase_hashes_on) w.phase_hashes.push_back({phase, w.state.hash()});
}

/// While a tick works on the contacts, the state holds those of the last one; a hash is of all that is known.
void checkpoint_with_contacts(Data& w, const char* phase) {
    if (w.phase_hashes_on) w.scratch.table.write(w.state, w.m.contacts);
    checkpoint(w, phase);
}

solve::StepConstants constants_of(const Config& c) {
    return solve::step_constants({static_cast<std::int32_t>(c.tick_rate),
                                  static_cast<std::int32_t>(c.substeps), c.contact_hertz, c.contact_damping,
                                  c.push_speed_max, c.restitution_speed_min});
}

void prepare(Data& w) {
    Scratch& s = w.scratch;
    s.step = constants_of(w.state.rows(w.m.config)[0]);
    const std::span<const Transform> poses = w.state.rows(w.m.body_pose).first(w.header().bodies_awake);
    s.pose_before.assign(poses.begin(), poses.end());
    solve::begin_step(w.body_columns(), w.header().gravity, s.step, s.bodies, w.tasks);
    list_joints(w);
    solve::stiffen_bodies(s.joints, w.state.rows(w.m.joint_memory), w.body_columns(), s.step, s.bodies);
    solve::follow_turns(s.joints, w.body_columns(), s.step, s.bodies);
    s.solver.prepare(s.contacts, s.table.list.memories, w.body_columns().mass, s.step, s.bodies, w.tasks);
    s.joint_solver.prepare(s.joints, w.state.rows(w.m.joint_memory), w.body_columns(), s.step, s.bodies,
                           w.tasks);
    s.vehicle_solver.prepare(w);
    list_fields(w);
    s.fluids.prepare(w);
}

void finish(Data& w) {
    Scratch& s = w.scratch;
    solve::finish_step(s.step, s.bodies, w.body_columns(), w.tasks);
    forget_forces(w);
    Faults& faults = w.state.edit_row(w.m.faults, 0);
    faults.speed_clamped += s.bodies.clamps.speed;
    faults.position_clamped += s.bodies.clamps.position;
    faults.impulse_clamped += s.bodies.clamps.impulse;
}

void substep(Data& w, const solve::FreeMotion& motion) {
    Scratch& s = w.scratch;
    integrate_velocities(motion, w.body_columns(), s.step, s.bodies, w.tasks);
    s.fluids.push(w, s.step, s.bodies, w.tasks);
    passed(w, "integrate");
    s.joint_solver.warm_start(s.step, s.bodies);
    s.vehicle_solver.warm_start(s.step, s.bodies);
    s.solver.warm_start(s.bodies, w.tasks);
    passed(w, "warm_start");
    // Contacts first: what a warm start after an impact gave too much is taken back before joints pull at it.
    s.solver.solve(s.step, s.bodies, /*bias=*/true, w.tasks);
    passed(w, "solve_contacts");
    s.joint_solver.solve(s.step, s.bodies, /*bias=*/true, w.tasks);
    s.vehicle_solver.solve(s.step, s.bodies, /*bias=*/true);
    passed(w, "solve_joints");
    integrate_poses(s.step, s.bodies, w.tasks);
    passed(w, "integrate");
    s.joint_solver.update(s.step, s.bodies, w.tasks);
    passed(w, "update_joints");
    s.joint_solver.solve(s.step, s.bodies, /*bias=*/false, w.tasks);
    s.vehicle_solver.solve(s.step, s.bodies, /*bias=*/false);
    passed(w, "relax_joints");
    s.solver.solve(s.step, s.bodies, /*bias=*/false, w.tasks);
    passed(w, "relax_contacts");
}

} // namespace

void tick(Data& w) {
    Scratch& s = w.scratch;
    w.contact_points.clear(), w.contact_points_wait = false;
    if (poisons_scratch && w.header().tick % 2 != 0) poison_scratch(w, std::byte{0xa5});
    w.phase_hashes.clear();
    checkpoint(w, "commands");

    move_characters(w);
    passed(w, "move_characters");
    do {
        update_bounds(w);
        passed(w, "update_bounds");
        find_pairs(w);
        passed(w, "find_pairs");
    } while (wake_touched(w) || s.vehicle_solver.cast(w));
    collide(w);
    checkpoint_with_contacts(w, "collide");
    prepare(w);

    const solve::FreeMotion motion{static_cast<solve::Scheme>(w.state.rows(w.m.config)[0].integrator),
                                   s.pulls, s.categories};
    s.joint_solver.update(s.step, s.bodies, w.tasks);
    passed(w, "prepare");
    for (std::int32_t i = 0; i < s.step.substeps; ++i) substep(w, motion);
    s.solver.apply_restitution(s.step, s.bodies);
    s.solver.store(s.contacts, s.table.list.memories, s.bodies.clamps, w.tasks);
    s.joint_solver.store(s.step, w.state.edit(w.m.joint_memory, 0, w.header().joints_awake), s.bodies.clamps);
    s.vehicle_solver.store(w);
    checkpoint_with_contacts(w, "solve");
    finish(w);
    checkpoint_with_contacts(w, "finish");
    if (w.state.rows(w.m.config)[0].continuous != 0) sweep_fast_bodies(w);
    checkpoint_with_contacts(w, "sweep_fast_bodies");

    break_joints(w);
    publish_events(w);
    s.table.write(w.state, w.m.contacts);
    settle(w);
    order_events(w);
    ++w.edit_header().tick;
    checkpoint(w, "settle");
    if (w.journal != nullptr) w.journal->on_tick(w.header().tick - 1, w.state.hash());
}

} // namespace lockstone::sim
