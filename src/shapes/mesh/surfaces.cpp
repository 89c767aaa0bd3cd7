#include "shapes/mesh/surfaces.h"

#include "base/text.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

#include <algorithm>

namespace lockstone::shapes {
namespace {

using base::join;

bool is_in(Real x, Real low, Real high) { return x >= low && x <= high; }

std::uint32_t number_of(std::span<const MaterialSurface> surfaces, std::uint32_t material) {
    const auto at = std::ranges::lower_bound(surfaces, material, {}, &MaterialSurface::material);
    if (at == surfaces.end() || at->material != material) return 0;
    return static_cast<std::uint32_t>(at - surfaces.begin()) + 1;
}

Piece made_of(std::uint32_t source, std::uint32_t material, std::span<const MaterialSurface> surfaces) {
    const std::uint32_t number = number_of(surfaces, material);
    return {source, material, number == 0 ? nullptr : &surfaces[number - 1]};
}

} // namespace

Piece piece_of(const Solid& solid, std::uint32_t index) {
    if (solid.mesh != nullptr && index < solid.mesh->triangle_count())
        return made_of(solid.mesh->source_of(index), solid.mesh->material_of(index), solid.mesh->surfaces());
    if (solid.height_field != nullptr && index < solid.height_field->triangle_count())
        return made_of(index / 2, solid.height_field->material_of(index), solid.height_field->surfaces());
    if (solid.compound != nullptr && index < solid.compound->parts.size()) return {index, 0, nullptr};
    return {0, 0, nullptr};
}

std::uint32_t surface_number(const Solid& solid, std::uint32_t triangle) {
    if (solid.mesh != nullptr && !solid.mesh->surfaces().empty())
        return number_of(solid.mesh->surfaces(), solid.mesh->material_of(triangle));
    if (solid.height_field != nullptr && !solid.height_field->surfaces().empty())
        return number_of(solid.height_field->surfaces(), solid.height_field->material_of(triangle));
    return 0;
}

std::string complaint_of_surfaces(std::span<const MaterialSurface> surfaces) {
    if (surfaces.size() > material_surfaces_max)
        return join(surfaces.size(), " surfaces, there may be ", material_surfaces_max);
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const MaterialSurface& s = surfaces[i];
        if (s.material > 65535 || (i > 0 && s.material <= surfaces[i - 1].material))
            return join("surface ", i, " is of material ", s.material,
                        ", they must be in ascending order of materials, at most 65535");
        if (!is_in(s.friction, Real{}, Real(4)) || !is_in(s.restitution, Real{}, Real(1)) ||
            !is_in(s.rolling_resistance, Real{}, Real(1)))
            return join("surface ", i,
                        ": friction must be 0 to 4, restitution 0 to 1, rolling_resistance 0 to 1 m");
        for (int k = 0; k < 3; ++k)
            if (!is_in(s.surface_velocity[k], Real(-100), Real(100)))
                return join("surface ", i, ": surface_velocity must be within 100 m/s on each axis");
    }
    return {};
}

void write_surfaces(base::ByteWriter& out, std::span<const MaterialSurface> surfaces) {
    out.u32(static_cast<std::uint32_t>(surfaces.size()));
    for (const MaterialSurface& s : surfaces) {
        out.u32(s.material);
        for (const Real x : {s.friction, s.restitution, s.rolling_resistance, s.surface_velocity.x,
                             s.surface_velocity.y, s.surface_velocity.z})
            out.u64(static_cast<std::uint64_t>(x.raw));
    }
}

std::vector<MaterialSurface> read_surfaces(base::ByteReader& in) {
    const std::size_t start = in.offset();
    const std::uint32_t count = in.u32("surface count");
    if (in.ok() && (count == 0 || count > material_surfaces_max))
        in.fail_at(start,
                   join(count, " surfaces, there must be 1 .. ", material_surfaces_max, " or no list"));
    std::vector<MaterialSurface> surfaces;
    for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
        MaterialSurface s{};
        s.material = in.u32("material");
        for (Real* x : {&s.friction, &s.restitution, &s.rolling_resistance, &s.surface_velocity.x,
                        &s.surface_velocity.y, &s.surface_velocity.z})
            x->raw = static_cast<std::int64_t>(in.u64("surface"));
        surfaces.push_back(s);
    }
    if (std::string why = complaint_of_surfaces(surfaces); in.ok() && !why.empty()) in.fail_at(start, why);
    return surfaces;
}

} // namespace lockstone::shapes
