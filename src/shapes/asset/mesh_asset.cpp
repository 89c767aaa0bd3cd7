// Reads and writes the bytes of a mesh, and orders its triangles.
#include "shapes/asset/asset_file.h"
#include "shapes/mesh/mesh.h"
#include "shapes/mesh/surfaces.h"
#include "shapes/mesh/triangle.h"

#include <algorithm>
#include <bit>

namespace lockstone {
namespace shapes {
namespace {

using base::join;
using TriangleIndices = std::array<std::uint32_t, 3>;

constexpr std::uint32_t mesh_two_sided = 1, mesh_materials = 2, mesh_sources = 4, mesh_surfaces = 8;
constexpr std::size_t vertex_size = 16, triangle_size = 12, material_size = 2, source_size = 4;
constexpr Coordinate reach_max = Coordinate(8000);
constexpr std::uint32_t not_numbered = 0xffffffffu;

/// Orders triangles so that each group of 8, 64, 512 ... lies close together: splits in halves along the widest
/// axis.
class SpaceOrder {
  public:
    explicit SpaceOrder(const std::vector<std::array<CoordinateVec3, 3>>& corners) {
        items.reserve(corners.size());
        for (std::uint32_t i = 0; i < corners.size(); ++i) {
            const auto& c = corners[i];
            const CoordinateVec3 low = min(c[0], min(c[1], c[2])), high = max(c[0], max(c[1], c[2]));
            items.push_back({{low.x.raw + high.x.raw, low.y.raw + high.y.raw, low.z.raw + high.z.raw}, i});
        }
        std::size_t size = 1;
        while (size < items.size()) size *= 8;
        split(0, items.size(), size);
    }
    std::vector<std::uint32_t> result() const {
        std::vector<std::uint32_t> out;
        out.reserve(items.size());
        for (const Item& item : items) out.push_back(item.index);
        return out;
    }

  private:
    struct Item {
        std::int64_t middle[3]; // twice the centre of the bounds
        std::uint32_t index;
    };
    /// Splits at multiples of `size` triangles (a power of 8), so that they fill whole nodes; the last may be
    /// smaller.
    void split(std::size_t first, std::size_t last, std::size_t size) {
        while (size > 1 && last - first <= size) size /= 8;
        if (size <= 1 && last - first <= 8) {
            std::sort(at(first), at(last), [](const Item& a, const Item& b) { return a.index < b.index; });
            return;
        }
        const std::size_t pieces = (last - first + size - 1) / size;
        const std::size_t middle = first + (pieces + 1) / 2 * size;
        const int axis = widest(first, last);
        std::nth_element(at(first), at(middle), at(last), [axis](const Item& a, const Item& b) {
            return a.middle[axis] != b.middle[axis] ? a.middle[axis] < b.middle[axis] : a.index < b.index;
        });
        split(first, middle, size);
        split(middle, last, size);
    }
    std::vector<Item>::iterator at(std::size_t i) { return items.begin() + static_cast<std::ptrdiff_t>(i); }
    int widest(std::size_t first, std::size_t last) const {
        std::int64_t low[3], high[3];
        for (int k = 0; k < 3; ++k) low[k] = high[k] = items[first].middle[k];
        for (std::size_t i = first; i < last; ++i)
            for (int k = 0; k < 3; ++k) {
                low[k] = std::min(low[k], items[i].middle[k]);
                high[k] = std::max(high[k], items[i].middle[k]);
            }
        int axis = 0;
        for (int k = 1; k < 3; ++k)
            if (high[k] - low[k] > high[axis] - low[axis]) axis = k;
        return axis;
    }

    std::vector<Item> items;
};

/// Vertices rounded to 24 fraction bits, and for each input vertex the first equal one.
struct Welded {
    std::vector<CoordinateVec3> places;
    std::vector<std::uint32_t> first_equal;
};
Welded weld(std::span<const Vec3> vertices) {
    Welded out;
    std::vector<std::uint32_t> order;
    for (std::uint32_t i = 0; i < vertices.size(); ++i) {
        out.places.push_back(to<Coordinate>(vertices[i]));
        order.push_back(i);
    }
    const auto before = [&](std::uint32_t a, std::uint32_t b) {
        for (int k = 0; k < 3; ++k)
            if (out.places[a][k] != out.places[b][k]) return out.places[a][k] < out.places[b][k];
        return a < b;
    };
    std::ranges::sort(order, before);
    out.first_equal.resize(vertices.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        const bool again = i > 0 && out.places[order[i]] == out.places[order[i - 1]];
        out.first_equal[order[i]] = again ? out.first_equal[order[i - 1]] : order[i];
    }
    return out;
}

std::string complaint(const MeshDef& def) {
    if (def.triangles.size() > mesh_triangles_max)
        return join("mesh has ", def.triangles.size(), " triangles, it may have ", mesh_triangles_max);
    if (!def.materials.empty() && def.materials.size() != def.triangles.size())
        return join("mesh has ", def.materials.size(), " materials for ", def.triangles.size(), " triangles");
    if (def.flat_sine < Unit{} || def.flat_sine > unit_one) return "mesh flat_sine must be in 0 .. 1";
    if (std::string why = complaint_of_surfaces(def.surfaces); !why.empty()) return "mesh: " + why;
    for (std::size_t i = 0; i < def.vertices.size(); ++i) {
        const CoordinateVec3 p = abs(to<Coordinate>(def.vertices[i]));
        if (max(p.x, max(p.y, p.z)) > reach_max)
            return join("mesh vertex ", i, " is further than 8000 m from the origin");
    }
    for (std::size_t i = 0; i < def.triangles.size(); ++i)
        for (std::uint32_t v : def.triangles[i])
            if (v >= def.vertices.size())
                return join("mesh triangle ", i, " names vertex ", v, ", there are ", def.vertices.size());
    return {};
}

/// `own_sources`: see bake_mesh_in_order(), which keeps the order; null: the index of each triangle is its source,
/// and the triangles are ordered in space.
MeshContent ordered(const MeshDef& def, const std::uint32_t* own_sources) {
    const Welded welded = weld(def.vertices);
    std::vector<TriangleIndices> kept;
    std::vector<std::array<CoordinateVec3, 3>> corners;
    std::vector<std::uint16_t> materials;
    std::vector<std::uint32_t> sources, order;
    for (std::uint32_t i = 0; i < def.triangles.size(); ++i) {
        TriangleIndices t = def.triangles[i];
        for (std::uint32_t& v : t) v = welded.first_equal[v];
        const CoordinateVec3 c[3] = {welded.places[t[0]], welded.places[t[1]], welded.places[t[2]]};
        if (!has_area(c)) continue;
        kept.push_back(t);
        corners.push_back({c[0], c[1], c[2]});
        materials.push_back(def.materials.empty() ? std::uint16_t{0} : def.materials[i]);
        order.push_back(static_cast<std::uint32_t>(sources.size()));
        sources.push_back(own_sources != nullptr ? own_sources[i] : i);
    }
    if (own_sources == nullptr) order = SpaceOrder(corners).result();
    MeshContent content;
    content.two_sided = def.two_sided;
    content.flat_sine = def.flat_sine;
    content.surfaces.assign(def.surfaces.begin(), def.surfaces.end());
    bool is_moved = false;
    const bool any_material = std::ranges::any_of(materials, [](std::uint16_t m) { return m != 0; });
    std::vector<std::uint32_t> name(def.vertices.size(), not_numbered);
    for (std::uint32_t i : order) {
        TriangleIndices t = kept[i];
        for (std::uint32_t& v : t) {
            if (name[v] == not_numbered) {
                name[v] = static_cast<std::uint32_t>(content.vertices.size());
                content.vertices.push_back(mesh_vertex(welded.places[v]));
            }
            v = name[v];
        }
        is_moved |= sources[i] != content.triangles.size();
        content.triangles.push_back(t);
        content.sources.push_back(sources[i]);
        if (any_material) content.materials.push_back(materials[i]);
    }
    if (!is_moved) content.sources.clear();
    return content;
}

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
    return base::load_little_endian<std::uint32_t>(bytes.data() + at);
}

void read_vertices(base::ByteReader& in, std::uint32_t count, MeshContent& content) {
    const std::size_t start = in.offset();
    const auto bytes = in.bytes(std::uint64_t{count} * vertex_size, "vertices");
    content.vertices.reserve(bytes.size() / vertex_size);
    for (std::size_t at = 0; in.ok() && at < bytes.size(); at += vertex_size) {
        MeshVertex v{};
        std::uint32_t above = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            v.local[k] = u32_at(bytes, at + 4 * k);
            v.cell[k] = static_cast<std::int8_t>(bytes[at + 12 + k]);
            above |= v.local[k];
        }
        const CoordinateVec3 p = abs(position_of(v));
        if (above >> 31 != 0 || bytes[at + 15] != std::byte{0} || max(p.x, max(p.y, p.z)) > reach_max)
            in.fail_at(start + at, join("vertex ", at / vertex_size, " is out of range"));
        content.vertices.push_back(v);
    }
}

/// Checks that vertices appear in order, so that equal meshes have equal bytes and no vertex is unused.
void read_triangles(base::ByteReader& in, std::uint32_t count, MeshContent& content) {
    const std::size_t start = in.offset();
    const auto bytes = in.bytes(std::uint64_t{count} * triangle_size, "triangles");
    content.triangles.reserve(bytes.size() / triangle_size);
    std::uint32_t fresh = 0;
    for (std::size_t at = 0; in.ok() && at < bytes.size(); at += triangle_size) {
        const TriangleIndices t{u32_at(bytes, at), u32_at(bytes, at + 4), u32_at(bytes, at + 8)};
        for (std::uint32_t v : t) {
            if (v > fresh || v >= content.vertices.size())
                in.fail_at(start + at,
                           join("triangle ", at / triangle_size, " names vertex ", v,
                                ", the next new one is ", fresh, " of ", content.vertices.size()));
            if (v == fresh) ++fresh;
        }
        if (!in.ok()) return;
        if (!has_area({position_of(content.vertices[t[0]]), position_of(content.vertices[t[1]]),
                       position_of(content.vertices[t[2]])}))
            in.fail_at(start + at, join("triangle ", at / triangle_size, " has no area"));
        content.triangles.push_back(t);
    }
    if (in.ok() && fresh != content.vertices.size())
        in.fail_at(start, join("vertex ", fresh, " of ", content.vertices.size(), " is not used"));
}

void read_materials(base::ByteReader& in, std::uint32_t count, MeshContent& content) {
    const std::size_t start = in.offset();
    const auto bytes = in.bytes(std::uint64_t{count} * material_size, "materials");
    std::uint16_t any = 0;
    for (std::size_t at = 0; at < bytes.size(); at += material_size) {
        content.materials.push_back(base::load_little_endian<std::uint16_t>(bytes.data() + at));
        any |= content.materials.back();
    }
    if (in.ok() && any == 0) in.fail_at(start, "all materials are 0, then none may be listed");
}

void read_sources(base::ByteReader& in, std::uint32_t count, MeshContent& content) {
    const std::size_t start = in.offset();
    const auto bytes = in.bytes(std::uint64_t{count} * source_size, "sources");
    bool is_moved = false;
    for (std::size_t at = 0; in.ok() && at < bytes.size(); at += source_size) {
        const std::uint32_t source = u32_at(bytes, at);
        if (source >= mesh_triangles_max)
            in.fail_at(start + at, join("triangle ", at / source_size, " was ", source, ", it must be below ",
                                        mesh_triangles_max));
        is_moved |= source != content.sources.size();
        content.sources.push_back(source);
    }
    if (in.ok() && !is_moved)
        in.fail_at(start, "all triangles are their own source, then none may be listed");
}

std::uint32_t flags_of(const MeshContent& content) {
    return (content.two_sided ? mesh_two_sided : 0) | (content.materials.empty() ? 0 : mesh_materials) |
           (content.sources.empty() ? 0 : mesh_sources) | (content.surfaces.empty() ? 0 : mesh_surfaces);
}

} // namespace

void write_mesh(base::ByteWriter& out, const MeshContent& content) {
    out.u32(flags_of(content));
    out.i32(content.flat_sine.raw);
    out.u32(static_cast<std::uint32_t>(content.vertices.size()));
    out.u32(static_cast<std::uint32_t>(content.triangles.size()));
    for (const MeshVertex& v : content.vertices) {
        for (std::uint32_t local : v.local) out.u32(local);
        for (std::int8_t cell : v.cell) out.u8(static_cast<std::uint8_t>(cell));
        out.u8(0);
    }
    for (const TriangleIndices& t : content.triangles)
        for (std::uint32_t v : t) out.u32(v);
    for (std::uint16_t m : content.materials) out.u16(m);
    for (std::uint32_t s : content.sources) out.u32(s);
    if (!content.surfaces.empty()) write_surfaces(out, content.surfaces);
}

std::unique_ptr<const Mesh> read_mesh(base::ByteReader& in) {
    const std::size_t start = in.offset();
    const std::uint32_t flags = in.u32("flags");
    MeshContent content;
    content.two_sided = (flags & mesh_two_sided) != 0;
    content.flat_sine = Unit::from_raw(in.i32("flat sine"));
    const std::uint32_t vertices = in.u32("vertex count"), triangles = in.u32("triangle count");
    if (in.ok() && flags > 15)
        in.fail_at(start, join("flags are ", base::hex(flags), ", only bits 0 to 3 may be set"));
    if (in.ok() && (content.flat_sine < Unit{} || content.flat_sine > unit_one))
        in.fail_at(start + 4, "flat sine is not in 0 .. 1");
    if (in.ok() && (triangles < 1 || triangles > mesh_triangles_max))
        in.fail_at(start + 12,
                   join("a mesh of ", triangles, " triangles, it must have 1 .. ", mesh_triangles_max));
    const std::size_t each = triangle_size + ((flags & mesh_materials) != 0 ? material_size : 0) +
                             ((flags & mesh_sources) != 0 ? source_size : 0);
    const std::uint64_t size = std::uint64_t{vertices} * vertex_size + triangles * std::uint64_t{each};
    const bool has_surfaces = (flags & mesh_surfaces) != 0; // the list of surfaces follows
    if (in.ok() && (has_surfaces ? size > in.remaining() : size != in.remaining()))
        in.fail_at(start + 8, join(vertices, " vertices and ", triangles, " triangles need ", size,
                                   " bytes, ", in.remaining(), " follow"));
    if (in.ok()) read_vertices(in, vertices, content);
    if (in.ok()) read_triangles(in, triangles, content);
    if (in.ok() && (flags & mesh_materials) != 0) read_materials(in, triangles, content);
    if (in.ok() && (flags & mesh_sources) != 0) read_sources(in, triangles, content);
    if (in.ok() && has_surfaces) content.surfaces = read_surfaces(in);
    if (!in.ok()) return nullptr;
    return std::make_unique<const Mesh>(std::move(content));
}

namespace {

Result<AssetBytes> bake_ordered(const MeshDef& def, const std::uint32_t* own_sources) {
    if (std::string why = complaint(def); !why.empty()) return Error{std::move(why)};
    const MeshContent content = ordered(def, own_sources);
    if (content.triangles.empty())
        return Error{join("mesh has no triangle with an area, of ", def.triangles.size())};
    AssetWriter writer(ShapeKind::mesh, minor_version(content));
    write_mesh(writer.out(), content);
    return std::move(writer).finish();
}

} // namespace

Result<AssetBytes> bake_mesh_in_order(const MeshDef& def, std::span<const std::uint32_t> sources) {
    return bake_ordered(def, sources.data());
}

} // namespace shapes

Result<AssetBytes> bake_mesh(const MeshDef& def) { return shapes::bake_ordered(def, nullptr); }

} // namespace lockstone
