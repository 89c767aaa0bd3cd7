// The few things that this room asks of libsodium. crypto.cpp is the only file of the library that includes sodium.h.
#pragma once

#include "lockstone/net.h"

namespace lockstone::net {

inline constexpr std::size_t tag_bytes = 16;
inline constexpr std::size_t nonce_bytes = 24; ///< of XChaCha20: long enough to be drawn by chance
inline constexpr std::size_t sealed_extra_bytes = nonce_bytes + tag_bytes;

using Bytes = std::span<const std::byte>;
using Space = std::span<std::byte>;

void fill_random(Space to);
std::uint64_t random_u64();

/// Two directions between two machines.
struct DirectedKeys {
    NetKey send, receive;
};
enum class Role : std::uint8_t { initiator, responder };
/// X25519, then BLAKE2b over the secret and both public keys (libsodium's crypto_kx). Nothing for a key of low order.
std::optional<DirectedKeys> agree(Role role, const NetKey& own_secret, const NetKey& their_public);
/// BLAKE2b-256 with a key.
NetKey derived(const NetKey& key, Bytes context);
/// BLAKE2b-128 with a key: who does not know the key cannot make it.
std::array<std::byte, tag_bytes> authenticator(const NetKey& key, Bytes message);
bool same(Bytes a, Bytes b); ///< in a time that does not depend on where they differ
/// SipHash-2-4 with the first half of a key.
std::uint64_t short_hash(const NetKey& key, Bytes message);

/// ChaCha20-Poly1305 (RFC 8439), the nonce is `counter`: never twice under one key. Writes message.size() + tag_bytes.
void seal(Space to, Bytes message, Bytes header, std::uint64_t counter, const NetKey& key);
/// Writes sealed.size() - tag_bytes, or nothing and returns false when it is not authentic.
bool open(Space to, Bytes sealed, Bytes header, std::uint64_t counter, const NetKey& key);

/// XChaCha20-Poly1305: a random nonce, then the ciphertext. Writes message.size() + sealed_extra_bytes.
void seal_with_nonce(Space to, Bytes message, Bytes header, const NetKey& key);
bool open_with_nonce(Space to, Bytes sealed, Bytes header, const NetKey& key);

/// What tokens and passes are: a magic, the version, and a sealed part that is authenticated with both.
std::vector<std::byte> sealed_file(std::string_view magic, Bytes plain, const NetKey& key);

} // namespace lockstone::net
