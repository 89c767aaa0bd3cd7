// Overwrites scratch memory that no later tick may read, for tests, proofs and debug builds. The structured bindings
// below name every member, so a new member that is missing here does not compile.
#include "base/poison.h"
#include "tick/tick.h"

namespace lockstone::sim {

namespace {

using base::poison;

void poison_narrow(std::byte with, collide::NarrowScratch& scratch, collide::Manifolds& found) {
    auto& [triangles, parts, pieces, order] = scratch;
    poison(with, triangles, parts, pieces, order, found);
}

/// Poisons the shapes of awake bodies, which every tick places again. Resting shapes stay as they were placed, and so
/// do the other caches.
void poison_shapes(std::byte with, PlacedShapes& placed) {
    auto& [solids, broad_phase, kernel, structure_stale, is_current, shape, planes, proxy_generation,
           proxies_of, awake_before, solids_replaced, changed, is_told, paths] = placed;
    poison(with, changed, is_told);
    is_current = false;
    for (PlacedShapes::Shape& one : shape)
        if (!one.rests)
            poison(with, one.pose, one.axes, one.has_axes, one.margin, one.bounds, one.resting_local,
                   one.resting_at, one.resting_center);
}

void poison_query(std::byte with, QueryScratch& query) {
    auto& [lock, idle] = query;
    collide::Manifolds unused;
    for (const std::unique_ptr<QueryWork>& work : idle) {
        auto& [near, candidates, narrow, ball] = *work;
        poison(with, near.open, near.proxies, candidates);
        poison_narrow(with, narrow, unused);
        ball.radius = Real{};
    }
}

/// Clears the hints of pairs.
void poison_pairs(std::byte with, PairScratch& scratch, NearPairs& found) {
    auto& [pairs, plane_pairs, merged_pairs, at_plane, keys, near_counts, of_chunks, before, joined,
           filters_of, changed, paths] = scratch;
    auto& [list, is_cut, ended] = found;
    poison(with, pairs, plane_pairs, merged_pairs, at_plane, keys, near_counts, ended);
    for (std::vector<ContactResult>& some : of_chunks) poison(with, some);
    list.clear(), before.clear(), is_cut = false;
}

void poison_contacts(std::byte with, ContactScratch& scratch, FoundContacts& found) {
    auto& [chunks, row_moves, workers, pair_kernel, paths] = scratch;
    auto& [results, contacts, heads, impacts, dropped] = found;
    poison(with, row_moves, results, contacts, heads, impacts, dropped);
    for (NearChunk& chunk : chunks) {
        auto& [memories, chunk_results, chunk_contacts, chunk_heads, row_count, first_row, first_contact,
               first_result] = chunk;
        poison(with, memories, chunk_results, chunk_contacts, chunk_heads, row_count, first_row,
               first_contact, first_result);
    }
    for (NarrowWorker& worker : workers) {
        auto& [narrow, manifolds, window, mean] = worker;
        poison_narrow(with, narrow, manifolds);
        poison(with, window);
        mean = {};
    }
}

void poison_sweep(std::byte with, SweepScratch& sweep) {
    auto& [workers, driven, paths] = sweep;
    poison(with, driven);
    for (SweepScratch::Worker& worker : workers)
        poison(with, worker.near.open, worker.near.proxies, worker.touching, worker.stopped);
}

void poison_islands(std::byte with, IslandScratch& islands, RowMoves& moves) {
    auto& [parent, still_ticks, first, last, touched, resting] = islands;
    poison(with, parent, still_ticks, first, last, touched, resting);
    auto& [joined, here, moving, there, swaps] = moves;
    poison(with, joined, swaps);
    for (ContactList* list : {&here, &moving, &there}) poison(with, list->keys, list->memories);
}

void poison_characters(std::byte with, CharacterScratch& characters) {
    auto& [order_of_body, slots, neighbours, pushes, landings, narrow, manifolds, motion_max] = characters;
    poison(with, order_of_body, slots, neighbours, pushes, landings, motion_max);
    poison_narrow(with, narrow, manifolds);
}

void poison_bodies(std::byte with, solve::SolverBodies& bodies) {
    auto& [body, step, push, drift, pull, joint_pulls, turns, fours, plain, forms, form_of, starts, fall,
           clamps, kernel, paths] = bodies;
    poison(with, body, step, push, drift, pull, joint_pulls, turns, fours, plain, forms, form_of, starts,
           fall, clamps);
}

} // namespace

void poison_scratch(Model& w, PlacedShapes& placed, QueryScratch& query, TickScratch& scratch,
                    std::byte with) {
    auto& [characters, pair_scratch, near, table, contact_scratch, found, pose_before, joints, fields, step,
           step_of, bodies, wheel_loads, pressed, contacts, joint_solver, vehicles, vehicle_solver, fluids,
           sweep, broken, islands, paths] = scratch;
    poison_characters(with, characters);
    poison_pairs(with, pair_scratch, near);
    table.poison(with);
    poison_contacts(with, contact_scratch, found);
    step_of = {};
    joints.poison(with);
    poison(with, pose_before.list, fields.pulls, fields.categories, step, broken, wheel_loads, w.mass_parts);
    poison_bodies(with, bodies);
    pressed.poison(with);
    contacts.poison(with);
    joint_solver.poison(with);
    vehicles.poison(with);
    vehicle_solver.poison(with);
    fluids.poison(with);
    poison_sweep(with, sweep);
    poison_islands(with, islands, w.moves);
    poison_shapes(with, placed);
    poison_query(with, query);
}

} // namespace lockstone::sim
