#include "solve/joints/joint.h"

#include "base/poison.h"
#include "base/prefetch.h"
#include "lockstone/math/math.h"
#include "solve/joints/joint_work.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>

namespace lockstone::solve {

JointSolver::JointSolver(const JointKernel& lanes) : work(std::make_unique<JointTick>()), kernel(&lanes) {}
JointSolver::~JointSolver() = default;
JointSolver::JointSolver(JointSolver&&) noexcept = default;
JointSolver& JointSolver::operator=(JointSolver&&) noexcept = default;

void JointSolver::reserve(std::size_t joints) {
    work->joints.reserve(joints);
    work->blocks.reserve(2 * joints);
    work->axes.reserve(7 * joints);
    work->packs.reserve(joints), work->turn_packs.reserve(joints), work->axis_packs.reserve(joints),
        work->steps.reserve(joints);
    work->singles.reserve(joints), work->with_rows.reserve(joints), work->acts.reserve(joints),
        work->glances.reserve(joints);
    work->packed.reserve(pack_lanes * joints), work->in_order.reserve(joints),
        work->before_sort.reserve(joints);
    work->last_stage.reserve(2 * joints), work->counts.reserve(5 * joints + 1);
    work->wanted.reserve(2 * joints), work->bodies.reserve(2 * joints), work->planned.reserve(2 * joints);
}

void JointSolver::poison(std::byte with) {
    auto& [joints, blocks, axes, packs, turn_packs, axis_packs, steps, down, up, singles, with_rows,
           framed_in_world, glances, held, turned, seen, wanted, given, acts, packed, last_stage, last_piece,
           counts, in_order, before_sort, bodies, planned, has_plan, planned_for, forest, cache_of, closed,
           pose, memory, clamped, ticks_per_second, first, paths, counter] = *work;
    base::poison(with, joints, blocks, axes, packs, turn_packs, axis_packs, steps, singles, with_rows,
                 framed_in_world, glances, held, turned, seen, wanted, given, acts, packed, last_stage,
                 last_piece, counts, in_order, before_sort, bodies, planned, cache_of, pose, memory, clamped,
                 ticks_per_second, first);
    base::poison(with, closed.of_body, closed.of_pack, closed.of_four, closed.stopped, closed.pushed,
                 closed.velocities, closed.packs);
    has_plan = false, planned_for = 0;
    down.clear(), up.clear();
    auto& [trees, nodes, edges, links, component, first_of, hung, node_of, size, root, anchor_of, loops,
           anchors, loose, above_of, above, carried, queue] = forest;
    base::poison(with, trees, nodes, edges, links, component, first_of, hung, node_of, size, root, anchor_of,
                 loops, anchors, loose, above_of, above, carried, queue);
}

std::string JointSolver::order_fault() const { return solve::order_fault(*work); }
void JointSolver::take_paths(base::Paths& to) {
    to.add(work->paths);
    work->paths.clear();
}

namespace {

std::uint32_t cached(JointTick& tick, std::uint32_t body, const BodyColumns& columns,
                     const SolverBodies& bodies) {
    std::uint32_t& at = tick.cache_of[body];
    if (at == 0) {
        make_room(tick.bodies);
        tick.bodies.push_back({});
        tick.bodies.back().body = body;
        start_body(tick.bodies.back(), columns.pose[body], bodies);
        at = static_cast<std::uint32_t>(tick.bodies.size());
    }
    return at - 1;
}

/// Fills one side of a joint. For a body that moves, levers are clamped to 128 m.
void set_side(JointTick& tick, JointWorkSide& s, JointFrame& own, bool framed, const Transform& frame,
              const BodyColumns& columns, const SolverBodies& bodies) {
    own.rotation = framed ? unit_of(frame.rotation) : frame.rotation;
    s.world = s.body == bodies.still() || !bodies.step[s.body].moves;
    if (s.body == bodies.still()) {
        own.anchor = frame.position;
        return;
    }
    const Vec3 lever = frame.position - columns.mass[s.body].center;
    if (s.world) {
        const Transform& pose = columns.pose[s.body];
        own.anchor = pose.position + rotate(pose.rotation, lever);
        if (framed) own.rotation = normalized(pose.rotation * frame.rotation);
        return;
    }
    s.cache = cached(tick, s.body, columns, bodies);
    own.lever = to<Length>(lever);
}

Real mul_share(Real mass, Share share) {
    return Real::from_raw(narrow_rounded(Wide::product(mass.raw, share.mantissa), 30 + share.shift));
}

/// mA mB / (mA + mB); the mass of the only body that moves, or zero
Real reduced_mass(const Shares& shares, const BodyMass& a, const BodyMass& b) {
    return shares.a.mantissa != 0 ? mul_share(a.mass, shares.a) : mul_share(b.mass, shares.b);
}

/// True if the joint is a point and has no other parts.
bool is_point(const JointWork& w) { return w.point && w.axis_count == 0 && w.block_count == 0; }
/// True if the joint is a point in a pack and has no other parts.
bool is_packed_point(const JointWork& w) {
    return w.pack != no_pack && w.axis_count + w.block_count == 0 && !w.counts_turns;
}

/// Calls visit(joint) for each joint that is more than a point in a pack. Workers share the joints.
template <class Visit> void for_joints(JointTick& tick, Tasks* tasks, Visit&& visit) {
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.with_rows.size()), joint_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) visit(tick.joints[tick.with_rows[i]]);
                     });
}

/// Calls visit(pack, its index) for each pack. Workers share the packs.
template <class Visit> void for_packs(JointTick& tick, Tasks* tasks, Visit&& visit) {
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.packs.size()), pack_chunk_of(tick.packs.size()),
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) visit(tick.packs[i], i);
                     });
}

void start_packs(JointTick& tick, const JointKernel& kernel, const StepConstants& step,
                 const SolverBodies& bodies, Tasks* tasks) {
    if (tick.packs.empty()) return;
    static_assert(offsetof(JointBody, radii_bits) == offsetof(JointBody, rotation) + sizeof(Quat));
    const JointStartData data{tick.packs.data(), tick.turn_packs.data(), bodies.step.data(),
                              reinterpret_cast<const std::byte*>(&tick.bodies.front().rotation),
                              step.joint_push_max.raw};
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.packs.size()), pack_chunk_of(tick.packs.size()),
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) start_points(tick, i);
                         kernel.start(data, first, last);
                     });
}

void turn_held(JointTick& tick, const JointKernel& kernel, const StepConstants& step,
               const SolverBodies& bodies, Tasks* tasks) {
    // The pass only reads bodies. The cast is needed because JointPassData is also used by passes that write.
    turn_bodies(tick, kernel, pass_data(tick, step, const_cast<SolverBody*>(bodies.body.data())), bodies,
                tasks);
}

/// Makes rows and biases of points at the present poses, and the inverses of all rows that packs make. `pass`: the
/// kernel function that does it. Calls `before(index)` before the rows of a pack are made and `after(pack)` after.
template <class Before, class After>
void refresh_packs(JointTick& tick, const JointKernel& kernel, decltype(JointKernel::refresh) pass,
                   const StepConstants& step, const SolverBodies& bodies, Tasks* tasks, const Before& before,
                   const After& after) {
    // These passes only read bodies. The cast is needed because JointPassData is also used by passes that write.
    const JointPassData data = pass_data(tick, step, const_cast<SolverBody*>(bodies.body.data()));
    const auto count = static_cast<std::uint32_t>(tick.packs.size());
    std::atomic<bool> any_asks = false;
    base::for_chunks(tasks, count, tasks == nullptr ? packs_in_cache : pack_chunk_of(count),
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) before(i);
                         pass(data, first, last);
                         for (std::uint32_t i = first; i < last; ++i) {
                             if (tick.packs[i].over != 0) enlarge_exponents(tick, i, pass, data, step);
                             after(tick.packs[i]);
                         }
                         for (std::uint32_t end = first; first < last; first = end + 1) {
                             for (end = first; end < last && !asks_for_rows(tick, end);) ++end;
                             if (end != first)
                                 invert_some(tick, first, end, kernel, data), kernel.join(data, first, end);
                             if (end != last) any_asks.store(true, std::memory_order_relaxed);
                         }
                     });
    for (std::uint32_t i = 0; i < count && any_asks.load(std::memory_order_relaxed);
         ++i) { // sequential: these joints place bodies that several packs share
        if (!asks_for_rows(tick, i)) continue;
        make_asked_rows(tick, i, step, bodies);
        settle_asks(tick.packs[i]);
        invert_some(tick, i, i + 1, kernel, data);
        kernel.join(data, i, i + 1);
    }
}

} // namespace

void enlarge_exponents(JointTick& tick, std::uint32_t p, decltype(JointKernel::refresh) pass,
                       const JointPassData& data, const StepConstants& step) {
    JointPack& pack = tick.packs[p];
    while (pack.over != 0) {
        for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
            if (((pack.over >> lane) & 1u) == 0) continue;
            JointWork& w = tick.joints[tick.packed[p * pack_lanes + lane]];
            enlarge_exponent(pack, w, step);
            pack.stale[lane] = -1; // the inverse belongs to the old rows
        }
        pass(data, p, p + 1);
    }
}

void settle_asks(JointPack& pack) { std::copy_n(pack.asks_next, pack_lanes, pack.asks); }

void invert_some(JointTick& tick, std::uint32_t first, std::uint32_t last, const JointKernel& kernel,
                 const JointPassData& data) {
    if (!kernel.invert(data, first, last)) return;
    for (std::uint32_t i = first; i < last; ++i)
        for (std::uint32_t lane = 0; lane < tick.packs[i].count; ++lane)
            invert_left(tick.packs[i], data.turns, lane);
}

void set_glance(JointTick& tick, const JointWork& work, bool own_rows, bool axes_alone) {
    JointGlance& glance = tick.glances[static_cast<std::size_t>(&work - tick.joints.data())];
    const auto at = [](const JointWorkSide& s) { return s.world ? 0 : s.cache + 1; };
    const bool packed = work.pack != no_pack;
    std::uint8_t rows_ask = seen_stirred, asks = seen_stirred;
    if (work.steady) {
        rows_ask = axes_alone ? seen_far | seen_followed : seen_strays;
        asks = packed && (!own_rows || axes_alone) ? seen_strays_far : seen_strays;
    }
    glance = {at(work.a), at(work.b), rows_ask, own_rows, own_rows || !packed, false};
    if (packed) tick.packs[work.pack].asks_next[work.lane] = asks;
}

void set_glance(JointTick& tick, const JointWork& work) {
    set_glance(tick, work, has_own_rows(tick, work), has_axes_alone(tick, work));
}

namespace {

PlannedBody planned_of(std::uint32_t body, const SolverBodies& bodies) {
    const BodyStep& step = bodies.step[body];
    return {step.moves, step.movable, fits_pack(body, bodies)};
}

/// Plans which bodies have joints, the parts of each joint, and the order of solving.
void plan_joints(JointTick& tick, std::span<const Joint> joints, std::span<const JointMemory> memory,
                 const BodyColumns& columns, const StepConstants& step, const SolverBodies& bodies,
                 std::uint32_t workers) {
    tick.joints.clear(), tick.blocks.clear(), tick.axes.clear(), tick.bodies.clear();
    tick.cache_of.assign(bodies.body.size(), 0);
    constexpr BodyMass none{};
    for (const Joint& joint : joints) {
        JointWork& w = tick.joints.emplace_back();
        w.pack = no_pack;
        w.def = joint.def;
        w.memory = joint.memory;
        w.a.body = joint.body_a, w.b.body = joint.body_b;
        const BodyMass& ma = joint.body_a == bodies.still() ? none : columns.mass[joint.body_a];
        const BodyMass& mb = joint.body_b == bodies.still() ? none : columns.mass[joint.body_b];
        w.shares = joint_shares(ma, bodies.step[joint.body_a], mb, bodies.step[joint.body_b]);
        w.mass = reduced_mass(w.shares, ma, mb);
        w.counts_turns = counts_turns(*w.def);
        w.twist = memory[joint.memory].twist;
        w.travel = memory[joint.memory].twist;
        assemble(tick, w, step, memory[joint.memory]);
        w.framed = !is_point(w);
        set_side(tick, w.a, w.frame_a, w.framed, joint.frame_a, columns, bodies);
        set_side(tick, w.b, w.frame_b, w.framed, joint.frame_b, columns, bodies);
        w.stays = may_stay(tick, w);
    }
    plan_trees(tick, columns, step, bodies);
    plan_packs(tick, step, bodies, workers);
    tick.planned_for = workers;
    tick.with_rows.clear(), tick.framed_in_world.clear();
    for (std::uint32_t i = 0; i < tick.joints.size(); ++i) {
        JointWork& w = tick.joints[i];
        if (w.a.world || w.b.world) tick.framed_in_world.push_back(i);
        if (w.pack != no_pack) tick.packs[w.pack].whole[w.lane] = is_packed_point(w);
        if (is_packed_point(w)) {
            w.steady = w.stays, w.made = true; // its pack makes everything
            continue;
        }
        tick.with_rows.push_back(i);
        for (const JointWorkSide* s : {&w.a, &w.b})
            if (!s->world && !w.hinge) {
                tick.bodies[s->cache].motion_asked = true;
                tick.bodies[s->cache].lever_asked |= w.needs_lever;
            }
    }
    tick.planned.clear();
    for (JointBody& now : tick.bodies) {
        tick.planned.push_back(planned_of(now.body, bodies));
        if (now.motion_asked) start_motion(now, columns.pose[now.body], bodies);
    }
    tick.has_plan = tick.forest.trees.empty();
}

/// True if the plan of the last tick is still valid. The size of a body's K^-1, which decides if the body fits into a
/// pack, changes from tick to tick.
bool is_plan_good(const JointTick& tick, std::size_t joints, const SolverBodies& bodies, Tasks* tasks) {
    if (!tick.has_plan || tick.planned_for != base::worker_count(tasks) || tick.joints.size() != joints)
        return false;
    constexpr std::uint32_t ahead = 8;
    const std::uint32_t count = static_cast<std::uint32_t>(tick.bodies.size());
    std::atomic<bool> is_good = true;
    base::for_all_chunks(tasks, count, body_chunk,
                         [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                             for (std::uint32_t i = first; i < last; ++i) {
                                 if (i + ahead < count) {
                                     const BodyStep& next = bodies.step[tick.bodies[i + ahead].body];
                                     base::prefetch(next.moves), base::prefetch(next.radii_inv);
                                 }
                                 if (tick.planned[i] != planned_of(tick.bodies[i].body, bodies))
                                     is_good.store(false, std::memory_order_relaxed);
                             }
                         });
    return is_good.load(std::memory_order_relaxed);
}

/// Has the result of plan_joints(), but starts from the plan of the last tick.
void keep_plan(JointTick& tick, std::span<const Joint> joints, const BodyColumns& columns,
               const SolverBodies& bodies, Tasks* tasks) {
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.bodies.size()), body_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) {
                             JointBody& now = tick.bodies[i];
                             start_body(now, columns.pose[now.body], bodies);
                             if (now.motion_asked) start_motion(now, columns.pose[now.body], bodies);
                         }
                     });
    for_joints(tick, tasks, [&](JointWork& w) {
        w.twist = tick.memory[w.memory].twist;
        if (w.needs_travel) w.travel = w.twist;
        w.made = w.remade = w.steady = false;
        reassemble(tick, w);
    });
    for (const std::uint32_t i : tick.framed_in_world) {
        JointWork& w = tick.joints[i];
        if (w.a.world) set_side(tick, w.a, w.frame_a, w.framed, joints[i].frame_a, columns, bodies);
        if (w.b.world) set_side(tick, w.b, w.frame_b, w.framed, joints[i].frame_b, columns, bodies);
        if (w.hinge) set_hinge_frames(tick, w);
    }
    for_packs(tick, tasks, [&](JointPack& pack, std::uint32_t) { restart_pack(tick, pack); });
}

} // namespace

void JointSolver::prepare(std::span<const Joint> joints, std::span<const JointMemory> memory,
                          const BodyColumns& columns, const StepConstants& step, const SolverBodies& bodies,
                          Tasks* tasks, bool same) {
    JointTick& tick = *work;
    const bool stays_empty = joints.empty() && tick.joints.empty(); // then all planned data is empty too
    tick.pose = columns.pose, tick.memory = memory;
    tick.clamped = 0;
    tick.ticks_per_second = step.ticks_per_second;
    tick.first = true;
    if (stays_empty) return;
    const bool kept = same && is_plan_good(tick, joints.size(), bodies, tasks);
    tick.paths.take(kept, base::Path::joint_plan_made, base::Path::joint_plan_kept);
    if (kept)
        keep_plan(tick, joints, columns, bodies, tasks);
    else
        plan_joints(tick, joints, memory, columns, step, bodies, base::worker_count(tasks));
    note_plan(tick, tasks);
    tick.counter.begin(bodies.body.size());
    if constexpr (checks_order) {
        const std::string fault = kept ? std::string() : solve::order_fault(tick);
        LOCKSTONE_ASSERT(fault.empty(), fault);
    }
    tick.glances.resize(tick.joints.size());
    for (const JointWork& w : std::span(tick.joints).first(kept ? 0 : tick.joints.size()))
        if (is_packed_point(w)) set_glance(tick, w); // does not change later
    hold_bodies(tick, bodies, tasks);
    turn_held(tick, *kernel, step, bodies, tasks);
    start_packs(tick, *kernel, step, bodies, tasks);
    for_joints(tick, tasks, [&](JointWork& w) { make_rows(tick, w, step, bodies); });
    refresh_packs(
        tick, *kernel, kernel->begin, step, bodies, tasks,
        [&](std::uint32_t pack) { settle_asks(tick.packs[pack]); },
        [](JointPack& pack) {
            for (std::uint32_t lane = 0; lane < pack_lanes; ++lane)
                pack.bias_before[lane] = std::max({std::abs(pack.bias[0][lane]), std::abs(pack.bias[1][lane]),
                                                   std::abs(pack.bias[2][lane])});
        });
    factorise_trees(tick, bodies, tasks);
}

namespace {

/// Finds joints with stale rows, and the bodies to place before new rows are made. Returns true if any joint has rows
/// of its own.
bool find_stale_joints(JointTick& tick) {
    bool any = false;
    tick.wanted.clear();
    JointGlance* const glances = tick.glances.data();
    std::uint8_t* const seen = tick.seen.data();
    for (const std::uint32_t i : tick.with_rows) { // excludes joints that are only points
        JointGlance& glance = glances[i];
        if (!glance.places) continue;
        any = any || glance.own_rows;
        glance.stale = ((seen[glance.a] | seen[glance.b]) & glance.rows_ask) != 0;
        tick.paths.take(glance.stale, base::Path::joint_rows_kept, base::Path::joint_rows_remade);
        if (!glance.stale) continue;
        for (const std::uint32_t body : {glance.a, glance.b}) {
            if (body == 0 || (seen[body] & seen_wanted) != 0) continue;
            seen[body] |= seen_wanted;
            tick.wanted.push_back(body - 1);
        }
    }
    return any;
}

/// Finds the stale lanes of a pack by the motion of their bodies, and copies the K^-1 of followed bodies to them.
void find_stale_lanes(JointTick& tick, std::uint32_t i, const SolverBodies& bodies) {
    const auto seen_of = [seen = tick.seen.data()](const PackSide& side, std::uint32_t lane) {
        return static_cast<std::uint32_t>(seen[side.turned[lane] / sizeof(TurnedBody)]);
    };
    JointPack& pack = tick.packs[i];
    std::uint32_t any = 0;
    for (std::uint32_t lane = 0; lane < pack_lanes; ++lane) {
        const std::uint32_t seen = seen_of(pack.a, lane) | seen_of(pack.b, lane);
        pack.stale[lane] = (seen & pack.asks[lane]) != 0 ? -1 : 0;
        any |= seen;
    }
    settle_asks(pack);
    for (std::uint32_t lane = 0; (any & seen_followed) != 0 && lane < pack.count; ++lane)
        give_gyration(tick, tick.joints[tick.packed[i * pack_lanes + lane]], bodies);
}

/// Computes the present placement of the bodies in JointTick::wanted.
void place_wanted(JointTick& tick, const SolverBodies& bodies, Tasks* tasks) {
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.wanted.size()), body_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) {
                             JointBody& body = tick.bodies[tick.wanted[i]];
                             place_body(body, tick.pose[body.body], bodies);
                         }
                     });
}

/// Updates the rows that packs do not make: makes stale rows again, and updates the errors of the others.
void follow_joints(JointTick& tick, const StepConstants& step, const SolverBodies& bodies, Tasks* tasks) {
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.with_rows.size()), joint_chunk,
                     [&, rows = tick.with_rows.data(),
                      glances = tick.glances.data()](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) {
                             const JointGlance& glance = glances[rows[i]];
                             if (!glance.own_rows) continue;
                             if (glance.stale)
                                 make_rows(tick, tick.joints[rows[i]], step, bodies);
                             else
                                 follow_errors(tick, tick.joints[rows[i]], step, bodies);
                         }
                     });
}

} // namespace

void JointSolver::update(const StepConstants& step, const SolverBodies& bodies, Tasks* tasks) {
    JointTick& tick = *work;
    if (tick.joints.empty()) return;
    if (tick.first) { // nothing has moved before the first substep
        for_joints(tick, tasks, [&](JointWork& w) {
            if (w.pack == no_pack) follow_errors(tick, w, step, bodies);
        });
        return;
    }
    turn_held(tick, *kernel, step, bodies, tasks);
    const bool own_rows = find_stale_joints(tick);
    place_wanted(tick, bodies, tasks);
    if (own_rows) follow_joints(tick, step, bodies, tasks);
    refresh_packs(
        tick, *kernel, kernel->refresh, step, bodies, tasks,
        [&](std::uint32_t pack) { find_stale_lanes(tick, pack, bodies); }, [](const JointPack&) {});
    factorise_trees(tick, bodies, tasks);
}

// ---- after the substeps -------------------------------------------------------------------------------------------

namespace {

/// Sums of impulses over the tick along world directions, unscaled.
struct Wrench {
    Vec3 force, torque;
    void add(Real sum, Vec3 direction, bool is_force) {
        if (sum != Real{}) (is_force ? force : torque) += direction * sum;
    }
};

void store_axis(const JointAxisPart& part, JointMemory& memory, Wrench& wrench) {
    if ((part.spring | part.motor | part.lower | part.upper) == 0 && part.sum == Real{}) return; // stays zero
    const auto unscaled = [&](std::int32_t p) { return unscaled_impulse(p, part.exponent); };
    wrench.add(part.sum + unscaled(part.spring) + unscaled(part.motor) + unscaled(part.lower) +
                   unscaled(part.upper),
               part.direction, part.is_force);
    if (part.features & is_swing) {
        memory.swing = unscaled(part.upper);
        return;
    }
    JointAxisImpulses& axis = memory.axis[part.slot];
    if (part.features & has_spring) axis.spring = unscaled(part.spring);
    if (part.features & has_motor) axis.motor = unscaled(part.motor);
    if (part.features & has_lower) axis.lower = unscaled(part.lower);
    if (part.features & has_upper) axis.upper = unscaled(part.upper);
}

void store_point(const JointPack& pack, std::uint32_t lane, JointMemory& memory, Wrench& wrench) {
    const int e = pack.exponent[lane], up = Real::fraction_bits - Speed::fraction_bits - e;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t p = pack.impulse[i][lane], sum = pack.sum[i][lane] + p;
        const bool fits = up >= 0 && magnitude(sum) >> 48 == 0; // true for all but the smallest levers
        memory.axis[static_cast<std::size_t>(i)].spring =
            fits ? Real::from_raw(p << up) : unscaled_impulse(p, e);
        wrench.force[i] += fits ? Real::from_raw(sum << up) : unscaled_impulse(sum, e);
    }
}

void store_block(const JointBlock& block, JointMemory& memory, Wrench& wrench) {
    for (int i = 0; i < block.count; ++i) {
        const Real p = unscaled_impulse(block.impulse[i], block.exponent);
        memory.axis[block.slot[i]].spring = p;
        wrench.add(block.sum[i] + p, block.direction[i], block.is_force[i]);
    }
}

/// Stores the impulses of a hinge whose rows its pack makes.
void store_hinge(const TurnPack& turn, std::uint32_t lane, JointMemory& memory, Wrench& wrench) {
    const int e = turn.exponent[lane], up = Real::fraction_bits - Speed::fraction_bits - e;
    const bool small = up >= 0 && up <= 20;
    for (std::size_t r = 0; r < 2; ++r) {
        const std::int64_t now = turn.impulse[r][lane], before = turn.sum[r][lane];
        const bool fits =
            small && magnitude(now + before) >> (34 - up) == 0; // true except for the heaviest loads
        const Real p = fits ? Real::from_raw(now << up) : unscaled_impulse(now, e);
        memory.axis[about_y + r].spring = p;
        if (!fits) {
            wrench.add(unscaled_impulse(before, e) + p, hinge_axis(turn, r, lane), false);
            continue;
        }
        const std::int64_t sum = (now + before) << up; // 34 bits times 29
        for (int i = 0; i < 3; ++i)
            wrench.torque[i] += Real::from_raw(
                shift_right_rounded(turn.axis[r][static_cast<std::size_t>(i)][lane] * sum, row_bits));
    }
}

void store_blocks(JointTick& tick, const JointWork& w, JointMemory& memory, Wrench& wrench) {
    TurnPack* const turn = w.turns_packed ? &turn_pack(tick, w) : nullptr;
    if (turn != nullptr && turn->generic[w.lane] == 0) return store_hinge(*turn, w.lane, memory, wrench);
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        JointBlock& block = tick.blocks[w.first_block + i];
        if (turn != nullptr) take_impulses(block, *turn, w.lane);
        store_block(block, memory, wrench);
    }
}

/// Converts the impulse of a tick to a force or a torque. The order of the products matters only for masses whose
/// product with the rate exceeds Real: even then the force may be in range.
Vec3 force_of(const JointTick& tick, Vec3 impulse, Real mass) {
    const Real mass_rate = mass * tick.ticks_per_second;
    if (mass_rate != Real::max()) return impulse * mass_rate;
    return impulse * Real(tick.ticks_per_second) * mass;
}

/// Stores the joints that are only a point in a pack.
void store_points(const JointTick& tick, const JointPack& pack, std::span<JointMemory> memory) {
    for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
        if (pack.whole[lane] == 0) continue;
        JointMemory& m = memory[pack.memory[lane]];
        Wrench wrench{};
        m = {};
        store_point(pack, lane, m, wrench);
        m.force = force_of(tick, wrench.force, Real::from_raw(pack.mass[lane]));
    }
}

} // namespace

void JointSolver::store_points(std::span<JointMemory> memory, Tasks* tasks) const {
    for_packs(*work, tasks,
              [&](const JointPack& pack, std::uint32_t) { solve::store_points(*work, pack, memory); });
}

void JointSolver::store(std::span<JointMemory> memory, const SolverBodies& bodies, ClampCounts& clamps,
                        Tasks* tasks) const {
    JointTick& tick = *work;
    for_joints(tick, tasks, [&](const JointWork& w) {
        JointMemory& m = memory[w.memory];
        m.axis = {}, m.swing = Real{};
        if (w.pack != no_pack) take_axes(tick, w);
        Wrench wrench{};
        for (std::uint32_t k = 0; k < w.axis_count; ++k) store_axis(tick.axes[w.first_axis + k], m, wrench);
        store_blocks(tick, w, m, wrench);
        if (w.pack != no_pack) store_point(tick.packs[w.pack], w.lane, m, wrench);
        m.twist = w.needs_travel   ? w.travel
                  : w.counts_turns ? twist_to_store(tick, w, m.twist, bodies)
                                   : Real{}; // its whole turns have no effect
        m.force = force_of(tick, wrench.force, w.mass);
        m.torque = wrench.torque == Vec3{} ? Vec3{} : force_of(tick, wrench.torque, w.mass);
    });
    base::add_count(clamps.impulse, tick.clamped);
}

} // namespace lockstone::solve
