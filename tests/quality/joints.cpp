// Joints: the stretch of a chain, the sag of a bridge; pendulum, motors, limits and a top against closed forms.
#include "engines/pieces.h"
#include "quality/row.h"

#include <algorithm>

namespace quality {

namespace {

constexpr double g = 9.81;

double gap_sum(const Scene& scene, const Engine& engine) {
    double sum = 0;
    for (const Joint& joint : scene.joints) sum += gap(scene, engine, joint);
    return sum;
}

double gap_most(const Scene& scene, const Engine& engine) {
    double most = 0;
    for (const Joint& joint : scene.joints) most = std::max(most, gap(scene, engine, joint));
    return most;
}

// ---- wrecking ball -----------------------------------------------------------------------------------------------

/// Thirty links of 1 kg and a ball of 1000 kg, released at 45 degrees. Planted: a joint in the middle is missing.
Figures run_chain(const Contestant& contestant, const Plan& plan) {
    constexpr int links = 30;
    constexpr double pitch = 0.5, radius = 0.6;
    const V3 along = V3{1, -1, 0} / std::sqrt(2.0);
    Scene scene;
    int last = -1;
    for (int i = 0; i < links; ++i) {
        Body link{.shape = capsule(0.05, 0.2), .position = along * (pitch * (i + 0.5)), .mass = 1};
        link.rotation = about({0, 0, 1}, pi / 4);
        const int now = scene.add(link);
        scene.joints.push_back({.kind = Link::ball, .a = last, .b = now, .anchor = along * (pitch * i)});
        last = now;
    }
    const int ball =
        scene.add({.shape = sphere(radius), .position = along * (pitch * links + radius), .mass = 1000});
    scene.joints.push_back({.kind = Link::ball, .a = last, .b = ball, .anchor = along * (pitch * links)});
    Scene damaged = scene;
    if (plan.planted >= 0) damaged.joints.erase(damaged.joints.begin() + links / 2);
    const auto engine = make_engine(contestant, damaged);
    const double exact = pitch * links + radius;
    double stretch = 0, widest = 0;
    for (int tick = 0; tick < (plan.quick ? 300 : 1200); ++tick) {
        engine->advance(1);
        stretch = std::max(stretch, length(engine->state(ball).position) / exact - 1);
        widest = std::max(widest, gap_most(scene, *engine));
    }

    return {{stretch * 100, widest * 1e3}, engine->seconds_per_tick()};
}

// ---- bridge ------------------------------------------------------------------------------------------------------

/// The parameter a of the catenary y = a cosh(x / a) of this length between two points of equal height.
double catenary(double span, double size) {
    double low = span / 20, high = span * 100;
    for (int i = 0; i < 200; ++i) {
        const double a = (low + high) / 2;
        (2 * a * std::sinh(span / (2 * a)) > size ? low : high) = a;
    }
    return low;
}

/// Planks of a rope bridge, hinged to each other and to both banks, started in their final shape. Planted: the banks
/// are 2 % nearer than the measure assumes; a hinge is missing.
Figures run_bridge(const Contestant& contestant, const Plan& plan) {
    const int planks = plan.quick ? 40 : 200;
    constexpr double pitch = 0.5;
    const double size = pitch * planks, right_span = 0.97 * size;
    const double span = plan.planted >= 0 ? 0.95 * size : right_span, a = catenary(span, size);
    const auto at = [&](int i) { // the i-th hinge, by arc length
        const double s = pitch * i - size / 2;
        return V3{a * std::asinh(s / a), std::sqrt(a * a + s * s), 0};
    };
    Scene scene;
    int last = -1;
    for (int i = 0; i < planks; ++i) {
        const V3 from = at(i), to = at(i + 1);
        Body plank = solid(box({0.23, 0.05, 1}), (from + to) / 2, 600);
        plank.rotation = about({0, 0, 1}, std::atan2(to.y - from.y, to.x - from.x));
        const int now = scene.add(plank);
        scene.joints.push_back({.kind = Link::hinge, .a = last, .b = now, .anchor = from});
        last = now;
    }
    scene.joints.push_back({.kind = Link::hinge, .a = -1, .b = last, .anchor = at(planks)});
    Scene built = scene;
    if (plan.plants(1)) built.joints.erase(built.joints.begin() + planks / 4);
    const auto engine = make_engine(contestant, built);
    engine->advance(plan.quick ? 300 : 1200);
    const double right_a = catenary(right_span, size);
    const double expected = std::sqrt(right_a * right_a + size * size / 4) - right_a;
    const double middle =
        (engine->state(planks / 2 - 1).position.y + engine->state(planks / 2).position.y) / 2;
    const double sag = at(0).y - middle;
    const double stretch = gap_sum(scene, *engine) / size;
    return {{std::abs(sag / expected - 1) * 100, stretch * 100}, engine->seconds_per_tick()};
}

// ---- pendulum ----------------------------------------------------------------------------------------------------

/// The complete elliptic integral K(k) by the arithmetic-geometric mean.
double elliptic_k(double k) {
    double a = 1, b = std::sqrt(1 - k * k);
    for (int i = 0; i < 30; ++i) {
        const double mean = (a + b) / 2;
        b = std::sqrt(a * b);
        a = mean;
    }
    return pi / (2 * a);
}

struct Swing {
    double period, kept; ///< [s]; last amplitude over the first
};

/// A pendulum released at `from`; its amplitude should be `amplitude`.
Swing swing(const Contestant& contestant, double amplitude, double from, double arm, int ticks,
            double& tick_time) {
    Scene scene;
    Body bob = solid(box({0.1, 0.1, 0.1}), {arm * std::sin(from), -arm * std::cos(from), 0});
    bob.rotation = about({0, 0, 1}, from);
    const int body = scene.add(bob);
    scene.joints.push_back({.kind = Link::hinge, .a = -1, .b = body, .anchor = {}});
    const auto engine = make_engine(contestant, scene);
    double last_angle = from, first_pass = 0, last_pass = 0, most = 0;
    int passes = 0;
    for (int tick = 1; tick <= ticks; ++tick) {
        engine->advance(1);
        const V3 p = engine->state(body).position;
        const double angle = std::atan2(p.x, -p.y);
        if (last_angle < 0 && angle >= 0) { // upwards through the lowest point
            last_pass = (tick - angle / (angle - last_angle)) / contestant.rate;
            if (passes++ == 0) first_pass = last_pass;
            most = 0; // of the last swing
        }
        if (std::abs(angle) > most) most = std::abs(angle);
        last_angle = angle;
    }
    tick_time = std::max(tick_time, engine->seconds_per_tick());
    return {passes < 2 ? 0 : (last_pass - first_pass) / (passes - 1), most / amplitude};
}

/// Periods at three amplitudes, and the remainder of the widest swing. Planted: an arm that is 2 % longer, a swing from
/// another angle.
Figures run_pendulum(const Contestant& contestant, const Plan& plan) {
    constexpr double arm = 1;
    const double used = plan.planted >= 0 ? arm * 1.02 : arm;
    const double inertia = arm * arm + 2.0 / 3 * 0.01; // per mass, about the hinge
    Figures figures{{}, 0};
    double kept = 1;
    for (const double degrees : {10.0, 90.0, 150.0}) {
        const double amplitude = radians(degrees);
        const double expected = 4 * std::sqrt(inertia / (g * arm)) * elliptic_k(std::sin(amplitude / 2));
        const double from = plan.plants(3) ? amplitude * 0.9 : amplitude;
        const Swing found = swing(contestant, amplitude, from, used,
                                  (plan.quick ? 20 : 300) * contestant.rate, figures.seconds_per_tick);
        figures.values.push_back(std::abs(found.period / expected - 1) * 100);
        kept = found.kept;
    }
    figures.values.push_back(std::abs(kept - 1) * 100);
    return figures;
}

// ---- motors and limits -------------------------------------------------------------------------------------------

/// An arm that a motor turns against gravity, a lift that a motor raises, and both at their limits. Planted: motors too
/// weak; limits elsewhere.
Figures run_motor(const Contestant& contestant, const Plan& plan) {
    const bool weak = plan.planted == 0 || plan.planted == 1, elsewhere = plan.planted >= 2;
    constexpr double turn_speed = 2, lift_speed = 0.5, turn_limit = pi / 6, lift_limit = 0.4;
    const auto arm_scene = [](const Joint& joint) {
        Scene scene;
        scene.add({.shape = box({0.5, 0.1, 0.1}), .position = {0.5, 0, 0}, .mass = 20});
        scene.joints.push_back(joint);
        return scene;
    };
    const auto lift_scene = [](const Joint& joint) {
        Scene scene;
        scene.add({.shape = box({0.5, 0.1, 0.5}), .position = {}, .mass = 100});
        scene.joints.push_back(joint);
        return scene;
    };
    const double torque = weak ? 60 : 1000, force = weak ? 500 : 5000;
    Joint hinge{.kind = Link::hinge, .b = 0, .motor_speed = turn_speed, .motor_force = torque};
    Joint slider{
        .kind = Link::slider, .b = 0, .axis = {0, 1, 0}, .motor_speed = lift_speed, .motor_force = force};
    Figures figures{{}, 0};
    const auto run = [&](const Scene& scene, int ticks) {
        const auto engine = make_engine(contestant, scene);
        engine->advance(ticks);
        figures.seconds_per_tick = std::max(figures.seconds_per_tick, engine->seconds_per_tick());
        return engine->state(0);
    };
    figures.values.push_back(std::abs(std::abs(run(arm_scene(hinge), 60).spin.z) / turn_speed - 1) * 100);
    figures.values.push_back(std::abs(std::abs(run(lift_scene(slider), 60).velocity.y) / lift_speed - 1) *
                             100);
    hinge.motor_force = slider.motor_force = 0;
    hinge.limit = elsewhere ? turn_limit * 0.9 : turn_limit,
    slider.limit = elsewhere ? lift_limit * 0.9 : lift_limit;
    const double angle = turned(run(arm_scene(hinge), 300).rotation, {});
    figures.values.push_back(std::abs(angle - turn_limit) * 180 / pi);
    figures.values.push_back(std::abs(-run(lift_scene(slider), 300).position.y - lift_limit) * 1e3);
    return figures;
}

// ---- heavy top ---------------------------------------------------------------------------------------------------

/// A disc on a pivot that precesses without nutation. source: Goldstein, Classical Mechanics, 5.7. At a tilt t with
/// moments I about the pivot and J about its axis, s the spin along its axis: I cos t W^2 - J s W + m g l = 0. Planted:
/// it spins 30 % slower.
Figures run_top(const Contestant& contestant, const Plan& plan) {
    constexpr double arm = 0.1, tilt = pi / 3, mass = 2, own = 30; // total spin about its axis [rad/s]
    const int seconds = plan.quick ? 10 : 60;
    const Shape disc = cylinder(0.2, 0.02);
    const V3 moments = solid_of(disc).inertia * mass;
    const double about_pivot = moments.x + mass * arm * arm;
    const double p = about_pivot * std::cos(tilt), q = moments.y * own, r = mass * g * arm;
    const double rate = (q - std::sqrt(q * q - 4 * p * r)) / (2 * p);
    const V3 axis{std::sin(tilt), std::cos(tilt), 0};
    // Spin = W up + rest along the axis, so that its part along the axis is `own`.
    const double given = plan.planted >= 0 ? own * 0.7 : own;
    const V3 spin = V3{0, rate, 0} + axis * (given - rate * std::cos(tilt));
    Scene scene;
    Body top{.shape = disc, .position = axis * arm, .mass = mass};
    top.rotation = about({0, 0, 1}, -tilt);
    top.spin = spin;
    top.velocity = cross(spin, top.position);
    const int body = scene.add(top);
    scene.joints.push_back({.kind = Link::ball, .a = -1, .b = body, .anchor = {}});
    const auto engine = make_engine(contestant, scene);
    double angle = 0, last = 0, worst = 0;
    for (int tick = 0; tick < seconds * contestant.rate; ++tick) {
        engine->advance(1);
        const V3 x = engine->state(body).position / arm;
        const double now = std::atan2(-x.z, x.x);
        angle += std::remainder(now - last, 2 * pi);
        last = now;
        worst = std::max(worst, std::abs(std::acos(std::clamp(x.y / length(x), -1.0, 1.0)) - tilt));
    }
    return {{std::abs(angle / (rate * seconds) - 1) * 100, worst * 180 / pi}, engine->seconds_per_tick()};
}

// ---- ragdolls ----------------------------------------------------------------------------------------------------

/// Ragdolls fall on each other. Returns the time when the last one comes to rest [s], and the widest joint then [mm].
std::pair<double, double> rest_of_ragdolls(const Contestant& contestant, const Plan& plan, int heap,
                                           double& tick_time) {
    Scene scene;
    scene.add(ground(0.7));
    const int count = plan.quick ? 4 : 12; // the head of every third hangs free and keeps swinging
    for (int i = 0; i < count; ++i)
        add_ragdoll(scene, {0.3 * (i % 3 - 1), 0.5 + 2 * i, (0.2 + 0.01 * heap) * (i % 2)});
    for (Body& body : scene.bodies) body.friction = 0.7, body.rolling_resistance = 0.01;
    if (plan.plants(0))
        for (Body& body : scene.bodies) body.restitution = 0.98, body.friction = 0;
    Scene damaged = scene;
    if (plan.plants(1)) damaged.joints.pop_back();
    const auto engine = make_engine(contestant, damaged);
    int rest = 0;
    const int ticks = plan.quick ? 900 : 1200;
    for (int tick = 1; tick <= ticks; ++tick) {
        engine->advance(1);
        double fastest = 0;
        for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
            const State s = engine->state(static_cast<int>(i));
            fastest = std::max({fastest, length(s.velocity), 0.1 * length(s.spin)});
        }
        if (fastest > 0.1) rest = tick;
    }
    tick_time = std::max(tick_time, engine->seconds_per_tick());
    return {rest / static_cast<double>(contestant.rate), gap_most(scene, *engine) * 1e3};
}

double middle_of(std::vector<double> figures) {
    const auto middle = figures.begin() + static_cast<std::ptrdiff_t>(figures.size() / 2);
    std::nth_element(figures.begin(), middle, figures.end());
    return *middle;
}

/// The median of nine heaps; in each heap every second ragdoll falls a centimetre further to the side. Rounding decides
/// which limb is wedged between others, so that they hold its joint open. Joints have no friction, but limbs have
/// rolling resistance. Planted: no friction and high restitution; a missing joint.
Figures run_ragdolls(const Contestant& contestant, const Plan& plan) {
    std::vector<double> rests, gaps;
    double tick_time = 0;
    for (int heap = 0; heap < 9; ++heap) {
        const auto [rest, gap] = rest_of_ragdolls(contestant, plan, heap, tick_time);
        rests.push_back(rest), gaps.push_back(gap);
    }
    return {{middle_of(rests), middle_of(gaps)}, tick_time};
}

} // namespace

std::vector<Row> joint_rows() {
    return {
        {"chain",
         "a ball of 1000 kg on 30 links of 1 kg, let go at 45 degrees, 1200 ticks",
         {{"stretch", "%", 1}, {"widest joint", "mm", 10}},
         false,
         run_chain},
        {"bridge",
         "200 planks hinged between two banks, after 1200 ticks: sag against the catenary",
         {{"sag", "%", 2}, {"stretch", "%", 0.1}},
         false,
         run_bridge},
        {"ragdolls",
         "12 ragdolls of 11 capsules fall on each other: the middle of nine such heaps",
         {{"at rest after", "s", 12}, {"widest joint", "mm", 5}},
         true,
         run_ragdolls},
        {"pendulum",
         "300 s on a hinge: period against the elliptic integral, and what is left of the swing",
         {{"period, 10 deg", "%", 0.1},
          {"period, 90 deg", "%", 0.1},
          {"period, 150 deg", "%", 0.1},
          {"amplitude", "%", 1}},
         true,
         run_pendulum,
         true},
        {"motor",
         "an arm turned and a mass raised against gravity; the same lying on their limits",
         {{"turning", "%", 0.5},
          {"raising", "%", 0.5},
          {"turned too far", "deg", 0.2},
          {"slid too far", "mm", 2}},
         true,
         run_motor},
        {"top",
         "a heavy top precesses for 60 s at a tilt of 60 degrees, without nutation",
         {{"rate", "%", 1}, {"tilt", "deg", 1}},
         true,
         run_top},
    };
}

} // namespace quality
