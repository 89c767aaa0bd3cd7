#include "replay/format/codec.h"

#include "replay/format/pack.h"

#include <algorithm>
#include <bit>
#include <set>

namespace lockstone::replay {
namespace {

using base::ByteReader;
using base::ByteWriter;
using base::join;

/// Returns an empty text, or why the text is not allowed: it is too long, or has characters that control a terminal.
std::string text_fault(std::string_view what, std::string_view text) {
    if (text.size() > text_bytes_max)
        return join(what, " has ", text.size(), " bytes, at most ", text_bytes_max);
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        if (c < 0x20 || c == 0x7f) return join(what, " holds the control character ", int{c}, " at ", i);
        // U+0080 to U+009F also control terminals.
        const auto next = i + 1 < text.size() ? static_cast<unsigned char>(text[i + 1]) : 0;
        if (c == 0xc2 && next >= 0x80 && next < 0xa0)
            return join(what, " holds the control character ", int{next}, " at ", i);
    }
    return {};
}

/// A range of a single value belongs to a field that a recording of commands does not use.
std::string range_fault(std::string_view what, std::uint64_t value, std::uint64_t low, std::uint64_t high) {
    if (value >= low && value <= high) return {};
    if (low == high) return join(what, " is ", value, ", must be ", low, " in a recording of commands");
    return join(what, " is ", value, ", must be ", low, "..", high);
}

/// The first sentence that is not empty.
template <class... Sentences> std::string first_of(Sentences&&... sentences) {
    std::string found;
    ((found.empty() ? void(found = std::forward<Sentences>(sentences)) : void()), ...);
    return found;
}

std::string read_text(ByteReader& in, std::string_view what) { return std::string(in.text(what)); }

} // namespace

// ---- HEAD ----------------------------------------------------------------------------------------------------

void append_header(const Header& header, std::vector<std::byte>& out) {
    ByteWriter to(out);
    to.u32(static_cast<std::uint32_t>(header.mode));
    to.text(header.engine);
    to.text(header.game);
    to.u64(header.content_id);
    to.u64(header.schema_hash);
    to.u32(header.tick_rate);
    to.u32(header.player_count);
    to.u32(header.input_size);
    to.u64(header.start_tick);
    to.u32(static_cast<std::uint32_t>(header.options.size()));
    for (const Option& option : header.options) {
        to.text(option.key);
        to.text(option.value);
    }
}

Header read_header(ByteReader& in) {
    Header header;
    const std::uint32_t mode = in.u32("mode");
    if (mode > 1) in.fail(join("mode is ", mode, ", must be 0 (inputs) or 1 (commands)"));
    header.mode = mode == 0 ? Mode::inputs : Mode::commands;
    header.engine = read_text(in, "engine");
    header.game = read_text(in, "game");
    header.content_id = in.u64("content id");
    header.schema_hash = in.u64("schema hash");
    header.tick_rate = in.u32("tick rate");
    header.player_count = in.u32("players");
    header.input_size = in.u32("input size");
    header.start_tick = in.u64("start");
    const std::uint32_t options = in.u32("options");
    if (options > options_max) in.fail(range_fault("number of options", options, 0, options_max));
    for (std::uint32_t i = 0; in.ok() && i < options; ++i) {
        Option option;
        option.key = read_text(in, "option key");
        option.value = read_text(in, "option value");
        header.options.push_back(std::move(option));
    }
    if (const std::string fault = find_fault(header); in.ok() && !fault.empty()) in.fail(fault);
    return header;
}

std::string find_fault(const Header& header) {
    const bool has_players = header.mode == Mode::inputs;
    std::string fault =
        first_of(text_fault("engine", header.engine), text_fault("game", header.game),
                 range_fault("tick rate", header.tick_rate, 1, tick_rate_max),
                 range_fault("content id", header.content_id, 0, has_players ? ~std::uint64_t{0} : 0),
                 range_fault("players", header.player_count, 0, has_players ? players_max : 0),
                 range_fault("input size", header.input_size, 0, has_players ? input_bytes_max : 0),
                 range_fault("start", header.start_tick, 0, start_tick_max),
                 range_fault("number of options", header.options.size(), 0, options_max));
    for (std::size_t i = 0; fault.empty() && i < header.options.size(); ++i) {
        const Option& option = header.options[i];
        fault = first_of(text_fault("option key", option.key), text_fault("option value", option.value));
        if (fault.empty() && i > 0 && header.options[i - 1].key >= option.key)
            fault =
                join("option keys are not ascending: ", header.options[i - 1].key, " before ", option.key);
    }
    return fault;
}

// ---- SCHM ----------------------------------------------------------------------------------------------------

void append_schema(const GameSchema& schema, std::vector<std::byte>& out) {
    ByteWriter to(out);
    to.u32(static_cast<std::uint32_t>(schema.entries().size()));
    for (const GameSchema::Entry& entry : schema.entries()) {
        to.text(entry.name);
        to.u8(entry.per_body ? 1 : 0);
        to.u32(static_cast<std::uint32_t>(entry.row_size));
        to.u32(static_cast<std::uint32_t>(entry.leaves.size()));
        for (const LeafInfo& leaf : entry.leaves) {
            to.text(leaf.name);
            to.u32(leaf.offset);
            to.u8(leaf.size);
            to.u8(static_cast<std::uint8_t>(leaf.kind));
            to.u8(leaf.fraction_bits);
        }
    }
}

namespace {

std::string leaf_fault(const LeafInfo& leaf, std::uint64_t offset_expected) {
    std::string fault = first_of(text_fault("leaf name", leaf.name),
                                 range_fault("leaf kind", static_cast<std::uint64_t>(leaf.kind), 0, 2));
    if (fault.empty() && (leaf.size > 8 || !std::has_single_bit(leaf.size)))
        fault = join("leaf size is ", int{leaf.size}, ", must be 1, 2, 4 or 8");
    if (fault.empty() && leaf.offset != offset_expected)
        fault = join("leaf offset is ", leaf.offset, ", must be ", offset_expected);
    if (!fault.empty()) return fault;
    const auto bits_max = leaf.kind == LeafKind::fixed_point ? 8u * leaf.size - 1u : 0u;
    return range_fault("leaf fraction bits", leaf.fraction_bits, 0, bits_max);
}

std::string entry_fault(const GameSchema::Entry& entry) {
    std::string fault = first_of(text_fault("column name", entry.name),
                                 range_fault("column name's length", entry.name.size(), 1, text_bytes_max));
    if (!fault.empty()) return fault; // without the name, which is not printable
    fault = range_fault("row size", entry.row_size, 1, row_bytes_max);
    std::uint64_t end = 0;
    for (std::size_t i = 0; fault.empty() && i < entry.leaves.size(); ++i) {
        fault = leaf_fault(entry.leaves[i], end);
        end += entry.leaves[i].size;
    }
    if (fault.empty() && end != entry.row_size)
        fault = join("leaves fill ", end, " bytes of a row of ", entry.row_size);
    return fault.empty() ? fault : join("column ", entry.name.substr(0, 64), ": ", fault);
}

LeafInfo read_leaf(ByteReader& in) {
    LeafInfo leaf{};
    leaf.name = read_text(in, "leaf name");
    leaf.offset = in.u32("leaf offset");
    leaf.size = in.u8("leaf size");
    const std::uint8_t kind = in.u8("leaf kind");
    if (kind > 2) in.fail(range_fault("leaf kind", kind, 0, 2));
    leaf.kind = static_cast<LeafKind>(kind);
    leaf.fraction_bits = in.u8("leaf fraction bits");
    return leaf;
}

} // namespace

std::string find_fault(const GameSchema& schema) {
    std::string fault = range_fault("number of columns", schema.entries().size(), 0, columns_max);
    std::set<std::string_view> names;
    for (const GameSchema::Entry& entry : schema.entries()) {
        if (fault.empty()) fault = entry_fault(entry);
        if (fault.empty() && !names.insert(entry.name).second)
            fault = join("two columns are named ", entry.name);
    }
    return fault;
}

GameSchema read_schema(ByteReader& in) {
    GameSchema schema;
    std::set<std::string> names;
    const std::uint32_t columns = in.u32("number of columns");
    if (columns > columns_max) in.fail(range_fault("number of columns", columns, 0, columns_max));
    for (std::uint32_t i = 0; in.ok() && i < columns; ++i) {
        GameSchema::Entry entry;
        entry.name = read_text(in, "column name");
        const std::uint8_t per_body = in.u8("per body");
        if (per_body > 1) in.fail(range_fault("per body", per_body, 0, 1));
        entry.per_body = per_body == 1;
        entry.row_size = in.u32("row size");
        const std::uint32_t leaves = in.u32("number of leaves");
        for (std::uint32_t k = 0; in.ok() && k < leaves; ++k) entry.leaves.push_back(read_leaf(in));
        if (const std::string fault = entry_fault(entry); in.ok() && !fault.empty()) in.fail(fault);
        if (in.ok() && !names.insert(entry.name).second) in.fail(join("two columns are named ", entry.name));
        if (in.ok()) schema.add(std::move(entry));
    }
    return schema;
}

// ---- WDEF ----------------------------------------------------------------------------------------------------

namespace {

constexpr std::size_t world_def_bytes = 136;
static_assert(sizeof(WorldDef) == world_def_bytes, "a field was added: FORMAT.md needs it too");

template <Leaf T> void append_leaf(const T& leaf, std::vector<std::byte>& out) {
    const auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(leaf);
    if constexpr (std::endian::native == std::endian::little)
        out.insert(out.end(), raw.begin(), raw.end());
    else
        out.insert(out.end(), raw.rbegin(), raw.rend());
}

template <Leaf T> void read_leaf_value(std::span<const std::byte> from, T& leaf) {
    std::array<std::byte, sizeof(T)> raw;
    std::copy_n(from.begin(), sizeof(T), raw.begin());
    if constexpr (std::endian::native != std::endian::little) std::ranges::reverse(raw);
    leaf = std::bit_cast<T>(raw);
}

template <class T> std::int64_t printable(const T& leaf) {
    if constexpr (FixedPoint<T>)
        return leaf.raw;
    else
        return static_cast<std::int64_t>(leaf);
}

} // namespace

void append_world_def(const WorldDef& def, std::vector<std::byte>& out) {
    WorldDef copy = def;
    for_each_leaf(copy, [&](auto& leaf) { append_leaf(leaf, out); });
}

WorldDef read_world_def(ByteReader& in) {
    WorldDef def;
    std::span<const std::byte> from = in.bytes(world_def_bytes, "the world's definition");
    if (!in.ok()) return def;
    for_each_leaf(def, [&](auto& leaf) {
        read_leaf_value(from, leaf);
        from = from.subspan(sizeof leaf);
    });
    return def;
}

std::string first_difference(const WorldDef& left, const WorldDef& right) {
    std::vector<std::int64_t> values;
    WorldDef l = left, r = right;
    for_each_leaf(l, [&](auto& leaf) { values.push_back(printable(leaf)); });
    const std::vector<LeafInfo> names = leaves_of<WorldDef>();
    std::string difference;
    std::size_t i = 0;
    for_each_leaf(r, [&](auto& leaf) {
        if (difference.empty() && values[i] != printable(leaf))
            difference = join(names[i].name, ": ", values[i], " against ", printable(leaf),
                              FixedPoint<std::remove_reference_t<decltype(leaf)>> ? " (raw)" : "");
        ++i;
    });
    return difference;
}

// ---- ASET ----------------------------------------------------------------------------------------------------

std::vector<std::span<const std::byte>> assets_in_order(const AssetLibrary& library) {
    std::vector<std::span<const std::byte>> out;
    // Compounds refer to hulls, so they come after them.
    for (const bool compounds : {false, true})
        for (AssetId id : library.ids())
            if ((library.geometry(id)->kind == ShapeKind::compound) == compounds)
                out.push_back(library.bytes(id));
    return out;
}

// ---- commands ------------------------------------------------------------------------------------------------

namespace {

template <class T> std::size_t leaf_bytes() {
    T value{};
    std::size_t bytes = 0;
    for_each_leaf(value, [&](auto& leaf) { bytes += sizeof leaf; });
    return bytes;
}

template <std::size_t... I> const auto& command_sizes(std::index_sequence<I...>) {
    static const std::array<std::size_t, sizeof...(I)> sizes = {
        leaf_bytes<std::variant_alternative_t<I, Command>>()...};
    return sizes;
}

template <class T> Command read_fields(std::span<const std::byte> from) {
    T command{};
    for_each_leaf(command, [&](auto& leaf) {
        read_leaf_value(from, leaf);
        from = from.subspan(sizeof leaf);
    });
    return command;
}

template <std::size_t... I>
Command read_kind(std::size_t kind, std::span<const std::byte> fields, std::index_sequence<I...>) {
    Command command;
    static_cast<void>((
        (kind == I && (command = read_fields<std::variant_alternative_t<I, Command>>(fields), true)) || ...));
    return command;
}

} // namespace

std::size_t command_bytes(std::size_t kind) {
    return command_sizes(std::make_index_sequence<command_kinds>{})[kind];
}

std::size_t command_memory(std::size_t kind) {
    constexpr std::size_t allocation = 32; ///< of an Indirect's content, in addition to its bytes
    const std::size_t bytes = command_bytes(kind);
    return sizeof(Command) + (bytes > sizeof(Command) ? bytes + allocation : 0);
}

void append_command(const Command& command, std::vector<std::byte>& out) {
    std::visit([&](auto copy) { for_each_leaf(copy, [&](auto& leaf) { append_leaf(leaf, out); }); }, command);
}

Command read_command(std::size_t kind, std::span<const std::byte> fields) {
    return read_kind(kind, fields, std::make_index_sequence<command_kinds>{});
}

} // namespace lockstone::replay
