// What a tick leaves behind and no later one may see, made different: for tests and proofs. Every member of the scratch
// is named here, or this does not compile.
#include "base/poison.h"
#include "tick/phases.h"

namespace lockstone::sim {

namespace {

using base::poison;

void poison_narrow(std::byte with, collide::NarrowScratch& scratch, collide::Manifolds& found) {
    auto& [triangles, parts, pieces, order] = scratch;
    poison(with, triangles, parts, pieces, order, found);
}

void poison_chunks(std::byte with, std::vector<Scratch::NearChunk>& chunks) {
    for (Scratch::NearChunk& chunk : chunks) {
        auto& [memories, results, contacts, first_row, first_contact] = chunk;
        poison(with, memories, results, contacts, first_row, first_contact);
    }
}

void poison_workers(std::byte with, std::vector<Scratch::NarrowWorker>& narrow, SweepScratch& sweep) {
    for (Scratch::NarrowWorker& worker : narrow) {
        auto& [scratch, manifolds, window, mean] = worker;
        poison_narrow(with, scratch, manifolds);
        poison(with, window);
        mean = {};
    }
    auto& [workers, stopped] = sweep;
    Transform somewhere;
    poison(with, somewhere);
    for (std::optional<Transform>& one : stopped) one = somewhere;
    for (SweepScratch::Worker& worker : workers)
        poison(with, worker.near.open, worker.near.proxies, worker.touching);
}

/// Of what is awake, which every tick places anew. What rests stays where it was placed.
void poison_shapes(std::byte with, std::vector<Scratch::Shape>& shapes) {
    for (Scratch::Shape& shape : shapes)
        if (!shape.rests)
            poison(with, shape.pose, shape.axes, shape.margin, shape.bounds, shape.resting_local,
                   shape.resting_at, shape.resting_center);
}

void poison_parts(std::byte with, SleepScratch& sleep, CharacterScratch& characters, QueryScratch& query,
                  solve::SolverBodies& bodies) {
    {
        auto& [parent, still_ticks, leaving, first, last, here, moving, there] = sleep;
        poison(with, parent, still_ticks, leaving, first, last);
        for (ContactList* list : {&here, &moving, &there}) poison(with, list->keys, list->memories);
    }
    {
        auto& [order_of_body, slots, neighbours, pushes, landings, motion_max] = characters;
        poison(with, order_of_body, slots, neighbours, pushes, landings, motion_max);
    }
    {
        auto& [is_fresh, tick, commands, lock, idle] = query; // the first three say how far the caches are
        collide::Manifolds unused;
        for (const std::unique_ptr<QueryWork>& work : idle) {
            auto& [near, candidates, narrow] = *work;
            poison(with, near.open, near.proxies, candidates);
            poison_narrow(with, narrow, unused);
        }
    }
    auto& [body, step, turns, plain, fall, clamps, kernel] = bodies;
    poison(with, body, step, turns, plain, fall, clamps);
}

} // namespace

void poison_scratch(Data& w, std::byte with) {
    // Caches, which hold from tick to tick: solids, broad_phase, structure_stale, proxy_generation, planes, proxies_of,
    // awake_before, solids_replaced; of the shapes what rests; of `near` the hints, which are forgotten here.
    auto& [solids, broad_phase, structure_stale, proxy_generation, shape, planes, proxies_of, awake_before,
           solids_replaced, changed, pairs, plane_pairs, merged_pairs, pair_keys, near, near_before,
           near_is_cut, narrow, manifolds, ended, results, table, contacts, contacts_dropped, near_chunks,
           row_moves, narrow_workers, pair_kernel, pose_before, query, sweep, sleep, characters, written_row,
           canonical_row, mass_parts, step, bodies, solver, joint_solver, joints, broken, vehicle_solver,
           pulls, categories, fluids] = w.scratch;
    poison(with, contacts_dropped, changed, pairs, plane_pairs, merged_pairs, pair_keys, ended, results,
           contacts, row_moves, pose_before, written_row, canonical_row, mass_parts, step, joints, broken,
           pulls, categories);
    near.clear(), near_before.clear(), near_is_cut = false;
    poison_narrow(with, narrow, manifolds);
    poison_chunks(with, near_chunks);
    poison_workers(with, narrow_workers, sweep);
    poison_shapes(with, shape);
    poison_parts(with, sleep, characters, query, bodies);
    table.poison(with);
    solver.poison(with);
    joint_solver.poison(with);
    vehicle_solver.poison(with);
    fluids.poison(with);
}

void disturb(Data& w, World::Leftover what, std::uint64_t seed) {
    find_contact_points(w); // which are made of scratch
    Random random = Random::seeded(seed);
    switch (what) {
    case World::Leftover::scratch:
        return poison_scratch(w, static_cast<std::byte>(random.next_u32() & 0xffu));
    case World::Leftover::trees:
        return w.scratch.broad_phase.rebuild_trees(random);
    case World::Leftover::pairs:
        return w.scratch.broad_phase.forget_pairs(random);
    }
}

} // namespace lockstone::sim
