// Contacts of compounds are the merged contacts of their parts, in the right frame. Rays hit a compound where they hit
// its parts.
#include "collide/query/cast.h"
#include "lockstone/math/math.h"
#include "oracle/mesh_scenes.h"
#include "support/effort.h"

#include <cstdio>

using namespace lockstone;
using namespace mesh_scenes;
using oracle::as_double;
using oracle::quat_of;

namespace {

const Length margin = as_fixed<Length>(0.02);

struct Part {
    Geometry geometry;
    D3 at;
    Quat rotation;
};

Owned compound(const std::vector<Part>& parts) {
    std::vector<CompoundPart> list;
    for (const Part& p : parts) list.push_back({p.geometry, {real(p.at), p.rotation}});
    AssetLibrary library;
    const Result<AssetId> id = library.add(bake_compound(list));
    if (!id) FAIL(id.error().message);
    return own(std::move(library), *id);
}

collide::Manifolds contacts(const shapes::Solid& a, const shapes::Solid& b,
                            const collide::RelativePose& pose) {
    collide::NarrowScratch scratch;
    collide::Manifolds m;
    collide::collide(a, b, pose, margin, scratch, m);
    return m;
}

struct Contact {
    D3 normal, at; ///< in A's frame
    double separation;
};
std::vector<Contact> contacts_of(const collide::Manifolds& m, D3 origin) {
    std::vector<Contact> out;
    for (std::uint32_t i = 0; i < m.count; ++i)
        for (std::uint32_t k = 0; k < m.items[i].count; ++k)
            out.push_back({as_double(m.items[i].normal), as_double(m.items[i].points[k].position) + origin,
                           as_double(m.items[i].points[k].separation)});
    return out;
}

D3 turned(Quat q, D3 v) {
    const Rotation r = to_rotation(q);
    return as_double(r.x) * v.x + as_double(r.y) * v.y + as_double(r.z) * v.z;
}

/// Returns whether each contact of `some` is one of `all`, up to rounding.
bool are_among(const std::vector<Contact>& some, const std::vector<Contact>& all, double tolerance) {
    for (const Contact& c : some) {
        bool found = false;
        for (const Contact& d : all)
            found = found || (oracle::norm(c.at - d.at) < tolerance &&
                              std::abs(c.separation - d.separation) < tolerance &&
                              oracle::norm(c.normal - d.normal) < 1e-6);
        if (!found) return false;
    }
    return true;
}
double deepest(const std::vector<Contact>& contacts) {
    double least = 1;
    for (const Contact& c : contacts) least = std::min(least, c.separation);
    return least;
}
bool features_are_unique(const collide::Manifolds& m) {
    std::vector<std::uint32_t> names;
    for (std::uint32_t i = 0; i < m.count; ++i)
        for (std::uint32_t k = 0; k < m.items[i].count; ++k) names.push_back(m.items[i].points[k].feature);
    std::sort(names.begin(), names.end());
    return std::adjacent_find(names.begin(), names.end()) == names.end();
}

const std::vector<Part>& table() {
    static const std::vector<Part> parts{
        {box(1_r, 0.05_r, 0.6_r), {0, 0, 0}, Quat::identity()},
        {cylinder(0.06_r, 0.4_r), {-0.9, -0.45, -0.5}, Quat::identity()},
        {cylinder(0.06_r, 0.4_r), {0.9, -0.45, -0.5}, Quat::identity()},
        {box(0.05_r, 0.4_r, 0.05_r), {-0.9, -0.45, 0.5}, Quat::identity()},
        {capsule(0.05_r, 0.35_r), {0.9, -0.45, 0.5}, Quat::identity()},
        {sphere(0.1_r), {0.3, 0.15, 0.1}, Quat::identity()},
        {box(0.3_r, 0.02_r, 0.02_r), {-0.4, 0.3, 0}, normalized(quat_of({0.3, 0.9, 0.1}, 0.7))},
    };
    return parts;
}

/// The contacts of each part of B with A, computed alone.
std::vector<Contact> part_by_part(const shapes::Solid& a, const std::vector<Part>& parts, D3 at,
                                  Quat rotation) {
    std::vector<Contact> out;
    for (const Part& p : parts) {
        const D3 origin = at + turned(rotation, p.at);
        collide::RelativePose pose = pose_at(origin, rotation * p.rotation);
        const shapes::Solid solid = primitive(p.geometry);
        const bool swapped = a.geometry.kind < p.geometry.kind;
        if (swapped) continue;
        const std::vector<Contact> own = contacts_of(contacts(a, solid, pose), origin);
        out.insert(out.end(), own.begin(), own.end());
    }
    return out;
}

/// Counts the random places where the contacts differ from those of the parts. `shift` plants a fault.
int wrong_places(const shapes::Solid& a, double height, std::uint64_t seed, double shift, int& hits) {
    const Owned b = compound(table());
    oracle::RandomReal random(seed);
    int wrong = 0;
    for (int i = 0; i < 300; ++i) {
        const Quat q =
            random.below(3) == 0 ? quat_of({0, 1, 0}, random.uniform(0, 3)) : random.rotation(0, 3);
        const D3 at{random.uniform(-1, 1), height * random.uniform(0.3, 1), random.uniform(-1, 1)};
        const collide::Manifolds m = contacts(a, b.solid, pose_at(at, q));
        const std::vector<Contact> merged = contacts_of(m, at),
                                   parts = part_by_part(a, table(), at + D3{0, shift, 0}, q);
        hits += m.count > 0;
        bool good = merged.empty() == parts.empty() && features_are_unique(m);
        if (good && !merged.empty()) {
            good = std::abs(deepest(merged) - deepest(parts)) < 1.3e-4; // the noise of the choice of points
            // A mesh gives more points to merge than the parts alone keep.
            for (const Contact& c : a.mesh != nullptr ? std::vector<Contact>{} : merged) {
                bool found = false;
                for (const Contact& d : parts)
                    found = found || (oracle::norm(c.at - d.at) < 2e-6 &&
                                      std::abs(c.separation - d.separation) < 2e-6 &&
                                      oracle::dot(c.normal, d.normal) > 0.998);
                good = good && found;
            }
        }
        wrong += !good;
    }
    return wrong;
}

} // namespace

TEST_CASE("a table of a compound stands on a plane and on a mesh with its four legs") {
    const Owned b = compound(table());
    const Owned ground = mesh(grid(-6, -6, 0.7, 18, 18, 0.2, 3, [](double, double) { return 0.0; }));
    for (const shapes::Solid& floor : {primitive(plane()), ground.solid}) {
        const collide::Manifolds m = contacts(floor, b.solid, pose_at({0, 0.85, 0}, Quat::identity()));
        REQUIRE(m.count == 1);
        CHECK(m.items[0].count == 4);
        double reach = 0;
        for (std::uint32_t k = 0; k < m.items[0].count; ++k) {
            CHECK(std::abs(as_double(m.items[0].points[k].separation)) < 1e-6);
            const D3 p = as_double(m.items[0].points[k].position);
            CHECK(std::abs(p.y + 0.85) < 1e-6);
            reach += std::hypot(p.x, p.z);
        }
        CHECK(reach / 4 > 1.0); // at the legs, all around
        CHECK(features_are_unique(m));
    }
}

TEST_CASE("a compound has the contacts of its parts with planes and meshes") {
    const Owned ground = mesh(grid(-6, -6, 0.7, 18, 18, 0.2, 3, [](double x, double z) {
        return 0.2 * std::sin(2 * x) * std::cos(1.5 * z);
    }));
    int hits = 0;
    CHECK(wrong_places(primitive(plane()), 1, 1, 0, hits) == 0);
    CHECK(wrong_places(ground.solid, 1, 2, 0, hits) == 0);
    CHECK(hits > 200);
    INFO("planted: the parts 3 mm higher");
    CHECK(wrong_places(primitive(plane()), 1, 1, 0.003, hits) > 50);
    CHECK(wrong_places(ground.solid, 1, 2, 0.003, hits) > 50);
}

TEST_CASE("a compound of one box has the contacts of that box") {
    const Quat turn = quat_of({0.2, 0.5, -0.3}, 0.9);
    const Quat part_turn = normalized(turn);
    const D3 place{0.3, -0.2, 0.5};
    const Geometry brick = box(0.4_r, 0.3_r, 0.5_r);
    const Owned single = compound({{brick, place, part_turn}});
    oracle::RandomReal random(21);
    int hits = 0;
    for (int i = 0; i < 500; ++i) {
        const Geometry other = i % 3 == 0   ? sphere(0.3_r)
                               : i % 3 == 1 ? box(0.3_r, 0.2_r, 0.4_r)
                                            : capsule(0.2_r, 0.3_r);
        const Quat q = random.rotation(0, 3);
        const D3 at = place + random.vector(0.2, 1.0);
        // This scene in the frame of the box.
        const D3 seen = turned(conjugate(part_turn), at - place);
        const std::vector<Contact> merged =
            contacts_of(contacts(single.solid, primitive(other), pose_at(at, q)), at);
        std::vector<Contact> own = contacts_of(
            contacts(primitive(brick), primitive(other), pose_at(seen, normalized(conjugate(part_turn) * q))),
            seen);
        for (Contact& c : own) {
            c.normal = turned(part_turn, c.normal);
            c.at = turned(part_turn, c.at) + place;
        }
        hits += !own.empty();
        INFO("pose ", i);
        CHECK(own.empty() == merged.empty());
        if (own.empty() || merged.empty()) continue;
        CHECK(std::abs(deepest(own) - deepest(merged)) < 1e-6);
        if (other.kind != ShapeKind::box) CHECK(are_among(merged, own, 5e-6));
    }
    CHECK(hits > 150);
}

TEST_CASE("two compounds have the contacts of their parts in both orders of the parts' kinds") {
    const Owned a = compound({{sphere(0.3_r), {0.5, 0.1, 0}, Quat::identity()},
                              {box(0.2_r, 0.2_r, 0.2_r), {-0.6, 0, 0}, quat_of({0, 1, 0}, 0.4)}});
    // B's box lies over A's ball, 1 mm deep, and B's ball over A's box, 2 mm apart; B is turned by a quarter.
    const double quarter = 1.5707963267948966;
    const Quat q = quat_of({0, 1, 0}, quarter);
    const Owned b = compound({{box(0.25_r, 0.2_r, 0.25_r), {0, 0, 0.5}, Quat::identity()},
                              {sphere(0.1_r), {0, -0.297, -0.6}, Quat::identity()}});
    // A quarter turn about y moves (0, 0, 0.5) to (0.5, 0, 0).
    const D3 at{0, 0.599, 0};
    const collide::Manifolds m = contacts(a.solid, b.solid, pose_at(at, q));
    const std::vector<Contact> all = contacts_of(m, at);
    REQUIRE(all.size() == 2);
    CHECK(m.count == 1); // both normals point straight up
    CHECK(features_are_unique(m));
    const auto is_at = [&](D3 place, double gap) {
        return std::any_of(all.begin(), all.end(), [&](const Contact& c) {
            return oracle::norm(c.at - place) < 2e-6 && std::abs(c.separation - gap) < 2e-6;
        });
    };
    CHECK(is_at({0.5, 0.3995, 0}, -0.001));
    CHECK(is_at({-0.6, 0.201, 0}, 0.002));
}

TEST_CASE("a ray hits a compound at the first hit among its parts for any number of parts") {
    oracle::RandomReal random(77);
    for (const std::size_t count : {1u, 8u, 9u, 70u, 600u}) {
        std::vector<Part> parts;
        std::vector<Owned> single;
        for (std::size_t i = 0; i < count; ++i) {
            const Geometry shapes[] = {sphere(0.3_r), box(0.4_r, 0.1_r, 0.2_r), capsule(0.2_r, 0.3_r),
                                       cone(0.3_r, 0.4_r)};
            parts.push_back({shapes[i % 4], random.vector(0, 4), random.rotation(0, 3)});
            single.push_back(compound({parts.back()}));
        }
        const Owned all = compound(parts);
        collide::NarrowScratch scratch;
        int hits = 0, differ = 0, differ_planted = 0;
        const int rays = test::is_long_run() ? 20'000 : 400;
        for (int i = 0; i < rays; ++i) {
            // Half of the rays pass the part's silhouette, near the end of its bounds.
            const D3 from = random.vector(0, 8);
            const D3 at =
                parts[static_cast<std::size_t>(i) % count].at + random.vector(0, i % 2 == 0 ? 0.2 : 0.7);
            const CoordinateVec3 start = to<Coordinate>(real(from)),
                                 way = to<Coordinate>(real((at - from) * 2));
            collide::CastHit hit{}, first{};
            const bool found = collide::cast_ray(all.solid, start, way, scratch, hit);
            bool any = false;
            for (std::size_t k = 0; k < count; ++k) {
                collide::CastHit one{};
                if (!collide::cast_ray(single[k].solid, start, way, scratch, one)) continue;
                one.feature = static_cast<std::uint32_t>(k);
                if (!any || one.distance < first.distance) first = one;
                any = true;
            }
            const auto same = [&](const collide::CastHit& h) {
                return found == any && (!found || (h.distance == first.distance && h.point == first.point &&
                                                   h.normal == first.normal && h.feature == first.feature));
            };
            hits += found, differ += !same(hit);
            hit.feature ^= 1; // planted: the next part
            differ_planted += !same(hit);
        }
        CAPTURE(count);
        CHECK(differ == 0);
        CHECK(hits > rays / 10);
        CHECK(differ_planted == hits);
    }
}
