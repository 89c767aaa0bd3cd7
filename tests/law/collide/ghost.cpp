// The seams of a flat surface stop no shape: contacts of shapes that are swept over flat meshes and height fields have
// the face's normal and one separation, at all edges and corners of the triangles.
#include "support/effort.h"

#include "collide/convex/convex.h"
#include "collide/pairs/pairs.h"
#include "oracle/mesh_scenes.h"

#include <cstdio>

using namespace lockstone;
using namespace mesh_scenes;

namespace {

const Length margin = as_fixed<Length>(0.02);

/// A shape that rests on the floor with its origin at `height`.
struct Slider {
    const char* name;
    Geometry geometry;
    double height, size;
    Quat rotation; ///< before the turn about y
};

std::vector<Slider> sliders() {
    const Quat upright = Quat::identity(), lying = oracle::quat_of({0, 0, 1}, 1.5707963267948966);
    return {{"ball", sphere(0.5_r), 0.5, 0.5, upright},
            {"marble", sphere(0.02_r), 0.02, 0.02, upright},
            {"box", box(0.5_r, 0.25_r, 0.4_r), 0.25, 0.6, upright},
            {"brick", box(0.1_r, 0.03_r, 0.05_r), 0.03, 0.1, upright},
            {"rounded box", rounded(box(0.3_r, 0.2_r, 0.3_r), 0.05_r), 0.25, 0.5, upright},
            {"standing capsule", capsule(0.3_r, 0.5_r), 0.8, 0.3, upright},
            {"lying capsule", capsule(0.3_r, 0.5_r), 0.3, 0.8, lying},
            {"cylinder", cylinder(0.4_r, 0.5_r), 0.5, 0.4, upright},
            {"cone", cone(0.4_r, 0.5_r), 0.5, 0.4, upright}};
}

struct Trouble {
    int places = 0, without_point = 0, wrong_normal = 0, wrong_separation = 0;
    double normal_most = 0, separation_most = 0;

    bool any() const { return without_point + wrong_normal + wrong_separation > 0; }
    friend std::string describe(const Trouble& t) {
        std::ostringstream out;
        out << t.places << " places: " << t.without_point << " without a point, " << t.wrong_normal
            << " with a wrong normal (by up to " << t.normal_most << "), " << t.wrong_separation
            << " with a wrong separation (by up to " << t.separation_most << " m)";
        return out.str();
    }
};

using Collide = void (*)(const shapes::Solid&, const shapes::Solid&, const collide::RelativePose&, Length,
                         collide::NarrowScratch&, collide::Manifolds&);

/// Sweeps from -reach to reach [m] in each of 16 directions through `middle`, at `gap` above the floors, which together
/// are flat at y = 0.
Trouble sweep(std::span<const Owned* const> floors, const Slider& slider, D3 middle, double gap, double step,
              double tolerance, Collide collide_one, double reach = 50) {
    Trouble t;
    collide::NarrowScratch scratch;
    const shapes::Solid b = primitive(slider.geometry);
    for (int direction = 0; direction < 16; ++direction) {
        const double angle = direction * 0.39269908169872414;
        const Quat turn = oracle::quat_of({0, 1, 0}, 0.37 * direction);
        for (double s = -reach; s <= reach; s += step) {
            const D3 at{middle.x + s * std::cos(angle), slider.height + gap, middle.z + s * std::sin(angle)};
            ++t.places;
            std::uint32_t points = 0;
            double normal = 0, separation = 0;
            for (const Owned* floor : floors) {
                collide::Manifolds m;
                collide_one(floor->solid, b, pose_at(at, turn * slider.rotation), margin, scratch, m);
                for (std::uint32_t i = 0; i < m.count; ++i) {
                    normal =
                        std::max(normal, oracle::norm(oracle::as_double(m.items[i].normal) - D3{0, 1, 0}));
                    for (std::uint32_t k = 0; k < m.items[i].count; ++k, ++points)
                        separation = std::max(
                            separation, std::abs(oracle::as_double(m.items[i].points[k].separation) - gap));
                }
            }
            t.without_point += points == 0;
            t.wrong_normal += normal > tolerance;
            t.wrong_separation += separation > tolerance;
            t.normal_most = std::max(t.normal_most, normal);
            t.separation_most = std::max(t.separation_most, separation);
        }
    }
    return t;
}

double step_length() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 0.0317 : 0.4317; }

constexpr double gaps[] = {-0.003, -0.0002, 0, 0.001};

void check_floors(std::span<const Owned* const> floors, const char* name, D3 middle) {
    for (const Slider& slider : sliders())
        for (const double gap : gaps) {
            const Trouble t = sweep(floors, slider, middle, gap, step_length(), 1e-6, collide::collide);
            INFO(std::string(name), ", ", std::string(slider.name), " at ", gap, ": ", describe(t));
            CHECK(!t.any());
        }
}

double flat(double, double) { return 0; }

/// Collides with every triangle alone, without the neighbours.
void collide_naively(const shapes::Solid& a, const shapes::Solid& b, const collide::RelativePose& pose,
                     Length reach, collide::NarrowScratch& scratch, collide::Manifolds& out) {
    const Coordinate far(2);
    const CoordinateVec3 all{far, far, far};
    scratch.triangles.clear();
    shapes::find_triangles(a, {pose.position - all, pose.position + all}, scratch.triangles);
    out.count = 0;
    for (const std::uint32_t index : scratch.triangles) {
        const shapes::Triangle t = shapes::triangle_at(a, index);
        const collide::Convex triangle = collide::convex_of_triangle(
            {collide::raw(t.corner[0] - pose.position), collide::raw(t.corner[1] - pose.position),
             collide::raw(t.corner[2] - pose.position)});
        collide::Manifold m{};
        collide::collide_convex(triangle, collide::convex_of(b, pose.rotation, CoordinateVec3{}), reach, m);
        if (m.count > 0 && out.count < collide::Manifolds::max) out.items[out.count++] = m;
    }
}

} // namespace

TEST_CASE("the seams of flat meshes change no normal and no separation of a shape that passes over them" *
          doctest::skip(test::is_too_long_here())) {
    const Owned regular = mesh(grid(-60, -60, 2, 60, 60, 0, 0, flat));
    const Owned irregular = mesh(grid(-60, -60, 1.5, 80, 80, 0.2, 7, flat));
    const Owned two = mesh(grid(-60, -60, 120, 1, 1, 0, 0, flat));
    const Owned* const floors[] = {&regular, &irregular, &two};
    check_floors({floors, 1}, "a regular mesh", {0.1, 0, 0.05});
    check_floors({floors + 1, 1}, "an irregular mesh", {0.1, 0, 0.05});
    check_floors({floors + 2, 1}, "two triangles", {0.1, 0, 0.05});
}

TEST_CASE("the seam between two meshes changes no normal and no separation of a shape that passes over it" *
          doctest::skip(lockstone::test::is_small_sample())) {
    const Owned left = mesh(grid(-60, -60, 3, 20, 40, 0.2, 3, flat)),
                right = mesh(grid(0, -60, 2, 30, 60, 0.2, 4, flat));
    const Owned* const floors[] = {&left, &right};
    check_floors(floors, "two meshes", {0.1, 0, 0.05});
}

TEST_CASE("the corners of a seam between two meshes change no normal and no separation even in fine steps" *
          doctest::skip(test::is_too_long_here())) {
    const Owned left = mesh(grid(-60, -60, 3, 20, 40, 0.2, 3, flat)),
                right = mesh(grid(0, -60, 2, 30, 60, 0.2, 4, flat));
    const Owned* const floors[] = {&left, &right};
    for (const Slider& slider : sliders())
        for (const double gap : gaps)
            // Near corners of the right mesh, of both, and of the left one.
            for (const double z : {-2.003, 0.001, 2.0, 3.0}) {
                const Trouble t = sweep(floors, slider, {0.0004, 0, z}, gap, slider.size / 37, 1e-6,
                                        collide::collide, slider.size * 1.5);
                INFO(std::string(slider.name), " at ", gap, " near ", z, ": ", describe(t));
                CHECK(!t.any());
            }
}

TEST_CASE(
    "the seams of flat height fields change no normal and no separation of a shape that passes over them" *
    doctest::skip(lockstone::test::is_small_sample())) {
    const Owned field = height_field(121, 121, 1, [](auto, auto) { return 0.0; });
    const Owned* const floors[] = {&field};
    check_floors(floors, "a height field", {60.1, 0, 60.05});
}

TEST_CASE("planted fault: the sweep reports wrong normals if each triangle collides without its neighbours") {
    const Owned irregular = mesh(grid(-60, -60, 1.5, 80, 80, 0.2, 7, flat));
    const Owned* const floors[] = {&irregular};
    for (const Slider& slider : sliders()) {
        INFO(std::string(slider.name));
        CHECK(sweep(floors, slider, {0.1, 0, 0.05}, -0.0002, 0.9, 1e-6, collide_naively).wrong_normal > 0);
    }
}

TEST_CASE("planted fault: the sweep reports a bump of a millimetre") {
    const Owned bumpy = mesh(grid(-60, -60, 1.5, 80, 80, 0.2, 7, [](double x, double z) {
        return std::abs(x - 15) < 0.8 && std::abs(z) < 60 ? 0.001 : 0.0;
    }));
    const Owned* const floors[] = {&bumpy};
    for (const Slider& slider : sliders()) {
        INFO(std::string(slider.name));
        CHECK(sweep(floors, slider, {0.1, 0, 0.05}, -0.0002, 0.4317, 1e-6, collide::collide).any());
    }
}
