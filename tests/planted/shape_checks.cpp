// Shapes: what of them is near, and their manifolds.
#include "checks.h"
#include "collide/narrow_phase.h"

namespace planted {

namespace {

/// A ball in a box that reaches 1074 m along its diagonal, asked for with that diagonal as what parted them.
std::string hint_of_large_box() {
    const shapes::Solid ball{sphere(1_r)}, cliff{scaled(box(77.5_r, 77.5_r, 77.5_r), 8_r)};
    const Coordinate along = decimal<Coordinate>("57.735");
    const Unit third = decimal<Unit>("0.577350269");
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    collide::collide(cliff, ball, {Rotation::identity(), {along, along, along}}, Length{},
                     {{third, third, third}, {}, 0}, scratch, found);
    return found.count == 1 ? "" : "a ball 100 m from its centre is outside";
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

/// Two cubes that overlap by 1 cm along x and by 2 cm along y, and touched along y in the last tick.
std::string kept_face_is_nearest() {
    std::vector<LengthVec3> corners;
    for (int i = 0; i < 8; ++i) {
        const auto side = [&](int axis) {
            return decimal<Length>("0.5") * Length((i >> axis & 1) != 0 ? 1 : -1);
        };
        corners.push_back({side(0), side(1), side(2)});
    }
    AssetLibrary library;
    const AssetId id = library.add(bake_hull(corners)).value();
    const shapes::Solid cube{library.geometry(id).value(), library.find(id)->hull.get()};
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

} // namespace

Checks shape_checks() {
    return {{"a hint does not part from large boxes", hint_of_large_box},
            {"parts are found", parts_are_found},
            {"a face that is kept is the nearest", kept_face_is_nearest}};
}

} // namespace planted
