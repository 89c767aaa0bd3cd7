// Manifolds of the near pairs, and the contacts made of them.
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

/// Output of collide().
struct FoundContacts {
    std::vector<ContactResult> results;        ///< of near pairs, in pair order
    std::vector<solve::Contact> contacts;      ///< for the solver, in row order
    std::vector<solve::ContactHead> heads;     ///< of `contacts`, in the same order
    std::vector<solve::ContactImpact> impacts; ///< elastic impacts of the tick, in row order
    void reserve(std::size_t rows) {
        results.reserve(rows), contacts.reserve(rows), heads.reserve(rows), impacts.reserve(rows);
    }
    std::uint32_t dropped; ///< rows for which the table had no room, plus one if NearPairs::is_cut
};

/// Output of one chunk of pairs. Rows count from the chunk's own first row, as its place in the table is not yet
/// known.
struct NearChunk {
    std::vector<ContactMemory> memories; ///< of the pairs whose rows are new, in order
    std::vector<ContactResult> results;
    std::vector<solve::Contact> contacts;
    std::vector<solve::ContactHead> heads;
    std::uint32_t row_count;                              ///< of its results
    std::uint32_t first_row, first_contact, first_result; ///< its place among all chunks
    void reserve(std::size_t rows) {
        memories.reserve(rows), results.reserve(rows), contacts.reserve(rows), heads.reserve(rows);
    }
};

/// A batch of pairs for the lane kernel: first the rows of manifolds of the last tick, then rows of new manifolds.
struct PairWindow {
    static constexpr std::uint32_t pairs_max = 16, rows_max = 2 * pairs_max * collide::Manifolds::max;
    std::uint32_t count; ///< rows in use
    std::array<solve::PairLane, pairs_max> pairs;
    std::array<solve::PairRow, rows_max> rows;
    std::array<solve::PairPlace, rows_max> places;
    std::array<solve::PairContact, rows_max> contacts;
    std::array<std::uint8_t, rows_max> serves; ///< 1: the row's old manifold is still valid
};

/// Scratch memory of one worker of the narrow phase.
struct alignas(64) NarrowWorker {
    collide::NarrowScratch narrow;
    collide::Manifolds manifolds;
    PairWindow window;
    /// The geometric mean of the last two different coefficients: the cache saves a square root.
    struct Mean {
        Real a{}, b{}, value{};
    } mean;
};

/// Scratch memory of collide().
struct ContactScratch {
    struct RowMove {
        std::uint32_t from, to, count;
    };

    std::vector<NearChunk> chunks;
    std::vector<RowMove> row_moves; ///< of kept rows of the contact table
    std::vector<NarrowWorker> workers;
    const solve::PairKernel* pair_kernel = solve::kernels_of(best_simd())->pairs;
    base::Paths paths; ///< of the tick

    /// Reserves for one thread, which puts all pairs into one chunk.
    void reserve(std::size_t rows) {
        row_moves.reserve(rows);
        if (chunks.empty()) chunks.emplace_back();
        chunks[0].reserve(rows);
    }
};

/// Computes the manifolds of all pairs, or reuses those of the last tick, and makes their contacts. Turns `table`,
/// the contact table of the last tick, into the table of this tick. Makes no solver contacts for contacts that the
/// characters in `movers` handle themselves. Updates the hints of the pairs, and counts dropped rows in the state.
void collide(Model& w, const PlacedShapes& placed, const CharacterScratch& movers, NearPairs& near,
             ContactList& table, ContactScratch& scratch, FoundContacts& out, Tasks* tasks);
/// Returns true if a pair would have contact points at the current poses.
bool has_contact_points(const Model& w, const PlacedShapes& placed, const NearPair& near,
                        ContactScratch& scratch);

/// Builds the contact table from the chunks of collide(). (contact_table.cpp)
/// `is_cut`: the list of near pairs was longer than the limit and was cut.
void place_contacts(Model& w, bool is_cut, std::span<NearChunk> chunks, ContactList& table,
                    ContactScratch& scratch, FoundContacts& out, Tasks* tasks);

} // namespace lockstone::sim
