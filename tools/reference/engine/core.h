// The thesis' engine without its collision detection, as its several builds offer it: numbers go in and come out in double
// precision; the build chooses the numbers inside. It includes neither Lockstone nor FCL. Section 3.3.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace reference {

struct Vec {
    double x = 0, y = 0, z = 0;
};
/// A rotation: w + xi + yj + zk, of length 1.
struct Turn {
    double x = 0, y = 0, z = 0, w = 1;
};

/// The integrators of section 2.1.
enum class Integrator {
    semi_implicit_euler, ///< formula 1 and listing 3, Euler-Cromer: order 1
    verlet,              ///< formula 2: positions alone, the velocity is their difference
    velocity_verlet,     ///< formula 3: order 2
    runge_kutta_4,       ///< the "RK4" of the text: order 4
};

/// A body as it begins.
struct BodyStart {
    double mass_inv = 0; ///< [1/kg]; 0: nothing pushes it
    Vec inertia_inv{};   ///< about its principal axes [1/(kg m^2)]
    Turn principal{};    ///< turns its axes into the principal ones
    Vec position{};      ///< of the centre of mass [m]
    Turn orientation{};  ///< of its axes
    Vec velocity{};      ///< of the centre of mass [m/s]
    Vec rotation{};      ///< angular velocity, which the thesis calls rotation [rad/s]
    double linear_damping = 1, angular_damping = 1; ///< what is left of a velocity after a second, 0..1
    double gravity_scale = 1;
    bool in_fields = true; ///< force fields act on it
};

enum class Attraction { point_gravity, spring, uniform };

/// A field of acceleration without bounds: towards its centre k / (r^2 + s^2), or k r; or the same everywhere.
struct Field {
    Attraction kind = Attraction::uniform;
    Vec center{};         ///< [m]
    double strength = 0;  ///< k [m^3/s^2] or [1/s^2]
    double softening = 0; ///< s [m]
    Vec acceleration{};   ///< of a uniform one [m/s^2]
};

/// A contact point as the collision detection finds it.
struct Contact {
    int a = 0, b = 0; ///< bodies; a < b
    Vec point{};      ///< [m]
    Vec normal{};     ///< unit, from b to a: the way that a is pushed
    double depth = 0; ///< [m], positive where they overlap
    double friction = 0, restitution = 0;
};

/// What the resolver did in one iteration.
struct Resolved {
    bool velocity;    ///< else a position
    int contact;      ///< index into the contacts that it was given
    double magnitude; ///< depth [m] or desired change of velocity [m/s], before
};

/// The resolver's settings ("a couple of parameters such as maximum iterations and epsilon", section 4.3.2).
struct Resolver {
    int position_iterations = 0, velocity_iterations = 0;
    double position_epsilon = 0; ///< [m]: a depth below it is left
    double velocity_epsilon = 0; ///< [m/s]: so is a wanted change of velocity
    double bounce_speed_min = 0; ///< [m/s]: slower impacts do not bounce
    double angular_limit = 0; ///< most that a depth is undone by turning, per distance from the centre [rad]
};

struct Law {
    double dt = 0; ///< of a step [s]
    Vec gravity{};
    Integrator integrator = Integrator::semi_implicit_euler;
    bool gyroscopic = false; ///< turn by Euler's equations; listing 3 leaves the term w x I w out
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
    /// Of listing 4: act until clear_forces. [N], [N m].
    virtual void add_force(int body, const Vec& force, const Vec& torque) = 0;
    virtual void add_force_at(int body, const Vec& force, const Vec& point) = 0;
    virtual void clear_forces() = 0;
    virtual void set_motion(int body, const Motion& motion) = 0;
    virtual Motion motion(int body) const = 0;
    /// Moves all bodies by one step.
    virtual void integrate() = 0;
    /// Listing 9: interpenetrations first, then velocities, the worst first. What it did, in order, into `log`.
    virtual void resolve(std::span<const Contact> contacts, std::vector<Resolved>& log) = 0;
};

/// The same sources, compiled several times.
enum class Build {
    double_plain, ///< double precision, every operation rounded as IEEE 754 says: the reference
    double_fused, ///< double precision, multiplications and additions fused where the compiler likes
    float_plain,  ///< single precision, which is what the thesis has
    float_twin,   ///< float_plain once more: the twin that must not part from it
    float_fused,  ///< single precision, fused
    float_fast,   ///< single precision, -ffast-math
};
inline constexpr Build every_build[] = {Build::double_plain, Build::double_fused, Build::float_plain,
                                        Build::float_twin,   Build::float_fused,  Build::float_fast};
const char* name_of(Build build); ///< "float, fused"
/// Whether this machine has the instructions.
bool is_available(Build build);
std::unique_ptr<Core> make_core(Build build, const Law& law, std::span<const BodyStart> bodies);

} // namespace reference
