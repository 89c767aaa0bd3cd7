// The header and checksum that all assets share (ASSET.md), and the readers and writers of each kind.
#pragma once

#include "base/bytes.h"
#include "shapes/asset/asset.h"

#include <string_view>

namespace lockstone::shapes {

struct MeshContent; // mesh.h

inline constexpr std::size_t asset_header_size = 20, asset_checksum_size = 8;

/// Collects a header and a payload; `finish` appends the checksum.
class AssetWriter {
  public:
    AssetWriter(ShapeKind kind, std::uint16_t minor_version);
    base::ByteWriter& out() { return writer; }
    AssetBytes finish() &&;

  private:
    AssetBytes bytes;
    base::ByteWriter writer;
};

/// 1 for content with surfaces or source indices, else 0.
std::uint16_t minor_version(const MeshContent& content);
std::uint16_t minor_version(const Asset& asset);

/// The id of an asset's bytes, which is their stored checksum; zero for fewer than 8 bytes.
AssetId id_of(std::span<const std::byte> bytes);

/// True if the bytes begin with the magic of a set of assets (asset_set.cpp).
bool is_asset_set(std::span<const std::byte> bytes);

/// Checks header, checksum and content, and returns the asset. Compounds look up their hulls in the library.
Result<std::unique_ptr<const Asset>> parse_asset(std::span<const std::byte> bytes,
                                                 const AssetLibrary& library);

/// bake_mesh() that keeps the order of the triangles. sources[i]: what hits tell of triangle i; at most
/// mesh_triangles_max - 1, one for each triangle.
Result<AssetBytes> bake_mesh_in_order(const MeshDef& def, std::span<const std::uint32_t> sources);

/// Encodes the parsed asset again. The result equals asset.bytes.
AssetBytes rebuilt(const Asset& asset);

// Write the payload of each kind. The definitions must be valid: these functions check nothing.
void write_hull(base::ByteWriter& out, std::span<const LengthVec3> corners);
void write_compound(base::ByteWriter& out, std::span<const CompoundPart> parts);
void write_height_field(base::ByteWriter& out, const HeightFieldDef& def);
void write_mesh(base::ByteWriter& out, const MeshContent& content);

// Each reads a payload to its end and checks it. On an error the reader `in` holds the sentence, and the result
// is null.
std::unique_ptr<const Hull> read_hull(base::ByteReader& in);
std::unique_ptr<const Compound> read_compound(base::ByteReader& in, const AssetLibrary& library);
std::unique_ptr<const HeightField> read_height_field(base::ByteReader& in);
std::unique_ptr<const Mesh> read_mesh(base::ByteReader& in);

} // namespace lockstone::shapes
