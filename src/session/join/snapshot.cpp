#include "session/join/snapshot.h"

#include "base/assert.h"
#include "base/hash.h"

#include <algorithm>

namespace lockstone::session {

namespace {

std::uint64_t joined(std::uint64_t left, std::uint64_t right) {
    base::HashStream hash;
    hash.add(left);
    hash.add(right);
    return hash.digest();
}

/// The hash covers the index, so two chunks cannot exchange their places.
std::uint64_t leaf(std::uint32_t index, std::span<const std::byte> bytes) {
    return base::xxh3(bytes, std::uint64_t{index} + 1);
}

std::uint64_t root_of(const Offer& offer, std::uint64_t top) {
    base::HashStream hash;
    hash.add(offer.tick);
    hash.add(offer.hash);
    hash.add(std::uint64_t{offer.bytes});
    hash.add(top);
    return hash.digest();
}

std::size_t size_of(const Offer& offer, std::uint32_t index) {
    return std::min<std::size_t>(chunk_bytes, offer.bytes - index * chunk_bytes);
}

} // namespace

Snapshot::Snapshot(std::uint64_t tick, std::uint64_t hash, std::vector<std::byte> of)
    : offered{tick, hash, 0, static_cast<std::uint32_t>(of.size())}, image(std::move(of)) {
    LOCKSTONE_ASSERT(!image.empty() && image.size() <= state_bytes_limit, image.size(), " bytes");
    std::vector<std::uint64_t> level;
    for (std::uint32_t i = 0; i < offered.chunks(); ++i)
        level.push_back(leaf(i, std::span(image).subspan(i * chunk_bytes, size_of(offered, i))));
    while (level.size() > 1) {
        std::vector<std::uint64_t> above;
        for (std::size_t i = 0; i < level.size(); i += 2) // the last one of an odd number moves up unchanged
            above.push_back(i + 1 < level.size() ? joined(level[i], level[i + 1]) : level[i]);
        levels.push_back(std::move(level));
        level = std::move(above);
    }
    offered.root = root_of(offered, level.front());
}

void Snapshot::chunk(std::uint32_t index, Chunk& out) const {
    out.tick = offered.tick;
    out.index = index;
    out.proof.clear();
    std::size_t at = index;
    for (const std::vector<std::uint64_t>& level : levels) {
        if ((at ^ 1u) < level.size()) out.proof.push_back(level[at ^ 1u]);
        at /= 2;
    }
    out.bytes = std::span(image).subspan(index * chunk_bytes, size_of(offered, index));
}

Assembly::Assembly(const Offer& offer) : offered(offer) {}

bool Assembly::take(const Chunk& chunk) {
    if (chunk.tick != offered.tick || chunk.index >= offered.chunks() || has(chunk.index)) return false;
    if (chunk.index > std::uint64_t{first_missing} + chunks_ahead) return false;
    if (chunk.bytes.size() != size_of(offered, chunk.index)) return false;
    std::uint64_t hash = leaf(chunk.index, chunk.bytes);
    std::size_t at = chunk.index, used = 0;
    for (std::size_t width = offered.chunks(); width > 1; width = (width + 1) / 2, at /= 2) {
        if ((at ^ 1u) >= width) continue;
        if (used == chunk.proof.size()) return false;
        const std::uint64_t beside = chunk.proof[used++];
        hash = at % 2 == 0 ? joined(hash, beside) : joined(beside, hash);
    }
    if (used != chunk.proof.size() || root_of(offered, hash) != offered.root) return false;
    bytes.resize(std::max(bytes.size(), chunk.index * chunk_bytes + chunk.bytes.size()));
    have.resize(std::max<std::size_t>(have.size(), std::size_t{chunk.index} + 1));
    std::ranges::copy(chunk.bytes, bytes.begin() + static_cast<std::ptrdiff_t>(chunk.index * chunk_bytes));
    have[chunk.index] = true;
    while (has(first_missing)) ++first_missing;
    return true;
}

std::uint64_t Assembly::have_after_missing() const {
    std::uint64_t bits = 0;
    for (std::uint32_t i = 0; i < 64 && first_missing + 1 + i < offered.chunks(); ++i)
        bits |= std::uint64_t{has(first_missing + 1 + i)} << i;
    return bits;
}

} // namespace lockstone::session
