// The frame that every asset's bytes share (ASSET.md), and the reader of each kind.
#pragma once

#include "base/bytes.h"
#include "shapes/asset/asset.h"

#include <string_view>

namespace lockstone::shapes {

struct MeshContent; // mesh.h

inline constexpr std::size_t asset_header_size = 20, asset_checksum_size = 8;

/// Collects a payload behind a header; `finish` adds the checksum.
class AssetWriter {
  public:
    AssetWriter(ShapeKind kind, std::uint16_t minor_version);
    base::ByteWriter& out() { return writer; }
    AssetBytes finish() &&;

  private:
    AssetBytes bytes;
    base::ByteWriter writer;
};

/// 1 for what has surfaces or tells what its triangles were before baking, else 0.
std::uint16_t minor_version(const MeshContent& content);
std::uint16_t minor_version(const Asset& asset);

/// The id that bytes have by their checksum.
AssetId id_of(std::span<const std::byte> bytes);

/// True if the bytes begin as a set of assets does (asset_set.cpp).
bool is_asset_set(std::span<const std::byte> bytes);

/// Checks frame and content. Compounds look up their hulls in the library.
Result<std::unique_ptr<const Asset>> parse_asset(std::span<const std::byte> bytes,
                                                 const AssetLibrary& library);

/// The bytes again, from what was read: equal to asset.bytes.
AssetBytes rebuilt(const Asset& asset);

// The payloads. Their definitions are complete: nothing is checked.
void write_hull(base::ByteWriter& out, std::span<const LengthVec3> corners);
void write_compound(base::ByteWriter& out, std::span<const CompoundPart> parts);
void write_height_field(base::ByteWriter& out, const HeightFieldDef& def);
void write_mesh(base::ByteWriter& out, const MeshContent& content);

// Each reads a payload to its end and proves it. What is wrong is told to the reader, and null comes back.
std::unique_ptr<const Hull> read_hull(base::ByteReader& in);
std::unique_ptr<const Compound> read_compound(base::ByteReader& in, const AssetLibrary& library);
std::unique_ptr<const HeightField> read_height_field(base::ByteReader& in);
std::unique_ptr<const Mesh> read_mesh(base::ByteReader& in);

} // namespace lockstone::shapes
