// The place where a sweep stops a body that moves towards a plane, in closed form.
#include "collide/query/cast.h"
#include "law/collide/long_sweeps.h"
#include "support/random.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double stop_gap = 0.002; ///< collide::stop_gap [m]

/// A shape that starts `gap` above a plane and ends `depth` below it [m], without turning.
struct Fall {
    Geometry shape;
    double reach; ///< from its centre down to its lowest point [m]
    double gap, depth;
};

double stop_of(const Fall& fall, const shapes::Solid& ground = {plane()}, double ground_at = 0,
               collide::Held held = collide::Held::not_at_all) {
    const shapes::Solid body{fall.shape};
    const collide::Sweep still{at(0, ground_at, 0), at(0, ground_at, 0), Transform::identity()};
    const collide::Sweep way{at(0, fall.reach + fall.gap, 0), at(0, fall.reach - fall.depth, 0),
                             Transform::identity()};
    collide::NarrowScratch scratch;
    return to_double(collide::stop_fraction(ground, still, body, way, {}, held, scratch));
}

/// The fraction of the way at which the shape is stop_gap above the plane.
double surface_fraction(const Fall& fall) { return (fall.gap - stop_gap) / (fall.gap + fall.depth); }

/// Returns whether the shape passes: the rounding that remains comes within stop_gap only at the depth of the other
/// part, less stop_gap.
bool passes(const Fall& fall, double rounding, double part) {
    return fall.depth < rounding * part - stop_gap;
}

} // namespace

TEST_CASE(
    "the sweep stops a rounded shape at the surface unless it enters by less than half of its rounding") {
    RandomPoint random(7);
    int passed = 0, stopped = 0, told_apart = 0;
    for (int i = 0; i < 2000; ++i) {
        const double radius = random(0.02, 1), half_height = random(0.02, 1), gap = random(0.01, 1),
                     depth = random(0, radius);
        const Fall falls[] = {
            {sphere(real(radius)), radius, gap, depth},
            {capsule(real(radius), real(half_height)), radius + half_height, gap, depth},
        };
        for (const Fall& fall : falls) {
            if (std::abs(depth - (radius / 2 - stop_gap)) < 0.001)
                continue; // the advance ends an eighth of stop_gap early
            const double stop = stop_of(fall), surface = surface_fraction(fall);
            if (passes(fall, radius, 0.5)) {
                CHECK(stop == 1);
                ++passed;
            } else {
                CHECK(stop <= surface + 1e-6 / (gap + depth));
                CHECK(stop >= surface - 0.001 / (gap + depth));
                ++stopped;
            }
            told_apart += (stop == 1) != passes(fall, 0.8 * radius, 0.5);
        }
    }
    CHECK(passed > 500);
    CHECK(stopped > 500);
    CHECK(told_apart > 100); // negative control: four fifths of the rounding
}

TEST_CASE("the centre of a jointed body may enter planes by its inner radius and boxes to the middle but no "
          "other shape") {
    RandomPoint random(11);
    int passed = 0, deep = 0, beyond = 0;
    for (int i = 0; i < 3000; ++i) {
        const double half = random(0.02, 0.5), tall = random(0.02, 1), gap = random(0.01, 1),
                     depth = random(0, 4 * half);
        const Fall fall = i % 2 == 0 ? Fall{box(real(half), real(half), real(half)), half, gap, depth}
                                     : Fall{capsule(real(half / 2), real(half / 2)), half, gap, depth};
        // how far the centre ends above the top
        const double centre = half - depth, inner = i % 2 == 0 ? half : half / 2;
        const double surface =
            (gap + half - stop_gap) / (gap + depth); // there the centre is stop_gap above the top
        const auto is_at_centre = [&](double stop) {
            return stop <= surface + 1e-6 / (gap + depth) && stop >= surface - 0.001 / (gap + depth);
        };
        const double by_plane = stop_of(fall, {plane()}, 0, collide::Held::by_joints);
        const double by_box = stop_of(fall, {box(2_r, real(tall), 2_r)}, -tall, collide::Held::by_joints);
        const double by_cylinder =
            stop_of(fall, {cylinder(2_r, real(tall))}, -tall, collide::Held::by_joints);
        if (std::abs(centre + inner) < 0.001 || std::abs(centre + tall) < 0.001) continue;
        if (std::abs(centre - stop_gap) < 0.001) continue;
        const bool is_shallow = centre > -inner, is_before = centre > -tall;
        CHECK((is_shallow ? by_plane == 1 : is_at_centre(by_plane)));
        CHECK((is_shallow && is_before ? by_box == 1 : is_at_centre(by_box)));
        CHECK((centre > stop_gap ? by_cylinder == 1 : is_at_centre(by_cylinder)));
        ++(!is_shallow ? deep : is_before ? passed : beyond);
    }
    CHECK(passed > 500);
    CHECK(deep > 500);
    CHECK(beyond > 30);
}

TEST_CASE("the sweep always stops a shape without rounding at the surface") {
    RandomPoint random(8);
    for (int i = 0; i < 1000; ++i) {
        const double half = random(0.02, 1);
        const Fall fall{box(real(half), real(half), real(half)), half, random(0.01, 1), random(0.001, half)};
        const double stop = stop_of(fall), surface = surface_fraction(fall);
        CHECK(stop <= surface + 1e-6 / (fall.gap + fall.depth));
        CHECK(stop >= surface - 0.001 / (fall.gap + fall.depth));
    }
}

namespace {

/// Two motions that begin apart: an obstacle that may turn, and a body that may hit it.
struct Crossing {
    collide::Sweep obstacle, mover;
};
Crossing crossing(RandomPoint& random) {
    const auto way = [&](double near, double far, double turn) {
        const Quat from = random.rotation();
        const D3 axis = random.direction();
        const Quat by =
            from_axis_angle({quantize<Unit>(axis[0]), quantize<Unit>(axis[1]), quantize<Unit>(axis[2])},
                            real(random(0, turn)));
        const Transform begin{vec3(random(near, far) * random.direction()), from};
        const Transform end{vec3(random(0, far) * random.direction()), normalized(by * from)};
        return collide::Sweep{begin, end, Transform::identity()};
    };
    const double turn = random(0, 1) < 0.5 ? 0 : 0.8;
    return {way(0, 0.1, turn), way(1, 4, random(0, 1.5))};
}

} // namespace

TEST_CASE("the sweep stops a box at an obstacle box exactly at the time of impact of their nearest points") {
    RandomPoint random(9);
    collide::NarrowScratch scratch;
    int stopped = 0, passed = 0;
    for (int i = 0; i < samples(4000, 100000); ++i) {
        const Geometry sharp = box(real(random(0.05, 2)), real(random(0.05, 2)), real(random(0.05, 2)));
        const shapes::Solid obstacle{i % 3 == 0 ? rounded(sharp, real(random(0.01, 0.5))) : sharp};
        const shapes::Solid mover{
            box(real(random(0.05, 0.5)), real(random(0.05, 0.5)), real(random(0.05, 0.5)))};
        const Crossing c = crossing(random);
        const auto impact = [&](Length target) {
            return collide::time_of_impact(obstacle, c.obstacle, mover, c.mover, target, scratch);
        };
        if (impact(quantize<Length>(4 * stop_gap)) == Unit{}) continue; // nearer than that at the start
        const Unit stop = collide::stop_fraction(obstacle, c.obstacle, mover, c.mover, {},
                                                 collide::Held::not_at_all, scratch);
        CHECK(stop == impact(quantize<Length>(stop_gap)));
        ++(stop == unit_one ? passed : stopped);
    }
    CHECK(stopped > 500);
    CHECK(passed > 500);
}

namespace {

/// The parts of a capsule that a box can stop: the whole, the thinner capsule that remains as it sinks in, and its
/// core.
struct Dipping {
    shapes::Solid whole, thin, core;

    Dipping(double radius, double half_height, int part) // an integer part is exact
        : whole{capsule(real(radius), real(half_height))}, thin{whole}, core{whole} {
        const Length rounding = whole.geometry.radius;
        thin.geometry.radius = Length::from_raw(rounding.raw / part);
        core = shapes::Solid{sphere(to<Real>(Length::from_raw(rounding.raw / 2)))};
    }
};

} // namespace

TEST_CASE("the sweep against a box's faces stops a rounded shape at the impact times of the whole and its "
          "thinner part") {
    RandomPoint random(10);
    collide::NarrowScratch scratch;
    int stopped = 0, passed = 0, dipped = 0, held_at_core = 0;
    for (int i = 0; i < samples(6000, 150000); ++i) {
        const shapes::Solid obstacle{
            box(real(random(0.05, 2)), real(random(0.05, 2)), real(random(0.05, 2)))};
        const Dipping mover(random(0.02, 0.4), random(0.02, 0.5), 2);
        const Crossing c = crossing(random);
        const auto impact = [&](const shapes::Solid& of, Length target) {
            return collide::time_of_impact(obstacle, c.obstacle, of, c.mover, target, scratch);
        };
        const Length gap = quantize<Length>(stop_gap);
        const Unit stop = collide::stop_fraction(obstacle, c.obstacle, mover.whole, c.mover, {},
                                                 collide::Held::not_at_all, scratch);
        if (impact(mover.whole, quantize<Length>(2 * stop_gap)) == Unit{}) { // it touches, or nearly
            if (impact(mover.whole, Length{}) != Unit{}) continue;
            if (impact(mover.core, quantize<Length>(2 * stop_gap)) == Unit{}) continue;
            // This core is a separate ball, that of the sweep is part of the capsule: rounding may bring one of them an
            // eighth nearer.
            CHECK(stop >= impact(mover.core, Length::from_raw(gap.raw / 4 * 5)));
            CHECK(stop <= impact(mover.core, Length::from_raw(gap.raw / 20 * 17)));
            held_at_core += stop != unit_one;
            continue;
        }
        const Unit surface = impact(mover.whole, gap), deep = impact(mover.thin, gap);
        CHECK(stop == (deep == unit_one ? unit_one : surface));
        dipped += surface != unit_one && deep == unit_one;
        ++(stop == unit_one ? passed : stopped);
    }
    CHECK(stopped > 500);
    CHECK(passed > 500);
    CHECK(dipped > 100);
    CHECK(held_at_core > 20);
}

TEST_CASE("the sweep stops a long body that turns at a triangle exactly at the time of impact") {
    RandomPoint random(14);
    lockstone::test::LongSweepCounts counts;
    for (int i = 0; i < samples(6000, 300000); ++i)
        CHECK(lockstone::test::long_sweep_fault(random, counts) == "");
    CHECK(counts.stopped > 500);
    CHECK(counts.passed > 500);
    CHECK(counts.skipped < 2 * (counts.stopped + counts.passed));
}

TEST_CASE("no point of a body moves further relative to a body that turns than the bound of their relative "
          "motion") {
    RandomPoint random(15);
    for (int i = 0; i < samples(4000, 200000); ++i)
        CHECK(lockstone::test::relative_motion_fault(random) == "");
}
