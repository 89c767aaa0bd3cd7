// Pairs of shapes that may meet and are near.
#pragma once

#include "collide/broad/broad_phase.h"
#include "scene/placed_shapes.h"
#include "tick/contact_result.h"

#include <vector>

namespace lockstone::sim {

/// Two shapes that may meet and are near, with their rows of the last tick's contact table.
struct NearPair {
    ContactKey key;
    Length margin; ///< how far ahead contacts of the two reach
    std::uint32_t old_first, old_count;
    /// What parted them when last looked at, in the axes of the narrow phase's A; zero: nothing known
    UnitVec3 apart;
};

/// What find_pairs() finds.
struct NearPairs {
    std::vector<NearPair> list;       ///< in pair order
    bool is_cut = false;              ///< there were more such pairs than are looked at
    std::vector<ContactResult> ended; ///< of pairs that touched and are no longer near
};

/// Which bodies joints hold together without letting them touch: are_joined() by slots, without a walk over rows of joints.
class JoinedBodies {
  public:
    void reserve(const WorldRows& rows);
    /// Cheap while no joint has come, gone or changed. Whether others are joined than in the last call.
    bool find(const Model& w);
    bool contain(std::uint32_t slot_a, std::uint32_t slot_b) const {
        const bool may = ((bits[slot_a] >> slot_b % 64 & bits[slot_b] >> slot_a % 64) & 1u) != 0;
        return may && has_partner(slot_a, slot_b);
    }

  private:
    bool has_partner(std::uint32_t slot_a, std::uint32_t slot_b) const;

    std::vector<std::uint64_t> bits; ///< by body slot: its partners' slots modulo 64
    /// The partners of slot s are partners[first[s]] to before partners[first[s + 1]].
    std::vector<std::uint32_t> first, partners, first_before, partners_before;
    // What it was made of
    ChangeMark seen;
    std::vector<RowRange> changed; ///< memory
};

/// Its memory.
struct PairScratch {
    std::vector<collide::ProxyPair> pairs, plane_pairs, merged_pairs;
    std::vector<std::uint64_t> at_plane; ///< bit per shape slot: near one plane
    struct Key {
        /// null: the two do not meet, or both rest, or they are further apart than the margin
        ContactKey key;
        Length margin; ///< how far ahead contacts of the two reach
    };
    std::vector<Key> keys;                         ///< by pair
    std::vector<std::uint32_t> near_counts;        ///< by chunk of keys: how many there are before it
    std::vector<std::vector<ContactResult>> ended; ///< by chunk: NearPairs::ended
    std::vector<NearPair> before; ///< gives the next ones their hints, which change speed only
    JoinedBodies joined;
    ChangeMark filters_of; ///< what the broad phase's filter was made of
    std::vector<RowRange> changed;
    base::Paths paths; ///< of the tick

    void reserve(const WorldRows& rows) { joined.reserve(rows); }
};

/// Shapes that may meet and are near, in pair order, with their rows of the contact table `old`.
void find_pairs(const Model& w, PlacedShapes& placed, const ContactList& old, PairScratch& scratch,
                NearPairs& out, Tasks* tasks);

} // namespace lockstone::sim
