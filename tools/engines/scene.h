// A scene that Lockstone, Bullet and ODE can all run, and the adapters that run it.
//
//   Scene scene;
//   scene.bodies.push_back(ground(0.6));
//   const int crate = scene.add({.shape = box({0.5, 0.5, 0.5}), .position = {0, 0.5, 0}, .mass = 1000});
//   std::unique_ptr<Engine> engine = make_engine(contestants()[0], scene);
//   engine->advance(600);
//   engine->state(crate).position
//
// SI units throughout. The scene has no damping, and no body sleeps unless the scene allows it. The measurements of
// quality (tests/quality) and of speed (tools/bench) use these adapters.
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
    /// box: half extents; capsule, cylinder: x the radius, y half the segment or height, along y; sphere: x the radius.
    V3 half{};
    std::vector<V3> points = {}; ///< of a hull, relative to its centre of mass; of a mesh
    /// Faces of a hull; triangles of a mesh, which only static or kinematic bodies may have. Counter-clockwise seen
    /// from outside.
    std::vector<std::vector<int>> faces = {};
    double round = 0; ///< of a box: radius of its edges, within `half`; only Lockstone rounds them
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

/// A further shape of a body, in the body's axes. If the body has mass, the centre of mass of all its shapes is the
/// body's origin, and their principal axes are the body's axes.
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
    double mass = 0;               ///< [kg]; 0: static, or kinematic if `moves` is set
    bool moves = false;            ///< kinematic: it follows its velocity and spin, whatever it touches
    double friction = 0.6;         ///< a pair uses the geometric mean
    double restitution = 0;        ///< a pair uses the larger; give both the same
    double rolling_resistance = 0; ///< [m]; a pair uses the larger; give both the same
    V3 surface_velocity{};         ///< of a conveyor [m/s]
    bool bullet = false;           ///< swept against moving bodies too
    std::vector<Part> parts = {};
};

/// Volume [m^3] and principal moments of inertia / mass [m^2] in the shape's axes. A hull's products of inertia must be
/// zero.
struct Solid {
    double volume;
    V3 inertia;
};
Solid solid_of(const Shape& shape);
Solid solid_of(const Body& body); ///< of all its shapes together
/// Moves the points of a hull so that its centre of mass becomes the origin, and turns its faces outwards. Returns the
/// old centre.
V3 center_hull(Shape& hull);
/// The convex hull of points in general position, relative to its centre of mass and its principal axes.
Shape hull_of_points(std::vector<V3> points);

enum class Link { ball, hinge, slider };

/// A joint between two bodies, or a body and the world. Angles and distances are 0 in the pose at the start.
struct Joint {
    Link kind = Link::ball;
    int a = -1; ///< -1: the world
    int b = -1;
    V3 anchor{};      ///< in the world, at the start
    V3 axis{0, 0, 1}; ///< of a hinge or slider: unit vector in the world, at the start
    double limit = 0; ///< [rad] or [m]: largest deviation to either side; 0: free
    /// [rad/s] or [m/s]; largest torque or force [N m] or [N], 0: no motor.
    double motor_speed = 0, motor_force = 0;
    // Lockstone and Bullet support these for balls and hinges; ODE ignores them.
    double friction = 0;       ///< brakes each free angle with at most this torque [N m]
    double spring_hertz = 0;   ///< pulls the angles back to 0; 0: no spring
    double spring_damping = 0; ///< damping ratio
    /// A joint of a human; Lockstone makes it by make_ragdoll. The orientations of the frames on A and B at the start
    /// in world axes, the limits of the angle about their x axes, and the half angle of the cone in which B's x axis
    /// stays (0: a hinge).
    struct Frames {
        Turn a{}, b{};
        double lower = 0, upper = 0, swing = 0;
    };
    std::optional<Frames> frames = {};
};

/// A human. Lockstone makes it by make_ragdoll; the other engines use the scene's bodies and joints from these indices
/// on.
struct Human {
    int body = 0, joint = 0;
    V3 at{};            ///< the ground between its feet
    double heading = 0; ///< about y [rad]
    V3 velocity{};      ///< of all its bodies [m/s]
};
/// A car: four wheels under a body. The front wheels steer, the rear wheels are driven.
struct Car {
    int chassis = 0;
    V3 hub{}; ///< of the wheel at +x, +z, relative to the chassis' origin [m]
};

struct Scene {
    std::vector<Body> bodies = {};
    std::vector<Joint> joints = {};
    V3 gravity{0, -9.81, 0};
    double attraction = 0;  ///< G M of a point mass at the origin [m^3/s^2]
    bool sleeping = false;  ///< bodies at rest may sleep, by the engine's own rules
    bool continuous = true; ///< Lockstone only: sweeps fast bodies
    std::vector<Human> humans = {};
    // Lockstone and Bullet only:
    std::vector<Car> cars = {};
    std::vector<V3> walkers = {};   ///< positions of the feet of characters of 1.8 m and 80 kg
    std::vector<Shape> probes = {}; ///< shapes of Engine::cast and Engine::overlap
    int room = 0;                   ///< capacity for bodies that Engine::add adds later

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

/// A scene in one engine. It measures its ticks by the thread's processor time, which excludes other work of the
/// machine, or by wall time.
class Engine {
  public:
    virtual ~Engine() = default;
    virtual State state(int body) const = 0;
    /// Adds to the velocity of a dynamic body [m/s], between ticks.
    virtual void kick(int body, V3 change) = 0;
    // Lockstone and Bullet only; other engines end the program.
    virtual void walk(int walker, V3 velocity); ///< sets the wanted horizontal velocity [m/s]
    /// Sets the controls: throttle from 0 to 1, steer from -1 (left) to 1 (right).
    virtual void drive(int car, double throttle, double steer);
    virtual int add(const Body& body); ///< adds a body with one primitive shape; returns its index
    /// Destroys a body and creates another one with an equal shape in its place.
    virtual void replace(int number, const Body& body);
    virtual double cast_ray(V3 from, V3 way) const; ///< fraction of the way to the first hit; 1: no hit
    /// Fraction of the way at which a shape hits; 1: no hit.
    virtual double cast(int probe, V3 from, V3 way) const;
    virtual int overlap(int probe, V3 at) const; ///< the number of bodies that the probe overlaps
    void advance(int ticks);
    double seconds_per_tick() const { return ticks_done == 0 ? 0 : seconds / ticks_done; }
    double seconds_spent() const { return seconds; } ///< in all ticks

  protected:
    virtual void tick() = 0;
    bool by_wall = false; ///< ticks are measured by wall time

  private:
    double seconds = 0;
    int ticks_done = 0;
};

enum class Product { lockstone, bullet, ode };
bool is_built(Product product); ///< false for Bullet or ODE if the build did not find it

/// Integrators. Only Lockstone offers a choice.
enum class Scheme { semi_implicit_euler, verlet, velocity_verlet, runge_kutta_4 };

/// An engine with its settings.
struct Contestant {
    std::string name;
    Product product = Product::lockstone;
    int rate = 60;      ///< ticks per second
    int substeps = 0;   ///< 0: the default: Lockstone's own, one for the others
    int iterations = 0; ///< of Bullet's and ODE's solver; 0: their default, 10 and 20
    Scheme scheme = Scheme::semi_implicit_euler;
    /// Bullet only: hulls get its default margin of 40 mm outside of their described size; otherwise 1 mm within it.
    bool default_margins = false;
    unsigned threads = 1; ///< Lockstone only
    /// Lockstone only: an instruction set that this machine has; empty: the best.
    std::string simd = {};
    bool by_wall = false;       ///< Lockstone only: measure wall time; required with several threads
    double contact_hertz = 0;   ///< Lockstone only; 0: the default
    double contact_damping = 0; ///< Lockstone only; 0: the default
};

/// Lockstone; Bullet and ODE with their defaults; both again with as many substeps as Lockstone and two iterations
/// each; Lockstone with twice the substeps and contacts of twice the frequency.
std::vector<Contestant> contestants();

/// Makes an engine. The product must be part of this build (is_built).
std::unique_ptr<Engine> make_engine(const Contestant& contestant, const Scene& scene);
std::unique_ptr<Engine> make_lockstone(const Contestant& contestant, const Scene& scene);
std::unique_ptr<Engine> make_bullet(const Contestant& contestant, const Scene& scene);
std::unique_ptr<Engine> make_ode(const Contestant& contestant, const Scene& scene);

/// Kinetic and potential energy of the dynamic bodies [J]. The potential energy is that of uniform gravity and of the
/// attraction.
double energy(const Scene& scene, const Engine& engine);
/// The distance between the anchors of a joint on its two bodies [m]; not for sliders.
double gap(const Scene& scene, const Engine& engine, const Joint& joint);
/// The largest horizontal distance of a dynamic body from its start [m].
double drift(const Scene& scene, const Engine& engine);
/// The number of dynamic bodies that dropped by more than `drop` [m] or turned by more than 20 degrees.
int fallen(const Scene& scene, const Engine& engine, double drop);
/// The angle between two orientations [rad].
double turned(Turn a, Turn b);
/// About the centre of mass [kg m^2/s], in world axes.
V3 angular_momentum(const Body& body, const State& state);

} // namespace engines
