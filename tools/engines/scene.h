// A scene that Lockstone, Bullet and ODE can all run, and the adapters that run it.
//
//   Scene scene;
//   scene.bodies.push_back(ground(0.6));
//   const int crate = scene.add({.shape = box({0.5, 0.5, 0.5}), .position = {0, 0.5, 0}, .mass = 1000});
//   std::unique_ptr<Engine> engine = make_engine(contestants()[0], scene);
//   engine->advance(600);
//   engine->state(crate).position
//
// SI units throughout. Nothing is damped, and nobody sleeps unless the scene says so. Measures of quality (tests/quality)
// and of speed (tools/bench) run the same adapters.
#pragma once

#include "engines/vector.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace engines {

enum class Kind { sphere, box, capsule, cylinder, hull, plane, mesh };

struct Shape {
    Kind kind = Kind::sphere;
    V3 half{}; ///< box: half extents; capsule, cylinder: x the radius, y half the segment or height, along y; sphere: x
    std::vector<V3> points = {}; ///< of a hull, about its centre of mass; of a mesh
    /// Of a hull; triangles of a mesh, which only bodies have that nothing moves. Counter-clockwise seen from outside.
    std::vector<std::vector<int>> faces = {};
    double round = 0; ///< of a box: radius of its edges, within `half`; others than Lockstone have them sharp
};
inline Shape sphere(double radius) { return {Kind::sphere, {radius, radius, radius}}; }
inline Shape box(V3 half) { return {Kind::box, half}; }
inline Shape capsule(double radius, double half_height) {
    return {Kind::capsule, {radius, half_height, radius}};
}
inline Shape cylinder(double radius, double half_height) {
    return {Kind::cylinder, {radius, half_height, radius}};
}
/// The half-space below its local y = 0.
inline Shape plane() { return {Kind::plane, {}}; }

/// A further shape of a body, in its axes. Of a body with mass all shapes together have their centre of mass in the body's
/// origin and their principal axes along the body's.
struct Part {
    Shape shape{};
    V3 position{};
    Turn rotation{};
};

struct Body {
    Shape shape{};
    V3 position{}; ///< of the centre of mass
    Turn rotation{};
    V3 velocity{}, spin{};         ///< [m/s], [rad/s] in world axes
    double mass = 0;               ///< [kg]; 0: static, or kinematic:
    bool moves = false;            ///< kinematic: follows its velocity and spin, whatever it meets
    double friction = 0.6;         ///< a pair has the geometric mean
    double restitution = 0;        ///< a pair has the larger; give both the same
    double rolling_resistance = 0; ///< [m]; a pair has the larger; give both the same
    V3 surface_velocity{};         ///< of a conveyor [m/s]
    bool bullet = false;           ///< passes through nothing that moves either
    std::vector<Part> parts = {};
};

/// Volume [m^3] and principal moments of inertia / mass [m^2] in the shape's axes; a hull's products of inertia have to
/// vanish.
struct Solid {
    double volume;
    V3 inertia;
};
Solid solid_of(const Shape& shape);
Solid solid_of(const Body& body); ///< all its shapes together
/// Moves the points of a hull so that its centre of mass is the origin, turns its faces outwards; returns where it was.
V3 center_hull(Shape& hull);
/// The convex hull of points in general position, about its centre of mass and its principal axes.
Shape hull_of_points(std::vector<V3> points);

enum class Link { ball, hinge, slider };

/// Between two bodies, or a body and the world. Where they stand at first is the zero of angles and ways.
struct Joint {
    Link kind = Link::ball;
    int a = -1; ///< -1: the world
    int b = -1;
    V3 anchor{};      ///< world, at first
    V3 axis{0, 0, 1}; ///< of a hinge or slider: unit vector, world, at first
    double limit = 0; ///< [rad] or [m]: not beyond this to either side; 0: free
    double motor_speed = 0,
           motor_force = 0; ///< [rad/s] or [m/s]; most that it applies [N m] or [N], 0: no motor
    // Balls and hinges in Lockstone and Bullet have these; ODE ignores them.
    double friction = 0;       ///< brakes each angle that is not locked with at most this [N m]
    double spring_hertz = 0;   ///< pulls the angles back to 0; 0: no spring
    double spring_damping = 0; ///< ratio
    /// A joint of a human, which Lockstone makes by make_ragdoll: orientations of the frames on A and B at first, world axes; limits of
    /// the angle about their x axes; half angle of the cone in which B's x axis stays, 0: a hinge.
    struct Frames {
        Turn a{}, b{};
        double lower = 0, upper = 0, swing = 0;
    };
    std::optional<Frames> frames = {};
};

/// A human that Lockstone makes by its make_ragdoll: the bodies and joints of a scene from these numbers on, which others take.
struct Human {
    int body = 0, joint = 0;
    V3 at{};            ///< of the ground between its feet
    double heading = 0; ///< about y [rad]
    V3 velocity{};      ///< of all its parts [m/s]
};
/// Four wheels under a body. The front steers, the rear is driven.
struct Car {
    int chassis = 0;
    V3 hub{}; ///< of the wheel at +x, +z, from the chassis' origin [m]
};

struct Scene {
    std::vector<Body> bodies = {};
    std::vector<Joint> joints = {};
    V3 gravity{0, -9.81, 0};
    double attraction = 0;  ///< G M of a point mass at the origin [m^3/s^2]
    bool sleeping = false;  ///< bodies at rest may fall asleep, by each engine's own defaults
    bool continuous = true; ///< Lockstone only: fast bodies are swept
    std::vector<Human> humans = {};
    // In Lockstone and Bullet only:
    std::vector<Car> cars = {};
    std::vector<V3> walkers = {};   ///< characters of 1.8 m and 80 kg: where their feet are
    std::vector<Shape> probes = {}; ///< that Engine::cast and Engine::overlap ask with
    int room = 0;                   ///< bodies that Engine::add may add

    int add(Body body) {
        bodies.push_back(std::move(body));
        return static_cast<int>(bodies.size()) - 1;
    }
};
inline Body ground(double friction, double restitution = 0) {
    return {.shape = plane(), .friction = friction, .restitution = restitution};
}
/// A body of the given density [kg/m^3].
Body solid(Shape shape, V3 position, double density = 1000, double friction = 0.6);

struct State {
    V3 position, velocity, spin;
    Turn rotation;
};

/// A scene in some engine. Its clock is that of the thread, so that a busy machine does not count, or the wall's.
class Engine {
  public:
    virtual ~Engine() = default;
    virtual State state(int body) const = 0;
    virtual void kick(int body,
                      V3 change) = 0; ///< adds to the velocity of a dynamic body [m/s], between ticks
    // Lockstone and Bullet only: elsewhere each ends the program.
    virtual void walk(int walker, V3 velocity); ///< wanted from now on, level [m/s]
    /// From now on: 0 to 1; -1 left to 1 right.
    virtual void drive(int car, double throttle, double steer);
    virtual int add(const Body& body); ///< one more, of one primitive; returns its number
    virtual void
    replace(int number,
            const Body& body); ///< destroys it; creates this one, whose shape is that of the old one
    virtual double cast_ray(V3 from, V3 way) const;        ///< share of the way to the first hit; 1: none
    virtual double cast(int probe, V3 from, V3 way) const; ///< the same of a shape
    virtual int overlap(int probe, V3 at) const;           ///< how many bodies it overlaps
    void advance(int ticks);
    double seconds_per_tick() const { return ticks_done == 0 ? 0 : seconds / ticks_done; }
    double seconds_spent() const { return seconds; } ///< in all ticks

  protected:
    virtual void tick() = 0;
    bool by_wall = false; ///< the clock

  private:
    double seconds = 0;
    int ticks_done = 0;
};

enum class Product { lockstone, bullet, ode };
bool is_built(Product product); ///< Bullet and ODE are left out where they were not found

/// Integrators that only Lockstone has a choice of.
enum class Scheme { semi_implicit_euler, verlet, velocity_verlet, runge_kutta_4 };

/// Who runs a scene, and how.
struct Contestant {
    std::string name;
    Product product = Product::lockstone;
    int rate = 60;      ///< ticks per second
    int substeps = 0;   ///< 0: the default: Lockstone's own, one for the others
    int iterations = 0; ///< of the peers' solvers; 0: their default, 10 of Bullet and 20 of ODE
    Scheme scheme = Scheme::semi_implicit_euler;
    /// Bullet only: hulls with its default margin of 40 mm, which is outside of their described size; else 1 mm within it.
    bool default_margins = false;
    unsigned threads = 1; ///< Lockstone only
    std::string simd =
        {}; ///< name of an instruction set that this machine has; empty: the best; Lockstone only
    bool by_wall = false;     ///< the clock is the wall's: with several threads it has to be; Lockstone only
    double contact_hertz = 0; ///< 0: the default; Lockstone only
    double contact_damping = 0; ///< 0: the default; Lockstone only
};

/// Lockstone; Bullet and ODE as they come; both again at Lockstone's substeps with two iterations each; Lockstone with
/// twice the substeps and contacts of twice the frequency.
std::vector<Contestant> contestants();

/// Of a product that is built.
std::unique_ptr<Engine> make_engine(const Contestant& contestant, const Scene& scene);
std::unique_ptr<Engine> make_lockstone(const Contestant& contestant, const Scene& scene);
std::unique_ptr<Engine> make_bullet(const Contestant& contestant, const Scene& scene);
std::unique_ptr<Engine> make_ode(const Contestant& contestant, const Scene& scene);

/// Kinetic and potential energy of the dynamic bodies [J]; potential of uniform gravity and of the attraction.
double energy(const Scene& scene, const Engine& engine);
/// How far the anchors of a joint on its two bodies have come apart [m]; not of a slider.
double gap(const Scene& scene, const Engine& engine, const Joint& joint);
/// Largest horizontal distance from where it started, of all dynamic bodies [m].
double drift(const Scene& scene, const Engine& engine);
/// Dynamic bodies that dropped by more than `drop` [m] or turned by more than 20 degrees.
int fallen(const Scene& scene, const Engine& engine, double drop);
/// Angle between two orientations [rad].
double turned(Turn a, Turn b);
V3 angular_momentum(const Body& body,
                    const State& state); ///< about the centre of mass [kg m^2/s], world axes

} // namespace engines
