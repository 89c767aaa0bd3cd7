// World::submersion() against closed forms.
#include "support/about.h"
#include "support/random.h"
#include "support/rigs/scale_field.h"
#include "support/sim_shapes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double pi_ = 3.14159265358979323846;

/// Water with its surface at a height, 100 m wide and 50 m deep.
FieldDef pool(double surface) {
    Region region{.kind = RegionKind::box, .pose = at(0, surface - 25, 0)};
    region.half_extent = vec(50, 25, 50);
    return water(region);
}

/// The part of a body below a level surface.
struct Expected {
    double fraction, volume;
    D3 center;
};

/// A level box that is sunk by `depth`, 0 to its height.
Expected box_below(D3 half, D3 middle, double depth) {
    const double area = 4 * half[0] * half[2];
    return {depth / (2 * half[1]), area * depth, {middle[0], middle[1] - half[1] + depth / 2, middle[2]}};
}

/// A ball that is sunk by `depth`: the cap pi d^2 (3 r - d) / 3, its centre 3 (2 r - d)^2 / (4 (3 r - d)) below the
/// middle.
Expected ball_below(double r, D3 middle, double depth) {
    const double volume = pi_ * depth * depth * (3 * r - depth) / 3;
    const double down = 3 * (2 * r - depth) * (2 * r - depth) / (4 * (3 * r - depth));
    return {volume / (4 * pi_ * r * r * r / 3), volume, {middle[0], middle[1] - down, middle[2]}};
}

/// Two bodies or parts as one.
Expected sum(const Expected& a, const Expected& b) {
    const double volume = a.volume + b.volume, all = a.volume / a.fraction + b.volume / b.fraction;
    return {volume / all, volume, (1 / volume) * (a.volume * a.center + b.volume * b.center)};
}

/// Returns what differs, or an empty string. Clipping is right to 1e-6 of the volume and of the size.
std::string fault_of(const Submersion& s, const Expected& expected, double size) {
    if (std::abs(to_double(s.fraction) - expected.fraction) > 1e-6) return "fraction";
    const double whole = expected.volume / expected.fraction;
    if (std::abs(to_double(s.volume) - expected.volume) > 1e-6 * whole + 1e-9) return "volume";
    // The first moment is right to 1e-6 of the whole, so the centre of a small part is less certain.
    return length(to_double(s.center) - expected.center) > 2e-6 * size / expected.fraction ? "centre" : "";
}

D3 random_half(RandomPoint& random) { return {random(0.1, 2), random(0.1, 2), random(0.1, 2)}; }

} // namespace

TEST_CASE("submersion() of a box and of a ball at random depths is that of the closed forms") {
    RandomPoint random(2);
    int planted = 0;
    const int tries = samples(300, 10000);
    for (int i = 0; i < tries; ++i) {
        const double surface = random(-20, 20), scale = std::exp2(std::floor(random(0, 4)));
        World w = made(World::create(small_def()));
        made(w.create_field(pool(surface)));
        const D3 half = random_half(random);
        // A box on any of its sides; the second half extent is vertical.
        const Quat turn = turned(axis_y, random(-180, 180)) * turned(axis_z, 90 * std::floor(random(0, 4)));
        const bool is_on_side = std::abs(to_double(rotate(turn, Vec3{1_r, 0_r, 0_r}).y)) > 0.5;
        const D3 own = is_on_side ? D3{half[1], half[0], half[2]} : half;
        const double depth = random(0.02, 1) * 2 * half[1] * scale;
        const D3 middle{random(-20, 20), surface + scale * half[1] - depth, random(-20, 20)};
        const BodyId crate = add(w, {.kind = BodyKind::static_, .pose = {vec3(middle), normalized(turn)}},
                                 {.geometry = test::with_scale(box(vec3(own)), real(scale))});
        const Expected expected = box_below(scale * half, middle, depth);
        CHECK(fault_of(w.submersion(crate), expected, 2 * scale) == "");

        const double r = random(0.1, 2), ball_depth = random(0.05, 1) * 2 * r;
        const D3 ball_middle{random(-20, 20), surface + r - ball_depth, random(-20, 20)};
        const BodyId ball =
            add(w, {.pose = {vec3(ball_middle), random.rotation()}}, {.geometry = sphere(real(r))});
        CHECK(fault_of(w.submersion(ball), ball_below(r, ball_middle, ball_depth), r) == "");
        planted +=
            fault_of(w.submersion(ball), ball_below(r, ball_middle, ball_depth * 1.001), r).empty() ? 0 : 1;
    }
    CHECK(planted == tries);
}

TEST_CASE("submersion() of a compound of two boxes and of a body of two shapes sums over the parts") {
    RandomPoint random(3);
    for (int i = 0; i < samples(100, 3000); ++i) {
        const double surface = random(-20, 20), factor = i % 2 == 0 ? 1 : 2;
        const D3 one = random_half(random), two = random_half(random);
        const D3 apart{random(-3, 3), random(-1, 1) * one[1], random(-3, 3)};
        const Geometry first = test::with_scale(box(vec3((1 / factor) * one)), real(factor)),
                       second = box(vec3(two));
        const CompoundPart parts[] = {{first, {}}, {second, {vec3(apart), Quat::identity()}}};
        AssetLibrary library;
        const AssetId id = made(library.add(bake_compound(parts)));
        World w = made(World::create(small_def(), {}, std::make_shared<AssetLibrary>(std::move(library))));
        made(w.create_field(pool(surface)));
        const double depth = random(0.1, 1) * one[1];
        const D3 middle{random(-20, 20), surface + one[1] - depth, random(-20, 20)};
        const double second_depth = std::clamp(surface - (middle[1] + apart[1] - two[1]), 0.0, 2 * two[1]);
        const Expected below = box_below(one, middle, depth);
        Expected all = box_below(two, middle + apart, second_depth);
        if (second_depth > 0) {
            all = sum(below, all);
        } else {
            all = below;
            all.fraction = below.volume / (below.volume / below.fraction + 8 * two[0] * two[1] * two[2]);
        }
        const Geometry compound = made(w.assets().geometry(id));
        const BodyId together = add(w, {.pose = {vec3(middle), Quat::identity()}}, {.geometry = compound});
        CHECK(fault_of(w.submersion(together), all, 6) == "");
        if (factor != 1) continue; // a scaled shape needs a static body
        const BodyId shapes = add(w, {.pose = {vec3(middle), Quat::identity()}}, {.geometry = first});
        made(w.create_shape(shapes, {.geometry = second, .local = {vec3(apart), Quat::identity()}}));
        CHECK(fault_of(w.submersion(shapes), all, 6) == "");
    }
}

TEST_CASE("submersion() is 0 outside of fluids and for meshes and for wind and counts the highest of several "
          "fluids") {
    const Zoo zoo = make_zoo();
    World w = made(World::create(small_def(), {}, zoo.library));
    const BodyId crate = add(w, {.pose = at(1, 0, 2)}, {.geometry = box(1_r, 1_r, 1_r)});
    const auto fraction = [&](BodyId body) { return to_double(w.submersion(body).fraction); };
    CHECK(fraction(crate) == 0);
    CHECK(w.submersion(crate).center == w.center_of_mass(crate));
    CHECK(w.submersion(crate).volume == Real{});
    made(w.create_field(wind({3_r, 0_r, 0_r})));
    CHECK(fraction(crate) == 0);
    const FieldId low = made(w.create_field(pool(-0.5)));
    CHECK(fraction(crate) == test::about(0.25));
    FieldDef oil = pool(0.5);
    oil.priority = 5, oil.density = 800_r;
    const FieldId high = made(w.create_field(oil));
    CHECK(fraction(crate) == test::about(0.75));
    CHECK(to_double(w.submersion(crate).volume) == test::about(6));
    oil.mask = 2;
    done(w.set_field(high, oil));
    CHECK(fraction(crate) == test::about(0.25));
    const BodyId waves = add(w, {.kind = BodyKind::static_, .pose = at(0, -9, 0)},
                             {.geometry = instance(ShapeKind::height_field, zoo.waves)});
    const BodyId step = add(w, {.kind = BodyKind::static_, .pose = at(0, -9, 0)},
                            {.geometry = instance(ShapeKind::mesh, zoo.step)});
    const BodyId sensor = add(w, {.pose = at(5, -9, 0)}, {.geometry = sphere(1_r), .sensor = 1});
    const BodyId empty = made(w.create_body({.pose = at(9, -9, 0)}));
    for (const BodyId body : {waves, step, sensor, empty}) CHECK(fraction(body) == 0);
    const BodyId gem = add(w, {.kind = BodyKind::static_, .pose = at(9, -9, 0)},
                           {.geometry = instance(ShapeKind::hull, zoo.hull)});
    CHECK(w.submersion(gem).fraction == unit_one);
    CHECK(to_double(w.submersion(gem).volume) > 0.3);
    const BodyId outside = add(w, {.pose = at(60, -9, 0)}, {.geometry = sphere(1_r)});
    CHECK(fraction(outside) == 0);
    done(w.destroy(low));
    CHECK(fraction(gem) == 0);
}

TEST_CASE("a floating body is submerged by the ratio of the densities, and a reading changes no hash") {
    World w = made(World::create(small_def()));
    made(w.create_field(pool(0)));
    const BodyId crate =
        add(w, {.pose = at(0, 0.2, 0)}, {.geometry = box(0.5_r, 0.3_r, 0.5_r), .density = 600_r});
    for (int t = 0; t < 1200; ++t) w.tick();
    World other = w.clone();
    const std::uint64_t before = w.hash();
    CHECK(to_double(w.submersion(crate).fraction) == test::about(0.6, 0.01));
    CHECK(w.hash() == before);
    for (int t = 0; t < 60; ++t) w.tick(), other.tick();
    CHECK(w.hash() == other.hash());
}

TEST_CASE("a compound of scaled primitives floats like a compound of primitives of their sizes") {
    AssetLibrary library;
    const auto pair_of = [&](const Geometry& a, const Geometry& b) {
        const CompoundPart parts[] = {{a, at(-1, 0, 0)}, {b, at(1, 0, 0, turned(axis_x, 20))}};
        return made(library.geometry(made(library.add(bake_compound(parts)))));
    };
    const Geometry by_scale = pair_of(test::with_scale(cone(0.25_r, 0.25_r), 2_r),
                                      test::with_scale(box(0.25_r, 0.125_r, 0.5_r), 2_r)),
                   by_size = pair_of(cone(0.5_r, 0.5_r), box(0.5_r, 0.25_r, 1_r));
    const auto shared = std::make_shared<AssetLibrary>(std::move(library));
    D3 ends[2];
    for (const bool is_scaled : {false, true}) {
        World w = made(World::create(small_def(), {}, shared));
        made(w.create_field(pool(0)));
        const BodyId body =
            add(w, {.pose = at(0, 0.5, 0, turned(axis_z, 10)), .linear_velocity = vec(2, 0, 0)},
                {.geometry = is_scaled ? by_scale : by_size, .density = 500_r});
        for (int t = 0; t < 240; ++t) w.tick();
        ends[is_scaled] = position(w, body);
    }
    CHECK(length(ends[1] - ends[0]) < 1e-4);
}
