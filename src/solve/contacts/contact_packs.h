// Contacts in packs, which lanes solve at once, and packs in strands, which workers solve side by side.
//
//   pack     contacts of which no two move the same body. A contact is in a later pack than each one before it in order that moves one of its
//            bodies: solving pack after pack is solving in order. Beyond that a pack takes what is ready: a pyramid of base 40 has a tenth
//            fewer packs than if each held contacts of one stage of the order alone
//   strand   the packs of a share of the contacts (contact_cut.h). Workers solve a strand each. A pack waits for that one of another strand
//            which moves one of its bodies before it. Bits do not depend on how contacts are shared out: whatever moves the same body
//            still comes in order
//   piece    packs of a strand that follow one another, none of which waits but the first, and is waited for but the last
//
// Where nothing but contacts changes velocities in a tick, its passes are one run of strands. What is done to a body between two passes is done by the
// strand of the last contact that moves it, after the piece that has this contact; in the next pass the first contact that moves it waits for that.
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
        std::uint32_t lanes, workers; ///< as many strands at most, where a pass is a run
        bool may_run_all;             ///< nothing but contacts changes velocities: passes may be one run
        std::size_t pack_bytes;       ///< of a pack
        bool operator==(const Wanted&) const = default;
    };
    /// Packs the contacts of an order, in strands where they are worth their while. Packs of the last order serve again while it is the same.
    /// `poses`: by body that can move.
    void make(const ContactOrder& order, const Wanted& wanted, std::span<const Transform> poses);

    static constexpr std::uint32_t no_contact = 0xffffffffu;
    /// The contact of each lane of each pack, strand after strand; lanes that are left over have `no_contact`.
    std::span<const std::uint32_t> contact_of_lane() const { return packed; }
    /// Pieces of packs. Without strands where one worker is to solve all packs of a pass.
    const base::StrandPlan& plan() const { return pieces; }
    /// Whether all passes of a tick are to be one run.
    bool runs_all_passes() const { return runs_all; }
    /// And whether strands have nothing to do with one another: each is one piece.
    bool has_islands() const { return runs_all && by_island; }
    /// Then: the bodies to which something is done between passes after a piece. In all each body that impulses move.
    std::span<const std::uint32_t> bodies_after(base::PieceAt at) const {
        const std::uint32_t* const first = &strands[at.strand].first_body[at.index];
        return std::span(bodies).subspan(first[0], first[1] - first[0]);
    }

    /// The first contact that a pack, a strand or a wait takes out of the order, in a sentence; empty: there is none. The order is that of make().
    std::string order_fault(const ContactOrder& order) const;

    void poison(std::byte with);

    base::Paths paths; ///< of the tick

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
        bool waits_between; ///< for what another strand does between passes
    };
    struct Queue {
        std::uint32_t count = 0, front = 0, back = 0;
    };
    struct Strand {
        Queue ready[sorts];                ///< of each sort in the order in which they became so
        Queue late;                        ///< ready in a later round
        Queue held;                        ///< ready, but in each pass it would wait for another strand
        std::uint32_t held_until = 0;      ///< round
        std::vector<std::uint32_t> seen;   ///< for so many packs of other strands it has waited
        std::vector<std::uint32_t> packed; ///< contact by lane
        std::vector<std::uint32_t> round_of_pack;
        /// By number of packs: 1 where a piece ends, then pieces up to there.
        std::vector<std::uint32_t> pieces_to;
        std::vector<std::uint32_t> first_body; ///< by piece, and the end: of `bodies`

        std::uint32_t packs() const { return static_cast<std::uint32_t>(round_of_pack.size()); }
    };
    /// Pack `pack` of strand `strand` is to wait for so many packs of another one, of the same pass or of the one before.
    struct Wait {
        std::uint32_t strand, pack, other, packs;
        bool is_between;
    };

    bool serve(const ContactOrder& order, const Wanted& wanted) const;
    void note_strands() const; ///< in `paths`
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

    // What the packs were made for:
    std::uint64_t made_of = ~std::uint64_t{0}; ///< version of the order
    Wanted made{};

    bool runs_all = false, by_island = false;
    ContactCut cut;
    std::uint32_t strand_count = 1;
    std::uint32_t grace = 0;         ///< rounds
    std::vector<Node> nodes;         ///< by contact
    std::vector<std::uint32_t> last; ///< by body: one more than its latest contact; 0: none
    Strand strands[base::strands_max];
    std::vector<Wait> waits;
    std::vector<std::uint32_t> packed;
    std::vector<std::uint32_t> bodies; ///< of bodies_after(), strand after strand
    base::StrandPlan pieces;
};

/// Contacts as packs solve them, by the lanes of ContactPacks::contact_of_lane().
CheckVector<Solved> solved_in_packs(const ContactOrder& order, std::span<const std::uint32_t> contact_of_lane,
                                    std::uint32_t lanes);

} // namespace lockstone::solve
