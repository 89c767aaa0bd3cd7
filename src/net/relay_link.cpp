// An endpoint's way into a relay: hello, cookie, request with the pass, accept; again after silence.
#include "net/endpoint.h"

#include "base/bytes.h"

namespace lockstone {

using namespace net;

namespace {

constexpr std::uint64_t retry_ms = 250, attempt_ms = 10'000, cookie_kept_ms = 3000;

} // namespace

void Endpoint::Impl::poll_relay() {
    if (relay.is_in && now - relay.heard_ms <= def.silence_ms) return;
    Attempt& attempt = relay.attempt;
    if (!attempt.runs || now - attempt.started_ms > attempt_ms)
        attempt = {.nonce = random_u64(), .started_ms = now, .secret = {}, .runs = true};
    else if (now - attempt.tried_ms < retry_ms)
        return;
    attempt.tried_ms = now;
    if (attempt.has_cookie && now - attempt.cookie_ms < cookie_kept_ms) return send_relay_request();
    if (const Space to = push(token.relay, hello_bytes); !to.empty())
        write_hello(to, first_byte(Kind::relay_hello, token.slot), 0, attempt.nonce);
}

void Endpoint::Impl::send_relay_request() {
    const Space to = push(token.relay, relay_request_bytes);
    if (to.empty()) return;
    write_cookie(to, first_byte(Kind::relay_request, token.slot), relay.attempt.nonce, relay.attempt.cookie);
    std::ranges::copy(token.pass, to.begin() + cookie_bytes);
    std::ranges::copy(authenticator(token.relay_key, to.first(relay_request_bytes - tag_bytes)),
                      to.end() - tag_bytes);
}

Endpoint::Impl::Fault Endpoint::Impl::take_from_relay(const NetAddress& from, Bytes datagram) {
    if (!has_relay() || from != token.relay) return NetFault::stranger;
    const Cookie answer = read_cookie(datagram);
    if (answer.version != net_version) return NetFault::version;
    Attempt& attempt = relay.attempt;
    if (!attempt.runs || answer.nonce != attempt.nonce) return NetFault::unexpected;
    if (kind_of(datagram[0]) == Kind::relay_cookie) {
        const bool is_first = !attempt.has_cookie;
        attempt.cookie = answer.cookie, attempt.cookie_ms = now, attempt.has_cookie = true;
        if (is_first) send_relay_request();
        return {};
    }
    const Bytes head = datagram.first(relay_accept_bytes - tag_bytes);
    if (!same(authenticator(token.relay_key, head), datagram.last(tag_bytes)))
        return NetFault::unauthenticated;
    relay.is_in = true, relay.heard_ms = now, attempt = {};
    return {};
}

} // namespace lockstone
