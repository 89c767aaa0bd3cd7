// One tick, on one screen. Everything from outside came in as commands before it (apply.cpp); everything that leaves,
// leaves as event arrays at the bottom. Each phase is a pure function of the columns and of this tick's scratch.
#include "sim/phases.h"

namespace lockstone::sim {

namespace {

/// The hash of the whole state between phases, for finding where two runs part. Off by default.
void checkpoint(Data& w, const char* phase) {
    if (w.phase_hashes_on) w.phase_hashes.push_back({phase, w.state.hash()});
}

dynamics::StepConstants constants_of(const Config& c) {
    return dynamics::step_constants({static_cast<std::int32_t>(c.tick_rate),
                                     static_cast<std::int32_t>(c.substeps), c.contact_hertz,
                                     c.contact_damping, c.push_speed_max, c.restitution_speed_min});
}

/// Half as many relaxing passes as substeps: twice the substeps for the same work hold a tower better than as many.
bool relaxes_after(std::int32_t substep, const dynamics::StepConstants& step) {
    return substep % 2 == 1 || substep + 1 == step.substeps;
}

void prepare(Data& w) {
    Scratch& s = w.scratch;
    s.step = constants_of(w.state.rows(w.m.config)[0]);
    s.pose_before.assign(w.state.rows(w.m.body_pose).begin(), w.state.rows(w.m.body_pose).end());
    dynamics::begin_step(w.body_columns(), w.header().gravity, s.step, s.bodies);
    s.solver.prepare(s.contacts, w.state.rows(w.m.contact_memory), w.state.rows(w.m.body_mass), s.step,
                     s.bodies);
}

void finish(Data& w) {
    Scratch& s = w.scratch;
    dynamics::finish_step(s.step, s.bodies, w.body_columns());
    for (BodyForce& force : w.state.rows(w.m.body_force)) force = {};
    Faults& faults = w.state.rows(w.m.faults)[0];
    faults.speed_clamped += s.bodies.clamps.speed;
    faults.position_clamped += s.bodies.clamps.position;
    faults.impulse_clamped += s.bodies.clamps.impulse;
}

} // namespace

void tick(Data& w) {
    Scratch& s = w.scratch;
    w.phase_hashes.clear();
    checkpoint(w, "commands");

    update_bounds(w);
    find_pairs(w);
    collide(w);
    checkpoint(w, "collide");
    prepare(w);

    const dynamics::FreeMotion motion{static_cast<dynamics::Scheme>(w.state.rows(w.m.config)[0].integrator),
                                      w.state.rows(w.m.field)};
    for (std::int32_t i = 0; i < s.step.substeps; ++i) {
        integrate_velocities(motion, w.body_columns(), s.step, s.bodies);
        s.solver.warm_start(s.bodies);
        s.solver.solve(s.step, s.bodies, /*bias=*/true);
        integrate_poses(s.step, s.bodies);
        if (relaxes_after(i, s.step)) s.solver.solve(s.step, s.bodies, /*bias=*/false);
    }
    s.solver.apply_restitution(s.step, s.bodies);
    s.solver.store(s.contacts, w.state.rows(w.m.contact_memory), s.bodies.clamps);
    checkpoint(w, "solve");
    finish(w);
    checkpoint(w, "finish");
    if (w.state.rows(w.m.config)[0].continuous != 0) sweep_fast_bodies(w);
    checkpoint(w, "sweep_fast_bodies");

    publish_events(w);
    ++w.header().tick;
    checkpoint(w, "publish_events");
    if (w.journal != nullptr) w.journal->on_tick(w.header().tick - 1, w.state.hash());
}

} // namespace lockstone::sim
