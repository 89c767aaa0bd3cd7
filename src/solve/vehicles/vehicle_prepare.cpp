// The start of a vehicle's tick in the solver: rows of wheels and bars, shares of the weight, and the order of solving.
#include "base/poison.h"
#include "base/text.h"
#include "lockstone/math/math.h"
#include "solve/bodies/solving_order.h"
#include "solve/vehicles/vehicle.h"
#include "solve/vehicles/vehicle_lines.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// largest ratio of the masses of chassis and ground; with a lighter ground the solver uses this ratio
constexpr Real ratio_max = Real(65536);
/// The largest ratio for a ground that is pressed (contacts/pressed.h). It is half of pressed_ratio, because wheels
/// press faster than contacts give way.
constexpr Real ratio_pressed = Real(2);
constexpr std::int32_t arm_most = 64; ///< limit of a component of K^-1 (r x d)
constexpr Real impulse_max = Real(2048);

Arm bounded(Arm x) { return clamp(x, Arm(-arm_most), Arm(arm_most)); }

/// A lever from a centre of mass [m].
struct Lever {
    Vec3 whole;
    Vector3<Arm> near{}; ///< the same, if it is below 128 m
    bool is_near = false;

    explicit Lever(Vec3 lever) : whole(lever) {
        constexpr Real far = Real(128);
        is_near = abs(lever.x) < far && abs(lever.y) < far && abs(lever.z) < far;
        if (is_near) near = to<Arm>(lever);
    }
};

/// K^-1 (lever x d); in 64 bits for levers below 128 m.
Vector3<Arm> arm_of(const BodyStep& body, const Lever& lever, UnitVec3 d, std::int32_t sign) {
    Vector3<Arm> x{};
    if (lever.is_near) {
        Vector3<Arm> turn = cross<Arm>(lever.near, d);
        for (int i = 0; i < 3; ++i)
            turn[i] = Arm::from_raw((body.angular_mask >> i & 1u) != 0 ? sign * turn[i].raw : 0);
        x = over_gyration<Arm>(body, turn);
    } else {
        Vec3 turn = cross<Real>(lever.whole, d);
        for (int i = 0; i < 3; ++i) turn[i] = (body.angular_mask >> i & 1u) != 0 ? turn[i] * sign : Real{};
        x = over_gyration<Arm>(body, turn);
    }
    return {bounded(x.x), bounded(x.y), bounded(x.z)};
}

/// The change of a body's speed along d_a by an impulse along d_b; x: the arms of both.
Real mobility(const SolverBody& body, UnitVec3 d_a, Vector3<Arm> x_a, UnitVec3 d_b, Vector3<Arm> x_b) {
    SumOfProducts<Unit, Unit> moves;
    for (int i = 0; i < 3; ++i)
        if (body.keep[i] != 0) moves.add(d_a[i], d_b[i]);
    return moves.round<Real>() + dot<Real>(x_a, x_b);
}

/// The levers of a wheel's patch [m], and the velocity of the ground's surface relative to its body [m/s].
struct Levers {
    Lever chassis, ground;
    Vec3 surface;
};

WheelLine line_of(const SolverBodies& bodies, std::uint32_t chassis, const Wheel& wheel, UnitVec3 d,
                  const Levers& levers) {
    WheelLine line{};
    line.d = d;
    line.xc = arm_of(bodies.step[chassis], levers.chassis, d, 1);
    if (levers.surface != Vec3{}) line.belt = dot<Real>(levers.surface, d);
    line.kappa = mobility(bodies.body[chassis], d, line.xc, d, line.xc);
    if (wheel.ground == bodies.still()) return line;
    line.xg = arm_of(bodies.step[wheel.ground], levers.ground, d, -1);
    if (wheel.ratio > Real{})
        line.kappa += wheel.ratio * mobility(bodies.body[wheel.ground], d, line.xg, d, line.xg);
    return line;
}

void forget_ground(WheelMemory& m) {
    m.ground = {};
    m.spring = m.stop = m.along = m.across = m.slip = m.slip_side = Real{};
}

/// Sets shares that are linear in the position: share = a + b x + c z, with sum 1 and no moment about the centre of
/// mass. Equal shares where one of these is below 2 % of an equal share, or above 1.
void find_shares(WeightShares& out) {
    Mat3 gram{};
    for (std::uint32_t i = 0; i < out.wheel_count; ++i) {
        const Vec3 row{Real(1), out.at[i].x, out.at[i].z};
        gram.x += row;
        gram.y += row * out.at[i].x;
        gram.z += row * out.at[i].z;
    }
    const Mat3 inv = inverse(gram);
    const Real least = decimal<Real>("0.02") / Real(out.wheel_count);
    bool good = true;
    for (std::uint32_t i = 0; i < out.wheel_count; ++i) {
        out.share[i] = inv.x.x + inv.x.y * out.at[i].x + inv.x.z * out.at[i].z;
        good = good && out.share[i] >= least && out.share[i] <= Real(1);
    }
    for (std::uint32_t i = 0; i < out.wheel_count && !good; ++i)
        out.share[i] = Real(1) / Real(out.wheel_count);
}

/// Sets the fractions of the chassis' mass on each wheel, so that springs of equal frequency sag by the same length;
/// `center`: centre of mass.
void find_shares(const VehicleDef& def, Vec3 center, WeightShares& known) {
    bool same = known.wheel_count == def.wheel_count;
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const Vec3 at = def.wheel[i].attachment - center;
        same = same && known.at[i] == at;
        known.at[i] = at;
    }
    known.wheel_count = def.wheel_count;
    if (!same) find_shares(known);
}

/// The direction to the left, for a wheel that is turned about the up axis of the chassis.
UnitVec3 axle_of(const Rotation& axes, Real steer) {
    if (steer == Real{}) return axes.x;
    const auto turn = sin_cos(steer);
    return lockstone::mul<Unit>(axes, UnitVec3{turn.cos, Unit{}, -turn.sin});
}

/// Implicit spring: a = h^2 k + h c. Small has room: frequency below 50 Hz and share up to 1, so rate stays below 2^17
/// and a below 2^18.
void set_spring(Real substep, const WheelDef& def, Real share, Wheel& wheel) {
    const Small h = number<Small>(substep), omega = number<Small>(two_pi) * number<Small>(def.frequency),
                stiff = number<Small>(share) * omega * h;
    const Real rate = real(stiff * omega);
    const Real damping[2] = {def.damping_rebound, def.damping_compression};
    for (int side = 0; side < 2; ++side) {
        const Small of_damping = stiff * number<Small>(damping[side]);
        const Real a = real(number<Small>(rate) * h + of_damping + of_damping),
                   whole = Real(1) + a * wheel.normal.kappa;
        wheel.pull[side] = quotient(rate, whole);
        wheel.yield[side] = quotient(a, whole);
    }
}

/// The inputs of a vehicle's rows, and the vehicle.
struct Making {
    const BodyColumns& columns;
    const SolverBodies& bodies;
    const DrivenVehicle& driven;
    Real substep; ///< [s]
    Vehicle& v;
    UnitVec3 down; ///< of the wheel's suspension
};

/// `share`: of the mass of the chassis.
void prepare_wheel(const Making& of, std::uint32_t i, Real share) {
    const SolverBodies& bodies = of.bodies;
    Vehicle& v = of.v;
    const WheelDef& def = v.def->wheel[i];
    const WheelGround& ground = of.driven.ground[i];
    WheelMemory& memory = v.memory->wheel[i];
    Wheel& wheel = v.wheel[i] = Wheel{};
    wheel.ground = bodies.still();
    wheel.length = memory.length = def.length_max;
    if (!ground.shape) return forget_ground(memory);

    const UnitVec3 n = ground.normal;
    const bool moves = ground.body != bodies.still() && bodies.step[ground.body].moves;
    wheel.ground = moves ? ground.body : bodies.still();
    wheel.rides = moves;
    const Levers levers{Lever(ground.point - of.columns.pose[v.chassis].position),
                        Lever(moves ? ground.point - of.columns.pose[ground.body].position : Vec3{}),
                        ground.velocity};
    if (moves && bodies.step[ground.body].movable)
        wheel.ratio = min(v.mass / of.columns.mass[ground.body].mass,
                          bodies.step[ground.body].pressed ? ratio_pressed : ratio_max);
    const UnitVec3 axle = axle_of(of.driven.axes, memory.steer);
    const UnitVec3 sideways = axle - lockstone::scale<Unit>(n, dot<Unit>(n, axle)),
                   left = sideways == UnitVec3{} ? any_perpendicular(n) : normalized(sideways);
    wheel.normal = line_of(bodies, v.chassis, wheel, n, levers);
    wheel.touches = wheel.normal.kappa > Real{};
    if (!wheel.touches) return forget_ground(memory); // the chassis cannot move along the normal
    wheel.along = line_of(bodies, v.chassis, wheel, cross<Unit>(left, n), levers);
    wheel.across = line_of(bodies, v.chassis, wheel, left, levers);
    wheel.mixed = mobility(bodies.body[v.chassis], wheel.along.d, wheel.along.xc, left, wheel.across.xc);
    if (wheel.ratio > Real{})
        wheel.mixed += wheel.ratio * mobility(bodies.body[wheel.ground], wheel.along.d, wheel.along.xg, left,
                                              wheel.across.xg);
    wheel.length_begin = ground.length;
    wheel.per_length = quotient(Real(1), max(-dot<Real>(n, of.down), 0.5_r));
    wheel.grip = quotient(ground.friction, v.def->tyre[def.tyre].ground_friction);
    set_spring(of.substep, def, share, wheel);
    // A wheel does not start from its impulses on another ground.
    if (memory.ground != ground.shape) forget_ground(memory);
    memory.ground = ground.shape;
    memory.normal = n;
    wheel.spring = clamp(memory.spring, Real{}, impulse_max);
    wheel.stop = clamp(memory.stop, Real{}, impulse_max);
    wheel.along_p = clamp(memory.along, -impulse_max, impulse_max);
    wheel.across_p = clamp(memory.across, -impulse_max, impulse_max);
}

void prepare_bars(const StepConstants& step, const SolverBodies& bodies, Vehicle& v) {
    for (std::uint32_t k = 0; k < vehicle_couplings_max; ++k) {
        const AntiRollBar& bar = v.def->anti_roll[k];
        Wheel &a = v.wheel[bar.wheel_a], &b = v.wheel[bar.wheel_b];
        Real& p = v.memory->anti_roll[k];
        BarRow& row = v.bar[k] = BarRow{};
        row.holds = bar.wheel_a != bar.wheel_b && bar.stiffness > Real{} && a.touches && b.touches;
        p = row.holds ? clamp(p, -impulse_max, impulse_max) : Real{};
        a.bars += p;
        b.bars -= p;
        if (!row.holds) continue;
        const WheelLine &of_a = a.normal, &of_b = b.normal;
        const Real shared = mobility(bodies.body[v.chassis], of_a.d, of_a.xc, of_b.d, of_b.xc);
        row.kappa = max(of_a.kappa + of_b.kappa - shared * 2, Real{});
        const Real rate = divided(bar.stiffness / v.mass, step.substeps_per_second);
        const Real soft = divided(rate, step.substeps_per_second), whole = Real(1) + soft * row.kappa;
        row.pull = quotient(rate, whole), row.yield = quotient(soft, whole);
    }
}

} // namespace

/// Vehicles that push the same body are one convoy: the chassis of one may be the ground of another. A ground that
/// impulses do not move joins no vehicles.
void VehicleSolver::find_convoys(const SolverBodies& bodies) {
    const std::uint32_t count = static_cast<std::uint32_t>(vehicles.size());
    pushed.clear(), order.clear(), convoy.clear(), convoy_begin.clear();
    for (std::uint32_t k = 0; k < count; ++k) {
        convoy.push_back(k);
        order.push_back(k);
        pushed.push_back({vehicles[k].chassis, k});
        for (std::uint32_t i = 0; i < vehicles[k].def->wheel_count; ++i)
            if (bodies.step[vehicles[k].wheel[i].ground].movable)
                pushed.push_back({vehicles[k].wheel[i].ground, k});
    }
    std::sort(pushed.begin(), pushed.end());
    const auto first_of = [&](std::uint32_t k) {
        while (convoy[k] != k) k = convoy[k];
        return k;
    };
    for (std::size_t i = 1; i < pushed.size(); ++i) {
        if (pushed[i].body != pushed[i - 1].body) continue;
        const std::uint32_t a = first_of(pushed[i].vehicle), b = first_of(pushed[i - 1].vehicle);
        convoy[std::max(a, b)] = std::min(a, b);
    }
    for (std::uint32_t k = 0; k < count; ++k) convoy[k] = first_of(k);
    std::sort(order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
        return std::pair(convoy[x], x) < std::pair(convoy[y], y);
    });
    for (std::uint32_t i = 0; i < count; ++i)
        if (i == 0 || convoy[order[i]] != convoy[order[i - 1]]) convoy_begin.push_back(i);
    convoy_begin.push_back(count);
}

std::string VehicleSolver::order_fault(const SolverBodies& bodies) const {
    CheckVector<std::uint32_t> times(vehicles.size());
    CheckVector<std::uint32_t> pushed_by(bodies.body.size(), no_body); // number of the convoy, by body
    for (std::uint32_t c = 0; c + 1 < convoy_begin.size(); ++c)
        for (std::uint32_t i = convoy_begin[c]; i < convoy_begin[c + 1]; ++i) {
            const Vehicle& v = vehicles[order[i]];
            ++times[order[i]];
            if (i > convoy_begin[c] && order[i] < order[i - 1])
                return base::join("vehicle ", order[i], " follows vehicle ", order[i - 1]);
            for (std::uint32_t w = 0; w <= v.wheel_count; ++w) { // the last round is the chassis
                const std::uint32_t body = w < v.wheel_count ? v.wheel[w].ground : v.chassis;
                if (!bodies.step[body].movable) continue;
                if (pushed_by[body] != no_body && pushed_by[body] != c)
                    return base::join("vehicles of convoys ", pushed_by[body], " and ", c, " push body ",
                                      body);
                pushed_by[body] = c;
            }
        }
    for (std::uint32_t k = 0; k < times.size(); ++k)
        if (times[k] != 1) return base::join("vehicle ", k, " is solved ", times[k], " times in a pass");
    return {};
}

void VehicleSolver::prepare(std::span<DrivenVehicle> driven, const BodyColumns& columns,
                            const StepConstants& step, const SolverBodies& bodies, Tasks* workers) {
    tasks = workers;
    substeps_left = step.substeps;
    vehicles.resize(driven.size());
    for (const DrivenVehicle& d : driven)
        if (d.row >= shares.size()) shares.resize(std::size_t{d.row} + 1);
    const std::uint32_t count = static_cast<std::uint32_t>(driven.size());
    const Real substep = Real(1) / Real(step.substeps_per_second);
    base::for_chunks(tasks, count, 1, [&](std::uint32_t k, std::uint32_t, std::uint32_t) {
        DrivenVehicle& d = driven[k];
        Vehicle& v = vehicles[k];
        v.def = d.def, v.input = d.input, v.memory = &d.memory, v.ratio = d.ratio;
        v.chassis = d.chassis, v.wheel_count = d.def->wheel_count;
        v.mass = columns.mass[v.chassis].mass;
        find_shares(*v.def, columns.mass[v.chassis].center, shares[d.row]);
        Making of{columns, bodies, d, substep, v, {}};
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
            if (const auto& wheel = v.def->wheel; i == 0 || wheel[i].direction != wheel[i - 1].direction)
                of.down = lockstone::mul<Unit>(d.axes, wheel[i].direction);
            prepare_wheel(of, i, shares[d.row].share[i]);
        }
        prepare_bars(step, bodies, v);
        prepare_train(v);
        prepare_rims(step, v);
        prepare_engine(step, v);
    });
    find_convoys(bodies);
    if constexpr (checks_order) {
        const std::string fault = order_fault(bodies);
        LOCKSTONE_ASSERT(fault.empty(), fault);
    }
}

void VehicleSolver::poison(std::byte with) {
    auto& [left, stand_list, vehicle_list, share_list, pool, order_list, begin_list, pushed_list,
           convoy_list] = *this;
    base::poison(with, stand_list, vehicle_list, share_list, pool, order_list, begin_list, pushed_list,
                 convoy_list);
}

} // namespace lockstone::solve
