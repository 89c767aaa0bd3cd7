// Times of impact of turning shapes against FCL and against sampling: never too late, and not too early.
#include "oracle/cast_double.h"

#include <doctest/doctest.h>

#include <fcl/narrowphase/continuous_collision.h>
#include <fcl/narrowphase/distance.h>

#include <cstdlib>

using namespace cast_oracle;
using collide::Sweep;

namespace {

constexpr ShapeKind kinds[] = {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::cone,
                               ShapeKind::box};

struct Case {
    Geometry a, b;
    Sweep sweep_a, sweep_b;
};

Transform pose(V p, Quat q) { return {{real(p.x), real(p.y), real(p.z)}, q}; }

/// Two shapes, sometimes one at rest, that approach each other while they turn by less than half a turn.
Case random_case(RandomCast& random) {
    Case c;
    c.a = random_primitive(random, kinds[random.engine() % 5], 0.05, 1, random(0, 1) < 0.3);
    c.b = random_primitive(random, kinds[random.engine() % 5], 0.05, 1, random(0, 1) < 0.3);
    const V d = random.direction();
    const double far = random(1, 8);
    const Quat qa = random.rotation(), qb = random.rotation();
    const auto turned = [&](Quat q) {
        const V axis = random.direction();
        return normalized(from_axis_angle({fixed<Unit>(axis.x), fixed<Unit>(axis.y), fixed<Unit>(axis.z)},
                                          real(random(0, 1.5))) *
                          q);
    };
    const V miss = random.in_box(0.7);
    c.sweep_a = {pose({0, 0, 0}, qa),
                 random(0, 1) < 0.4 ? pose({0, 0, 0}, qa) : pose(random.in_box(0.5), turned(qa)),
                 Transform::identity()};
    c.sweep_b = {pose(d * far, qb), pose(miss - d * random(0, far), turned(qb)), Transform::identity()};
    if (random(0, 1) < 0.3) c.sweep_b.local = pose(random.in_box(0.3), random.rotation());
    return c;
}

double separation(const shapes::Solid& a, const shapes::Solid& b, const Case& c, double t,
                  collide::NarrowScratch& scratch) {
    collide::Nearest n{};
    const Unit f = fixed<Unit>(t);
    collide::nearest_points(
        a, b, collide::relative_pose(collide::pose_at(c.sweep_a, f), collide::pose_at(c.sweep_b, f)),
        Coordinate(100), scratch, n);
    return value(n.distance);
}

struct Tally {
    int cases = 0, impacts = 0, late = 0, early = 0;
};

/// `shift`: a planted error, added to every answer.
Tally check_many(int count, double shift) {
    RandomCast random{std::mt19937_64(12)};
    Solids solids;
    collide::NarrowScratch scratch;
    Tally tally;
    const double target = 0.002;
    for (int i = 0; i < count; ++i) {
        const Case c = random_case(random);
        const shapes::Solid a = solids(c.a), b = solids(c.b);
        if (separation(a, b, c, 0, scratch) < 0.01) continue;
        const Unit answer =
            collide::time_of_impact(a, c.sweep_a, b, c.sweep_b, fixed<Length>(target), scratch);
        const double t = std::clamp(value(answer) + (answer < unit_one ? shift : 0), 0.0, 1.0);
        ++tally.cases;
        tally.impacts += answer < unit_one;
        // Samples: apart until the impact, and at about the target distance there.
        for (int k = 0; k <= 200; ++k)
            if (separation(a, b, c, t * k / 200, scratch) < target * 0.9) {
                ++tally.late;
                break;
            }
        tally.early += answer < unit_one && separation(a, b, c, t, scratch) > target * 1.3;
    }
    return tally;
}

// ---- FCL ----

std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const Geometry& g) {
    const V h = of(g.half_extent);
    const double r = value(g.radius);
    switch (g.kind) {
    case ShapeKind::sphere:
        return std::make_shared<fcl::Sphered>(r);
    case ShapeKind::box:
        return std::make_shared<fcl::Boxd>(2 * h.x, 2 * h.y, 2 * h.z);
    case ShapeKind::cone:
        return std::make_shared<fcl::Coned>(h.x, 2 * h.y);
    default:
        return std::make_shared<fcl::Cylinderd>(h.x, 2 * h.y);
    }
}
/// FCL's cylinders and cones have their axis along z.
fcl::Transform3d fcl_pose(const Transform& t, bool upright) {
    fcl::Transform3d out = fcl::Transform3d::Identity();
    fcl::Quaterniond q(value(t.rotation.w), value(t.rotation.x), value(t.rotation.y), value(t.rotation.z));
    out.linear() = q.normalized().toRotationMatrix();
    if (upright)
        out.linear() =
            out.linear() * Eigen::AngleAxisd(-std::acos(0.0), Eigen::Vector3d::UnitX()).toRotationMatrix();
    const V p = of(t.position);
    out.translation() = Eigen::Vector3d(p.x, p.y, p.z);
    return out;
}

/// The time of contact by FCL's conservative advancement, for shapes that only translate; negative when it finds none.
double fcl_time(const Case& c) {
    const auto upright = [](const Geometry& g) {
        return g.kind == ShapeKind::cylinder || g.kind == ShapeKind::cone;
    };
    const auto a = fcl_shape(c.a), b = fcl_shape(c.b);
    fcl::ContinuousCollisionRequestd request(1000, 1e-6, fcl::CCDM_TRANS, fcl::GST_LIBCCD,
                                             fcl::CCDC_CONSERVATIVE_ADVANCEMENT);
    fcl::ContinuousCollisionResultd result;
    fcl::continuousCollide(
        a.get(), fcl_pose(c.sweep_a.from, upright(c.a)), fcl_pose(c.sweep_a.to, upright(c.a)), b.get(),
        fcl_pose(c.sweep_b.from, upright(c.b)), fcl_pose(c.sweep_b.to, upright(c.b)), request, result);
    return result.is_collide ? result.time_of_contact : -1;
}

} // namespace

TEST_CASE("a time of impact is never late and rarely early") {
    const Tally t = check_many(samples(400, 10000), 0);
    CHECK(t.late == 0);
    CHECK(t.early <= t.cases / 500); // the steps run out for shapes that turn beside each other for long
    CHECK(t.impacts > t.cases / 4);
    CHECK(t.cases - t.impacts > t.cases / 10);
}

TEST_CASE("planted: the test detects a late or early time of impact") {
    CHECK(check_many(200, 0.01).late > 20);
    CHECK(check_many(200, -0.01).early > 20);
}

TEST_CASE("times of impact and casts of straight motions agree with FCL") {
    RandomCast random{std::mt19937_64(13)};
    Solids solids;
    collide::NarrowScratch scratch;
    int compared = 0, wrong = 0, wrong_cast = 0;
    for (int i = 0; i < samples(300, 5000); ++i) {
        Case c = random_case(random);
        for (Geometry* g : {&c.a, &c.b}) {
            if (g->kind != ShapeKind::sphere) g->radius = Length{};
            if (g->kind == ShapeKind::capsule) *g = box(0.1_r, 0.2_r, 0.3_r);
        }
        c.sweep_a.to = c.sweep_a.from;
        c.sweep_b.to.rotation = c.sweep_b.from.rotation;
        c.sweep_b.local = Transform::identity();
        const shapes::Solid a = solids(c.a), b = solids(c.b);
        if (separation(a, b, c, 0, scratch) < 0.01) continue;
        const double truth = fcl_time(c);
        const double length = norm(of(c.sweep_b.to.position - c.sweep_b.from.position));
        const Unit own = collide::time_of_impact(a, c.sweep_a, b, c.sweep_b, fixed<Length>(1e-5), scratch);
        if (truth < 0 || own == unit_one) {
            // One of the two reports a miss: then the distance must be small.
            double least = 1;
            for (int k = 0; k <= 400; ++k) least = std::min(least, separation(a, b, c, k / 400.0, scratch));
            wrong += (truth < 0) != (own == unit_one) && least > 2e-3 && least < 1;
            continue;
        }
        ++compared;
        const collide::RelativePose rel = collide::relative_pose(c.sweep_a.from, c.sweep_b.from);
        const Vec3 way =
            rotate_inverse(c.sweep_a.from.rotation, c.sweep_b.to.position - c.sweep_b.from.position);
        collide::CastHit hit{};
        const bool met = collide::cast_shape(a, b, rel, to<Coordinate>(way), scratch, hit);
        // The result of a grazing contact depends on the tolerance of FCL's distance, about 1e-5 m.
        const double cosine = met ? -dot(of(hit.normal), unit(of(way))) : 1;
        if (cosine < 0.1) continue;
        wrong += std::abs(value(own) - truth) * length * cosine > 1e-3;
        wrong_cast += !met || std::abs(value(hit.fraction) - truth) * length * cosine > 1e-3;
    }
    CHECK(compared > 50);
    // FCL itself is off by a millimetre in one of thousands; cast_shape.cpp proves the casts without it.
    CHECK(wrong <= compared / 1000);
    CHECK(wrong_cast <= compared / 1000);
}
