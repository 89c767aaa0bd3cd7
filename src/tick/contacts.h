// Manifolds of the pairs that are near, and the contacts made of them.
#pragma once

#include "collide/narrow_phase.h"
#include "play/character/character.h"
#include "solve/contacts/contact.h"
#include "solve/kernels/kernels.h"
#include "solve/pairs/pair_kernel.h"
#include "tick/pairs.h"

#include <array>
#include <vector>

namespace lockstone::sim {

/// What collide() finds.
struct FoundContacts {
    std::vector<ContactResult> results;    ///< of pairs that are near, in pair order
    std::vector<solve::Contact> contacts;  ///< for the solver, in row order
    std::vector<solve::ContactHead> heads; ///< of these
    void reserve(std::size_t rows) { results.reserve(rows), contacts.reserve(rows), heads.reserve(rows); }
    std::uint32_t dropped; ///< rows that the table had no room for, and one for all pairs not looked at
};

/// What a chunk of pairs makes, before it is known where it goes: rows count from the chunk's own first.
struct NearChunk {
    std::vector<ContactMemory> memories; ///< of the pairs whose rows are new, in order
    std::vector<ContactResult> results;
    std::vector<solve::Contact> contacts;
    std::vector<solve::ContactHead> heads;
    std::uint32_t row_count;                              ///< of its results
    std::uint32_t first_row, first_contact, first_result; ///< where it goes
    void reserve(std::size_t rows) {
        memories.reserve(rows), results.reserve(rows), contacts.reserve(rows), heads.reserve(rows);
    }
};

/// Some pairs at once, side by side in lanes: those of the last tick's manifolds, then those of new ones.
struct PairWindow {
    static constexpr std::uint32_t pairs_max = 16, rows_max = 2 * pairs_max * collide::Manifolds::max;
    std::uint32_t count; ///< rows
    std::array<solve::PairLane, pairs_max> pairs;
    std::array<solve::PairRow, rows_max> rows;
    std::array<solve::PairPlace, rows_max> places;
    std::array<solve::PairContact, rows_max> contacts;
    std::array<std::uint8_t, rows_max> serves;
};

/// What a worker of the narrow phase needs for itself.
struct alignas(64) NarrowWorker {
    collide::NarrowScratch narrow;
    collide::Manifolds manifolds;
    PairWindow window;
    struct Mean { ///< geometric, of the last two coefficients that differed: a root is worth keeping
        Real a{}, b{}, value{};
    } mean;
};

/// Memory of collide().
struct ContactScratch {
    struct RowMove {
        std::uint32_t from, to, count;
    };

    std::vector<NearChunk> chunks;
    std::vector<RowMove> row_moves; ///< of kept rows of the contact table
    std::vector<NarrowWorker> workers;
    const solve::PairKernel* pair_kernel = solve::kernels_of(best_simd())->pairs;
    base::Paths paths; ///< of the tick

    /// As one thread needs it, which makes one chunk of all pairs.
    void reserve(std::size_t rows) {
        row_moves.reserve(rows);
        if (chunks.empty()) chunks.emplace_back();
        chunks[0].reserve(rows);
    }
};

/// Manifolds of the pairs, made anew or used again, and their contacts. `table`: the contact table of the last tick becomes that
/// of this one. `movers`: contacts that are theirs are not solved. Hints of the pairs are renewed; what is dropped is counted in
/// the state.
void collide(Model& w, const PlacedShapes& placed, const CharacterScratch& movers, NearPairs& near,
             ContactList& table, ContactScratch& scratch, FoundContacts& out, Tasks* tasks);
/// Whether a pair would have contact points now.
bool has_contact_points(const Model& w, const PlacedShapes& placed, const NearPair& near,
                        ContactScratch& scratch);

/// What the chunks of collide() made becomes the contact table. (contact_table.cpp)
/// `is_cut`: there were more pairs than were looked at.
void place_contacts(Model& w, bool is_cut, std::span<NearChunk> chunks, ContactList& table,
                    ContactScratch& scratch, FoundContacts& out, Tasks* tasks);

} // namespace lockstone::sim
