// Reads and writes the bytes of a hull, which are its corners only.
#include "shapes/asset/asset_file.h"
#include "shapes/hull/hull.h"

namespace lockstone {
namespace shapes {

void write_hull(base::ByteWriter& out, std::span<const LengthVec3> corners) {
    out.u32(static_cast<std::uint32_t>(corners.size()));
    for (const LengthVec3& v : corners)
        for (int i = 0; i < 3; ++i) out.i32(v[i].raw);
}

std::unique_ptr<const Hull> read_hull(base::ByteReader& in) {
    const std::size_t start = in.offset();
    const std::uint32_t count = in.u32("corner count");
    if (in.ok() && (count < 4 || count > hull_vertices_max))
        in.fail_at(start, base::join("a hull of ", count, " corners, it must have 4 .. ", hull_vertices_max));
    std::vector<LengthVec3> corners;
    for (std::uint32_t i = 0; in.ok() && i < count; ++i) {
        const std::int32_t x = in.i32("corner x"), y = in.i32("corner y"), z = in.i32("corner z");
        corners.push_back({Length::from_raw(x), Length::from_raw(y), Length::from_raw(z)});
    }
    if (!in.ok()) return nullptr;
    Result<Hull> hull = make_hull(corners);
    if (!hull) {
        in.fail_at(start, hull.error().message);
        return nullptr;
    }
    for (std::size_t i = 0; i < corners.size(); ++i)
        if (i >= hull->vertices.size() || !(corners[i] == hull->vertices[i])) {
            in.fail_at(start + 4 + 12 * i,
                       base::join("point ", i, " is not a corner of the hull, or out of order"));
            return nullptr;
        }
    return std::make_unique<const Hull>(std::move(*hull));
}

} // namespace shapes

Result<AssetBytes> bake_hull(std::span<const LengthVec3> points) {
    Result<shapes::Hull> hull = shapes::make_hull(points);
    if (!hull) return hull.error();
    shapes::AssetWriter writer(ShapeKind::hull, 0);
    shapes::write_hull(writer.out(), hull->vertices);
    return std::move(writer).finish();
}

} // namespace lockstone
