// The asset library and the objects made from its assets: ids, solids, masses, drawings.
#include "fuzz/asset_samples.h"
#include "lockstone/math/math.h"
#include "oracle/double_shapes.h"
#include "support/about.h"
#include "support/effort.h"
#include "support/rigs/scale_field.h"

#include <doctest/doctest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <tuple>

using namespace lockstone;
using namespace lockstone::shapes;
using oracle::D3;

namespace {

LengthVec3 factors(double x, double y, double z) {
    return {oracle::as_fixed<Length>(x), oracle::as_fixed<Length>(y), oracle::as_fixed<Length>(z)};
}

/// Every sample, in one library.
std::shared_ptr<AssetLibrary> library_of_samples() {
    auto library = std::make_shared<AssetLibrary>(fuzz::library_with_hull());
    for (const fuzz::Sample& s : fuzz::samples())
        REQUIRE(library->add(std::span<const std::byte>(s.bytes)).ok());
    return library;
}
AssetId id_of_kind(const AssetLibrary& library, ShapeKind kind) {
    for (AssetId id : library.ids())
        if (library.find(id)->kind == kind) return id;
    FAIL("no such asset");
    return {};
}

struct Measured {
    double volume = 0;
    D3 center{0, 0, 0};
    double second[3] = {0, 0, 0}; // of x^2, y^2, z^2 about the centre, by volume
    std::size_t open_edges = 0;
};

/// Measures by the divergence theorem in double precision. Edges are matched by position.
Measured measure(const TriangleSoup& soup) {
    Measured m;
    std::map<std::array<std::int64_t, 3>, int> names;
    std::map<std::pair<int, int>, int> edges;
    const auto name = [&](Vec3 p) { // to 2^-12 m
        return names
            .emplace(std::array{(p.x.raw + (1 << 19)) >> 20, (p.y.raw + (1 << 19)) >> 20,
                                (p.z.raw + (1 << 19)) >> 20},
                     static_cast<int>(names.size()))
            .first->second;
    };
    for (const auto& t : soup.triangles) {
        const D3 p[3] = {oracle::as_double(soup.vertices[t[0]]), oracle::as_double(soup.vertices[t[1]]),
                         oracle::as_double(soup.vertices[t[2]])};
        const double d = dot(p[0], cross(p[1], p[2]));
        const D3 s = p[0] + p[1] + p[2];
        m.volume += d / 6;
        m.center = m.center + s * (d / 24);
        for (int k = 0; k < 3; ++k)
            m.second[k] +=
                d / 120 * (s[k] * s[k] + p[0][k] * p[0][k] + p[1][k] * p[1][k] + p[2][k] * p[2][k]);
        const int v[3] = {name(soup.vertices[t[0]]), name(soup.vertices[t[1]]), name(soup.vertices[t[2]])};
        for (int k = 0; k < 3; ++k)
            if (v[k] != v[(k + 1) % 3])
                v[k] < v[(k + 1) % 3] ? ++edges[{v[k], v[(k + 1) % 3]}] : --edges[{v[(k + 1) % 3], v[k]}];
    }
    m.center = m.center * (1 / m.volume);
    for (int k = 0; k < 3; ++k) m.second[k] = m.second[k] / m.volume - m.center[k] * m.center[k];
    for (const auto& [edge, count] : edges) m.open_edges += count != 0 ? 1 : 0;
    return m;
}

/// Returns an error sentence unless the mass properties at density 1 agree with those of the drawing, to a relative
/// error.
std::string compare(const MassProperties& m, const Measured& e, double relative) {
    const double size = std::sqrt(e.second[0] + e.second[1] + e.second[2]);
    if (std::abs(oracle::as_double(m.mass) - e.volume) > relative * e.volume) return "volume";
    if (norm(oracle::as_double(m.center) - e.center) > relative * size) return "centre";
    const double k[3] = {oracle::as_double(m.gyration_squared.x.x), oracle::as_double(m.gyration_squared.y.y),
                         oracle::as_double(m.gyration_squared.z.z)};
    for (int i = 0; i < 3; ++i) {
        const double expected = e.second[(i + 1) % 3] + e.second[(i + 2) % 3];
        if (std::abs(k[i] - expected) > relative * expected) return "gyration";
    }
    return {};
}

const Geometry primitives[] = {sphere(0.7_r),
                               capsule(0.3_r, 0.8_r),
                               capsule(0.5_r, 0_r),
                               cylinder(0.6_r, 0.4_r),
                               cylinder(0.1_r, 2_r),
                               cone(0.6_r, 0.9_r),
                               cone(2_r, 0.3_r),
                               box(0.2_r, 0.5_r, 0.9_r),
                               rounded(box(0.2_r, 0.5_r, 0.9_r), 0.1_r),
                               rounded(box(0.1_r, 0.1_r, 0.1_r), 1_r),
                               rounded(cylinder(0.6_r, 0.4_r), 0.15_r),
                               rounded(cylinder(0.1_r, 0.4_r), 1_r),
                               rounded(cone(0.6_r, 0.9_r), 0.1_r),
                               rounded(cone(0.2_r, 0.9_r), 0.7_r),
                               rounded(cone(2_r, 0.1_r), 0.3_r)};

} // namespace

TEST_CASE("the library derives an asset's id from its bytes and stores an equal asset only once") {
    AssetLibrary library;
    const AssetBytes bytes = fuzz::sample_hull(true);
    const AssetId id = library.add(std::span<const std::byte>(bytes)).value();
    CHECK(static_cast<bool>(id));
    CHECK(library.add(std::span<const std::byte>(bytes)).value() == id);
    CHECK(library.ids() == std::vector<AssetId>{id});
    CHECK(std::ranges::equal(library.bytes(id), bytes));
    CHECK(library.contains(id));
    CHECK_FALSE(library.contains({id.value + 1}));
    CHECK(library.bytes({id.value + 1}).empty());
    CHECK(library.find({id.value + 1}) == nullptr);
    CHECK_FALSE(library.geometry({id.value + 1}).ok());
    CHECK(library.geometry(id).value() == instance(ShapeKind::hull, id));
    const AssetLibrary moved = std::move(library);
    CHECK(moved.find(id)->hull->vertices.size() == 8);
    CHECK(moved.find(id)->hull->faces.size() == 6);
}

TEST_CASE("the library adds each asset of a set but adds none if the last asset of the set is invalid") {
    const AssetBytes hull = fuzz::sample_hull(true), other = fuzz::sample_hull(false);
    const CompoundPart parts[] = {{instance(ShapeKind::hull, shapes::id_of(hull)), Transform::identity()},
                                  {instance(ShapeKind::hull, shapes::id_of(other)), Transform::identity()}};
    const AssetBytes compound = bake_compound(parts).value();
    const AssetBytes in_order[] = {hull, other, compound}, reversed[] = {compound, hull, other};
    AssetLibrary library;
    CHECK(library.add(encode_assets(in_order)).value() == shapes::id_of(compound));
    CHECK(library.ids().size() == 3);
    CHECK(library.add(encode_assets(in_order)).value() == shapes::id_of(compound));
    CHECK(library.ids().size() == 3);
    CHECK(encode_assets({}).empty());
    CHECK(encode_assets(std::span(in_order, 1)) == hull);

    AssetLibrary none;
    CHECK_FALSE(none.add(encode_assets(reversed)).ok());
    AssetBytes damaged = encode_assets(in_order);
    damaged.back() ^= std::byte{1};
    const Result<AssetId> refused = none.add(damaged);
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().message.find("asset set: asset 2 of 3: asset: checksum is") != std::string::npos);
    CHECK(none.ids().empty());
    // An asset that was in the library before a refused set remains.
    REQUIRE(none.add(other).ok());
    CHECK_FALSE(none.add(damaged).ok());
    CHECK(none.ids() == std::vector<AssetId>{shapes::id_of(other)});
    // A set inside a set is no asset, and no bytes may follow the last asset.
    const AssetBytes nested[] = {hull, encode_assets(in_order)};
    CHECK_FALSE(none.add(encode_assets(nested)).ok());
    AssetBytes longer = encode_assets(in_order);
    longer.push_back({});
    CHECK_FALSE(none.add(longer).ok());
    CHECK(none.ids().size() == 1);
}

TEST_CASE("a baked asset that is loaded and baked again has the same bytes") {
    const auto library = library_of_samples();
    for (AssetId id : library->ids()) CHECK(rebuilt(*library->find(id)) == library->find(id)->bytes);
    std::set<AssetId> ids;
    for (const fuzz::Sample& s : fuzz::samples()) ids.insert(shapes::id_of(s.bytes));
    CHECK(ids.size() == fuzz::samples().size());
}

TEST_CASE("the asset format has not changed: the samples have their stored ids") {
    const std::map<std::string, std::uint64_t> expected = {
        {"hull cube", 0xc035e7a9679def7bu},    {"hull of five", 0x6d989a80f55c4e44u},
        {"mesh", 0x8a0210d54510191fu},         {"large mesh", 0x68032c86130df444u},
        {"height field", 0x001bebc10aa41a74u}, {"height field with holes", 0x827f370713b07a11u},
        {"compound", 0x79e6b53c8189d8fdu}};
    for (const fuzz::Sample& s : fuzz::samples())
        CHECK_MESSAGE(shapes::id_of(s.bytes).value == expected.at(s.name), s.name);
    const fuzz::Sample cube = fuzz::samples()[0], mesh = fuzz::samples()[2]; // planted
    CHECK(shapes::id_of(cube.bytes).value != expected.at(mesh.name));
}

TEST_CASE("SolidCache resolves a shape to its asset at its scale or returns an error that names the asset") {
    const auto library = library_of_samples();
    SolidCache cache(library);
    const AssetId hull = shapes::id_of(fuzz::sample_hull(true)),
                  mesh = shapes::id_of(fuzz::sample_mesh(false));
    const auto message = [&](const Geometry& g) {
        const Result<Solid> solid = cache.resolve(g);
        return solid ? std::string() : solid.error().message;
    };
    CHECK(message(instance(ShapeKind::hull, hull)) == "");
    CHECK(message(instance(ShapeKind::hull, {77})) == "asset 0x4d is not in the library");
    CHECK(message(instance(ShapeKind::hull, mesh)).ends_with(" is a mesh, the shape's kind is hull"));
    CHECK(message(instance(ShapeKind::hull, {})) == "hull names no asset");
    CHECK(
        message(instance(ShapeKind::hull, hull, factors(1, 0.001, 1))).starts_with("hull scale.y is 0.001"));
    CHECK(message(instance(ShapeKind::hull, hull, factors(1, 1, 0.0079)))
              .ends_with("it must be at least 5000 um") == false);
    CHECK(message(instance(ShapeKind::hull, hull, factors(1, 100, 1))) == "");
    CHECK(message(rounded(instance(ShapeKind::hull, hull, factors(99, 99, 99)), 2_r))
              .ends_with("from its origin, it may reach 100 m"));
    CHECK(message(instance(ShapeKind::mesh, shapes::id_of(fuzz::sample_mesh(true)), factors(3, 1, 1)))
              .ends_with("it may reach 8000 m"));

    const Solid plain = cache.resolve(instance(ShapeKind::hull, hull)).value();
    CHECK(plain.hull == library->find(hull)->hull.get());
    const Geometry twice = instance(ShapeKind::hull, hull, factors(2, 3, 4));
    const Solid scaled = cache.resolve(twice).value();
    CHECK(cache.resolve(twice).value().hull == scaled.hull);
    for (const LengthVec3& v : plain.hull->vertices) {
        const LengthVec3 expected{v.x * 2, v.y * 3, v.z * 4};
        CHECK(std::ranges::find(scaled.hull->vertices, expected) != scaled.hull->vertices.end());
    }
    CHECK(oracle::as_double(mass_properties(scaled, 1_r).mass) ==
          test::about(24 * oracle::as_double(mass_properties(plain, 1_r).mass)));
    CHECK(extent_of(scaled).upper.z == extent_of(plain).upper.z * 4);
}

TEST_CASE("the drawing of each primitive is closed and has the mass of its shape" *
          doctest::skip(lockstone::test::is_small_sample())) {
    const AssetLibrary library;
    SolidCache cache(nullptr);
    for (const Geometry& g : primitives)
        for (const int factor : {1, 4}) {
            const Geometry shape = test::with_scale(g, Real(factor));
            const Measured drawn = measure(triangulate(shape, library, 40));
            const MassProperties m = mass_properties(shape, 1_r);
            INFO(std::string(name_of(g.kind)), " rounded by ", oracle::as_double(g.radius));
            CHECK(drawn.open_edges == 0);
            CHECK(compare(m, drawn, 2e-3) == "");
            MassProperties wrong = m; // planted
            wrong.gyration_squared.y.y =
                wrong.gyration_squared.y.y + shift_right(wrong.gyration_squared.y.y, 7);
            CHECK(compare(wrong, drawn, 2e-3) == "gyration");
            const Solid solid = cache.resolve(shape).value();
            const Extent extent = extent_of(solid);
            for (const Vec3& v : triangulate(shape, library, 10).vertices)
                for (int k = 0; k < 3; ++k) {
                    CHECK(to<Coordinate>(v[k]) <= extent.upper[k] + Coordinate::step() * 8);
                    CHECK(to<Coordinate>(v[k]) >= extent.lower[k] - Coordinate::step() * 8);
                }
        }
}

TEST_CASE(
    "a shape with a rounding radius of one step has the closed-form mass and gyration of the sharp shape") {
    for (const Geometry& g : {box(0.2_r, 0.5_r, 0.9_r), cylinder(0.6_r, 0.4_r), cone(0.6_r, 0.9_r)}) {
        Geometry hair = g;
        hair.radius = Length::step();
        const MassProperties sharp = mass_properties(g, 1_r), round = mass_properties(hair, 1_r);
        CHECK(oracle::as_double(round.mass) == test::about(oracle::as_double(sharp.mass), 1e-6));
        CHECK(oracle::as_double(round.center.y) == test::about(oracle::as_double(sharp.center.y), 1e-6));
        for (int k = 0; k < 3; ++k)
            CHECK(oracle::as_double(k == 1 ? round.gyration_squared.y.y : round.gyration_squared.x.x) ==
                  test::about(
                      oracle::as_double(k == 1 ? sharp.gyration_squared.y.y : sharp.gyration_squared.x.x),
                      1e-6));
    }
}

TEST_CASE("a rounded hull of a box has the mass of the rounded box and a gyration within 2 % of it") {
    const auto library = std::make_shared<AssetLibrary>();
    std::vector<LengthVec3> points;
    for (int i = 0; i < 8; ++i)
        points.push_back(factors(i & 1 ? 0.2 : -0.2, i & 2 ? 0.5 : -0.5, i & 4 ? 0.9 : -0.9));
    const AssetId id = library->add(bake_hull(points)).value();
    SolidCache cache(library);
    for (const double r : {0.0, 0.02, 0.1, 1.0}) {
        const Solid solid =
            cache.resolve(rounded(instance(ShapeKind::hull, id), oracle::as_fixed<Real>(r))).value();
        const MassProperties hull = mass_properties(solid, 10_r);
        const MassProperties exact =
            mass_properties(rounded(box(0.2_r, 0.5_r, 0.9_r), oracle::as_fixed<Real>(r)), 10_r);
        CHECK(oracle::as_double(hull.mass) == test::about(oracle::as_double(exact.mass), 1e-8));
        CHECK(oracle::as_double(hull.gyration_squared.x.x) ==
              test::about(oracle::as_double(exact.gyration_squared.x.x),
                          0.02)); // 26 corners approximate a ball
        CHECK(measure(triangulate(solid.geometry, *library)).open_edges == 0);
        CHECK(oracle::as_double(inner_radius(solid)) == test::about(0.2 + r, 1e-6));
    }
}

TEST_CASE(
    "triangulate() draws meshes and height fields by their triangles and draws hulls and compounds closed") {
    const auto library = library_of_samples();
    const auto drawn = [&](ShapeKind kind) {
        return triangulate(library->geometry(id_of_kind(*library, kind)).value(), *library);
    };
    CHECK(drawn(ShapeKind::mesh).triangles.size() == 4);
    CHECK(drawn(ShapeKind::compound).triangles.size() > 100);
    CHECK(measure(drawn(ShapeKind::compound)).open_edges == 0);
    CHECK(measure(drawn(ShapeKind::hull)).open_edges == 0);
    const Geometry field = library->geometry(shapes::id_of(fuzz::sample_height_field(true))).value();
    CHECK(triangulate(field, *library).triangles.size() == 8);
    CHECK(triangulate(instance(ShapeKind::mesh, {5}), *library).triangles.empty());
    CHECK(triangulate(plane(), *library).triangles.empty());
}

TEST_CASE("a compound has the mass of its parts and its tree finds each part") {
    oracle::RandomReal random(23);
    std::vector<CompoundPart> parts;
    std::vector<MassPart> masses;
    for (int i = 0; i < 300; ++i) {
        const auto place = [&] { return oracle::as_fixed<Real>(random.uniform(-40, 40)); };
        const Geometry g = i % 2 == 0 ? rounded(box(0.3_r, 0.5_r, 1_r), 0.1_r) : cone(0.5_r, 1_r);
        const Real x = place(), y = place(), z = place();
        parts.push_back({g, {{x, y, z}, random.rotation(0, 3)}});
        masses.push_back({mass_properties(g, 3_r), parts.back().local});
    }
    auto library = std::make_shared<AssetLibrary>();
    const AssetId id = library->add(bake_compound(parts)).value();
    SolidCache cache(library);
    const Solid solid = cache.resolve(library->geometry(id).value()).value();
    const MassProperties m = mass_properties(solid, 3_r), expected = combine(masses);
    CHECK(m.mass == expected.mass);
    CHECK(m.center == expected.center);
    CHECK(oracle::as_double(inner_radius(solid)) == test::about(0.4, 1e-6));
    const Compound& compound = *solid.compound;
    for (std::size_t i = 0; i < parts.size(); ++i) { // every drawn point is within the part's extent
        for (const Vec3& v : triangulate(parts[i].geometry, *library, 3).vertices) {
            const CoordinateVec3 p = to<Coordinate>(parts[i].local * v);
            CHECK(overlap(compound.parts[i].extent, {p, p}));
        }
    }
    for (int i = 0; i < 500; ++i) {
        const auto corner = [&] { return oracle::as_fixed<Coordinate>(random.uniform(-42, 42)); };
        const CoordinateVec3 p{corner(), corner(), corner()}, q{corner(), corner(), corner()};
        const Extent box{min(p, q), max(p, q)};
        std::vector<std::uint32_t> found, all;
        compound.find(box, found);
        for (std::uint32_t k = 0; k < compound.parts.size(); ++k)
            if (overlap(compound.parts[k].extent, box)) all.push_back(k);
        REQUIRE(found == all);
        if (!all.empty()) { // planted
            all.pop_back();
            CHECK(found != all);
        }
    }
}

TEST_CASE("load_assets() adds the assets of a file and names the file in an error") {
    const std::filesystem::path folder = std::filesystem::temp_directory_path();
    const std::string path = (folder / "lockstone_load_assets.lsa").string();
    const auto write = [&](const AssetBytes& bytes) {
        std::ofstream file(path, std::ios::binary);
        for (const std::byte b : bytes) file.put(static_cast<char>(b));
    };
    AssetLibrary source, library;
    const AssetId hull = source.add(fuzz::sample_hull(true)).value();
    const CompoundPart part{source.geometry(hull).value(), {}};
    AssetBytes set = encode_assets({{fuzz::sample_hull(true), bake_compound(std::span(&part, 1)).value()}});
    write(set);
    const AssetId loaded = load_assets(path, library).value();
    CHECK(library.find(loaded)->kind == ShapeKind::compound);
    CHECK(library.contains(hull));
    set.back() = ~set.back();
    write(set);
    AssetLibrary empty;
    CHECK(load_assets(path, empty).error().message.starts_with(path + ": asset set: asset 1 of 2"));
    CHECK(empty.ids().empty());
    std::filesystem::remove(path);
    CHECK(load_assets(path, empty).error().message.starts_with(path + ": cannot read: "));
    CHECK(load_assets(folder.string(), empty).error().message.find("is a directory") != std::string::npos);
}
