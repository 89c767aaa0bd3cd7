// The integrators of section 2.1, formulas 1 to 3. x position, v velocity, a acceleration; q orientation, w angular
// velocity, b angular acceleration; h the time step (delta t in the thesis).
//
// "Angular velocity and orientation are updated with the same integration methods as the linear forces" (section 2.1).
// All integrators use the damping of listing 3: v *= d^h.
#include "reference/engine/rigid_body.h"

namespace reference::LOCKSTONE_REFERENCE_BUILD {
namespace {

void damp(Rigidbody& body, Number h) {
    body.velocity *= std::pow(body.linear_damping, h);
    body.rotation *= std::pow(body.angular_damping, h);
}

/// Formula 1, Euler-Cromer, as in listing 3:  v' = v + a h,  x' = x + v' h.
/// Its `acceleration` is the constant one of gravity, to which F / m is added.
void semi_implicit_euler(Rigidbody& body, const Forces& forces) {
    const Number h = forces.dt;
    body.previous_acceleration = body.acceleration_at(body.position, forces);
    body.velocity += body.previous_acceleration * h;
    body.rotation += body.angular_acceleration_at(body.orientation, body.rotation, forces) * h;
    damp(body, h);
    body.position += body.velocity * h;
    body.orientation = body.orientation + rate_of(body.orientation, body.rotation) * h;
}

/// Formula 2, Verlet:  x'' = 2 x' - x + a h^2, where x is the previous position. The previous position is stored as the
/// velocity v = (x' - x) / h (of order 1, as the text says), so that the resolver can change it and a body can start
/// with one. Orientations are treated alike.
void verlet(Rigidbody& body, const Forces& forces) {
    const Number h = forces.dt;
    damp(body, h);
    const V3 before = body.position - body.velocity * h;
    body.previous_acceleration = body.acceleration_at(body.position, forces);
    const V3 next = 2 * body.position - before + body.previous_acceleration * (h * h);
    body.velocity = (next - body.position) * (1 / h);
    body.position = next;
    body.rotation += body.angular_acceleration_at(body.orientation, body.rotation, forces) * h;
    body.orientation = body.orientation + rate_of(body.orientation, body.rotation) * h;
}

/// Formula 3, velocity Verlet:  x' = x + v h + a h^2 / 2,  v' = v + (a + a') h / 2.
void velocity_verlet(Rigidbody& body, const Forces& forces) {
    const Number h = forces.dt;
    const V3 a = body.acceleration_at(body.position, forces);
    const V3 b = body.angular_acceleration_at(body.orientation, body.rotation, forces);
    body.position += body.velocity * h + a * (half * h * h);
    body.orientation =
        normalize(body.orientation + rate_of(body.orientation, body.rotation + b * (half * h)) * h);
    body.previous_acceleration = (a + body.acceleration_at(body.position, forces)) * half;
    const V3 b_next = body.angular_acceleration_at(body.orientation, body.rotation + b * h, forces);
    body.velocity += body.previous_acceleration * h;
    body.rotation += (b + b_next) * (half * h);
    damp(body, h);
}

/// The state that an integrator changes, or its rate of change.
struct Phase {
    V3 x, v;
    Q4 q;
    V3 w;
    friend Phase operator+(const Phase& p, const Phase& r) {
        return {p.x + r.x, p.v + r.v, p.q + r.q, p.w + r.w};
    }
    friend Phase operator*(const Phase& p, Number s) { return {p.x * s, p.v * s, p.q * s, p.w * s}; }
};

/// The classical Runge-Kutta method: y' = y + (k1 + 2 k2 + 2 k3 + k4) h / 6, with "the evaluation four times".
void runge_kutta_4(Rigidbody& body, const Forces& forces) {
    const Number h = forces.dt;
    const auto rate = [&](const Phase& y) -> Phase {
        return {y.v, body.acceleration_at(y.x, forces), rate_of(y.q, y.w),
                body.angular_acceleration_at(normalize(y.q), y.w, forces)};
    };
    const Phase y{body.position, body.velocity, body.orientation, body.rotation};
    const Phase k1 = rate(y), k2 = rate(y + k1 * (half * h)), k3 = rate(y + k2 * (half * h)),
                k4 = rate(y + k3 * h);
    const Phase sum = (k1 + k2 * 2 + k3 * 2 + k4) * (Number(1) / 6);
    body.position = y.x + sum.x * h, body.velocity = y.v + sum.v * h;
    body.orientation = y.q + sum.q * h, body.rotation = y.w + sum.w * h;
    body.previous_acceleration = sum.v;
    damp(body, h);
}

} // namespace

Integrate integrator_of(Integrator kind) {
    switch (kind) {
    case Integrator::verlet:
        return verlet;
    case Integrator::velocity_verlet:
        return velocity_verlet;
    case Integrator::runge_kutta_4:
        return runge_kutta_4;
    case Integrator::semi_implicit_euler:
        break;
    }
    return semi_implicit_euler;
}

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
