#include "law/zoo/floor.h"

#include "law/zoo/draw.h"

#include <vector>

namespace lockstone::zoo {

namespace {

struct FloorAssets {
    AssetBytes mesh, sheet, field, hull;
    AssetId mesh_id{}, sheet_id{}, field_id{}, hull_id{};
};

FloorAssets baked_floors() {
    FloorAssets floors;
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    constexpr std::uint32_t cells = 16;
    for (std::uint32_t j = 0; j <= cells; ++j)
        for (std::uint32_t i = 0; i <= cells; ++i) vertices.push_back(vec(10.0 * i - 80, 0, 10.0 * j - 80));
    for (std::uint32_t j = 0; j < cells; ++j)
        for (std::uint32_t i = 0; i < cells; ++i) {
            const std::uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
            triangles.push_back({a, c, b}), triangles.push_back({b, c, d});
        }
    floors.mesh = bake_mesh({.vertices = vertices, .triangles = triangles}).value();
    floors.sheet = bake_mesh({.vertices = vertices, .triangles = triangles, .two_sided = true}).value();
    const std::vector<Length> heights(33 * 33);
    floors.field =
        bake_height_field({.columns = 33, .rows = 33, .spacing = Length(5), .heights = heights}).value();
    std::vector<LengthVec3> corners;
    for (const double y : {-4.0, 0.0})
        for (int k = 0; k < 12; ++k)
            corners.push_back(length_vec({80 * std::cos(pi * k / 6), y, 80 * std::sin(pi * k / 6)}));
    floors.hull = bake_hull(corners).value();
    AssetLibrary library;
    floors.mesh_id = library.add(floors.mesh).value(), floors.sheet_id = library.add(floors.sheet).value();
    floors.field_id = library.add(floors.field).value(), floors.hull_id = library.add(floors.hull).value();
    return floors;
}

const FloorAssets& floor_assets() {
    static const FloorAssets floors = baked_floors();
    return floors;
}

} // namespace

const char* name_of(Floor floor) {
    constexpr const char* names[all_floor_count] = {"plane", "box",          "seam", "parts", "hull",
                                                    "mesh",  "height field", "slab", "sheet"};
    return names[static_cast<int>(floor)];
}

std::shared_ptr<AssetLibrary> floor_library() {
    auto library = std::make_shared<AssetLibrary>();
    for (const AssetBytes* bytes :
         {&floor_assets().mesh, &floor_assets().sheet, &floor_assets().field, &floor_assets().hull})
        (void)library->add(*bytes).value();
    return library;
}

void add_floor(World& w, Floor floor, Vec3 offset) {
    const auto add = [&](Geometry geometry, Vec3 at) {
        const BodyId body =
            w.create_body({.kind = BodyKind::static_, .pose = {at + offset, Quat::identity()}}).value();
        (void)w.create_shape(body, {.geometry = geometry}).value();
        return body;
    };
    switch (floor) {
    case Floor::plane:
        add(plane(), {});
        break;
    case Floor::box:
        add(box(Real(80), Real(2), Real(80)), {Real{}, Real(-2), Real{}});
        break;
    case Floor::seam: // two boxes side by side
        add(box(Real(40), Real(2), Real(80)), {Real(-40), Real(-2), Real{}});
        add(box(Real(40), Real(2), Real(80)), {Real(40), Real(-2), Real{}});
        break;
    case Floor::parts: { // two shapes of one body
        const BodyId body = add(box(Real(30), Real(2), Real(80)), {Real(-30), Real(-2), Real{}});
        (void)w
            .create_shape(body, {.geometry = box(Real(30), Real(2), Real(80)),
                                 .local = {{Real(60), Real{}, Real{}}, Quat::identity()}})
            .value();
        break;
    }
    case Floor::hull:
        add(instance(ShapeKind::hull, floor_assets().hull_id), {});
        break;
    case Floor::mesh:
        add(instance(ShapeKind::mesh, floor_assets().mesh_id), {});
        break;
    case Floor::height_field:
        add(instance(ShapeKind::height_field, floor_assets().field_id), {Real(-80), Real{}, Real(-80)});
        break;
    case Floor::slab:
        add(box(Real(80), real(0.01), Real(80)), {Real{}, real(-0.01), Real{}});
        break;
    case Floor::sheet:
        add(instance(ShapeKind::mesh, floor_assets().sheet_id), {});
        break;
    }
}

} // namespace lockstone::zoo
