// One tick, on one screen. All input arrives as commands before it (apply.cpp), and all output leaves as event arrays
// at its end. Each phase is a pure function of the columns and of this tick's scratch memory. A phase that takes
// tasks is shared by workers: each worker writes data that no other worker reads, and the results are joined in a
// fixed order.
#include "tick/tick.h"

#include "base/parallel.h"
#include "base/room.h"
#include "base/two_jobs.h"
#include "solve/bodies/integrate.h"
#include "solve/bodies/step.h"
#include "solve/joints/followed_turn.h"
#include "solve/joints/joint_stiffness.h"

#include <algorithm>
#include <tuple>

namespace lockstone::sim {

namespace {

#ifdef NDEBUG
constexpr bool poisons_scratch = false;
#else
/// Poisoning reveals code that reads scratch memory before writing it. It runs in every second tick only, since it
/// also clears the hints of pairs, and sanitizers should cover the code that uses the hints too.
constexpr bool poisons_scratch = true;
#endif

/// The arguments of one tick, which its phases share.
struct Tick {
    Model& w;
    PlacedShapes& placed;
    TickScratch& s;
    TickOutput& out;
    const TickHooks& hooks;
};

/// Reports the end of a phase to a profiler. The observer gets only a name and returns nothing.
void passed(const Tick& t, const char* phase) {
    if (t.hooks.observer != nullptr) t.hooks.observer->on_phase(phase);
}

/// Stores the hash of the whole state between phases, to find where two runs diverge. Off by default.
void checkpoint(const Tick& t, const char* phase) {
    passed(t, phase);
    if (t.hooks.phase_hashes) t.out.phase_hashes.push_back({phase, t.w.state.hash()});
}

/// While a tick works on the contacts, the state still holds those of the last tick. So this writes the contact table
/// to the state before the hash.
void checkpoint_with_contacts(const Tick& t, const char* phase) {
    if (t.hooks.phase_hashes) t.s.table.write(t.w.state, t.w.m.contacts, t.hooks.tasks);
    checkpoint(t, phase);
}

/// Computes the constants of a step if the settings have changed. Returns true if it did.
bool find_constants(const Config& c, TickScratch& s) {
    const solve::StepSettings now{static_cast<std::int32_t>(c.tick_rate),
                                  static_cast<std::int32_t>(c.substeps),
                                  c.contact_hertz,
                                  c.contact_damping,
                                  c.push_speed_max,
                                  c.restitution_speed_min};
    const auto all = [](const solve::StepSettings& x) {
        return std::tie(x.ticks_per_second, x.substeps, x.contact_hertz, x.contact_damping, x.push_speed_max,
                        x.restitution_speed_min);
    };
    if (all(now) == all(s.step_of)) return false;
    s.step = solve::step_constants(now);
    s.step_of = now;
    return true;
}

/// Updates bounds and finds pairs; repeats this while an awake body wakes bodies that it touches.
void find_near(const Tick& t, const Scene& scene) {
    TickScratch& s = t.s;
    bool again = false;
    do {
        update_bounds(t.w, t.placed, t.hooks.tasks);
        passed(t, "update_bounds");
        s.table.read(t.w.state, t.w.m.contacts);
        find_pairs(t.w, t.placed, s.table.list, s.pair_scratch, s.near, t.hooks.tasks);
        passed(t, "find_pairs");
        again = wake_touched(t.w, t.placed, s.near.list, s.contact_scratch, s.islands) ||
                s.vehicles.cast(t.w, scene);
        s.paths.take(again, base::Path::nothing_woken, base::Path::islands_woken);
    } while (again);
}

solve::FreeMotion motion_of(const Tick& t) {
    return {static_cast<solve::Scheme>(t.w.config().integrator), t.s.fields.pulls, t.s.fields.categories};
}

/// Returns true if only contacts, gravity, forces and damping change velocities in this tick.
bool contacts_are_alone(const Tick& t) {
    const Model& w = t.w;
    return solve::is_plain_motion(motion_of(t)) && w.state.rows(w.m.field).empty() &&
           w.state.rows(w.m.vehicle).empty() && t.s.joints.all.empty();
}

/// Runs `contacts` on the contacts and `joints` on the joints; neither reads data that the other writes. If both sets
/// are large, the two run at the same time, as each has parts that workers cannot share.
template <class OfContacts, class OfJoints>
void both_sets(const Tick& t, const OfContacts& contacts, const OfJoints& joints) {
    constexpr std::size_t many = 64;
    Tasks* const tasks = t.hooks.tasks;
    const bool are_many = std::min(t.s.found.contacts.size(), t.s.joints.all.size()) >= many;
    const bool at_once = base::worker_count(tasks) > 1 && are_many;
    t.s.paths.take(at_once, base::Path::solvers_in_turn, base::Path::solvers_at_once);
    if (at_once) return base::run_both(*tasks, contacts, joints);
    contacts(tasks);
    joints(tasks);
}

/// Lists the loads of wheels on bodies that move.
void list_wheel_loads(std::span<const solve::DrivenVehicle> driven, const solve::SolverBodies& bodies,
                      std::vector<solve::Load>& out) {
    out.clear();
    for (const solve::DrivenVehicle& v : driven)
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i)
            if (const solve::WheelGround& ground = v.ground[i]; ground.shape && ground.body != bodies.still())
                out.push_back({ground.body, v.chassis, -ground.normal});
}

/// Converts rows of the state to the solver's data.
void prepare(const Tick& t, const Scene& scene, const solve::BodyColumns& columns) {
    TickScratch& s = t.s;
    Model& w = t.w;
    Tasks* const tasks = t.hooks.tasks;
    const bool other_step = find_constants(w.config(), s);
    s.paths.take(other_step, base::Path::step_kept, base::Path::step_new);
    const std::span<const JointMemory> memory = w.state.rows(w.m.joint_memory);
    solve::begin_step(columns, w.header().gravity, s.step, s.bodies, tasks);
    list_joints(w, s.joints);
    const bool same_joints = !s.joints.is_new && !other_step;
    if (!same_joints) solve::find_weak_forces(s.joints.all, columns, s.step, s.bodies);
    solve::stiffen_bodies(s.joints.all, memory, columns, s.step, s.bodies, tasks);
    solve::follow_turns(columns, s.step, s.bodies, tasks);
    list_fields(w, s.fields);
    const std::span<solve::DrivenVehicle> driven = s.vehicles.drive(scene);
    list_wheel_loads(driven, s.bodies, s.wheel_loads);
    solve::find_still_contacts(s.found.contacts, s.bodies);
    const bool any_pressed = s.pressed.find(s.found.contacts, s.wheel_loads, columns.mass.traits, s.bodies);
    s.paths.take(any_pressed, base::Path::none_pressed, base::Path::some_pressed);
    both_sets(
        t,
        [&](Tasks* by) {
            s.contacts.prepare(s.found.heads, s.found.contacts, s.table.list.memories, columns.mass, s.step,
                               s.bodies, columns.pose, contacts_are_alone(t), by);
        },
        [&](Tasks* by) {
            s.joint_solver.prepare(s.joints.all, memory, columns, s.step, s.bodies, by, same_joints);
        });
    s.vehicle_solver.prepare(driven, columns, s.step, s.bodies, tasks);
    s.fluids.prepare(w, t.placed, s.fields, s.step, s.bodies);
    s.joint_solver.update(s.step, s.bodies, tasks);
    passed(t, "prepare");
}

void substep(const Tick& t, const solve::FreeMotion& motion, const solve::BodyColumns& columns) {
    TickScratch& s = t.s;
    Tasks* const tasks = t.hooks.tasks;
    s.contacts.begin_substep(s.bodies);
    integrate_velocities(motion, columns, s.step, s.bodies, tasks);
    s.fluids.push(t.w, s.step, s.bodies, tasks);
    s.contacts.leave_forces_out(s.bodies);
    passed(t, "integrate");
    s.joint_solver.warm_start(s.step, s.bodies, tasks);
    s.vehicle_solver.warm_start(s.step, s.bodies);
    s.contacts.warm_start(s.bodies, tasks);
    s.contacts.rebound(s.step, s.bodies);
    passed(t, "warm_start");
    // Contacts come first: they take back the excess of a warm start after an impact before joints react to it.
    s.contacts.solve(s.step, s.bodies, /*bias=*/true, tasks);
    passed(t, "solve_contacts");
    s.joint_solver.solve(s.step, s.bodies, /*bias=*/true, tasks);
    s.vehicle_solver.solve(s.step, s.bodies, /*bias=*/true);
    passed(t, "solve_joints");
    integrate_poses(s.step, s.bodies, tasks);
    s.contacts.end_ways(s.bodies);
    passed(t, "integrate");
    s.joint_solver.update(s.step, s.bodies, tasks);
    passed(t, "update_joints");
    s.joint_solver.solve(s.step, s.bodies, /*bias=*/false, tasks);
    s.vehicle_solver.solve(s.step, s.bodies, /*bias=*/false);
    passed(t, "relax_joints");
    s.contacts.solve(s.step, s.bodies, /*bias=*/false, tasks);
    passed(t, "relax_contacts");
}

void solve_substeps(const Tick& t, const solve::BodyColumns& columns) {
    TickScratch& s = t.s;
    const solve::FreeMotion motion = motion_of(t);
    if (!s.contacts.has_all_passes()) {
        for (std::int32_t i = 0; i < s.step.substeps; ++i) substep(t, motion, columns);
        return;
    }
    if (s.contacts.has_islands()) {
        s.contacts.solve_islands(s.found.contacts, s.table.list.memories, columns.mass, s.step, s.bodies,
                                 t.hooks.tasks);
        return passed(t, "solve_contacts");
    }
    s.contacts.begin_substep(s.bodies);
    integrate_velocities(motion, columns, s.step, s.bodies, t.hooks.tasks);
    passed(t, "integrate");
    s.contacts.solve_substeps(s.step, s.bodies, t.hooks.tasks);
    passed(t, "solve_contacts");
}

/// Stores the solver's results in the contact table and the state.
void store(const Tick& t) {
    TickScratch& s = t.s;
    Model& w = t.w;
    const std::span<JointMemory> memory = w.state.edit(w.m.joint_memory, 0, w.header().joints_awake);
    both_sets(
        t, [&](Tasks* by) { s.contacts.store(s.found.contacts, s.table.list.memories, s.bodies.clamps, by); },
        [&](Tasks* by) {
            s.joint_solver.close(s.step, s.bodies);
            s.joint_solver.store_points(memory, by);
        });
    s.contacts.list_impacts(s.found.impacts);
    s.joint_solver.store(memory, s.bodies, s.bodies.clamps, t.hooks.tasks);
    s.vehicle_solver.store(s.step, s.bodies, s.vehicles.driven());
    s.vehicles.store(w);
}

void finish(const Tick& t) {
    TickScratch& s = t.s;
    Model& w = t.w;
    const solve::BodyColumns columns = w.body_columns();
    base::make_room(s.pose_before.list, columns.pose.size());
    s.pose_before.list.resize(columns.pose.size());
    solve::finish_step(s.step, s.bodies, columns, t.hooks.tasks, s.pose_before.list);
    forget_forces(w);
    Faults& faults = w.state.edit_row(w.m.faults, 0);
    faults.speed_clamped += s.bodies.clamps.speed;
    faults.position_clamped += s.bodies.clamps.position;
    faults.impulse_clamped += s.bodies.clamps.impulse;
}

/// Writes the contacts back to the state; then bodies that rest fall asleep.
void update_sleep(const Tick& t) {
    TickScratch& s = t.s;
    Model& w = t.w;
    s.table.write(w.state, w.m.contacts, t.hooks.tasks);
    find_resting(w, {s.found.heads, s.joints.all, s.vehicle_solver.standing()},
                 {s.pose_before, s.fluids.afloat()}, s.islands);
    s.paths.take(!s.islands.resting.empty(), base::Path::nothing_falls_asleep,
                 base::Path::islands_fall_asleep);
    if (s.islands.resting.empty()) return;
    find_contact_points(w, t.placed, s.pose_before, s.table.list, s.found, t.out.contact_points);
    put_to_sleep(w, t.placed, s.islands.resting, t.out.events);
}

// ---- the paths that a tick took --------------------------------------------------------------------------------

/// Calls visit(paths) for the sets of the phases. The solvers keep their own sets.
template <class Visit> void for_each_paths(const Tick& t, const Visit& visit) {
    TickScratch& s = t.s;
    visit(t.placed.paths), visit(t.placed.broad_phase.paths), visit(s.pair_scratch.paths);
    visit(s.contact_scratch.paths), visit(s.table.paths), visit(s.sweep.paths), visit(s.bodies.paths);
}
/// Clears the sets first: calls between ticks may have added paths that belong to no tick.
void begin_paths(const Tick& t) {
    TickScratch& s = t.s;
    s.contacts.take_paths(s.paths), s.joint_solver.take_paths(s.paths);
    for_each_paths(t, [](base::Paths& some) { some.clear(); });
    s.paths.clear();
    s.paths.take(base::worker_count(t.hooks.tasks) > 1, base::Path::one_worker, base::Path::many_workers);
    s.paths.take(s.contacts.level() != Simd::scalar, base::Path::lanes_scalar, base::Path::lanes_wide);
    const std::size_t most =
        std::max(t.w.state.rows(t.w.m.body_traits.row).size(), t.w.state.rows(t.w.m.shape_traits.row).size());
    s.paths.take(most > shared_rows_compared, base::Path::shared_rows_all_compared,
                 base::Path::shared_rows_beyond);
}
void end_paths(const Tick& t) {
    TickScratch& s = t.s;
    s.contacts.take_paths(s.paths), s.joint_solver.take_paths(s.paths);
    if (!s.vehicles.driven().empty())
        s.paths.take(s.vehicle_solver.has_convoys(), base::Path::vehicles_alone,
                     base::Path::vehicles_in_convoy);
    for_each_paths(t, [&](const base::Paths& some) { s.paths.add(some); });
}

} // namespace

void tick(Model& w, PlacedShapes& placed, QueryScratch& query, TickScratch& s, TickOutput& out,
          const TickHooks& hooks) {
    const Tick t{w, placed, s, out, hooks};
    const Scene scene{w, placed, query, hooks.tasks};
    out.events.clear(), out.contact_points.clear(), out.phase_hashes.clear();
    if (poisons_scratch && w.header().tick % 2 != 0) poison_scratch(w, placed, query, s, std::byte{0xa5});
    begin_paths(t);
    checkpoint(t, "commands");

    move_characters(w, placed, s.characters, hooks.tasks);
    passed(t, "move_characters");
    find_near(t, scene);
    collide(w, placed, s.characters, s.near, s.table.list, s.contact_scratch, s.found, hooks.tasks);
    checkpoint_with_contacts(t, "collide");
    const solve::BodyColumns columns = w.body_columns();
    prepare(t, scene, columns);

    solve_substeps(t, columns);
    store(t);
    checkpoint_with_contacts(t, "solve");
    finish(t);
    checkpoint_with_contacts(t, "finish");
    if (w.config().continuous != 0)
        sweep_fast_bodies(w, placed, s.pose_before, s.contact_scratch.workers, s.sweep, hooks.tasks);
    checkpoint_with_contacts(t, "sweep_fast_bodies");

    break_joints(w, s.joints, s.broken, out.events);
    settle_touching(s.found.results, s.table.list, s.paths, hooks.tasks);
    publish_events(w, placed, s.near, s.found, s.characters.landings, s.table.list, out.events);
    if (w.config().continuous != 0)
        find_crossings(w, placed, s.pose_before, s.table.list, s.contact_scratch.workers[0], s.sweep,
                       out.events);
    out.contact_points.wait = true;
    update_sleep(t);
    order_events(out.events);
    ++w.edit_header().tick;
    placed.is_current = false;
    end_paths(t);
    checkpoint(t, "update_sleep");
}

} // namespace lockstone::sim
