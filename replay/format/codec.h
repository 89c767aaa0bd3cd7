// The payloads of HEAD, SCHM and WDEF, and the fields of commands. Readers check everything that FORMAT.md demands,
// so what they hand out can be written again and is the same.
#pragma once

#include "base/bytes.h"
#include "lockstone/world.h"
#include "replay/format/format.h"

namespace lockstone::replay {

void append_header(const Header& header, std::vector<std::byte>& out);
/// On any error the reader holds the sentence and the result means nothing; so with the others.
Header read_header(base::ByteReader& in);
/// The rules of HEAD that go beyond its grammar; empty when they hold. For writers and readers.
std::string find_fault(const Header& header);

void append_schema(const GameSchema& schema, std::vector<std::byte>& out);
GameSchema read_schema(base::ByteReader& in);
std::string find_fault(const GameSchema& schema);

void append_world_def(const WorldDef& def, std::vector<std::byte>& out);
WorldDef read_world_def(base::ByteReader& in);
/// The first field in which two definitions differ: "substeps: 4 against 8"; empty when they are equal.
std::string first_difference(const WorldDef& left, const WorldDef& right);

/// Every asset, in an order in which they can be added to an empty library.
std::vector<std::span<const std::byte>> assets_in_order(const AssetLibrary& library);

// ---- commands: kind = index in the variant ----
inline constexpr std::size_t command_kinds = std::variant_size_v<Command>;
/// Bytes of the fields of a kind, kind < command_kinds.
std::size_t command_bytes(std::size_t kind);
/// What a command of the kind takes in memory [bytes].
std::size_t command_memory(std::size_t kind);
void append_command(const Command& command, std::vector<std::byte>& out);
/// `fields` has command_bytes(kind) bytes.
Command read_command(std::size_t kind, std::span<const std::byte> fields);

} // namespace lockstone::replay
