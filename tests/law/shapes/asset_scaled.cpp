// bake_scaled(): the copy of an asset is the image of the original under x -> (fx x, fy y, fz z).
#include "shapes/asset/asset.h"
#include "support/random.h"
#include "support/sim_shapes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double length_step = 0x1p-24;

D3 image(D3 p, Vec3 factor) {
    const D3 f = to_double(factor);
    return {p[0] * f[0], p[1] * f[1], p[2] * f[2]};
}
double product(Vec3 factor) {
    return std::abs(to_double(factor.x) * to_double(factor.y) * to_double(factor.z));
}

AssetBytes random_hull(RandomPoint& random) {
    const D3 size{random(0.3, 2), random(0.3, 2), random(0.3, 2)}, aside = random.point(1, -1, 1);
    std::vector<LengthVec3> points;
    for (int i = 0; i < 16; ++i) {
        const D3 d = random.direction();
        points.push_back(to<Length>(
            vec3({aside[0] + size[0] * d[0], aside[1] + size[1] * d[1], aside[2] + size[2] * d[2]})));
    }
    return made(bake_hull(points));
}

/// The surface of a random hull, each triangle with its own material.
AssetBytes random_mesh(RandomPoint& random) {
    AssetLibrary library;
    const AssetId hull = made(library.add(random_hull(random)));
    const TriangleSoup soup = triangulate(made(library.geometry(hull)), library);
    std::vector<std::uint16_t> materials;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i)
        materials.push_back(static_cast<std::uint16_t>(i + 1));
    const MaterialSurface belt{.material = 2, .friction = 0.5_r, .surface_velocity = {1_r, 2_r, 3_r}};
    return made(bake_mesh({.vertices = soup.vertices,
                           .triangles = soup.triangles,
                           .materials = materials,
                           .surfaces = std::span(&belt, 1)}));
}

/// A rotation by quarter turns.
Quat quarter_turns(RandomPoint& random) {
    const auto quarter = [&](UnitVec3 axis) { return turned(axis, 90 * std::floor(random(0, 4))); };
    return normalized(quarter(axis_x) * quarter(axis_y) * quarter(axis_z));
}

/// Parts of every kind with any rotations, or those that any factors can scale. Adds its hulls to the library.
AssetBytes random_compound(RandomPoint& random, AssetLibrary& library, bool any_part) {
    std::vector<CompoundPart> parts;
    const auto size = [&] { return real(random(0.1, 1)); };
    for (int i = 0; i < 6; ++i) {
        const bool is_hull = i % 3 == 2;
        const Transform local{vec3(random.point(3, -3, 3)),
                              is_hull || any_part ? random.rotation() : quarter_turns(random)};
        const Geometry any[] = {capsule(size(), size()), cone(size(), size()),     {},
                                sphere(size()),          cylinder(size(), size()), {}};
        Geometry g = any_part ? any[i] : box(size(), size(), size());
        if (is_hull) g = made(library.geometry(made(library.add(random_hull(random)))));
        if (any_part && i % 3 != 0) g = rounded(g, real(random(0, 0.1)));
        parts.push_back({g, local});
    }
    return made(bake_compound(parts));
}

/// Volume and centre.
struct Measured {
    double volume = 0;
    D3 center{};
};
Measured measure(const std::shared_ptr<const AssetLibrary>& library, AssetId id) {
    Measured m;
    const Geometry geometry = made(library->geometry(id));
    if (geometry.kind != ShapeKind::mesh) {
        shapes::SolidCache cache(library);
        const MassProperties mass = shapes::mass_properties(made(cache.resolve(geometry)), Real(1000));
        return {to_double(mass.mass) / 1000, to_double(mass.center)};
    }
    const TriangleSoup soup = triangulate(geometry, *library);
    for (const auto& t : soup.triangles) {
        const D3 a = to_double(soup.vertices[t[0]]), b = to_double(soup.vertices[t[1]]),
                 c = to_double(soup.vertices[t[2]]);
        const D3 n{b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]};
        const double volume = dot(a, n) / 6;
        m.volume += volume;
        m.center = m.center + (volume / 4) * (a + b + c);
    }
    return {m.volume, (1 / m.volume) * m.center};
}

/// Returns what is wrong with the volume and centre of a copy, or an empty string. Rounding moves each point of the
/// surface of the copy by at most sqrt(3) / 2 steps of a Length, so it changes the volume by at most the area times
/// this, and the centre by at most this times area * width / volume. Area and width are at most those of the box
/// around each of the parts, which overlap. A rotated part adds 4e-9 of its reach: the accuracy of its axes.
std::string fault_of_mass(const std::shared_ptr<const AssetLibrary>& library, AssetId original, AssetId copy,
                          Vec3 factor) {
    const Measured from = measure(library, original), to = measure(library, copy);
    shapes::SolidCache cache(library);
    const shapes::Solid solid = made(cache.resolve(made(library->geometry(copy))));
    const auto width_of = [](const shapes::Extent& e) {
        return to_double(lockstone::to<Real>(e.upper - e.lower));
    };
    const auto area_of = [](D3 w) { return 2 * (w[0] * w[1] + w[1] * w[2] + w[2] * w[0]); };
    const D3 width = width_of(shapes::extent_of(solid));
    double area = area_of(width);
    if (solid.compound != nullptr) {
        area = 0;
        for (const shapes::Compound::Part& part : solid.compound->parts)
            area += area_of(width_of(part.extent));
    }
    const double reach = to_double(lockstone::to<Real>(shapes::reach_of(solid)));
    const double move = length_step + 4e-9 * reach, off = area * move;
    const double expected = product(factor) * from.volume;
    if (std::abs(to.volume - expected) > off + 1e-9 * expected) return "volume";
    if (length(to.center - image(from.center, factor)) > off * length(width) / expected + move)
        return "centre";
    return {};
}

World world_with(const std::shared_ptr<const AssetLibrary>& library, AssetId id) {
    World w = made(World::create(small_def(), {}, library));
    add(w, {.kind = BodyKind::static_}, {.geometry = made(library->geometry(id))});
    return w;
}

struct Shots {
    int hits = 0, misses = 0, differences = 0, wrong = 0;
};
/// Casts rays at the original, and their images at the copy. A point of a surface is right to 2e-6 m along its
/// normal; rays that pass an edge may hit one of the two only.
Shots shoot(const std::shared_ptr<const AssetLibrary>& library, AssetId original, AssetId copy, Vec3 factor,
            RandomPoint& random, Vec3 believed) {
    const World from = world_with(library, original), to = world_with(library, copy);
    Shots shots;
    for (int i = 0; i < 200; ++i) {
        const D3 start = 9 * random.direction(), end = random.point(2.5, -2.5, 2.5) - start;
        const auto one = from.cast_ray({vec3(start), vec3(2 * end)});
        const auto other = to.cast_ray({vec3(image(start, believed)), vec3(image(2 * end, believed))});
        if (one.has_value() != other.has_value()) {
            ++shots.differences;
            continue;
        }
        if (!one) {
            ++shots.misses;
            continue;
        }
        ++shots.hits;
        const D3 way = (1 / length(image(end, factor))) * image(end, factor);
        const double slope = std::abs(dot(to_double(other->normal), way));
        const double off = length(to_double(other->point) - image(to_double(one->point), factor));
        const bool is_same = one->part == other->part && one->feature == other->feature;
        if (slope > 0.05 && (off > 2e-6 / slope || !is_same)) ++shots.wrong;
    }
    return shots;
}

Vec3 random_factor(RandomPoint& random, bool is_uniform) {
    Vec3 f{};
    const double all = random(0.5, 3);
    for (int i = 0; i < 3; ++i)
        f[i] = real((is_uniform ? all : random(0.5, 3)) * (random(0, 1) < 0.5 ? -1 : 1));
    return f;
}

/// An asset, in a library that also has its copy.
struct Pair {
    std::shared_ptr<const AssetLibrary> library;
    AssetId original, copy;
};
constexpr int asset_styles = 4; ///< hull, mesh, compound for uniform factors, compound for any
Pair random_pair(RandomPoint& random, int style, Vec3 factor) {
    AssetLibrary library;
    const AssetBytes bytes = style == 0   ? random_hull(random)
                             : style == 1 ? random_mesh(random)
                                          : random_compound(random, library, style == 2);
    const AssetId original = made(library.add(bytes));
    const AssetId copy = made(library.add(bake_scaled(library, original, factor)));
    return {std::make_shared<const AssetLibrary>(std::move(library)), original, copy};
}

} // namespace

TEST_CASE("a scaled or mirrored asset has the volume and the centre of the original times the factors") {
    RandomPoint random(5);
    const int tries = samples(160, 4000);
    int planted = 0;
    for (int i = 0; i < tries; ++i) {
        const int style = i % asset_styles;
        const Vec3 factor = random_factor(random, style == 2);
        const Pair pair = random_pair(random, style, factor);
        INFO("style ", style, " times ", to_string(factor));
        CHECK(fault_of_mass(pair.library, pair.original, pair.copy, factor) == "");
        const Vec3 wrong{-factor.x, factor.y, factor.z};
        planted += fault_of_mass(pair.library, pair.original, pair.copy, wrong) == "centre" ? 1 : 0;
    }
    CHECK(planted == tries);
}

TEST_CASE("a ray hits a scaled or mirrored asset at the image of the point where it hits the original") {
    RandomPoint random(6);
    int hits = 0, differences = 0, planted = 0;
    for (int i = 0; i < samples(40, 1000); ++i) {
        const int style = i % asset_styles;
        const Vec3 factor = random_factor(random, style == 2);
        const Pair pair = random_pair(random, style, factor);
        INFO("style ", style, " times ", to_string(factor));
        const Shots shots = shoot(pair.library, pair.original, pair.copy, factor, random, factor);
        CHECK(shots.wrong == 0);
        hits += shots.hits, differences += shots.differences;
        const Vec3 wrong{factor.x, -factor.y, factor.z};
        const Shots other = shoot(pair.library, pair.original, pair.copy, wrong, random, wrong);
        planted += other.wrong + other.differences;
    }
    CHECK(hits > 1000);
    CHECK(differences <= hits / 1000);
    CHECK(planted > hits / 2);
}

TEST_CASE("an asset that is mirrored twice is the original again") {
    RandomPoint random(7);
    for (int i = 0; i < samples(80, 2000); ++i) {
        const int style = i % asset_styles;
        Vec3 factor = random_factor(random, true);
        for (int k = 0; k < 3; ++k) factor[k] = factor[k] < Real{} ? Real(-1) : Real(1);
        AssetLibrary library;
        const AssetBytes bytes = style == 0   ? random_hull(random)
                                 : style == 1 ? random_mesh(random)
                                              : random_compound(random, library, style == 2);
        const AssetId id = made(library.add(bytes));
        const AssetId once = made(library.add(bake_scaled(library, id, factor)));
        const AssetId twice = made(library.add(bake_scaled(library, once, factor)));
        INFO("style ", style, " times ", to_string(factor));
        CHECK((once == id) == (factor == Vec3{1_r, 1_r, 1_r}));
        if (style < 2) {
            CHECK(twice == id);
            continue;
        }
        const auto& parts = library.find(id)->compound->parts;
        const auto& again = library.find(twice)->compound->parts;
        REQUIRE(parts.size() == again.size());
        for (std::size_t k = 0; k < parts.size(); ++k) {
            CHECK(parts[k].solid.geometry == again[k].solid.geometry);
            CHECK(parts[k].local.position == again[k].local.position);
            CHECK(to_rotation(parts[k].local.rotation) == to_rotation(again[k].local.rotation));
        }
    }
}

TEST_CASE("a scaled mesh keeps its order and mirrors the surface velocities of its materials") {
    RandomPoint random(8);
    AssetLibrary library;
    const AssetId id = made(library.add(random_mesh(random)));
    const AssetId copy = made(library.add(bake_scaled(library, id, {-2_r, 1_r, 1_r})));
    const Geometry from = made(library.geometry(id)), to = made(library.geometry(copy));
    const TriangleSoup a = triangulate(from, library), b = triangulate(to, library);
    REQUIRE(a.triangles.size() == b.triangles.size());
    for (std::size_t i = 0; i < a.triangles.size(); ++i)
        for (const std::uint32_t v : a.triangles[i]) {
            const Vec3 p{-2_r * a.vertices[v].x, a.vertices[v].y, a.vertices[v].z};
            CHECK(std::ranges::any_of(b.triangles[i], [&](std::uint32_t k) { return b.vertices[k] == p; }));
        }
    // The belt of the material 2 runs to the other side along x.
    const AssetId twice = made(library.add(bake_scaled(library, copy, {-0.5_r, 1_r, 1_r})));
    CHECK(twice == id);
    const AssetId turned_belt = made(library.add(bake_scaled(library, id, {1_r, 1_r, 1_r})));
    CHECK(turned_belt == id);
    CHECK(library.bytes(copy).size() == library.bytes(id).size());
}

TEST_CASE("a scaled height field has its samples at the scaled places and no mirror image") {
    AssetLibrary library;
    const AssetId id = made(library.add(wave_bytes(9)));
    const AssetId copy = made(library.add(bake_scaled(library, id, {2.5_r, 0.5_r, 2.5_r})));
    const TriangleSoup a = triangulate(made(library.geometry(id)), library),
                       b = triangulate(made(library.geometry(copy)), library);
    REQUIRE(a.vertices.size() == b.vertices.size());
    CHECK(a.triangles == b.triangles);
    for (std::size_t i = 0; i < a.vertices.size(); ++i) {
        const D3 off = to_double(b.vertices[i]) - image(to_double(a.vertices[i]), {2.5_r, 0.5_r, 2.5_r});
        CHECK(length(off) <= length_step / 2);
    }
    const auto why = [&](Vec3 factor) { return bake_scaled(library, id, factor).error().message; };
    CHECK(
        why({-1_r, 1_r, 1_r}).find("a height_field, times (-1, 1, 1): a height field has no mirror image") !=
        std::string::npos);
    CHECK(why({1_r, -1_r, 1_r}).find("no mirror image") != std::string::npos);
    CHECK(why({1_r, 1_r, 2_r}).find("factor.x is 1 and factor.z is 2") != std::string::npos);
    CHECK(why({1_r, 1000_r, 1_r}).find("height 1 is not in") != std::string::npos);
}

TEST_CASE("a copy that has no exact form is an error that names the asset and the factor and the part") {
    AssetLibrary library;
    const Quat askew = turned(axis_z, 30), quarter = turned(axis_z, 90);
    const auto why = [&](const Geometry& g, Quat rotation, Vec3 factor) {
        const CompoundPart parts[] = {{box(1_r, 1_r, 1_r), {}}, {g, {{1_r, 0_r, 0_r}, rotation}}};
        const AssetId id = made(library.add(bake_compound(parts)));
        const Result<AssetBytes> copy = bake_scaled(library, id, factor);
        return copy ? "" : copy.error().message;
    };
    const Vec3 wide{2_r, 1_r, 1_r}, tall{1_r, -2_r, 1_r};
    const auto says = [&](const std::string& text, const char* part) {
        INFO(text);
        CHECK(text.starts_with("asset 0x"));
        CHECK(text.find(part) != std::string::npos);
    };
    says(why(box(1_r, 2_r, 1_r), askew, wide), ", a compound, times (2, 1, 1): part 1: it is a rotated box");
    CHECK(why(box(1_r, 2_r, 1_r), quarter, wide) == "");
    CHECK(why(box(1_r, 2_r, 1_r), askew, {-2_r, 2_r, -2_r}) == "");
    says(why(sphere(1_r), quarter, wide), "part 1: it is a sphere, the absolute factors must be equal");
    says(why(capsule(1_r, 1_r), quarter, tall), "part 1: it is a capsule");
    says(why(cylinder(1_r, 1_r), Quat::identity(), wide), "across its axis are 2 and 1, they must be equal");
    CHECK(why(cylinder(1_r, 1_r), Quat::identity(), tall) == "");
    CHECK(why(cylinder(1_r, 1_r), quarter, wide) == "");
    says(why(rounded(box(1_r, 1_r, 1_r), 0.25_r), quarter, wide), "part 1: it is a box rounded by 0.25 m");
    says(why(box(1_r, 0.5_r, 1_r), askew, {0.004_r, 0.004_r, -0.004_r}), "part 1: box");
    says(why(sphere(0.1_r), askew, {120_r, 120_r, 120_r}), "part 0: box");
    const AssetId hull = made(library.add(gem_bytes()));
    const Geometry gem = made(library.geometry(hull));
    CHECK(why(gem, askew, wide) == "");
    CHECK(why(rounded(gem, 0.25_r), askew, {-2_r, 2_r, 2_r}) == "");
    says(why(rounded(gem, 0.25_r), askew, wide), "part 1: it is a hull rounded by 0.25 m");
    says(why(gem, askew, {0.003_r, 1_r, 1_r}), "part 1: its hull 0x");
    const std::string flat = bake_scaled(library, hull, {0.002_r, 1_r, 1_r}).error().message;
    says(flat, ", a hull, times (");
    says(bake_scaled(library, hull, {1_r, 0_r, 1_r}).error().message, "factor.y is 0, its absolute value");
    says(bake_scaled(library, hull, {1_r, 1_r, -1001_r}).error().message, "factor.z is -1001");
}

TEST_CASE("a compound with its copied hulls goes to another library as one set") {
    AssetLibrary library;
    const Geometry gem = made(library.geometry(made(library.add(gem_bytes()))));
    const CompoundPart parts[] = {{gem, at(1, 0, 0)}, {gem, at(-1, 0, 0, turned(axis_y, 40))}};
    const AssetId pair = made(library.add(bake_compound(parts)));
    const auto count = [&](Vec3 factor) {
        AssetLibrary other;
        made(other.add(bake_scaled(library, pair, factor)));
        return other.ids().size();
    };
    CHECK(count({-1_r, 1_r, 1_r}) == 2); // one hull, and the compound
    CHECK(count({1_r, 2_r, 1_r}) == 3);  // two rotations, two hulls
}
