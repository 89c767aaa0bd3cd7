// The library of assets, and the header and checksum of an asset's bytes.
#include "shapes/asset/asset.h"

#include "base/hash.h"
#include "base/text.h"
#include "shapes/asset/asset_file.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

#include <algorithm>

namespace lockstone {
namespace shapes {
namespace {

using base::hex;
using base::join;

// A byte that is not text, "LSA", CR LF, ctrl-Z, LF: transfers in text mode damage this visibly.
constexpr std::array<std::uint8_t, 8> magic{0x89, 'L', 'S', 'A', 0x0d, 0x0a, 0x1a, 0x0a};
constexpr std::uint16_t version_major = 1, version_minor_max = 1;

std::uint64_t checksum_of(std::span<const std::byte> content) {
    const std::uint64_t sum = base::xxh3(content);
    return sum == 0 ? 1 : sum; // the checksum is also the id, and zero means no id
}

/// Reads magic, versions and kind. Returns `plane`, a kind that no asset has, on an error.
ShapeKind read_header(base::ByteReader& in, std::uint16_t& minor) {
    const auto start = in.bytes(magic.size(), "magic");
    if (in.ok() && !std::ranges::equal(start, std::as_bytes(std::span(magic))))
        in.fail_at(0, "this is not an asset: the first 8 bytes are not 89 4c 53 41 0d 0a 1a 0a");
    const std::uint16_t major = in.u16("major version");
    minor = in.u16("minor version");
    if (in.ok() && (major != version_major || minor > version_minor_max))
        in.fail_at(8, join("version is ", major, ".", minor, ", this library reads 1.0 and 1.1"));
    const std::uint32_t kind = in.u32("kind");
    if (in.ok() && (kind < static_cast<std::uint32_t>(ShapeKind::hull) ||
                    kind > static_cast<std::uint32_t>(ShapeKind::mesh)))
        in.fail_at(
            12, join("kind is ", kind, ", it must be 5 (hull), 6 (compound), 7 (height field) or 8 (mesh)"));
    const std::uint32_t reserved = in.u32("reserved");
    if (in.ok() && reserved != 0) in.fail_at(16, join("reserved is ", reserved, ", it must be 0"));
    return in.ok() ? static_cast<ShapeKind>(kind) : ShapeKind::plane;
}

} // namespace

Asset::Asset(AssetId asset_id, AssetBytes asset_bytes, ShapeKind asset_kind)
    : id(asset_id), bytes(std::move(asset_bytes)), kind(asset_kind) {}
Asset::~Asset() = default;

std::uint16_t minor_version(const MeshContent& content) {
    return content.sources.empty() && content.surfaces.empty() ? 0 : 1;
}
std::uint16_t minor_version(const Asset& asset) {
    if (asset.mesh != nullptr) return minor_version(asset.mesh->raw());
    return asset.height_field != nullptr && !asset.height_field->surfaces().empty() ? 1 : 0;
}

AssetWriter::AssetWriter(ShapeKind kind, std::uint16_t minor) : writer(bytes) {
    writer.bytes(std::as_bytes(std::span(magic)));
    writer.u16(version_major);
    writer.u16(minor);
    writer.u32(static_cast<std::uint32_t>(kind));
    writer.u32(0);
}
AssetBytes AssetWriter::finish() && {
    writer.u64(checksum_of(bytes));
    return std::move(bytes);
}

AssetId id_of(std::span<const std::byte> bytes) {
    if (bytes.size() < asset_checksum_size) return {};
    return {base::load_little_endian<std::uint64_t>(bytes.last(asset_checksum_size).data())};
}

Result<std::unique_ptr<const Asset>> parse_asset(std::span<const std::byte> bytes,
                                                 const AssetLibrary& library) {
    if (bytes.size() < asset_header_size + asset_checksum_size)
        return Error{join("asset: it has ", bytes.size(), " bytes, the least is ",
                          asset_header_size + asset_checksum_size)};
    const AssetId id = id_of(bytes);
    const std::uint64_t sum = checksum_of(bytes.first(bytes.size() - asset_checksum_size));
    if (sum != id.value)
        return Error{join("asset: checksum is ", hex(id.value), ", the content has ", hex(sum), " (at byte ",
                          bytes.size() - asset_checksum_size, ")")};
    auto asset = std::make_unique<Asset>(id, AssetBytes(bytes.begin(), bytes.end()), ShapeKind::plane);
    // Reads from the asset's own copy, because height fields keep references into it.
    base::ByteReader in(std::span<const std::byte>(asset->bytes).first(bytes.size() - asset_checksum_size),
                        "asset");
    std::uint16_t minor = 0;
    const ShapeKind kind = asset->kind = read_header(in, minor);
    if (kind == ShapeKind::hull) asset->hull = read_hull(in);
    if (kind == ShapeKind::compound) asset->compound = read_compound(in, library);
    if (kind == ShapeKind::height_field) asset->height_field = read_height_field(in);
    if (kind == ShapeKind::mesh) asset->mesh = read_mesh(in);
    in.expect_end();
    if (in.ok() && minor != minor_version(*asset))
        in.fail_at(10, join("minor version is ", minor, ", what it holds is of ", minor_version(*asset)));
    if (!in.ok()) return in.error();
    return std::unique_ptr<const Asset>(std::move(asset));
}

AssetBytes rebuilt(const Asset& asset) {
    AssetWriter writer(asset.kind, minor_version(asset));
    if (asset.hull != nullptr) write_hull(writer.out(), asset.hull->vertices);
    if (asset.mesh != nullptr) write_mesh(writer.out(), asset.mesh->raw());
    if (asset.compound != nullptr) {
        std::vector<CompoundPart> parts;
        for (const Compound::Part& part : asset.compound->parts)
            parts.push_back({part.solid.geometry, part.local});
        write_compound(writer.out(), parts);
    }
    if (asset.height_field != nullptr) {
        const HeightField& field = *asset.height_field;
        std::vector<Length> heights;
        std::vector<std::uint8_t> cells;
        for (std::uint32_t i = 0; i < field.sample_count(); ++i)
            heights.push_back(to<Length>(field.sample(i).y));
        for (std::byte cell : field.cell_bytes()) cells.push_back(static_cast<std::uint8_t>(cell));
        const HeightGrid& grid = field.size();
        write_height_field(writer.out(), {.columns = grid.columns,
                                          .rows = grid.rows,
                                          .spacing = grid.spacing,
                                          .heights = heights,
                                          .cells = cells,
                                          .surfaces = field.surfaces(),
                                          .flat_sine = grid.flat_sine});
    }
    return std::move(writer).finish();
}

} // namespace shapes

AssetLibrary::AssetLibrary() = default;
AssetLibrary::AssetLibrary(AssetLibrary&&) noexcept = default;
AssetLibrary& AssetLibrary::operator=(AssetLibrary&&) noexcept = default;
AssetLibrary::~AssetLibrary() = default;

Result<AssetId> AssetLibrary::add(std::span<const std::byte> bytes) {
    return shapes::is_asset_set(bytes) ? add_set(bytes) : add_one(bytes);
}
Result<AssetId> AssetLibrary::add_one(std::span<const std::byte> bytes) {
    if (const shapes::Asset* known = find(shapes::id_of(bytes));
        known != nullptr && std::ranges::equal(known->bytes, bytes))
        return known->id;
    auto asset = shapes::parse_asset(bytes, *this);
    if (!asset) return asset.error();
    const AssetId id = (*asset)->id;
    if (contains(id))
        return Error{base::join("asset: another one is named ", base::hex(id.value), " already")};
    assets.emplace(id, std::move(*asset));
    return id;
}
Result<AssetId> AssetLibrary::add(const Result<AssetBytes>& baked) {
    if (!baked) return baked.error();
    return add(std::span<const std::byte>(*baked));
}

bool AssetLibrary::contains(AssetId id) const { return find(id) != nullptr; }
std::vector<AssetId> AssetLibrary::ids() const {
    std::vector<AssetId> all;
    for (const auto& [id, asset] : assets) all.push_back(id);
    return all;
}
std::span<const std::byte> AssetLibrary::bytes(AssetId id) const {
    const shapes::Asset* asset = find(id);
    return asset == nullptr ? std::span<const std::byte>{} : asset->bytes;
}
Result<Geometry> AssetLibrary::geometry(AssetId id, LengthVec3 scale) const {
    const shapes::Asset* asset = find(id);
    if (asset == nullptr) return Error{base::join("asset ", base::hex(id.value), " is not in the library")};
    return instance(asset->kind, id, scale);
}
const shapes::Asset* AssetLibrary::find(AssetId id) const {
    const auto at = assets.find(id);
    return at == assets.end() ? nullptr : at->second.get();
}

} // namespace lockstone
