// Bodies and joints without a world: the solver's own loop on columns that the test fills.
#pragma once

#include "lockstone/math/convert.h"
#include "lockstone/math/math.h"
#include "solve/bodies/integrate.h"
#include "solve/joints/followed_turn.h"
#include "solve/joints/joint.h"
#include "solve/joints/joint_parts.h"
#include "solve/joints/joint_stiffness.h"
#include "solve/kernels/kernels.h"

#include <array>
#include <cmath>
#include <vector>

namespace lockstone::test::rig {

using namespace lockstone::solve;

using D3 = std::array<double, 3>;
inline D3 operator+(D3 a, D3 b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline D3 operator-(D3 a, D3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline D3 operator*(double s, D3 a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(D3 a, D3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline D3 cross(D3 a, D3 b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double length(D3 a) { return std::sqrt(dot(a, a)); }

inline Real real(double x) { return quantize<Real>(x); }
inline Vec3 vec(double x, double y, double z) { return {real(x), real(y), real(z)}; }
inline Vec3 vec(D3 v) { return vec(v[0], v[1], v[2]); }
template <FixedPoint T> D3 d3(Vector3<T> v) { return {to_double(v.x), to_double(v.y), to_double(v.z)}; }
inline Quat turn(D3 axis, double angle) {
    const double n = length(axis);
    return from_axis_angle(
        {quantize<Unit>(axis[0] / n), quantize<Unit>(axis[1] / n), quantize<Unit>(axis[2] / n)}, real(angle));
}

/// The part of a tick that acts on bodies with joints and no contacts.
struct Rig {
    std::vector<BodyInfo> info;
    std::vector<BodyTraits> traits;
    std::vector<std::uint32_t> pushes;
    std::vector<BodyMass> mass; ///< columns() puts it into the traits
    std::vector<BodyForce> force;
    std::vector<Transform> pose;
    std::vector<Velocity> velocity;
    std::vector<JointDef> defs;
    std::vector<Joint> joints;
    std::vector<JointMemory> memory;
    SolverBodies bodies;
    JointSolver solver{*solve::kernels_of(best_simd())->joints};
    StepSettings settings{60, 8, Real(30), Real(10), Real(3), Real(1)};
    Vec3 gravity = vec(0, -9.81, 0);
    ClampCounts clamps;

    static constexpr std::uint32_t world = 0xffffffffu;

    /// Adds a body with its centre of mass at `at`; mass 0: static.
    std::uint32_t add(double kg, D3 gyration, D3 at, Quat rotation = Quat::identity()) {
        BodyInfo i{};
        i.kind = kg > 0 ? BodyKind::dynamic : BodyKind::static_;
        i.traits = static_cast<std::uint32_t>(info.size());
        pushes.push_back(i.traits + 1);
        BodyTraits t{};
        t.gyroscopic = 1;
        t.gravity_scale = Real(1);
        info.push_back(i), traits.push_back(t);
        mass.push_back({real(kg), Vec3{}, vec(gyration), Quat::identity()});
        force.push_back({});
        pose.push_back({vec(at), rotation});
        velocity.push_back({});
        return static_cast<std::uint32_t>(info.size() - 1);
    }
    /// Adds the joint, with both frames at one place.
    std::uint32_t join(JointDef def, std::uint32_t a, std::uint32_t b, D3 at,
                       Quat rotation = Quat::identity()) {
        const Transform place{vec(at), rotation};
        const auto local = [&](std::uint32_t body) {
            const Transform inverse_pose = inverse(pose[body]);
            const Transform local_place = inverse_pose * place;
            return Transform{local_place.position, normalized(local_place.rotation)};
        };
        def.frame_a = a == world ? place : local(a);
        def.frame_b = local(b);
        return join_as_is(def, a, b);
    }
    std::uint32_t join_as_is(const JointDef& def, std::uint32_t a, std::uint32_t b) {
        defs.push_back(def);
        joints.push_back(
            {nullptr, a, b, static_cast<std::uint32_t>(memory.size()), 0, 0, def.frame_a, def.frame_b});
        memory.push_back({});
        return static_cast<std::uint32_t>(defs.size() - 1);
    }
    BodyColumns columns() {
        for (std::size_t b = 0; b < mass.size(); ++b) traits[b].mass = mass[b];
        return {info, traits, pushes, force, pose, velocity};
    }
    StepConstants constants() const { return step_constants(settings); }

    void begin(const StepConstants& step) {
        begin_step(columns(), gravity, step, bodies);
        std::vector<Joint> ready = joints;
        for (std::size_t i = 0; i < ready.size(); ++i) {
            ready[i].def = &defs[i];
            if (ready[i].body_a == world) ready[i].body_a = bodies.still();
            bodies.step[ready[i].body_a].jointed = bodies.step[ready[i].body_b].jointed = true;
        }
        stiffen_bodies(ready, memory, columns(), step, bodies);
        follow_turns(columns(), step, bodies, nullptr);
        solver.prepare(ready, memory, columns(), step, bodies);
    }
    /// A substep as in tick.cpp, without contacts, vehicles and fluids.
    void substep(const StepConstants& step) {
        integrate_velocities({Scheme::semi_implicit_euler, {}}, columns(), step, bodies);
        solver.warm_start(step, bodies);
        solver.solve(step, bodies, true);
        integrate_poses(step, bodies);
        solver.update(step, bodies);
        solver.solve(step, bodies, false);
    }
    void tick() {
        const StepConstants step = constants();
        begin(step);
        for (std::int32_t i = 0; i < step.substeps; ++i) substep(step);
        solver.store_points(memory);
        solver.store(memory, bodies, clamps);
        finish_step(step, bodies, columns());
    }
    void run(int ticks) {
        for (int i = 0; i < ticks; ++i) tick();
    }

    Transform frame_a(std::uint32_t j) const {
        return joints[j].body_a == world ? defs[j].frame_a : pose[joints[j].body_a] * defs[j].frame_a;
    }
    Transform frame_b(std::uint32_t j) const { return pose[joints[j].body_b] * defs[j].frame_b; }
    std::array<Real, joint_axis_count> coordinates(std::uint32_t j) const {
        return joint_coordinates(defs[j], frame_a(j), frame_b(j), memory[j].twist);
    }
    double coordinate(std::uint32_t j, std::uint32_t axis) const { return to_double(coordinates(j)[axis]); }
    /// The distance of the two frames [m].
    double gap(std::uint32_t j) const { return length(d3(frame_b(j).position) - d3(frame_a(j).position)); }
    D3 v(std::uint32_t b) const { return d3(velocity[b].linear); }
    D3 w(std::uint32_t b) const { return d3(velocity[b].angular); }
    D3 x(std::uint32_t b) const { return d3(pose[b].position); }

    /// I w in world axes.
    D3 spin(std::uint32_t b) const {
        const Rotation r = to_rotation(pose[b].rotation * mass[b].principal);
        const D3 axes[3] = {d3(r.x), d3(r.y), d3(r.z)}, k = d3(mass[b].gyration);
        D3 sum{};
        for (std::size_t i = 0; i < 3; ++i)
            sum = sum + (to_double(mass[b].mass) * k[i] * k[i] * dot(axes[i], w(b))) * axes[i];
        return sum;
    }
    D3 momentum() const {
        D3 sum{};
        for (std::uint32_t b = 0; b < info.size(); ++b) sum = sum + to_double(mass[b].mass) * v(b);
        return sum;
    }
    D3 angular_momentum() const {
        D3 sum{};
        for (std::uint32_t b = 0; b < info.size(); ++b)
            sum = sum + spin(b) + to_double(mass[b].mass) * cross(x(b), v(b));
        return sum;
    }
    double energy() const {
        double sum = 0;
        for (std::uint32_t b = 0; b < info.size(); ++b) {
            const double m = to_double(mass[b].mass);
            sum += 0.5 * m * dot(v(b), v(b)) + 0.5 * dot(w(b), spin(b)) - m * dot(d3(gravity), x(b));
        }
        return sum;
    }
};

} // namespace lockstone::test::rig
