// The interface of the thesis' engine without its collision detection. Numbers are passed in double precision; each
// build chooses its own number type inside. This file includes neither Lockstone nor FCL. Section 3.3.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace reference {

struct Vec {
    double x = 0, y = 0, z = 0;
};
/// A rotation: the unit quaternion w + xi + yj + zk.
struct Turn {
    double x = 0, y = 0, z = 0, w = 1;
};

/// The integrators of section 2.1.
enum class Integrator {
    semi_implicit_euler, ///< formula 1 and listing 3, Euler-Cromer: order 1
    verlet,              ///< formula 2: stores positions only, the velocity is their difference
    velocity_verlet,     ///< formula 3: order 2
    runge_kutta_4,       ///< the "RK4" of the text: order 4
};

/// The initial state of a body.
struct BodyStart {
    double mass_inv = 0; ///< [1/kg]; 0: infinite mass
    Vec inertia_inv{};   ///< about its principal axes [1/(kg m^2)]
    Turn principal{};    ///< turns the body's axes into the principal axes
    Vec position{};      ///< of the centre of mass [m]
    Turn orientation{};  ///< of the body's axes
    Vec velocity{};      ///< of the centre of mass [m/s]
    Vec rotation{};      ///< angular velocity, which the thesis calls rotation [rad/s]
    /// The share of a velocity that remains after a second, 0..1.
    double linear_damping = 1, angular_damping = 1;
    double gravity_scale = 1;
    bool in_fields = true; ///< force fields act on it
};

enum class Attraction { point_gravity, spring, uniform };

/// A field of acceleration without bounds: towards a centre by k / (r^2 + s^2) or k r, or uniform.
struct Field {
    Attraction kind = Attraction::uniform;
    Vec center{};         ///< [m]
    double strength = 0;  ///< k [m^3/s^2] or [1/s^2]
    double softening = 0; ///< s [m]
    Vec acceleration{};   ///< of a uniform field [m/s^2]
};

/// A contact point from the collision detection.
struct Contact {
    int a = 0, b = 0; ///< bodies; a < b
    Vec point{};      ///< [m]
    Vec normal{};     ///< unit, from b to a: the direction in which a is pushed
    double depth = 0; ///< [m], positive if the shapes overlap
    double friction = 0, restitution = 0;
};

/// One iteration of the resolver.
struct Resolved {
    bool velocity;    ///< true: a velocity was resolved; false: a position
    int contact;      ///< index into the contacts
    double magnitude; ///< depth [m] or desired change of velocity [m/s] before the iteration
};

/// The resolver's settings ("a couple of parameters such as maximum iterations and epsilon", section 4.3.2).
struct Resolver {
    int position_iterations = 0, velocity_iterations = 0;
    double position_epsilon = 0; ///< [m]: smaller depths are not resolved
    double velocity_epsilon = 0; ///< [m/s]: smaller changes of velocity are not resolved
    double bounce_speed_min = 0; ///< [m/s]: slower impacts do not bounce
    /// Largest turn that resolves a depth, per distance from the centre [rad].
    double angular_limit = 0;
};

struct Law {
    double dt = 0; ///< duration of a step [s]
    Vec gravity{};
    Integrator integrator = Integrator::semi_implicit_euler;
    bool gyroscopic = false; ///< uses Euler's equations; listing 3 omits the term w x I w
    Resolver resolver{};
    std::vector<Field> fields{};
};

struct Motion {
    Vec position; ///< of the centre of mass [m]
    Turn orientation;
    Vec velocity, rotation;
};

class Core {
  public:
    virtual ~Core() = default;
    virtual void set_gravity(const Vec& gravity) = 0;
    /// Adds a force as in listing 4. It acts until clear_forces. [N], [N m].
    virtual void add_force(int body, const Vec& force, const Vec& torque) = 0;
    virtual void add_force_at(int body, const Vec& force, const Vec& point) = 0;
    virtual void clear_forces() = 0;
    virtual void set_motion(int body, const Motion& motion) = 0;
    virtual Motion motion(int body) const = 0;
    /// Moves all bodies by one step.
    virtual void integrate() = 0;
    /// Listing 9: resolves penetrations first, then velocities, each with the worst first. Appends each iteration to
    /// `log`.
    virtual void resolve(std::span<const Contact> contacts, std::vector<Resolved>& log) = 0;
};

/// The builds: equal sources, compiled with different number types and flags.
enum class Build {
    double_plain, ///< double precision, IEEE 754 rounding of every operation: the reference
    double_fused, ///< double precision; the compiler may fuse multiplications and additions
    float_plain,  ///< single precision, as in the thesis
    float_twin,   ///< like float_plain; it must not diverge from it
    float_fused,  ///< single precision, fused
    float_fast,   ///< single precision, -ffast-math
};
inline constexpr Build every_build[] = {Build::double_plain, Build::double_fused, Build::float_plain,
                                        Build::float_twin,   Build::float_fused,  Build::float_fast};
const char* name_of(Build build); ///< "float, fused"
/// True if this machine has the instructions of the build.
bool is_available(Build build);
std::unique_ptr<Core> make_core(Build build, const Law& law, std::span<const BodyStart> bodies);

} // namespace reference
