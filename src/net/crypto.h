// The cryptographic functions of this folder. crypto.cpp is the only file of the library that includes
// sodium.h.
#pragma once

#include "lockstone/net.h"

namespace lockstone::net {

inline constexpr std::size_t tag_bytes = 16;
inline constexpr std::size_t nonce_bytes = 24; ///< of XChaCha20: long enough for random nonces
inline constexpr std::size_t sealed_extra_bytes = nonce_bytes + tag_bytes;

using Bytes = std::span<const std::byte>;
using Space = std::span<std::byte>;

void fill_random(Space to);
std::uint64_t random_u64();

/// The keys of the two directions between two machines.
struct DirectedKeys {
    NetKey send, receive;
};
enum class Role : std::uint8_t { initiator, responder };
/// Key agreement: X25519, then BLAKE2b over the secret and both public keys (crypto_kx of libsodium).
/// Empty: a public key of low order.
std::optional<DirectedKeys> agree(Role role, const NetKey& own_secret, const NetKey& their_public);
/// BLAKE2b-256 of `context` with a key.
NetKey derived(const NetKey& key, Bytes context);
/// BLAKE2b-128 of `message` with a key. It can be computed only with the key.
std::array<std::byte, tag_bytes> authenticator(const NetKey& key, Bytes message);
bool same(Bytes a, Bytes b); ///< True if equal. Takes constant time for a length.
/// SipHash-2-4 with the first half of a key.
std::uint64_t short_hash(const NetKey& key, Bytes message);

/// Encrypts with ChaCha20-Poly1305 (RFC 8439). `counter` is the nonce: never use it twice with a key. `to`:
/// message.size() + tag_bytes bytes.
void seal(Space to, Bytes message, Bytes header, std::uint64_t counter, const NetKey& key);
/// Decrypts. `to`: sealed.size() - tag_bytes bytes. False: not authentic, or a wrong length.
bool open(Space to, Bytes sealed, Bytes header, std::uint64_t counter, const NetKey& key);

/// Encrypts with XChaCha20-Poly1305: a random nonce, then the ciphertext. `to`: message.size() +
/// sealed_extra_bytes bytes.
void seal_with_nonce(Space to, Bytes message, Bytes header, const NetKey& key);
/// Decrypts. `to`: sealed.size() - sealed_extra_bytes bytes. False: not authentic, or a wrong length.
bool open_with_nonce(Space to, Bytes sealed, Bytes header, const NetKey& key);

/// The file format of tokens and passes: a magic, the version, and a sealed part that authenticates both.
std::vector<std::byte> sealed_file(std::string_view magic, Bytes plain, const NetKey& key);

} // namespace lockstone::net
