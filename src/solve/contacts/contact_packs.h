// Groups contacts into packs, which lanes solve at once, and packs into strands, which workers solve side by side.
//
//   pack     contacts that move different bodies. A contact is in a later pack than each contact before it in
//            the order that moves one of its bodies: so solving pack after pack is solving in order. Apart from this
//            rule a pack takes any ready contacts, which gives fewer packs than packs of one stage of the order each
//   strand   the packs of a share of the contacts (contact_cut.h), which one worker solves. A pack waits for a pack of
//            another strand that moves one of its bodies earlier in the order. Bits do not depend on the shares:
//            contacts that move the same body are still solved in order
//   piece    consecutive packs of a strand. Only its first pack waits for packs of other strands, and they wait only
//            for its last pack
//
// Where only contacts change velocities in a tick, its passes are one run of strands. The strand of the last contact
// that moves a body also does the steps of this body between two passes, after the piece that has this contact; in the
// next pass the first contact that moves the body waits for these steps.
#pragma once

#include "base/paths.h"
#include "base/strands.h"
#include "lockstone/math/vec.h"
#include "solve/bodies/solving_order.h"
#include "solve/contacts/contact_cut.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lockstone::solve {

class ContactOrder;

class ContactPacks {
  public:
    void reserve(std::size_t contacts, std::size_t bodies);
    struct Wanted {
        /// workers: the largest number of strands, where strands are not islands
        std::uint32_t lanes, workers;
        bool may_run_all;       ///< only contacts change velocities: passes may be one run
        std::size_t pack_bytes; ///< size of one pack
        bool operator==(const Wanted&) const = default;
    };
    /// Packs the contacts of an order, in strands where they save time. Keeps the packs of the last call while they are
    /// valid. `poses`: by body that can move.
    void make(const ContactOrder& order, const Wanted& wanted, std::span<const Transform> poses);

    static constexpr std::uint32_t no_contact = 0xffffffffu;
    /// The contact of each lane of each pack, strand after strand; unused lanes have `no_contact`.
    std::span<const std::uint32_t> contact_of_lane() const { return packed; }
    /// The pieces. The plan has no strands where one worker solves all packs of a pass.
    const base::StrandPlan& plan() const { return pieces; }
    /// True if all passes of a tick are one run.
    bool runs_all_passes() const { return runs_all; }
    /// True if in addition no strand waits for another: each strand is one piece.
    bool has_islands() const { return runs_all && by_island; }
    /// Where all passes are one run: the bodies whose steps between passes follow a piece. All pieces together have
    /// each body that impulses move once.
    std::span<const std::uint32_t> bodies_after(base::PieceAt at) const {
        const std::uint32_t* const first = &strands[at.strand].first_body[at.index];
        return std::span(bodies).subspan(first[0], first[1] - first[0]);
    }

    /// The first contact that a pack, a strand or a wait takes out of the order, in a sentence; empty if there is none.
    /// `order`: the argument of make().
    std::string order_fault(const ContactOrder& order) const;

    void poison(std::byte with);

    base::Paths paths; ///< of the tick

  private:
    /// of contacts: one point or several, carried an impulse or not
    static constexpr std::uint32_t sorts = 4;
    /// The state of a contact while packs are made; a cache line has two nodes.
    struct Node {
        std::uint32_t after_a, after_b;   ///< the next contacts that move its bodies, or no_contact
        std::uint32_t before_a, before_b; ///< the last contacts before it that move its bodies, or no_contact
        std::uint32_t next;               ///< the next contact of the same queue
        std::uint32_t pack;               ///< its pack in its strand
        /// the first round in which it may be packed; before packing, the length of the longest chain that ends with it
        std::uint32_t round;
        std::uint8_t strand, sort;
        std::uint8_t waits; ///< number of its direct predecessors that are in no pack so far
        bool waits_between; ///< it waits for a step between passes that another strand does
    };
    struct Queue {
        std::uint32_t count = 0, front = 0, back = 0;
    };
    struct Strand {
        Queue ready[sorts]; ///< by sort, in the order in which contacts became ready
        Queue late;         ///< contacts that become ready in a later round
        Queue held;         ///< ready, but held back because in each pass they wait for another strand
        std::uint32_t held_until = 0; ///< first round in which `held` may be packed
        /// by strand: the number of its packs that this strand already waits for
        std::vector<std::uint32_t> seen;
        std::vector<std::uint32_t> packed; ///< contact by lane
        std::vector<std::uint32_t> round_of_pack;
        /// By number of packs: while pieces are cut, 1 where a piece ends; then the number of pieces up to there.
        std::vector<std::uint32_t> pieces_to;
        std::vector<std::uint32_t> first_body; ///< by piece, and the end: index into `bodies`

        std::uint32_t packs() const { return static_cast<std::uint32_t>(round_of_pack.size()); }
    };
    /// Pack `pack` of strand `strand` waits for the first `packs` packs of strand `other`, of the same pass, or of the
    /// pass before if `is_between`.
    struct Wait {
        std::uint32_t strand, pack, other, packs;
        bool is_between;
    };

    bool serve(const ContactOrder& order, const Wanted& wanted) const;
    void note_strands() const; ///< counts them in `paths`
    void share_out(const ContactOrder& order, const Wanted& wanted, std::uint32_t longest,
                   std::span<const Transform> poses);
    std::uint32_t find_nodes(const ContactOrder& order);
    void find_waits_between_passes(const ContactOrder& order, std::uint32_t lanes);
    void list_bodies(const ContactOrder& order);
    void pack_all(const ContactOrder& order, std::uint32_t lanes);
    void add(Queue& queue, std::uint32_t contact);
    std::uint32_t take_front(Queue& queue);
    bool fill_pack(Strand& own, std::uint32_t lanes, std::uint32_t round);
    void let_follow(std::uint32_t contact, std::uint32_t strand, std::uint32_t round);
    void wait_for(std::uint32_t before, std::uint32_t strand, std::uint32_t pack);
    bool waits_between(std::uint32_t body, std::uint32_t before, std::uint32_t strand) const;
    void cut_pieces();
    void add_waits();

    // The inputs of the packs:
    std::uint64_t made_of = ~std::uint64_t{0}; ///< version of the order
    Wanted made{};

    bool runs_all = false, by_island = false;
    ContactCut cut;
    std::uint32_t strand_count = 1;
    std::uint32_t grace = 0; ///< additional rounds before a contact that follows a contact of another strand
    std::vector<Node> nodes; ///< by contact
    std::vector<std::uint32_t> last; ///< by body: one more than the index of its latest contact; 0: none
    Strand strands[base::strands_max];
    std::vector<Wait> waits;
    std::vector<std::uint32_t> packed;
    std::vector<std::uint32_t> bodies; ///< of bodies_after(), strand after strand
    base::StrandPlan pieces;
};

/// The contacts in the order in which packs solve them, from ContactPacks::contact_of_lane().
CheckVector<Solved> solved_in_packs(const ContactOrder& order, std::span<const std::uint32_t> contact_of_lane,
                                    std::uint32_t lanes);

} // namespace lockstone::solve
