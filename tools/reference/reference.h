// The thesis' engine beside ours: a second opinion in floating point, never linked into the library.
//
//   auto engine = reference::Engine::create(world);          a world at its start, read through its public interface
//   if (!engine) return report(engine.error().message);      what the thesis or FCL lacks, in a sentence
//   engine->tick();                                          as long as a tick of that world
//   for (const reference::Body& body : engine->bodies()) draw(body.id, body.pose);      in the order of world.bodies()
//
// "The thesis" is Real-time Physics Simulation. Comments name its sections, formulas and listings; this class is section 3.1, listing 1. Rigid bodies, damping,
// the integrators of section 2.1, collision by FCL (section 3.4) and the worst-first resolver (section 4.3.2). Joints, sleeping
// and continuous collision are not in it.
#pragma once

#include "lockstone/world.h"
#include "reference/engine/core.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace reference {

struct Settings {
    Integrator integrator = Integrator::semi_implicit_euler; ///< listing 3's
    int substeps = 0; ///< steps in a tick, 1..64; 0: as many as the world has, so that steps are equally long
    int position_iterations = 200; ///< at most, 1..1000000
    int velocity_iterations = 200;
    double position_epsilon = 0.001; ///< [m], 0..1
    double velocity_epsilon = 0.01;  ///< [m/s], 0..10
    double bounce_speed_min =
        -1; ///< [m/s]: slower impacts do not bounce; below 0: the world's restitution_speed_min
    double angular_limit = 0.2; ///< see Resolver
    bool gyroscopic = false;    ///< see Law: false is the thesis
    /// Boxes, cylinders and cones meet a plane as the top of a box, of which FCL finds up to four points; else its half-space,
    /// of which it finds one, and of cones and cylinders that point down a wrong one.
    bool box_ground = true;
    Build build = Build::double_plain;
    /// Sees what FCL has found before the resolver does, and may change it. For tests.
    std::function<void(std::vector<Contact>&)> on_contacts = {};
};

struct Pose {
    Vec position; ///< of the body's origin [m]
    Turn rotation;
};

struct Body {
    lockstone::BodyId id; ///< in the world that it began as
    Pose pose;
    Vec center;             ///< of mass [m]
    Vec velocity, rotation; ///< of the centre [m/s], and angular [rad/s]
};

/// Of all dynamic bodies together.
struct Measures {
    double kinetic = 0, potential = 0; ///< [J]; the potential of gravity and of fields
    Vec momentum{};                    ///< [N s]
    Vec angular_momentum{};            ///< about the world's origin [N m s]
    double penetration = 0;            ///< the deepest overlap that FCL finds [m]
    double energy() const { return kinetic + potential; }
};

class Engine {
  public:
    /// The bodies, shapes, fields and gravity of a world as they stand. Refuses settings out of range, and by body and shape
    /// what FCL or the thesis has no counterpart of: rounded shapes, compounds, joints, fluids, axis locks and so on.
    static lockstone::Result<Engine> create(const lockstone::World& start, const Settings& settings = {});
    Engine(Engine&&) noexcept;
    Engine& operator=(Engine&&) noexcept;
    ~Engine();

    /// A command that the world was given before its tick: forces, impulses, velocities, poses, gravity. Passes over those
    /// that move nothing (write_game, wake_body), refuses all others.
    lockstone::Status apply(const lockstone::Command& command);
    void tick();
    std::uint64_t tick_count() const;

    std::span<const Body>
    bodies() const; ///< in the order of world.bodies() at the start; valid until the next tick
    std::span<const lockstone::ShapeDef> shapes(std::size_t body) const; ///< in order of creation
    bool is_dynamic(std::size_t body) const;

    double energy() const;      ///< kinetic and potential [J]
    Vec momentum() const;       ///< [N s]
    double penetration() const; ///< [m]; asks FCL
    Measures measure() const;
    /// The same figures of a world with the same bodies, by the same judge.
    Measures measure(const lockstone::World& world) const;

    /// What FCL found in the last step, before anything was resolved, in order of bodies and shapes.
    std::span<const Contact> contacts() const;
    bool touched() const; ///< whether it found any in the last tick
    /// What the resolver did in the last step, in order.
    std::span<const Resolved> resolved() const;

  private:
    struct Impl;
    explicit Engine(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl;
};

} // namespace reference
