#include "net/crypto.h"

#include "base/assert.h"
#include "base/bytes.h"

#include <sodium.h>

namespace lockstone::net {
namespace {

/// Initialises libsodium once; it then chooses code for the present processor.
void start() {
    static const int started = sodium_init();
    LOCKSTONE_ASSERT(started >= 0, "libsodium does not start");
}

const unsigned char* in(Bytes bytes) { return reinterpret_cast<const unsigned char*>(bytes.data()); }
unsigned char* out(Space bytes) { return reinterpret_cast<unsigned char*>(bytes.data()); }
const unsigned char* in(const NetKey& key) { return in(Bytes(key.bytes)); }
unsigned char* out(NetKey& key) { return out(Space(key.bytes)); }

using CounterNonce = std::array<unsigned char, crypto_aead_chacha20poly1305_ietf_NPUBBYTES>;
CounterNonce nonce_of(std::uint64_t counter) {
    CounterNonce nonce{};
    base::store_little_endian(counter, reinterpret_cast<std::byte*>(nonce.data()) + 4);
    return nonce;
}

} // namespace

void fill_random(Space to) {
    start();
    randombytes_buf(to.data(), to.size());
}

std::uint64_t random_u64() {
    std::array<std::byte, 8> bytes;
    fill_random(bytes);
    return base::load_little_endian<std::uint64_t>(bytes.data());
}

std::optional<DirectedKeys> agree(Role role, const NetKey& own_secret, const NetKey& their_public) {
    DirectedKeys keys;
    const NetKey own_public = public_key_of(own_secret);
    const auto exchange =
        role == Role::initiator ? crypto_kx_client_session_keys : crypto_kx_server_session_keys;
    if (exchange(out(keys.receive), out(keys.send), in(own_public), in(own_secret), in(their_public)) != 0)
        return {};
    return keys;
}

NetKey derived(const NetKey& key, Bytes context) {
    NetKey made;
    crypto_generichash(out(made), made.bytes.size(), in(context), context.size(), in(key), key.bytes.size());
    return made;
}

std::array<std::byte, tag_bytes> authenticator(const NetKey& key, Bytes message) {
    std::array<std::byte, tag_bytes> made;
    crypto_generichash(out(made), made.size(), in(message), message.size(), in(key), key.bytes.size());
    return made;
}

bool same(Bytes a, Bytes b) {
    return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

std::uint64_t short_hash(const NetKey& key, Bytes message) {
    std::array<std::byte, crypto_shorthash_BYTES> made;
    crypto_shorthash(out(made), in(message), message.size(), in(key));
    return base::load_little_endian<std::uint64_t>(made.data());
}

void seal(Space to, Bytes message, Bytes header, std::uint64_t counter, const NetKey& key) {
    LOCKSTONE_ASSERT(to.size() == message.size() + tag_bytes, to.size(), " bytes for ", message.size());
    crypto_aead_chacha20poly1305_ietf_encrypt(out(to), nullptr, in(message), message.size(), in(header),
                                              header.size(), nullptr, nonce_of(counter).data(), in(key));
}

bool open(Space to, Bytes sealed, Bytes header, std::uint64_t counter, const NetKey& key) {
    if (sealed.size() < tag_bytes || to.size() != sealed.size() - tag_bytes) return false;
    const int refused = crypto_aead_chacha20poly1305_ietf_decrypt(out(to), nullptr, nullptr, in(sealed),
                                                                  sealed.size(), in(header), header.size(),
                                                                  nonce_of(counter).data(), in(key));
    return refused == 0;
}

void seal_with_nonce(Space to, Bytes message, Bytes header, const NetKey& key) {
    LOCKSTONE_ASSERT(to.size() == message.size() + sealed_extra_bytes, to.size(), " bytes for ",
                     message.size());
    fill_random(to.first(nonce_bytes));
    crypto_aead_xchacha20poly1305_ietf_encrypt(out(to.subspan(nonce_bytes)), nullptr, in(message),
                                               message.size(), in(header), header.size(), nullptr, in(to),
                                               in(key));
}

bool open_with_nonce(Space to, Bytes sealed, Bytes header, const NetKey& key) {
    if (sealed.size() < sealed_extra_bytes || to.size() != sealed.size() - sealed_extra_bytes) return false;
    const Bytes cipher = sealed.subspan(nonce_bytes);
    const int not_authentic = crypto_aead_xchacha20poly1305_ietf_decrypt(
        out(to), nullptr, nullptr, in(cipher), cipher.size(), in(header), header.size(), in(sealed), in(key));
    return not_authentic == 0;
}

} // namespace lockstone::net

namespace lockstone {

NetKey random_key() {
    NetKey key;
    net::fill_random(key.bytes);
    return key;
}

NetKey public_key_of(const NetKey& secret) {
    net::start();
    NetKey made;
    crypto_scalarmult_base(net::out(made), net::in(secret));
    return made;
}

Result<NetKey> parse_key(std::string_view text) {
    net::start();
    NetKey key;
    std::size_t length = 0;
    if (text.size() != 64 ||
        sodium_hex2bin(net::out(key), key.bytes.size(), text.data(), text.size(), nullptr, &length,
                       nullptr) != 0 ||
        length != key.bytes.size())
        return Error{"a key is 64 hexadecimal digits"};
    return key;
}

std::string to_string(const NetKey& key) {
    std::array<char, 65> text;
    return sodium_bin2hex(text.data(), text.size(), net::in(key), key.bytes.size());
}

} // namespace lockstone
