// A state on its way to a machine that has none: cut into chunks, each of which proves itself.
//
//   root = H(tick, hash of the state, bytes, H(H(H(chunk 0), H(chunk 1)), H(H(chunk 2), H(chunk 3))...))
//
// A chunk comes with the hashes beside its way up the tree (Merkle, "A Digital Signature Based on a Conventional Encryption
// Function", 1987), so that it is judged when it arrives, in whatever order. That the state itself is the right one, its hash
// decides, which other machines tell too: see spectator.h. XXH3 finds accidents and plain lies; whoever searches for another
// state with the same 64 bits is not stopped by it.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

inline constexpr std::size_t chunk_bytes = 960;
inline constexpr std::uint32_t state_bytes_limit = 64u << 20; ///< of any offer

/// What a host has to give: the state before a tick, as a portable image.
struct Offer {
    std::uint64_t tick = 0;
    std::uint64_t hash = 0; ///< of the state, as State::hash gives it
    std::uint64_t root = 0; ///< of the tree over the chunks
    std::uint32_t bytes = 0;

    std::uint32_t chunks() const {
        return static_cast<std::uint32_t>((bytes + chunk_bytes - 1) / chunk_bytes);
    }
    friend bool operator==(const Offer&, const Offer&) = default;
};
struct Chunk {
    std::uint64_t tick = 0;
    std::uint32_t index = 0;
    std::vector<std::uint64_t> proof; ///< the hashes beside its way, from the bottom
    std::span<const std::byte> bytes;
};

/// The host's side.
class Snapshot {
  public:
    /// `image` is not empty, and at most state_bytes_limit long (asserted).
    Snapshot(std::uint64_t tick, std::uint64_t hash, std::vector<std::byte> image);
    const Offer& offer() const { return offered; }
    void chunk(std::uint32_t index, Chunk& out) const; ///< below offer().chunks()

  private:
    Offer offered;
    std::vector<std::byte> image;
    std::vector<std::vector<std::uint64_t>> levels; ///< of the tree, from the chunks to the top
};

/// Longest time that a host may take for a whole state, given the number of received chunks. It sends two chunks a poll.
inline std::uint32_t polls_for_state(std::uint32_t chunks_here) { return 600 + 8 * chunks_here; }

/// Accepted distance of a chunk from the first missing one: the bits of a request cover as many.
inline constexpr std::uint32_t chunks_ahead = 64;

/// The receiver's side: takes chunks of one offer. Its memory is that of the chunks that are here, and a bit for each: an offer alone costs
/// nothing.
class Assembly {
  public:
    Assembly() = default;
    explicit Assembly(const Offer& offer);
    const Offer& offer() const { return offered; }
    /// False: it is not of this offer, is not what the root says, is here already, or lies more than chunks_ahead beyond the first that is
    /// missing; then nothing has changed.
    bool take(const Chunk& chunk);
    std::uint32_t missing() const { return first_missing; } ///< the first chunk that is
    std::uint64_t have_after_missing() const;               ///< bit i: chunk missing() + 1 + i is here
    bool is_complete() const { return first_missing == offered.chunks(); }
    std::span<const std::byte> image() const { return bytes; }

  private:
    bool has(std::uint32_t chunk) const { return chunk < have.size() && have[chunk]; }

    Offer offered;
    std::vector<std::byte> bytes; ///< up to the last chunk that is here
    std::vector<bool> have;       ///< by chunk, up to the last received one
    std::uint32_t first_missing = 0;
};

} // namespace lockstone::session
