#include "cli/input_source.h"

#include "cli/text.h"
#include "scenes/scenes.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace lockstone::cli {
namespace {

/// Parses "7f00" into exactly `size` bytes; nothing if the text does not fit.
std::optional<std::vector<std::byte>> bytes_of_hex(const std::string& text, std::size_t size) {
    if (text == "-") return std::vector<std::byte>(size);
    if (text.size() != 2 * size) return std::nullopt;
    std::vector<std::byte> bytes(size);
    for (std::size_t i = 0; i < size; ++i) {
        unsigned value = 0;
        const char* const from = text.data() + 2 * i;
        if (std::from_chars(from, from + 2, value, 16).ptr != from + 2) return std::nullopt;
        bytes[i] = static_cast<std::byte>(value);
    }
    return bytes;
}

template <class N> bool read_number(const std::string& text, N& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size();
}

/// Reads one line, whose comment is already removed, into `held`. Returns an empty text, or what is wrong with the
/// line.
std::string read_line(const std::string& line, std::uint32_t input_size,
                      std::vector<std::vector<HeldInput>>& held) {
    std::istringstream words(line);
    std::string tick_word, player_word, bytes_word, more;
    if (!(words >> tick_word)) return {};
    if (!(words >> player_word >> bytes_word) || words >> more)
        return "a line must have tick, player and bytes";
    std::uint64_t tick = 0;
    std::uint32_t player = 0;
    if (!read_number(tick_word, tick)) return "'" + shown(tick_word) + "' is not a tick";
    if (!read_number(player_word, player) || player >= held.size())
        return "'" + shown(player_word) + "' is not a player; there are " + std::to_string(held.size()) +
               " players, numbered from 0";
    const auto bytes = bytes_of_hex(bytes_word, input_size);
    if (!bytes)
        return "'" + shown(bytes_word) + "' is not an input of " + std::to_string(input_size) +
               " bytes in hex";
    std::vector<HeldInput>& of_player = held[player];
    if (!of_player.empty() && of_player.back().tick >= tick)
        return "tick " + shown(tick_word) + " of player " + shown(player_word) +
               " does not come after the last tick of this player, " + std::to_string(of_player.back().tick);
    of_player.push_back({tick, *bytes});
    return {};
}

} // namespace

Result<std::vector<std::vector<HeldInput>>> parse_inputs(const std::string& text, const std::string& name,
                                                         std::uint32_t players, std::uint32_t input_size) {
    std::vector<std::vector<HeldInput>> held(players);
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        line.resize(std::min(line.size(), line.find('#')));
        if (const std::string wrong = read_line(line, input_size, held); !wrong.empty())
            return Error{name + ": line " + std::to_string(number) + ": " + wrong};
    }
    return held;
}

InputSource::InputSource(const Game& rules)
    : game(&rules), bytes(std::size_t{rules.player_count()} * rules.input_size()),
      inputs(rules.player_count()) {}

InputSource InputSource::scripted(const Game& game, std::uint64_t seed) {
    InputSource source(game);
    source.seed = seed;
    return source;
}

/// True if the file starts like a recording. Pipes and devices are no recordings, because a recording is read more than
/// once.
static bool is_recording(const std::string& path) {
    std::error_code none;
    if (!std::filesystem::is_regular_file(path, none)) return false;
    std::ifstream file(path, std::ios::binary);
    char magic[4] = {};
    return file.read(magic, sizeof magic) && std::string_view(magic, sizeof magic) == "\x89LSR";
}

InputSource InputSource::idle(const Game& game) { return InputSource(game); }

Result<InputSource> InputSource::open(const Game& game, const std::string& path) {
    InputSource source(game);
    if (!is_recording(path)) {
        constexpr std::size_t longest = std::size_t{64} << 20; // enough for hundreds of hours of key presses
        Result<std::string> text = read_file(path, longest);
        if (!text) return text.error();
        auto held = parse_inputs(*text, path, game.player_count(), game.input_size());
        if (!held) return held.error();
        source.held = std::move(*held);
        return source;
    }
    Result<replay::Recording> recording = replay::Recording::open(path, replay::OnDamage::recover_cut);
    if (!recording) return recording.error();
    const replay::Header& head = recording->header();
    if (head.mode != replay::Mode::inputs || head.player_count != game.player_count() ||
        head.input_size != game.input_size())
        return Error{path + ": does not hold inputs of " + std::to_string(game.player_count()) +
                     " players of " + std::to_string(game.input_size()) + " bytes each, which '" +
                     game.name() + "' needs"};
    source.recording = std::move(*recording);
    return source;
}

std::span<const PlayerInput> InputSource::at(std::uint64_t tick) {
    const std::size_t size = game->input_size();
    std::ranges::fill(bytes, std::byte{});
    for (std::size_t p = 0; p < inputs.size(); ++p) inputs[p] = {std::span(bytes).subspan(p * size, size)};
    if (recording)
        play_recording(tick);
    else
        play_script(tick);
    return inputs;
}

void InputSource::play_recording(std::uint64_t tick) {
    if (tick < recording->start_tick() || tick >= recording->end_tick()) return;
    if (!block.holds(tick)) block = recording->block_with(tick);
    inputs = block.inputs(tick);
}

void InputSource::play_script(std::uint64_t tick) {
    const std::size_t size = game->input_size();
    for (std::uint32_t p = 0; p < inputs.size(); ++p) {
        const std::span<std::byte> input = std::span(bytes).subspan(p * size, size);
        if (seed) scripted_input(*game, *seed, tick, p, input);
        if (p >= held.size()) continue;
        const auto after = std::ranges::upper_bound(held[p], tick, {}, &HeldInput::tick);
        if (after != held[p].begin()) std::ranges::copy(std::prev(after)->bytes, input.begin());
    }
}

} // namespace lockstone::cli
