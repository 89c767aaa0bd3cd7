#include "game_values.h"

#include <algorithm>
#include <cstring>

namespace lockstone::demo {
namespace {

/// A value in host byte order.
template <class T> T load(std::span<const std::byte> bytes) {
    T value;
    std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
}

std::int64_t load_leaf(std::span<const std::byte> bytes, const LeafInfo& leaf) {
    const bool is_signed = leaf.kind != LeafKind::unsigned_integer;
    std::int64_t raw = 0;
    switch (leaf.size) {
    case 1:
        raw = is_signed ? std::int64_t{load<std::int8_t>(bytes)} : std::int64_t{load<std::uint8_t>(bytes)};
        break;
    case 2:
        raw = is_signed ? std::int64_t{load<std::int16_t>(bytes)} : std::int64_t{load<std::uint16_t>(bytes)};
        break;
    case 4:
        raw = is_signed ? std::int64_t{load<std::int32_t>(bytes)} : std::int64_t{load<std::uint32_t>(bytes)};
        break;
    default:
        raw = load<std::int64_t>(bytes);
    }
    return raw >> leaf.fraction_bits;
}

} // namespace

std::optional<std::int64_t> game_value(const World& world, std::string_view column, std::uint32_t row,
                                       std::string_view field) {
    const StateLayout& layout = world.state().layout();
    const ColumnInfo* info = layout.find_column(column);
    if (info == nullptr) return std::nullopt;
    const auto leaf = std::find_if(info->leaves.begin(), info->leaves.end(),
                                   [&](const LeafInfo& l) { return l.name == field; });
    const auto index = static_cast<std::uint32_t>(info - layout.columns().data());
    const std::span<const std::byte> bytes = world.state().bytes(index);
    const std::size_t offset = std::size_t{row} * info->row_size;
    if (leaf == info->leaves.end() || offset + info->row_size > bytes.size()) return std::nullopt;
    return load_leaf(bytes.subspan(offset + leaf->offset, leaf->size), *leaf);
}

std::optional<MatchValues> match_values(const World& world) {
    const auto it = game_value(world, "game.match", 0, "it");
    if (!it) return std::nullopt;
    MatchValues match{.scores = {}, .it = static_cast<std::size_t>(*it)};
    while (const auto score =
               game_value(world, "game.match", 0, "score[" + std::to_string(match.scores.size()) + "]"))
        match.scores.push_back(*score);
    return match;
}

std::optional<std::uint32_t> prop_owner(const World& world, std::uint32_t body_row) {
    const auto owner = game_value(world, "game.claim", body_row, "owner");
    if (!owner || *owner <= 0) return std::nullopt;
    return static_cast<std::uint32_t>(*owner - 1);
}

} // namespace lockstone::demo
