// The constants and the header of the replay file. FORMAT.md is the specification; names here follow it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone::replay {

/// The content of the ticks of a recording.
enum class Mode : std::uint32_t {
    inputs,   ///< the players' inputs; playing needs the game's code
    commands, ///< the commands of the world; playing needs the engine only
};
std::string_view name_of(Mode mode);

/// A pair of texts that the caller of the recorder stores: a seed, a map, a date.
struct Option {
    std::string key;
    std::string value;
    friend bool operator==(const Option&, const Option&) = default;
};

/// The HEAD chunk.
struct Header {
    Mode mode = Mode::inputs;
    std::string engine; ///< version of the engine that made the recording
    std::string game;
    std::uint64_t content_id = 0;
    std::uint64_t schema_hash = 0; ///< of the state's layout
    std::uint32_t tick_rate = 60;
    std::uint32_t player_count = 0;
    std::uint32_t input_size = 0;
    std::uint64_t start_tick = 0;
    std::vector<Option> options; ///< ascending by key
    friend bool operator==(const Header&, const Header&) = default;
};

/// The value of an option, or null.
const std::string* find_option(const Header& header, std::string_view key);

inline constexpr std::string_view engine_version =
    "0.1.0"; ///< as in CMakeLists.txt; a test compares the two values and fails if they differ
inline constexpr std::uint16_t version_major = 6;
inline constexpr std::uint16_t version_minor = 0;

// ---- limits: writer and reader refuse a file beyond them ----
inline constexpr std::uint32_t text_bytes_max = 4096;
inline constexpr std::uint32_t options_max = 64;
inline constexpr std::uint32_t players_max = 16;
inline constexpr std::uint32_t input_bytes_max = 64;
inline constexpr std::uint32_t columns_max = 256;
inline constexpr std::uint32_t row_bytes_max = 65536;
inline constexpr std::uint32_t schema_bytes_max = 1u << 20; ///< payload of SCHM
inline constexpr std::uint32_t block_ticks_max = 1024;
inline constexpr std::uint32_t tick_rate_max = 1000;
inline constexpr std::uint64_t start_tick_max = std::uint64_t{1} << 62;
inline constexpr std::uint64_t block_bytes_max = std::uint64_t{1} << 26; ///< unpacked
inline constexpr std::uint64_t image_bytes_max = std::uint64_t{1} << 32;
inline constexpr std::uint64_t file_bytes_max = std::uint64_t{1} << 34;

/// Limits on the resources to read and play a recording, set by the reader. A file that needs more is refused with a
/// sentence.
struct Limits {
    std::uint64_t memory = std::uint64_t{1}
                           << 30; ///< [bytes], of the recording and everything that plays it at the same time
    /// For recordings of commands. An explosion, which reads every shape, counts as 64.
    std::uint32_t commands_per_tick = 1u << 16;
};

inline constexpr std::uint32_t block_ticks_default = 64;     ///< one second at 60 Hz, which a crash may lose
inline constexpr std::uint64_t keyframe_ticks_default = 600; ///< ten seconds at 60 Hz

// ---- the frame ----
inline constexpr std::size_t preamble_bytes = 16;
inline constexpr std::size_t chunk_head_bytes = 16; ///< type, flags, size
inline constexpr std::size_t checksum_bytes = 8;
inline constexpr std::uint32_t flag_skippable = 1;

/// Four ASCII characters, as a little-endian u32.
constexpr std::uint32_t chunk_type(const char (&name)[5]) {
    std::uint32_t type = 0;
    for (std::size_t i = 4; i-- > 0;) type = type << 8 | static_cast<std::uint8_t>(name[i]);
    return type;
}
inline constexpr std::uint32_t chunk_head = chunk_type("HEAD");
inline constexpr std::uint32_t chunk_schema = chunk_type("SCHM");
inline constexpr std::uint32_t chunk_world_def = chunk_type("WDEF");
inline constexpr std::uint32_t chunk_asset = chunk_type("ASET");
inline constexpr std::uint32_t chunk_keyframe = chunk_type("KEYF");
inline constexpr std::uint32_t chunk_ticks = chunk_type("TICK");
inline constexpr std::uint32_t chunk_index = chunk_type("INDX");
inline constexpr std::uint32_t chunk_end = chunk_type("END.");
/// For error sentences: the four characters, with '?' for those that are not printable.
std::string chunk_name(std::uint32_t type);

/// The first bytes of every file.
std::array<std::byte, preamble_bytes> preamble();
/// Seed for the checksum of the first chunk.
std::uint64_t chain_start(const std::array<std::byte, preamble_bytes>& first_bytes);

/// Entry of the INDX chunk.
struct IndexEntry {
    std::uint32_t type;
    std::uint64_t offset; ///< of the chunk, from the start of the file
    std::uint64_t tick;   ///< first tick of TICK, time of KEYF, 0 for other types
    friend bool operator==(const IndexEntry&, const IndexEntry&) = default;
};

} // namespace lockstone::replay
