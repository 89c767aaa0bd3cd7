// Pairs of shapes that may collide and are near each other.
#pragma once

#include "collide/broad/broad_phase.h"
#include "scene/placed_shapes.h"
#include "tick/contact_result.h"

#include <vector>

namespace lockstone::sim {

/// Two shapes that may collide and are near each other, with their rows of the last tick's contact table.
struct NearPair {
    ContactKey key;
    Length margin; ///< the distance within which the two get contacts [m]
    std::uint32_t old_first, old_count;
    /// The direction that separated the two when they were last compared, in the axes of the narrow phase's A. Zero:
    /// unknown.
    UnitVec3 apart;
};

/// Output of find_pairs().
struct NearPairs {
    std::vector<NearPair> list;       ///< in pair order
    bool is_cut = false;              ///< there were more near pairs than the limit
    std::vector<ContactResult> ended; ///< of pairs that touched in the last tick and are no longer near
};

/// The pairs of bodies that joints keep from colliding: are_joined() by body slots, without a walk over rows of
/// joints.
class JoinedBodies {
  public:
    void reserve(const WorldRows& rows);
    /// Updates the table; cheap while no joint was created, removed or changed. Returns true if other bodies are
    /// joined than at the last call.
    bool find(const Model& w);
    bool contain(std::uint32_t slot_a, std::uint32_t slot_b) const {
        const bool may = ((bits[slot_a] >> slot_b % 64 & bits[slot_b] >> slot_a % 64) & 1u) != 0;
        return may && has_partner(slot_a, slot_b);
    }

  private:
    bool has_partner(std::uint32_t slot_a, std::uint32_t slot_b) const;

    std::vector<std::uint64_t> bits; ///< by body slot: bit (partner's slot modulo 64) is set for each partner
    /// The partners of slot s are partners[first[s]] up to, without, partners[first[s + 1]].
    std::vector<std::uint32_t> first, partners, first_before, partners_before;
    // The state of the columns from which the table was made
    ChangeMark seen;
    std::vector<RowRange> changed; ///< scratch memory
};

/// Scratch memory of find_pairs().
struct PairScratch {
    std::vector<collide::ProxyPair> pairs, plane_pairs, merged_pairs;
    std::vector<std::uint64_t> at_plane; ///< one bit per shape slot: the shape is near the present plane
    struct Key {
        /// null: both bodies rest, or the two shapes are further apart than the margin
        ContactKey key;
        Length margin; ///< the distance within which the two get contacts [m]
    };
    std::vector<Key> keys;                  ///< by pair
    std::vector<std::uint32_t> near_counts; ///< by chunk of keys: near pairs in it, then in those before
    std::vector<std::vector<ContactResult>> ended; ///< by chunk: NearPairs::ended
    std::vector<NearPair> before; ///< those of the last tick, the source of hints, which change speed only
    JoinedBodies joined;
    ChangeMark filters_of; ///< the state of the columns from which the broad phase's filter results come
    std::vector<RowRange> changed;
    base::Paths paths; ///< of the tick

    void reserve(const WorldRows& rows) { joined.reserve(rows); }
};

/// Finds shapes that may collide and are near each other, in pair order, with their rows of the contact table `old`.
void find_pairs(const Model& w, PlacedShapes& placed, const ContactList& old, PairScratch& scratch,
                NearPairs& out, Tasks* tasks);

} // namespace lockstone::sim
