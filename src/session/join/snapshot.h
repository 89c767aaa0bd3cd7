// Transfer of a state to a machine without one, in chunks that each carry a proof.
//
//   root = H(tick, hash of the state, bytes, H(H(H(chunk 0), H(chunk 1)), H(H(chunk 2), H(chunk 3))...))
//
// A chunk carries the sibling hashes on its path to the root (Merkle, "A Digital Signature Based on a Conventional
// Encryption Function", 1987), so the receiver can check it on arrival, in any order. The hash of the state, which
// other machines report too, shows that the state itself is the right one: see spectator.h. XXH3 detects accidents and
// plain lies, but no attack with a specially computed state with the same 64 bits.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

/// Maximum length of the content of a chunk [bytes].
inline constexpr std::size_t chunk_bytes = 960;
inline constexpr std::uint32_t state_bytes_limit = 64u << 20; ///< maximum length of an offered state [bytes]

/// Announcement of a state before a tick, as a portable image.
struct Offer {
    std::uint64_t tick = 0;
    std::uint64_t hash = 0; ///< State::hash()
    std::uint64_t root = 0; ///< root of the tree over the chunks
    /// Length of the portable image [bytes].
    std::uint32_t bytes = 0;

    std::uint32_t chunks() const {
        return static_cast<std::uint32_t>((bytes + chunk_bytes - 1) / chunk_bytes);
    }
    friend bool operator==(const Offer&, const Offer&) = default;
};
/// A part of a state.
struct Chunk {
    std::uint64_t tick = 0;
    std::uint32_t index = 0;
    std::vector<std::uint64_t> proof; ///< sibling hashes on the path to the root, from the chunk upwards
    std::span<const std::byte> bytes;
};

/// The host's side: a state with its tree of hashes.
class Snapshot {
  public:
    /// `image`: 1 to state_bytes_limit bytes; another length ends the program.
    Snapshot(std::uint64_t tick, std::uint64_t hash, std::vector<std::byte> image);
    const Offer& offer() const { return offered; }
    /// Fills `out` with chunk `index` < chunks(), a view of this snapshot.
    void chunk(std::uint32_t index, Chunk& out) const;

  private:
    Offer offered;
    std::vector<std::byte> image;
    /// Hashes of the tree, from the chunks upwards, without the top.
    std::vector<std::vector<std::uint64_t>> levels;
};

/// Maximum time for the transfer of a whole state [polls], given the number of received chunks. A host
/// sends two chunks a poll.
inline std::uint32_t polls_for_state(std::uint32_t chunks_here) { return 600 + 8 * chunks_here; }

/// Maximum distance of an accepted chunk from the first missing one: a request has one bit for each of
/// them.
inline constexpr std::uint32_t chunks_ahead = 64;

/// The receiver's side: collects the chunks of one offer. It allocates memory only for chunks that have
/// arrived, and a bit for each, so an offer alone costs no memory.
class Assembly {
  public:
    Assembly() = default;
    explicit Assembly(const Offer& offer);
    const Offer& offer() const { return offered; }
    /// Adds a chunk. Returns false, without a change, if the chunk belongs to another offer, contradicts
    /// the root, has arrived before, or is more than chunks_ahead beyond the first missing one.
    bool take(const Chunk& chunk);
    std::uint32_t missing() const { return first_missing; } ///< the first missing chunk
    std::uint64_t have_after_missing() const;               ///< bit i: chunk missing() + 1 + i has arrived
    bool is_complete() const { return first_missing == offered.chunks(); }
    std::span<const std::byte> image() const { return bytes; }

  private:
    bool has(std::uint32_t chunk) const { return chunk < have.size() && have[chunk]; }

    Offer offered;
    std::vector<std::byte> bytes; ///< up to the last chunk that has arrived
    std::vector<bool> have;       ///< [chunk] up to the last chunk that has arrived
    std::uint32_t first_missing = 0;
};

} // namespace lockstone::session
