// One body on a surface, against closed forms: friction, rolling, bouncing, belts.
#include "quality/row.h"

#include <algorithm>

namespace quality {

namespace {

constexpr double g = 9.81;

/// Gravity on an incline of this angle [rad] that falls towards `direction` (a horizontal unit vector).
V3 incline(double angle, V3 direction) {
    return direction * (g * std::sin(angle)) + V3{0, -g * std::cos(angle), 0};
}

double relative_error(double found, double expected) { return std::abs(found / expected - 1); }

// ---- rolling -----------------------------------------------------------------------------------------------------

/// A ball starts to roll down 20 degrees. Planted: it slips, because friction is below 2/7 tan a.
Figures run_roll(const Contestant& contestant, const Plan& plan) {
    constexpr double angle = 20.0 / 180 * pi, radius = 0.5;
    const int ticks = 120;
    const double friction = plan.planted >= 0 ? 0.05 : 0.6;
    Scene scene;
    scene.gravity = incline(angle, {1, 0, 0});
    scene.add(ground(friction));
    const int ball = scene.add(solid(sphere(radius), {0, radius, 0}, 1000, friction));
    const auto engine = make_engine(contestant, scene);
    engine->advance(ticks);
    const State s = engine->state(ball);
    const double expected = 5.0 / 7 * g * std::sin(angle) * ticks / contestant.rate;
    return {{relative_error(s.velocity.x, expected) * 100,
             std::abs(s.velocity.x + s.spin.z * radius) / expected * 100},
            engine->seconds_per_tick()};
}

// ---- friction ----------------------------------------------------------------------------------------------------

/// Returns whether a box at rest starts to slide, by 10 mm within two seconds.
bool slides(const Contestant& contestant, double friction, double angle, V3 direction, double& tick_time) {
    Scene scene;
    scene.gravity = incline(angle, direction);
    scene.add(ground(friction));
    const int crate = scene.add(solid(box({0.5, 0.25, 0.5}), {0, 0.25, 0}, 1000, friction));
    const auto engine = make_engine(contestant, scene);
    engine->advance(60);
    const V3 before = engine->state(crate).position;
    engine->advance(120);
    tick_time = std::max(tick_time, engine->seconds_per_tick());
    return length(engine->state(crate).position - before) > 0.01;
}

/// The error of the angle at which a box starts to slide, by bisection, against atan(friction): the largest over
/// coefficients [degrees].
double slide_angle_error(const Contestant& contestant, const Plan& plan, V3 direction, double& tick_time) {
    double worst = 0;
    for (const double friction : {0.2, 0.5, 0.8}) {
        const double given = plan.planted >= 0 ? friction * 1.1 : friction, expected = std::atan(friction);
        double low = std::max(expected - radians(12), 0.0), high = expected + radians(12);
        while (high - low > radians(0.05)) {
            const double middle = (low + high) / 2;
            (slides(contestant, given, middle, direction, tick_time) ? high : low) = middle;
        }
        worst = std::max(worst, std::abs((low + high) / 2 - expected) * 180 / pi);
    }
    return worst;
}

Figures run_cone(const Contestant& contestant, const Plan& plan) {
    double tick_time = 0;
    const double along = slide_angle_error(contestant, plan, {1, 0, 0}, tick_time);
    const double slanted =
        slide_angle_error(contestant, plan, {std::cos(radians(40)), 0, std::sin(radians(40))}, tick_time);
    return {{along, slanted}, tick_time};
}

/// A box with 5 m/s must stop after v^2 / (2 mu g).
Figures run_slide(const Contestant& contestant, const Plan& plan) {
    constexpr double speed = 5, friction = 0.5;
    const double given = plan.planted >= 0 ? 0.48 : friction;
    Scene scene;
    scene.add(ground(given));
    Body body = solid(box({0.5, 0.1, 0.5}), {0, 0.1, 0}, 1000, given);
    const double heading = plan.plants(1) ? 0.31 : 0.3;
    body.velocity = V3{std::cos(heading), 0, std::sin(heading)} * speed;
    const int crate = scene.add(body);
    const auto engine = make_engine(contestant, scene);
    engine->advance(180);
    const V3 moved = engine->state(crate).position;
    const double expected = speed * speed / (2 * friction * g);
    const double sideways = std::abs(moved.x * std::sin(0.3) - moved.z * std::cos(0.3));
    return {{relative_error(std::hypot(moved.x, moved.z), expected) * 100, sideways * 1e3},
            engine->seconds_per_tick()};
}

// ---- bouncing ----------------------------------------------------------------------------------------------------

/// The height of a ball's bounce after a fall of 2 m, against e^2 h: the largest error of eleven coefficients [% of h].
Figures run_bounce(const Contestant& contestant, const Plan& plan) {
    constexpr double radius = 0.25, height = 2;
    double worst = 0, tick_time = 0;
    for (int tenth = 0; tenth <= 10; ++tenth) {
        const double e = tenth / 10.0, given = plan.planted >= 0 ? e * 0.95 : e;
        Scene scene;
        scene.add(ground(0.6, given));
        Body body = solid(sphere(radius), {0, radius + height, 0});
        body.restitution = given;
        const int ball = scene.add(body);
        const auto engine = make_engine(contestant, scene);
        bool bounced = false;
        double top = 0, last = radius + height;
        for (int tick = 0; tick < 150; ++tick) { // falls for 0.64 s, rises for at most that time
            engine->advance(1);
            const State s = engine->state(ball);
            if (s.velocity.y >= 0 || last - s.position.y < 0) bounced = true;
            last = s.position.y;
            if (bounced) top = std::max(top, s.position.y - radius);
            if (bounced && s.velocity.y < -0.5) break;
        }
        worst = std::max(worst, std::abs(top - e * e * height) / height);
        tick_time = std::max(tick_time, engine->seconds_per_tick());
    }
    return {{worst * 100}, tick_time};
}

// ---- belts -------------------------------------------------------------------------------------------------------

/// A box on a belt that moves at 2 m/s must have the belt's speed after v / (mu g).
Figures run_belt(const Contestant& contestant, const Plan& plan) {
    if (contestant.product == Product::bullet) return {};
    constexpr double speed = 2, friction = 0.4;
    Scene scene;
    Body belt = ground(friction);
    belt.shape = box({50, 0.5, 2});
    belt.position = {0, -0.5, 0};
    belt.surface_velocity = {plan.plants(0) ? speed * 1.02 : speed, 0, 0};
    scene.add(belt);
    const int crate =
        scene.add(solid(box({0.3, 0.3, 0.3}), {0, 0.3, 0}, 500, plan.plants(1) ? 0.35 : friction));
    const auto engine = make_engine(contestant, scene);
    engine->advance(240);
    const State s = engine->state(crate);
    const double lag = speed * 240 / contestant.rate - s.position.x,
                 expected = speed * speed / (2 * friction * g);
    return {{relative_error(s.velocity.x, speed) * 100, relative_error(lag, expected) * 100},
            engine->seconds_per_tick()};
}

} // namespace

std::vector<Row> surface_rows() {
    return {
        {"roll",
         "a ball from rest down 20 degrees for 2 s, against 5/7 g sin a",
         {{"speed", "%", 0.5}, {"slip", "%", 0.5}},
         true,
         run_roll},
        {"friction-cone",
         "the angle at which a box starts to slide, against atan(mu), mu 0.2, 0.5, 0.8",
         {{"along an edge", "deg", 0.5}, {"slanted 40 deg", "deg", 0.5}},
         false,
         run_cone},
        {"slide",
         "a box shoved at 5 m/s, against v^2 / (2 mu g)",
         {{"distance", "%", 0.5}, {"sideways", "mm", 5}},
         true,
         run_slide},
        {"bounce",
         "a ball from 2 m, against e^2 h, e = 0, 0.1 .. 1",
         {{"height", "% of h", 1}},
         true,
         run_bounce},
        {"belt", "a box on a belt of 2 m/s", {{"speed", "%", 0.5}, {"lag", "%", 1}}, true, run_belt},
    };
}

} // namespace quality
