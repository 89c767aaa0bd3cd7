// Changes data that a tick leaves behind and no later tick may read, for tests and proofs.
#include "prove/disturb.h"

#include "lockstone/math/random.h"
#include "world/world_impl.h"

namespace lockstone::testing {

struct Access {
    static sim::Data& inside_of(World& world) { return *world.impl; }
    static const sim::Data& inside_of(const World& world) { return *world.impl; }
};

void disturb(World& world, Leftover what, std::uint64_t seed) {
    sim::disturb(Access::inside_of(world), what, seed);
}

State& state_of(World& world) { return Access::inside_of(world).state; }

std::span<const std::string_view> path_names() { return base::path_names; }

PathSet paths_taken(const World& world) {
    static_assert(base::path_count <= PathSet{}.size());
    const base::Paths& taken = Access::inside_of(world).scratch.paths;
    PathSet out;
    for (std::size_t k = 0; k < base::path_count; ++k) out[k] = taken.has(static_cast<base::Path>(k));
    return out;
}

std::string order_fault(const World& world) {
    const sim::TickScratch& s = Access::inside_of(world).scratch;
    std::string fault = s.contacts.order_fault();
    if (fault.empty()) fault = s.joint_solver.order_fault();
    if (!fault.empty()) return fault;
    fault = s.vehicle_solver.order_fault(s.bodies);
    return fault.empty() ? fault : "vehicles: " + fault;
}

} // namespace lockstone::testing

namespace lockstone::sim {

void disturb(Data& w, testing::Leftover what, std::uint64_t seed) {
    find_contact_points(w); // first, as they are computed from scratch memory
    Random random = Random::seeded(seed);
    switch (what) {
    case testing::Leftover::scratch:
        return poison_scratch(w, static_cast<std::byte>(random.next_u32() & 0xffu));
    case testing::Leftover::trees:
        return w.placed.broad_phase.rebuild_trees(random);
    case testing::Leftover::pairs:
        return w.placed.broad_phase.forget_pairs(random);
    }
}

} // namespace lockstone::sim
