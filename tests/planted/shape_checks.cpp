// Shapes: queries of their parts near a place, and their manifolds.
#include "checks.h"
#include "collide/bounds.h"
#include "collide/broad/broad_phase.h"
#include "collide/narrow_phase.h"
#include "collide/query/cast.h"
#include "law/collide/long_sweeps.h"
#include "law/collide/sunken.h"
#include "shapes/asset/asset.h"
#include "solve/kernels/kernels.h"
#include "support/rigs/quick_queries.h"
#include "support/rigs/scale_field.h"

namespace planted {

namespace {

/// A ball in a box that reaches 1074 m along its diagonal, with that diagonal as the hint of a separating direction.
std::string hint_of_large_box() {
    const shapes::Solid ball{sphere(1_r)}, cliff{test::with_scale(box(77.5_r, 77.5_r, 77.5_r), 8_r)};
    const Coordinate along = decimal<Coordinate>("57.735");
    const Unit third = decimal<Unit>("0.577350269");
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    collide::collide(cliff, ball, {Rotation::identity(), {along, along, along}}, Length{},
                     {{third, third, third}, {}, 0}, scratch, found);
    return found.count == 1 ? "" : "a ball 100 m from its centre is outside";
}

std::string long_margins_reach() {
    const Rotation axes = Rotation::identity();
    const shapes::Solid ball{sphere(0.1_r)};
    return collide::are_parted({ball, axes, {}}, {ball, axes, {Real{}, 64_r, Real{}}},
                               {Unit{}, unit_one, Unit{}}, Length::max())
               ? "balls 64 m apart are parted by a margin of 128 m"
               : "";
}

std::string parts_are_found() {
    AssetLibrary library;
    std::vector<CompoundPart> balls(20, {sphere(0.1_r), Transform::identity()});
    for (std::size_t i = 0; i < balls.size(); ++i) balls[i].local.position.x = Real(static_cast<int>(i));
    const auto& row = *library.find(library.add(bake_compound(balls)).value());
    std::vector<std::uint32_t> found;
    row.compound->find(row.compound->extent, found);
    return found.size() == balls.size() ? "" : "a part of a compound is not found";
}

/// Movers that the broad phase knows, a level that never moves around them, and movers that come with it. Then the
/// level begins to move. Each of its boxes overlaps its neighbours and one mover.
std::string level_is_found() {
    constexpr std::uint32_t boxes = 100, proxies = 2 * boxes;
    collide::BroadPhase phase(proxies);
    std::vector<collide::ProxyPair> pairs;
    const auto place = [&](std::uint32_t proxy) {
        const Bound x = Bound(static_cast<int>(proxy % boxes)), one = Bound(1);
        phase.set(proxy, {{x, Bound{}, Bound{}}, {x + one, one, one}}, false);
    };
    const auto find = [&] {
        phase.find_pairs(pairs);
        return pairs.size();
    };
    for (std::uint32_t mover = 0; mover < 20; ++mover) place(mover);
    if (find() != 19) return "the movers alone have other pairs";
    for (std::uint32_t i = 0; i < boxes; ++i) phase.set_never_moves(boxes + i, true), place(boxes + i);
    for (std::uint32_t mover = 20; mover < 30; ++mover) place(mover);
    if (find() != 29 + 30 * 3 - 1) return "the movers and the level have other pairs";
    for (std::uint32_t mover = 30; mover < 40; ++mover) place(mover);
    if (find() != 39 + 40 * 3 - 1) return "more movers and the level have other pairs";
    for (std::uint32_t i = 0; i < boxes; ++i) phase.set_never_moves(boxes + i, false);
    return find() == 39 + 40 * 3 - 1 + boxes - 1 ? "" : "the level that moves has other pairs";
}

/// A cube of a metre, as a hull.
shapes::Solid hull_cube(AssetLibrary& library) {
    std::vector<LengthVec3> corners;
    for (int i = 0; i < 8; ++i) {
        const auto side = [&](int axis) {
            return decimal<Length>("0.5") * Length((i >> axis & 1) != 0 ? 1 : -1);
        };
        corners.push_back({side(0), side(1), side(2)});
    }
    const AssetId id = library.add(bake_hull(corners)).value();
    return {library.geometry(id).value(), library.find(id)->hull.get()};
}

/// Two cubes that overlap by 1 cm along x and by 2 cm along y. In the last tick they touched along y.
std::string kept_face_is_nearest() {
    AssetLibrary library;
    const shapes::Solid cube = hull_cube(library);
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    collide::collide(
        cube, cube,
        {Rotation::identity(), {decimal<Coordinate>("0.99"), decimal<Coordinate>("0.98"), Coordinate{}}},
        decimal<Length>("0.02"), {{}, {Unit{}, unit_one, Unit{}}, 0}, scratch, found);
    return found.count == 1 && found.items[0].normal.x == unit_one
               ? ""
               : "a face is kept though another is nearer";
}

/// Two cubes 5 mm apart, on each of the six sides, collided with and without the hint of the last tick. Whichever
/// corner is the first one, some side does not have it.
std::string cubes_face_each_other() {
    AssetLibrary library;
    const shapes::Solid cube = hull_cube(library);
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    for (int side = 0; side < 6; ++side) {
        collide::RelativePose pose{Rotation::identity(), {}};
        pose.position[side / 2] = decimal<Coordinate>("1.005") * Coordinate(side % 2 == 0 ? 1 : -1);
        collide::PairHints hints{};
        for (const char* when : {" now", " in the tick before"}) {
            collide::collide(cube, cube, pose, decimal<Length>("0.02"), hints, scratch, found);
            if (found.count != 1 || found.items[0].count != 4)
                return "cubes do not face each other on side " + std::to_string(side) + ", met" + when;
            for (const collide::ManifoldPoint& point : found.items[0].points)
                if (abs(point.separation - decimal<Separation>("0.005")) > decimal<Separation>("0.0001"))
                    return "a corner is not where it touches on side " + std::to_string(side) + ", met" +
                           when;
            hints.normal = found.items[0].normal;
        }
    }
    return "";
}

/// A cube whose edge crosses the edge of another cube, overlapping by `deep` and moved along the other's edge [m].
std::string kept_edges_are_nearest() {
    AssetLibrary library;
    const shapes::Solid cube = hull_cube(library);
    const Rotation turned =
        to_rotation(from_axis_angle({Unit{}, Unit{}, unit_one}, decimal<Real>("-0.785398163")) *
                    from_axis_angle({unit_one, Unit{}, Unit{}}, 0.785398163_r));
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    const auto look = [&](Real deep, Real aside, const collide::PairHints& hints) {
        const Real each = (1.414213562_r - deep) * 0.707106781_r;
        collide::collide(cube, cube,
                         {turned, {to<Coordinate>(each), to<Coordinate>(each), to<Coordinate>(aside)}},
                         decimal<Length>("0.02"), hints, scratch, found);
    };
    look(0.01_r, Real{}, {});
    const collide::Manifold first = found.items[0];
    if (found.count != 1 || first.on_face != 0) return "two edges do not touch";
    const collide::PairHints hints{{}, first.normal, first.points[0].feature};
    look(0.01_r, 0.1_r, hints);
    if (found.count != 1 || found.items[0].points[0].feature != hints.edges)
        return "edges that touch are not kept";
    look(0.01_r, 0.6_r, hints);
    if (found.count != 0) return "edges are kept beyond an end of one";
    // A face at B's edge separates them by 0.60 m, on either side. Whichever of the two sides the code tries first, one
    // of the cases needs the second.
    for (const Real aside : {0.45_r, Real{} - 0.45_r}) {
        look(0.8_r, aside, hints);
        if (abs(found.items[0].normal.z) < decimal<Unit>("0.5"))
            return "edges are kept though a face is nearer";
    }
    return "";
}

/// A ball and a box 2 mm above a mesh of two triangles: within the margin of a centimetre.
std::string mesh_is_found() {
    const std::vector<Vec3> vertices = {
        {-4_r, 0_r, -4_r}, {-4_r, 0_r, 4_r}, {4_r, 0_r, 4_r}, {4_r, 0_r, -4_r}};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
    const auto library = std::make_shared<AssetLibrary>();
    const AssetId id =
        library->add(bake_mesh({.vertices = vertices, .triangles = triangles}).value()).value();
    shapes::SolidCache cache(library);
    const shapes::Solid ground = cache.resolve(library->geometry(id).value()).value();
    for (const Geometry& shape : {sphere(0.5_r), box(0.5_r, 0.5_r, 0.5_r)}) {
        const shapes::Solid above{shape};
        collide::NarrowScratch scratch;
        collide::Manifolds found;
        const collide::RelativePose pose{
            Rotation::identity(),
            {decimal<Coordinate>("1"), decimal<Coordinate>("0.502"), decimal<Coordinate>("0.5")}};
        collide::collide(ground, above, pose, decimal<Length>("0.01"), {}, scratch, found);
        if (found.count == 0)
            return std::string(shape.kind == ShapeKind::sphere ? "a ball" : "a box") +
                   " that is about to touch a mesh has no contact";
    }
    return "";
}

/// Two small triangles at heights -0.1 and 0, 40 cm beside the path of a box of 1 m that moves down. The box is cast at
/// them, and is beside them.
std::string queries_find_triangles() {
    std::vector<Vec3> vertices;
    for (const Real y : {-0.1_r, 0_r})
        for (const Vec3 corner : {Vec3{0.4_r, y, 0_r}, Vec3{0.4_r, y, 0.1_r}, Vec3{0.5_r, y, 0_r}})
            vertices.push_back(corner);
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {3, 4, 5}};
    const auto library = std::make_shared<AssetLibrary>();
    const AssetId id =
        library->add(bake_mesh({.vertices = vertices, .triangles = triangles}).value()).value();
    shapes::SolidCache cache(library);
    const shapes::Solid mesh = cache.resolve(library->geometry(id).value()).value(),
                        moving{box(0.5_r, 0.5_r, 0.5_r)};
    collide::NarrowScratch scratch;
    collide::CastHit hit{};
    collide::RelativePose pose{Rotation::identity(), {Coordinate{}, decimal<Coordinate>("2"), Coordinate{}}};
    const CoordinateVec3 down{Coordinate{}, decimal<Coordinate>("-4"), Coordinate{}};
    if (!collide::cast_shape(mesh, moving, pose, down, scratch, hit) || hit.feature != 1)
        return "a box that is cast down does not hit the upper triangle";
    collide::Nearest nearest{};
    pose.position.y = decimal<Coordinate>("0.7");
    if (!collide::nearest_points(mesh, moving, pose, decimal<Coordinate>("3"), scratch, nearest) ||
        nearest.feature_a != 1)
        return "the upper triangle is not the nearest to a box above both";
    return "";
}

/// A rotated box and a rotated capsule, six of each: enough to fill the lanes more than once.
std::string many_have_their_bounds() {
    const Quat turned = from_axis_angle({unit_one, Unit{}, Unit{}}, 0.6_r) *
                        from_axis_angle({Unit{}, Unit{}, unit_one}, 0.4_r);
    collide::RoundBoxes boxes;
    constexpr std::uint32_t count = 12;
    Transform pose[count];
    Geometry shape[count];
    Rotation axes[count];
    collide::Bounds found[count];
    for (std::uint32_t i = 0; i < count; ++i) {
        shape[i] = i % 2 == 0 ? box(20_r, 40_r, 0.7_r) : capsule(0.2_r, 0.8_r);
        pose[i] = {{Real(static_cast<int>(i)), 3_r, 1_r}, turned};
        boxes.rotation[i] = &pose[i].rotation.x.raw;
        boxes.axes[i] = &axes[i].x.x.raw, boxes.bounds[i] = &found[i].lower.x.raw;
        for (int k = 0; k < 3; ++k) {
            boxes.position[k][i] = pose[i].position[k].raw;
            boxes.half[k][i] = shape[i].half_extent[k].raw;
        }
        boxes.margin[i] = collide::bounds_guard + static_cast<std::int64_t>(i) * 4096;
        boxes.radius[i] = shape[i].radius.raw;
    }
    const std::uint32_t left =
        solve::kernels_of(best_simd())->bounds->place(boxes, count, collide::bounds_drop(0));
    for (std::uint32_t i = 0; i < count; ++i) {
        const Length margin = Length::from_raw(static_cast<std::int32_t>(i) * 4096);
        if (left != 0 || axes[i] != to_rotation(turned) ||
            found[i] != collide::bounds_of({shape[i]}, pose[i], margin))
            return "one of many has other bounds than by itself";
    }
    return "";
}

/// Returns whether a sweep lets a body sink from one height to another through a plane, or through a box whose top is
/// at the plane.
bool is_let_through(const shapes::Solid& ground, const shapes::Solid& body, Real from, Real to,
                    collide::Held held) {
    const auto at = [](Real y) { return Transform{{0_r, y, 0_r}, Quat::identity()}; };
    const bool is_box = ground.geometry.kind == ShapeKind::box;
    const Transform place = at(is_box ? -1_r : 0_r);
    const collide::Sweep still{place, place, Transform::identity()},
        way{at(from), at(to), Transform::identity()};
    collide::NarrowScratch scratch;
    return collide::stop_fraction(ground, still, body, way, {}, held, scratch) == unit_one;
}

/// A limb that joints hold passes if its centre ends less deep than its inner radius in a plane, or in a box above its
/// middle. A deeper end is stopped, and so is a limb without joints. The core stops a ball that touches at first and
/// sinks in.
std::string limbs_pass() {
    const shapes::Solid limb{capsule(0.1_r, 0.2_r)}, ball{sphere(0.1_r)}, slab{box(5_r, 1_r, 5_r)},
        board{box(5_r, 0.03_r, 5_r)};
    using enum collide::Held;
    for (const shapes::Solid& ground : {shapes::Solid{plane()}, slab}) {
        if (!is_let_through(ground, limb, 0.4_r, 0.1_r, by_joints))
            return "a limb is held where it first touches";
        if (!is_let_through(ground, limb, 0.4_r, -0.09_r, by_joints)) return "a limb is held by its core";
        if (is_let_through(ground, limb, 0.4_r, -0.11_r, by_joints))
            return "a limb sinks in deeper than its inner radius";
        if (is_let_through(ground, limb, 0.4_r, 0.24_r, not_at_all))
            return "what no joint holds enters by 0.6 of its rounding";
        if (is_let_through(ground, ball, 0.1_r, 0.04_r, not_at_all)) return "the core of a ball enters";
        if (!is_let_through(ground, limb, 0.4_r, 0.26_r, not_at_all))
            return "a capsule that enters by 0.4 of its rounding is held";
    }
    return is_let_through(board, limb, -0.57_r, -1.04_r, by_joints) ? "a limb passes the middle of a box"
                                                                    : "";
}

std::string long_bodies_stop() {
    test::scene::RandomPoint random(16);
    test::LongSweepCounts counts;
    for (int i = 0; i < 4000; ++i)
        if (std::string fault = test::long_sweep_fault(random, counts); !fault.empty()) return fault;
    return counts.stopped > 100 ? "" : "none was stopped";
}

std::string sunken_shapes_come_out() {
    test::scene::RandomPoint random(22);
    for (int i = 0; i < 200; ++i)
        if (std::string fault = test::sunken_fault(random); !fault.empty()) return fault;
    return "";
}

std::string bodies_move_within_bounds() {
    test::scene::RandomPoint random(17);
    for (int i = 0; i < 1000; ++i)
        if (std::string fault = test::relative_motion_fault(random); !fault.empty()) return fault;
    return "";
}

/// A rounded cone of 4 mm, and one 256 times as large: 2^24 times as heavy, to a step of the small one's mass.
std::string small_cones_weigh_as_large_ones() {
    const auto mass = [](std::int64_t times) {
        const auto at = [&](Real size) {
            return to<Real>(Length::from_raw(static_cast<std::int32_t>(to<Length>(size).raw * times)));
        };
        const Geometry geometry = rounded(cone(at(0.004_r), at(0.0055_r)), at(0.0055_r));
        return mass_properties(geometry, Real(100000)).mass.raw;
    };
    const std::int64_t small = mass(1), large = mass(256);
    const std::int64_t off = small * (1 << 24) - large, most = 1 << 24;
    return off <= most && -off <= most ? "" : "a small cone weighs too much or too little";
}

/// A box times 3, and capsules of 135 m as a whole, which cannot be.
std::string scaled_shapes_have_their_size() {
    const Geometry large = scaled(rounded(box(1_r, 2_r, 0.5_r), 0.25_r), 3_r);
    if (!(large == rounded(box(3_r, 6_r, 1.5_r), 0.75_r))) return "a box times 3 is not three times as large";
    return scaled(capsule(30_r, 60_r), 1.5_r).radius == Length(30) ? ""
                                                                   : "a capsule is longer than it may be";
}

/// Returns the height of an asset above y = 0 at a place, by a ray from 9 m; -9: it is not hit.
Real height_at(const std::shared_ptr<const AssetLibrary>& library, AssetId id, Real x) {
    World world = scene::made(World::create(scene::small_def(), {}, library));
    scene::add(world, {.kind = BodyKind::static_}, {.geometry = scene::made(library->geometry(id))});
    const auto hit = world.cast_ray({{x, 9_r, 0.125_r}, {0_r, -18_r, 0_r}});
    return hit ? hit->point.y : -9_r;
}

/// A ramp as a mesh, and a rotated box beside a cone, mirrored along x and y.
std::string mirrored_assets_are_images() {
    const std::vector<Vec3> vertices = {
        {-4_r, 0_r, -4_r}, {-4_r, 0_r, 4_r}, {4_r, 2_r, 4_r}, {4_r, 2_r, -4_r}};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 3}};
    const CompoundPart parts[] = {
        {box(2_r, 0.25_r, 1_r), {{}, from_axis_angle({Unit{}, Unit{}, unit_one}, 0.4_r)}},
        {cone(1_r, 1_r), {{5_r, 0_r, 0_r}, Quat::identity()}}};
    AssetLibrary made;
    const AssetId ramp = made.add(bake_mesh({.vertices = vertices, .triangles = triangles})).value(),
                  pair = made.add(bake_compound(parts)).value();
    const AssetId ramp_in_x = made.add(bake_scaled(made, ramp, {-1_r, 1_r, 1_r})).value(),
                  pair_in_x = made.add(bake_scaled(made, pair, {-1_r, 1_r, 1_r})).value(),
                  pair_in_y = made.add(bake_scaled(made, pair, {1_r, -1_r, 1_r})).value();
    const auto library = std::make_shared<const AssetLibrary>(std::move(made));
    const auto differ = [](Real a, Real b) { return abs(a - b) > 0.0001_r; };
    if (differ(height_at(library, ramp_in_x, -3_r), height_at(library, ramp, 3_r)))
        return "a mirrored ramp is not the image";
    if (differ(height_at(library, pair_in_x, -1_r), height_at(library, pair, 1_r)))
        return "a mirrored box is not the image";
    if (height_at(library, pair_in_y, 5.5_r) < 0.99_r) return "a mirrored cone does not stand on its apex";
    return "";
}

/// A crate of 2 m in two pools and in the wind, and a large one whose size is in its scale.
std::string submerged_parts_are_told() {
    World world = scene::made(World::create(scene::small_def()));
    const auto pool = [](Real surface) {
        return water({.kind = RegionKind::box,
                      .pose = {{0_r, surface - 20_r, 0_r}, Quat::identity()},
                      .half_extent = {90_r, 20_r, 90_r}});
    };
    const BodyId crate = scene::add(world, {}, {.geometry = box(1_r, 1_r, 1_r)});
    const BodyId large = scene::add(world, {.kind = BodyKind::static_},
                                    {.geometry = test::with_scale(box(2_r, 2_r, 2_r), 2_r)});
    const auto is = [&](BodyId body, Real expected) {
        return abs(to<Real>(world.submersion(body).fraction) - expected) < 0.0001_r;
    };
    scene::made(world.create_field(wind({1_r, 0_r, 0_r})));
    if (!is(crate, 0_r)) return "a crate is under wind";
    scene::made(world.create_field(pool(0.5_r)));
    scene::made(world.create_field(pool(-0.5_r)));
    if (!is(crate, 0.75_r)) return "a crate is not in the higher of two pools";
    return is(large, 0.5625_r) ? "" : "a scaled box is submerged by another part";
}

std::string wide_trees_find_all() {
    std::size_t met = 0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed)
        if (std::string found = test::wide_tree_fault(seed, met); !found.empty()) return found;
    return {};
}

std::string first_triangles_are_hit() {
    int hits = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed)
        if (std::string found = test::cast_order_fault(seed, hits); !found.empty()) return found;
    return {};
}

std::string casts_meet_what_is_in_the_way() {
    int hits = 0;
    for (std::uint64_t seed = 1; seed <= 50; ++seed)
        if (std::string found = test::cast_beside_fault(seed, hits); !found.empty()) return found;
    return {};
}

std::string rays_hit_each_triangle() {
    for (std::uint64_t seed = 1; seed <= 50; ++seed)
        if (std::string found = test::ray_order_fault(seed); !found.empty()) return found;
    return {};
}

} // namespace

Checks shape_checks() {
    return {{"a hint does not part from large boxes", hint_of_large_box},
            {"long margins reach", long_margins_reach},
            {"parts are found", parts_are_found},
            {"cubes face each other", cubes_face_each_other},
            {"a face that is kept is the nearest", kept_face_is_nearest},
            {"edges that are kept are the nearest", kept_edges_are_nearest},
            {"what is near a mesh has contacts", mesh_is_found},
            {"queries find triangles", queries_find_triangles},
            {"wide trees find all", wide_trees_find_all},
            {"casts hit the first triangle", first_triangles_are_hit},
            {"casts meet what is in the way", casts_meet_what_is_in_the_way},
            {"rays hit each triangle", rays_hit_each_triangle},
            {"limbs pass where contacts push them out", limbs_pass},
            {"long bodies stop where they meet", long_bodies_stop},
            {"bodies move no further than their bound", bodies_move_within_bounds},
            {"sunken shapes come out at the nearest triangle", sunken_shapes_come_out},
            {"small cones weigh as large ones", small_cones_weigh_as_large_ones},
            {"scaled shapes have their size", scaled_shapes_have_their_size},
            {"mirrored assets are images", mirrored_assets_are_images},
            {"submerged parts are told", submerged_parts_are_told},
            {"what never moves is found", level_is_found},
            {"many boxes have the bounds of each", many_have_their_bounds}};
}

} // namespace planted
