// Closes points of joints that an impact opened, before the tick ends.
//
// A figure that lands on stretched legs is stopped at its feet within a substep. One pass over its joints carries the
// impulse only as far as their order allows, so a hip opens by centimetres and closes over the next ticks. After the
// substeps, open points are therefore closed by moving bodies: passes over the points and hinges of packs, each from
// bodies at rest and from zero impulses, remove the whole error. Only joints of pushed bodies pull: a body is pushed
// if it belongs to an open point, or if a pass over a joint moves it. All other bodies stay unchanged, to the bit.
// Velocities and impulses are restored afterwards. Bodies may penetrate what they touch by the correction, which
// contacts remove later.
// source: errors of positions solved apart from velocities: Bender, Mueller, Macklin, A survey on position based
// dynamics (2017)
#include "solve/joints/joint_work.h"

#include "lockstone/math/math.h"

#include <algorithm>
#include <cstdlib>

namespace lockstone::solve {

namespace {

/// Gaps below this are left to the next substeps [m].
constexpr std::int32_t open_gap = decimal<Separation>("0.006").raw;
/// A gap that grew by less since the tick began is not closed: a load may keep it open [m].
constexpr std::int32_t opened_gap = decimal<Separation>("0.003").raw;
/// If a pass moves bodies by less than about this, their other joints are not included [m].
constexpr std::int32_t push_gap = decimal<Separation>("0.0005").raw;
/// Upper bound of the number of passes. A large correction in a net spreads slowly over its joints.
constexpr int passes_max = 16;

/// Flags in ClosedPoints::of_body.
constexpr std::uint8_t is_stopped = 1, is_pushed = 2;

class Closer {
    JointTick& tick;
    ClosedPoints& closed;
    const StepConstants& step;
    SolverBodies& bodies;
    const JointKernel& kernel;
    JointPassData data;

    static std::uint32_t body_of(const PackSide& side, std::uint32_t lane) {
        return side.place[lane] / static_cast<std::uint32_t>(sizeof(SolverBody));
    }
    JointWork& joint_of(std::uint32_t p, std::uint32_t lane) {
        return tick.joints[tick.packed[p * pack_lanes + lane]];
    }
    TurnPack* turn_of(const JointPack& pack) {
        return pack.turn_rows != 0 ? &tick.turn_packs[pack.turn] : nullptr;
    }

    // ---- open points and pushed bodies ---------------------------------------------------------------------------

    /// The speed that closes a gap at the rate of `data`, for e = 0.
    std::int32_t speed_for(std::int32_t gap) const {
        return static_cast<std::int32_t>(
            (std::int64_t{gap} * data.rate) >>
            (joint_rate_bits + Separation::fraction_bits - Speed::fraction_bits));
    }
    static bool is_beyond(const std::int32_t (&x)[3][pack_lanes], std::uint32_t lane, std::int32_t most) {
        return std::abs(x[0][lane]) > most || std::abs(x[1][lane]) > most || std::abs(x[2][lane]) > most;
    }
    /// True if the point of a lane is off by more than open_gap, according to its bias.
    bool is_open(const JointPack& pack, std::uint32_t lane) const {
        return is_beyond(pack.bias, lane, speed_for(open_gap) >> pack.exponent[lane]);
    }
    /// True if the gap grew since the tick began. A gap that a load keeps open did not.
    bool has_opened(const JointPack& pack, std::uint32_t lane) const {
        std::int32_t now = 0;
        for (const auto& bias : pack.bias) now = std::max(now, std::abs(bias[lane]));
        return now - pack.bias_before[lane] > speed_for(opened_gap) >> pack.exponent[lane];
    }
    void push(std::uint32_t body) {
        if (!bodies.step[body].movable || (closed.of_body[body] & is_pushed) != 0) return;
        closed.of_body[body] |= is_pushed;
        closed.pushed.push_back(body);
    }
    void push(const JointPack& pack, std::uint32_t lane) {
        push(body_of(pack.a, lane)), push(body_of(pack.b, lane));
    }
    bool is_lane_pushed(const JointPack& pack, std::uint32_t lane) const {
        return ((closed.of_body[body_of(pack.a, lane)] | closed.of_body[body_of(pack.b, lane)]) &
                is_pushed) != 0;
    }
    bool is_any_pushed(const JointPack& pack) const {
        for (std::uint32_t lane = 0; lane < pack.count; ++lane)
            if (is_lane_pushed(pack, lane)) return true;
        return false;
    }

    // ---- saved velocities and impulses ---------------------------------------------------------------------------

    /// Saves the velocity of a body and sets it to zero until all points are closed.
    void stop(std::uint32_t body) {
        if ((closed.of_body[body] & is_stopped) != 0) return;
        closed.of_body[body] |= is_stopped;
        closed.stopped.push_back(body);
        SolverBody& b = bodies.body[body];
        for (auto* x : {&b.v, &b.u})
            for (std::int64_t& part : *x) {
                make_room(closed.velocities);
                closed.velocities.push_back(part), part = 0;
            }
    }
    static void clear_impulses(JointPack& pack, TurnPack* turn) {
        std::fill_n(&pack.impulse[0][0], 3 * pack_lanes, 0);
        if (turn != nullptr) std::fill_n(&turn->impulse[0][0], 3 * pack_lanes, 0);
    }
    static void clear_biases(JointPack& pack, TurnPack* turn, std::uint32_t lane) {
        for (auto& bias : pack.bias) bias[lane] = 0;
        for (int r = 0; turn != nullptr && r < 3; ++r) turn->bias[r][lane] = 0;
    }
    /// Saves and clears the impulses of a pack, and stops its bodies. The kernel processes all lanes of a pack, so
    /// this covers lanes that do not pull as well.
    void take(std::uint32_t p) {
        if (closed.of_pack[p] != 0) return;
        closed.of_pack[p] = 1;
        JointPack& pack = tick.packs[p];
        TurnPack* const turn = turn_of(pack);
        make_room(closed.packs);
        ClosedPack& kept = closed.packs.emplace_back();
        kept.pack = p;
        std::copy_n(pack.exponent, pack_lanes, kept.exponent);
        std::copy_n(&pack.impulse[0][0], 3 * pack_lanes, &kept.point[0][0]);
        if (turn != nullptr) std::copy_n(&turn->impulse[0][0], 3 * pack_lanes, &kept.turn[0][0]);
        clear_impulses(pack, turn);
        for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
            stop(body_of(pack.a, lane)), stop(body_of(pack.b, lane));
            clear_biases(pack, turn, lane);
        }
    }
    void give_back() {
        std::size_t at = 0;
        for (const std::uint32_t body : closed.stopped) {
            SolverBody& b = bodies.body[body];
            for (auto* x : {&b.v, &b.u})
                for (std::int64_t& part : *x) part = closed.velocities[at++];
        }
        for (const ClosedPack& kept : closed.packs) {
            JointPack& pack = tick.packs[kept.pack];
            for (int r = 0; r < 3; ++r)
                for (std::uint32_t lane = 0; lane < pack_lanes; ++lane)
                    pack.impulse[r][lane] =
                        rescaled_impulse(kept.point[r][lane], kept.exponent[lane], pack.exponent[lane]);
            if (TurnPack* const turn = turn_of(pack); turn != nullptr)
                std::copy_n(&kept.turn[0][0], 3 * pack_lanes, &turn->impulse[0][0]);
        }
    }

    // ---- a pass --------------------------------------------------------------------------------------------------

    /// Updates the placement of the stopped bodies, in groups of four.
    void look_at_bodies() {
        closed.of_four.assign(tick.held.size(), 0);
        for (const std::uint32_t body : closed.stopped) {
            const std::uint32_t at = tick.cache_of[body]; // 0: it does not move
            if (at == 0 || closed.of_four[(at - 1) / pack_lanes] != 0) continue;
            closed.of_four[(at - 1) / pack_lanes] = 1;
            turn_four(tick, (at - 1) / pack_lanes, kernel, data, bodies);
        }
    }
    void follow_joint(std::uint32_t p, std::uint32_t lane) {
        const JointGlance& glance = tick.glances[tick.packed[p * pack_lanes + lane]];
        const int seen = tick.seen[glance.a] | tick.seen[glance.b];
        tick.packs[p].stale[lane] = (seen & tick.packs[p].asks[lane]) != 0 ? -1 : 0;
        if ((seen & seen_followed) != 0) give_gyration(tick, joint_of(p, lane), bodies);
        if (glance.own_rows) follow_errors(tick, joint_of(p, lane), step, bodies);
        settle_asks(tick.packs[p]);
    }
    /// Makes the rows of a pack, and the biases of those of its joints that pull. Returns true if one of these is
    /// open.
    bool refresh(std::uint32_t p, bool moved) {
        JointPack& pack = tick.packs[p];
        for (std::uint32_t lane = 0; lane < pack.count && moved; ++lane) follow_joint(p, lane);
        kernel.refresh(data, p, p + 1);
        enlarge_exponents(tick, p, kernel.refresh, data, step);
        if (moved) invert_some(tick, p, p + 1, kernel, data);
        bool open = false;
        for (std::uint32_t lane = 0; lane < pack.count; ++lane)
            if (is_lane_pushed(pack, lane))
                open = open || is_open(pack, lane);
            else
                clear_biases(pack, turn_of(pack), lane);
        return open;
    }
    bool refresh_pushed(bool moved) {
        bool open = false;
        for (std::uint32_t p = 0; p < tick.packs.size(); ++p)
            if (is_any_pushed(tick.packs[p])) take(p);
        look_at_bodies();
        for (std::uint32_t p = 0; p < tick.packs.size(); ++p)
            if (is_any_pushed(tick.packs[p])) open = refresh(p, moved) || open;
        return open;
    }
    /// One pass over the lanes of a pack with pushed bodies. The kernel processes all lanes, so the others are
    /// restored.
    void solve(std::uint32_t p) {
        JointPack& pack = tick.packs[p];
        if (!is_any_pushed(pack)) return;
        take(p);
        bool pulls[pack_lanes];
        SolverBody before[pack_lanes][2];
        for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
            pulls[lane] = is_lane_pushed(pack, lane);
            if (pulls[lane]) continue;
            before[lane][0] = bodies.body[body_of(pack.a, lane)];
            before[lane][1] = bodies.body[body_of(pack.b, lane)];
        }
        tick.clamped += kernel.solve(data, p, p + 1, true);
        for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
            if (!pulls[lane]) {
                bodies.body[body_of(pack.a, lane)] = before[lane][0];
                bodies.body[body_of(pack.b, lane)] = before[lane][1];
            } else if (is_beyond(pack.impulse, lane, speed_for(push_gap) >> pack.exponent[lane])) {
                push(pack, lane);
            }
        }
    }
    /// Moves bodies by their velocities for a substep, then stops them. Followed bodies shift but do not turn.
    void move_and_stop() {
        constexpr int to_separation = accumulator_bits - Separation::fraction_bits;
        const auto way = [&](std::int64_t& v) {
            const std::int64_t out =
                shift_right_rounded((v >> to_separation) * step.substep_time.raw, Unit::fraction_bits);
            v = 0;
            return out;
        };
        for (const std::uint32_t body : closed.stopped) {
            SolverBody& b = bodies.body[body];
            const bool turns = bodies.step[body].turn == 0;
            for (int i = 0; i < 3; ++i) {
                b.shift[i] = saturate_to_int32(b.shift[i] + way(b.v[i]));
                const std::int64_t turn = way(b.u[i]);
                if (turns) b.theta[i] = saturate_to_int32(b.theta[i] + turn);
            }
        }
        for (const ClosedPack& kept : closed.packs)
            clear_impulses(tick.packs[kept.pack], turn_of(tick.packs[kept.pack]));
    }

  public:
    Closer(JointTick& joint_tick, const StepConstants& step_constants, SolverBodies& solver_bodies,
           const JointKernel& lanes)
        : tick(joint_tick), closed(joint_tick.closed), step(step_constants), bodies(solver_bodies),
          kernel(lanes), data(pass_data(joint_tick, step_constants, solver_bodies.body.data())) {}

    /// Marks the bodies of open points as pushed. Returns true if there are any.
    bool find_open() {
        closed.pushed.clear();
        for (const JointPack& pack : tick.packs)
            for (std::uint32_t lane = 0; lane < pack.count; ++lane) {
                if (!is_open(pack, lane) || !has_opened(pack, lane)) continue;
                if (closed.pushed.empty()) closed.of_body.assign(bodies.body.size(), 0);
                push(pack, lane);
            }
        const bool any_open = !closed.pushed.empty();
        if (!tick.packs.empty())
            tick.paths.take(any_open, base::Path::joint_points_left, base::Path::joint_points_closed);
        return any_open;
    }
    void close() {
        closed.of_pack.assign(tick.packs.size(), 0);
        closed.stopped.clear(), closed.velocities.clear(), closed.packs.clear();
        // Remove the whole error within a substep.
        data.rate = saturate_to_int32(step.substeps_per_second << joint_rate_bits);
        data.mass_scale = unit_one.raw, data.impulse_scale = 0;
        data.axes = nullptr;
        for (int pass = 0; pass < passes_max; ++pass) {
            if (!refresh_pushed(pass != 0)) break;
            const std::uint32_t counted = tick.counter.next_pass();
            for (const JointStep& now : tick.steps) {
                count_step(tick, now, counted, /*forwards=*/true);
                for (std::uint32_t p = now.first_pack; p < now.last_pack; ++p) solve(p);
            }
            move_and_stop();
        }
        give_back();
    }
};

} // namespace

void JointSolver::close(const StepConstants& step, SolverBodies& bodies) {
    Closer closer(*work, step, bodies, *kernel);
    if (closer.find_open()) closer.close();
}

} // namespace lockstone::solve
