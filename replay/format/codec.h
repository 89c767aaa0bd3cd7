// The payloads of HEAD, SCHM and WDEF, and the fields of commands. Readers check every rule of FORMAT.md, so a result
// can be written again and gives equal bytes.
#pragma once

#include "base/bytes.h"
#include "lockstone/world.h"
#include "replay/format/format.h"

namespace lockstone::replay {

void append_header(const Header& header, std::vector<std::byte>& out);
/// On an error the reader `in` holds the sentence, and the result is invalid. This applies to all read functions
/// here.
Header read_header(base::ByteReader& in);
/// Checks the rules of HEAD beyond its grammar, for writers and readers. Returns an empty text if they hold.
std::string find_fault(const Header& header);

void append_schema(const GameSchema& schema, std::vector<std::byte>& out);
GameSchema read_schema(base::ByteReader& in);
std::string find_fault(const GameSchema& schema);

void append_world_def(const WorldDef& def, std::vector<std::byte>& out);
WorldDef read_world_def(base::ByteReader& in);
/// The first field in which two definitions differ: "substeps: 4 against 8"; empty if they are equal.
std::string first_difference(const WorldDef& left, const WorldDef& right);

/// All assets, in an order in which they can be added to an empty library.
std::vector<std::span<const std::byte>> assets_in_order(const AssetLibrary& library);

// ---- commands: kind = index in the variant ----
inline constexpr std::size_t command_kinds = std::variant_size_v<Command>;
/// Bytes of the fields of a kind, kind < command_kinds.
std::size_t command_bytes(std::size_t kind);
/// The memory that a command of the kind needs [bytes].
std::size_t command_memory(std::size_t kind);
void append_command(const Command& command, std::vector<std::byte>& out);
/// `fields` has command_bytes(kind) bytes.
Command read_command(std::size_t kind, std::span<const std::byte> fields);

} // namespace lockstone::replay
