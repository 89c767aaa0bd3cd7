// Contacts in packs, which lanes solve at once, and packs in strands, which workers solve side by side.
//
//   pack     contacts of which no two move the same body. A contact is in a later pack than each one before it in order that moves one of its
//            bodies: solving pack after pack is solving in order. Beyond that a pack takes what is ready: a pyramid of base 40 has a tenth
//            fewer packs than if each held contacts of one stage of the order alone
//   strand   the packs of contacts in one part of space. Workers solve a strand each. Where a body lies at the border, a pack waits for that one of
//            the other strand which moves the body before it. Bits do not depend on where the borders are: whatever moves the same body
//            still comes in order
//   piece    packs of a strand that follow one another, none of which waits but the first, and is waited for but the last
#pragma once

#include "base/strands.h"
#include "lockstone/math/vec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

class ContactOrder;

class ContactPacks {
  public:
    void reserve(std::size_t contacts, std::size_t bodies);
    /// Packs the contacts of an order, in at most so many strands: fewer where there are few contacts, or where most follow one another. Packs of
    /// the last order serve again while it is the same. `poses`: by body that can move.
    void make(const ContactOrder& order, std::uint32_t lanes, std::uint32_t strands_most,
              std::span<const Transform> poses);

    static constexpr std::uint32_t no_contact = 0xffffffffu;
    /// The contact of each lane of each pack, strand after strand; lanes that are left over have `no_contact`.
    std::span<const std::uint32_t> contact_of_lane() const { return packed; }
    /// Pieces of packs for several workers. Without strands where one is to solve all packs.
    const base::StrandPlan& plan() const { return pieces; }

    void poison(std::byte with);

  private:
    static constexpr std::uint32_t sorts = 4; ///< of contacts: several points or one, carried or did not
    /// What is known of a contact; a cache line has two.
    struct Node {
        std::uint32_t after_a, after_b;   ///< the next contacts that move its bodies, or no_contact
        std::uint32_t before_a, before_b; ///< the last ones before it
        std::uint32_t next;               ///< of the same queue
        std::uint32_t pack;               ///< of its strand
        std::uint32_t round;              ///< not before; at first how many follow one another up to it
        std::uint8_t strand, sort;
        std::uint8_t waits; ///< for so many contacts that are in no pack so far
    };
    struct Queue {
        std::uint32_t count = 0, front = 0, back = 0;
    };
    struct Strand {
        Queue ready[sorts];                         ///< of each sort in the order in which they became so
        Queue late;                                 ///< ready in a later round
        std::uint32_t seen[base::strands_max] = {}; ///< for so many packs of other strands it has waited
        std::vector<std::uint32_t> packed;          ///< contact by lane
        std::vector<std::uint32_t> round_of_pack;
        /// By number of packs: 1 where a piece ends, then pieces up to there.
        std::vector<std::uint32_t> piece_end;
    };
    /// Pack `pack` of strand `strand` is to wait for so many packs of another one.
    struct Wait {
        std::uint32_t strand, pack, other, packs;
    };

    bool serve(const ContactOrder& order, std::uint32_t lanes, std::uint32_t strands_most) const;
    void share_out(const ContactOrder& order, std::span<const Transform> poses);
    std::uint32_t find_nodes(const ContactOrder& order);
    void pack_all(const ContactOrder& order, std::uint32_t lanes);
    void add(Queue& queue, std::uint32_t contact);
    std::uint32_t take_front(Queue& queue);
    bool fill_pack(Strand& own, std::uint32_t lanes, std::uint32_t round);
    void let_follow(std::uint32_t contact, std::uint32_t strand, std::uint32_t round);
    void wait_for(std::uint32_t before, std::uint32_t strand, std::uint32_t pack);
    void cut_pieces();

    /// What the packs were made for.
    struct Made {
        std::uint64_t order = ~std::uint64_t{0}; ///< its version
        std::uint32_t lanes = 0, strands_most = 0;
        bool operator==(const Made&) const = default;
    };
    Made made;
    std::uint32_t strand_count = 1;
    std::uint32_t grace = 0;         ///< rounds
    std::vector<Node> nodes;         ///< by contact
    std::vector<std::uint32_t> last; ///< by body: one more than its latest contact; 0: none
    Strand strands[base::strands_max];
    std::vector<Wait> waits; ///< by round, and of a round by strand
    std::vector<std::uint32_t> packed;
    base::StrandPlan pieces;
};

} // namespace lockstone::solve
