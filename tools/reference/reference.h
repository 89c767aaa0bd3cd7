// The engine of the thesis in floating point, to compare with Lockstone. It is never linked into the library.
//
//   auto engine = reference::Engine::create(world);          a world at its start, read through its public interface
//   if (!engine) return report(engine.error().message);      the sentence names a feature that the thesis or FCL lacks
//   engine->tick();                                          advances by a tick of that world
//   for (const reference::Body& body : engine->bodies()) draw(body.id, body.pose);      in the order of world.bodies()
//
// "The thesis" is Real-time Physics Simulation. Comments name its sections, formulas and listings; this class is
// section 3.1, listing 1. The engine has rigid bodies, damping, the integrators of section 2.1, collision by FCL
// (section 3.4) and the worst-first resolver (section 4.3.2). It has no joints, no sleeping and no continuous
// collision.
#pragma once

#include "lockstone/world.h"
#include "reference/engine/core.h"

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace reference {

struct Settings {
    Integrator integrator = Integrator::semi_implicit_euler; ///< as in listing 3
    /// Steps in a tick, 1..64; 0: as many as the world has, so that steps are equally long.
    int substeps = 0;
    int position_iterations = 200; ///< at most, 1..1000000
    int velocity_iterations = 200;
    double position_epsilon = 0.001; ///< [m], 0..1
    double velocity_epsilon = 0.01;  ///< [m/s], 0..10
    /// [m/s]: slower impacts do not bounce; below 0: the world's restitution_speed_min.
    double bounce_speed_min = -1;
    double angular_limit = 0.2; ///< see Resolver
    bool gyroscopic = false;    ///< see Law; the thesis uses false
    /// If true, boxes, cylinders and cones touch a plane as the top of a box, for which FCL finds up to four points.
    /// Otherwise they touch its half-space: FCL then finds one point, and a wrong one for cones and cylinders that
    /// point down.
    bool box_ground = true;
    Build build = Build::double_plain;
    /// For tests: called with the contacts that FCL found, before the resolver uses them. It may change them.
    std::function<void(std::vector<Contact>&)> on_contacts = {};
};

struct Pose {
    Vec position; ///< of the body's origin [m]
    Turn rotation;
};

struct Body {
    lockstone::BodyId id; ///< the id of the body in the world of the start
    Pose pose;
    Vec center;             ///< centre of mass [m]
    Vec velocity, rotation; ///< of the centre [m/s], and angular [rad/s]
};

/// Sums over all dynamic bodies.
struct Measures {
    double kinetic = 0, potential = 0; ///< [J]; the potential energy is that of gravity and of fields
    Vec momentum{};                    ///< [N s]
    Vec angular_momentum{};            ///< about the world's origin [N m s]
    double penetration = 0;            ///< the deepest overlap that FCL finds [m]
    double energy() const { return kinetic + potential; }
};

class Engine {
  public:
    /// Copies the bodies, shapes, fields and gravity of a world in its current state. Errors: a setting out of range,
    /// or a body or shape that FCL or the thesis cannot represent, such as rounded shapes, compounds, joints, fluids
    /// and axis locks.
    static lockstone::Result<Engine> create(const lockstone::World& start, const Settings& settings = {});
    Engine(Engine&&) noexcept;
    Engine& operator=(Engine&&) noexcept;
    ~Engine();

    /// Applies a command that the world received before its tick: forces, impulses, velocities, poses, gravity. Ignores
    /// commands that move nothing (write_game, wake_body); all others are errors.
    lockstone::Status apply(const lockstone::Command& command);
    void tick();
    std::uint64_t tick_count() const;

    /// In the order of world.bodies() at the start. Valid until the next tick.
    std::span<const Body> bodies() const;
    std::span<const lockstone::ShapeDef> shapes(std::size_t body) const; ///< in order of creation
    bool is_dynamic(std::size_t body) const;

    double energy() const;      ///< kinetic and potential [J]
    Vec momentum() const;       ///< [N s]
    double penetration() const; ///< [m]; computed by FCL
    Measures measure() const;
    /// These measures for a world with the same bodies; FCL measures its overlaps too.
    Measures measure(const lockstone::World& world) const;

    /// The contacts that FCL found in the last step before the resolver ran, in the order of bodies and shapes.
    std::span<const Contact> contacts() const;
    bool touched() const; ///< true if the last tick had contacts
    /// The iterations of the resolver in the last step, in order.
    std::span<const Resolved> resolved() const;

  private:
    struct Impl;
    explicit Engine(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl;
};

} // namespace reference
