// LobbyClient: the player's side of the lobby; lobby.cpp is the relay's side.
#include "net/relay.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::uint64_t ask_every_ms = 500, cookie_kept_ms = 3000;

const char* sentence_of(LobbyStatus status) {
    switch (status) {
    case LobbyStatus::no_such_code:
        return "the lobby knows no such code, or it has expired";
    case LobbyStatus::room_full:
        return "all players of this code are there already";
    case LobbyStatus::lobby_full:
        return "the lobby has no room for another match";
    case LobbyStatus::bad_request:
        return "the lobby takes 2 to 16 players";
    case LobbyStatus::door_full:
        return "all places for those who watch are taken";
    default:
        return "the lobby answers what this program does not know";
    }
}

} // namespace

struct LobbyClient::Impl {
    NetAddress lobby;
    std::string asked;
    std::uint32_t players;
    NetKey secret = random_key();
    std::optional<DirectedKeys> keys;
    std::uint64_t now = 0, nonce = random_u64(), cookie = 0, cookie_ms = 0, asked_ms = 0, answered_ms = 0;
    bool has_cookie = false;
    std::string code, refusal;
    std::optional<ConnectToken> token;
    PacketQueue<NetAddress> outgoing{8, 8 * packet_bytes_max};

    void ask();
    void take_answer(Bytes datagram);
};

LobbyClient::LobbyClient(const NetAddress& lobby, const NetKey& lobby_public_key, std::string_view code,
                         std::uint32_t players)
    : impl(std::make_unique<Impl>()) {
    impl->lobby = lobby, impl->asked = code, impl->players = players;
    impl->keys = agree(Role::initiator, impl->secret, lobby_public_key);
    if (!impl->keys) impl->refusal = "the lobby's key is one that no secret belongs to";
    if (!code.empty() && code.size() != code_letters)
        impl->refusal = base::join("a code has ", code_letters, " letters");
}
LobbyClient::LobbyClient(LobbyClient&&) noexcept = default;
LobbyClient& LobbyClient::operator=(LobbyClient&&) noexcept = default;
LobbyClient::~LobbyClient() = default;

void LobbyClient::Impl::ask() {
    if (!has_cookie || now - cookie_ms > cookie_kept_ms) {
        if (const Space to = outgoing.push(lobby, hello_bytes); !to.empty())
            write_hello(to, first_byte(Kind::relay_hello, 0), 0, nonce);
        return;
    }
    const Space to = outgoing.push(lobby, packet_bytes_max);
    if (to.empty()) return;
    write_cookie(to, first_byte(Kind::lobby_request, 0), nonce, cookie);
    std::ranges::copy(public_key_of(secret).bytes, to.begin() + cookie_bytes);
    std::array<std::byte, lobby_request_plain> plain{};
    plain[0] = static_cast<std::byte>(players);
    std::ranges::copy(std::as_bytes(std::span(asked)), plain.begin() + 1);
    seal_with_nonce(to.subspan(lobby_request_head), plain, to.first(lobby_request_head), keys->send);
}

void LobbyClient::Impl::take_answer(Bytes datagram) {
    std::array<std::byte, lobby_answer_plain> plain;
    if (!open_with_nonce(plain, datagram.subspan(lobby_answer_head), datagram.first(lobby_answer_head),
                         keys->receive))
        return;
    answered_ms = now;
    base::ByteReader in(plain, "lobby answer");
    const auto status = static_cast<LobbyStatus>(in.u8("status"));
    in.u8("members");
    const Bytes named = in.bytes(code_letters, "code");
    const Bytes sealed = in.bytes(in.u16("token length"), "token");
    if (status > LobbyStatus::ready) {
        refusal = sentence_of(status);
        return;
    }
    code.assign(reinterpret_cast<const char*>(named.data()), named.size());
    if (status == LobbyStatus::waiting) return;
    auto opened = open_token(sealed, keys->receive, now);
    if (!opened) {
        refusal = opened.error().message;
        return;
    }
    opened->secret = secret;
    if (opened->pass.empty()) { // a place at a door, which has the address of its lobby
        opened->addresses = {};
        opened->addresses[0] = lobby;
        token = std::move(*opened);
        return;
    }
    opened->relay = lobby;
    if (opened->second_relay.address == lobby) opened->second_relay = {}; // the lobby has named itself
    token = std::move(*opened);
}

void LobbyClient::receive(const NetAddress& from, std::span<const std::byte> datagram, std::uint64_t now_ms) {
    impl->now = std::max(impl->now, now_ms);
    if (from != impl->lobby || length_fault(datagram) || impl->token || !impl->refusal.empty()) return;
    const Kind kind = kind_of(datagram[0]);
    if (kind != Kind::relay_cookie && kind != Kind::lobby_answer) return;
    const Cookie answer = read_cookie(datagram);
    if (answer.version != net_version || answer.nonce != impl->nonce) return;
    if (kind == Kind::lobby_answer) return impl->take_answer(datagram);
    const bool is_first = !impl->has_cookie;
    impl->cookie = answer.cookie, impl->cookie_ms = impl->now, impl->has_cookie = true;
    if (is_first) impl->ask();
}

void LobbyClient::poll(std::uint64_t now_ms) {
    impl->now = std::max(impl->now, now_ms);
    const bool is_done = impl->token || !impl->refusal.empty();
    if (is_done || (impl->asked_ms != 0 && impl->now - impl->asked_ms < ask_every_ms)) return;
    impl->asked_ms = impl->now;
    impl->ask();
}

std::optional<OutgoingDatagram> LobbyClient::next_outgoing() {
    const auto* entry = impl->outgoing.pop();
    if (!entry) return {};
    return OutgoingDatagram{entry->label, impl->outgoing.bytes_of(*entry)};
}

const std::string& LobbyClient::code() const { return impl->code; }
const std::optional<ConnectToken>& LobbyClient::token() const { return impl->token; }
std::uint64_t LobbyClient::answered_ms() const { return impl->answered_ms; }
const std::string& LobbyClient::refusal() const { return impl->refusal; }

} // namespace lockstone
