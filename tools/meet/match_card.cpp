#include "meet/match_card.h"

#include <iomanip>
#include <sstream>

namespace lockstone {
namespace {

constexpr std::string_view magic = "DEMO1"; ///< no packet of a session begins with 'D'
constexpr std::size_t card_bytes_max = 300;
constexpr std::uint64_t ticks_max = 1'000'000;

/// The number as 16 hexadecimal digits.
std::string hex(std::uint64_t number) {
    std::ostringstream out;
    out << std::hex << std::setw(16) << std::setfill('0') << number;
    return out.str();
}
std::string first_word(const std::string& text) { return text.substr(0, text.find(' ')); }

} // namespace

std::vector<std::byte> to_bytes(const MatchCard& card) {
    std::ostringstream out;
    out << magic << ' ' << card.content_id << ' ' << card.script_seed << ' ' << card.ticks << ' '
        << card.machines << ' ' << card.game;
    const std::string text = out.str();
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

std::optional<MatchCard> card_of(std::span<const std::byte> packet) {
    if (packet.size() > card_bytes_max) return {};
    std::istringstream in(std::string(reinterpret_cast<const char*>(packet.data()), packet.size()));
    std::string begin;
    MatchCard card;
    in >> begin;
    if (begin != magic) return {};
    in >> card.content_id >> card.script_seed >> card.ticks >> card.machines >> std::ws;
    std::getline(in, card.game);
    const bool is_match = card.machines >= 2 && card.machines <= net_players_max;
    return in && is_match && card.ticks > 0 && card.ticks <= ticks_max ? std::optional(card) : std::nullopt;
}

Result<std::unique_ptr<Game>> game_of(const MatchCard& card, const std::string& wanted) {
    if (!wanted.empty() && first_word(card.game) != wanted)
        return Error{"the host plays " + first_word(card.game) + ", and this machine was asked to play " +
                     wanted + ": leave the scene out, or enter another match"};
    Result<std::unique_ptr<Game>> game = make_scene_named(card.game);
    if (!game)
        return Error{"the host plays '" + card.game +
                     "', which this program cannot: " + game.error().message};
    if ((*game)->content_id() != card.content_id)
        return Error{"the host plays " + first_word(card.game) + " by other rules (" + hex(card.content_id) +
                     ") than this program has (" + hex((*game)->content_id()) +
                     "): both must be of one version"};
    return game;
}

std::optional<Datagram> CardTransport::receive() {
    while (const std::optional<Datagram> packet = whole_.receive()) {
        std::optional<MatchCard> card = card_of(packet->bytes);
        if (!card) return packet;
        card_ = std::move(card), from_ = packet->from;
    }
    return {};
}

} // namespace lockstone
