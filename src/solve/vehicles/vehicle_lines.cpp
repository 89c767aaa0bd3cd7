// Rare cases of lines of vehicles, outside of the inner loops: grounds that move, and large impulses. See
// vehicle_lines.h.
#include "solve/vehicles/vehicle_lines.h"

namespace lockstone::solve {

namespace {

constexpr std::int64_t speed_most = 2048; ///< [m/s]

void add_far(std::int64_t& v, std::int64_t p, std::int64_t by, int shift, int fraction_bits) {
    const std::int64_t most = speed_most << fraction_bits;
    v = std::clamp(add_saturated(v, narrow_rounded(Wide::product(p, by), shift)), -most, most);
}

} // namespace

Real ground_speed(const SolverBody& ground, const WheelLine& line) {
    const Chassis motion(ground);
    std::int64_t back[3];
    for (int i = 0; i < 3; ++i) back[i] = -motion.u[i]; // xg includes the sign of the ground's side
    return motion.has_room() ? real(speed_along<Small>(motion.v, back, line.d, line.xg))
                             : speed_along<Real>(motion.v, back, line.d, line.xg);
}

void push_far(Chassis& chassis, const WheelLine& line, Real impulse) {
    for (int i = 0; i < 3; ++i) {
        if (chassis.keep[i] != 0)
            add_far(chassis.v[i], impulse.raw, line.d[i].raw, push_d_shift, chassis_bits);
        add_far(chassis.u[i], impulse.raw, line.xc[i].raw, push_x_shift, chassis_bits);
    }
    chassis.look();
}

void push_ground(const Wheel& wheel, const WheelLine& line, Real impulse, SolverBodies& bodies) {
    SolverBody& ground = bodies.body[wheel.ground];
    const Real turns = impulse * wheel.ratio, moves = -turns;
    for (int i = 0; i < 3; ++i) {
        if (ground.keep[i] != 0)
            add_far(ground.v[i], moves.raw, line.d[i].raw, push_d_shift - chassis_to_accumulator,
                    accumulator_bits);
        add_far(ground.u[i], turns.raw, line.xg[i].raw, push_x_shift - chassis_to_accumulator,
                accumulator_bits);
    }
}

void push_lines(Chassis& chassis, const Wheel& wheel, SolverBodies& bodies) {
    const Real normal = wheel.spring + wheel.stop + wheel.bars;
    const WheelLine &n = wheel.normal, &a = wheel.along, &s = wheel.across;
    if (wheel.ratio > Real{} || abs(normal) + abs(wheel.along_p) + abs(wheel.across_p) > Real(1)) {
        push_line(chassis, wheel, n, normal, bodies);
        push_line(chassis, wheel, a, wheel.along_p, bodies);
        return push_line(chassis, wheel, s, wheel.across_p, bodies);
    }
    const std::int64_t of_n = normal.raw, of_a = wheel.along_p.raw, of_s = wheel.across_p.raw;
    for (int i = 0; i < 3; ++i) {
        chassis.v[i] += rounded<push_d_shift>(of_n * n.d[i].raw + of_a * a.d[i].raw + of_s * s.d[i].raw) &
                        chassis.keep[i];
        chassis.u[i] += rounded<push_x_shift>(of_n * n.xc[i].raw + of_a * a.xc[i].raw + of_s * s.xc[i].raw);
    }
}

void write_back(const Chassis& chassis, SolverBody& body) {
    constexpr std::int64_t most = speed_most << chassis_bits;
    constexpr std::int64_t finer = std::int64_t{1} << chassis_to_accumulator;
    const Chassis before(body);
    const bool far = chassis.is_far();
    for (int i = 0; i < 3; ++i) {
        const std::int64_t v = far ? std::clamp(chassis.v[i], -most, most) : chassis.v[i],
                           u = far ? std::clamp(chassis.u[i], -most, most) : chassis.u[i];
        body.v[i] += (v - before.v[i]) * finer;
        body.u[i] += (u - before.u[i]) * finer;
    }
}

} // namespace lockstone::solve
