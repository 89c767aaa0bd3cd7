// A world's inside: the state, and scratch that no later tick can see.
#pragma once

#include "base/parallel.h"
#include "collide/broad/broad_phase.h"
#include "collide/narrow_phase.h"
#include "model/manifest.h"
#include "play/fluids/fluids.h"
#include "play/vehicle/vehicle.h"
#include "solve/bodies/integrate.h"
#include "solve/contacts/contact.h"
#include "solve/contacts/contact_memory.h"
#include "solve/contacts/contact_solver.h"
#include "solve/joints/joint.h"
#include "solve/kernels/kernels.h"
#include "solve/pairs/pair_kernel.h"
#include "tick/sleep_scratch.h"
#include "tick/sweep.h"
#include "world/query.h"

namespace lockstone::sim {

/// What the tick derives and forgets. Caches in it (the broad phase, poses of static shapes) change speed only.
struct Scratch {
    explicit Scratch(std::shared_ptr<const AssetLibrary> assets) : solids(std::move(assets)), broad_phase(0) {
        changed.reserve(64);
        bodies.kernel = solve::kernels_of(best_simd())->bodies;
        solids.use(solve::kernels_of(best_simd())->hulls);
    }
    /// What is kept by shape slot has room for so many, if it had less.
    void fit(std::uint32_t shape_slots);
    /// Memory for what ticks of a world with so many rows need, ahead of them.
    void reserve(const WorldRows& rows);

    shapes::SolidCache solids;
    collide::BroadPhase broad_phase;
    bool structure_stale = true; ///< objects came, went or were restored since the last tick
    std::vector<std::uint32_t>
        proxy_generation; ///< by shape slot: of the shape the broad phase holds, 0: none
    /// What the tick knows of a living shape, by shape slot.
    struct Shape {
        shapes::Solid solid;
        Transform pose;   ///< world
        Rotation axes;    ///< of the pose
        Length margin;    ///< how far its contacts reach ahead at most
        Coordinate reach; ///< of its points from its origin [m]
        Length inner;     ///< shapes::inner_radius() of the solid
        collide::Bounds bounds;
        bool is_placed; ///< while bounds are updated: pose, margin and bounds are those of this tick
        bool rests;     ///< it was handed over as resting, as made of:
        Transform resting_local, resting_at;
        Vec3 resting_center;
    };
    std::vector<Shape> shape;
    std::vector<std::uint32_t> planes; ///< shape slots, sorted

    // What the proxies of resting shapes were made of, so that only what changed since is looked at.
    ChangeMark proxies_of;
    std::uint32_t awake_before = 0;             ///< bodies, when bounds were last updated
    std::vector<std::uint32_t> solids_replaced; ///< shape slots that rested when another solid was put there
    std::vector<RowRange> changed;

    std::vector<collide::ProxyPair> pairs, plane_pairs, merged_pairs;
    struct PairKey {
        ContactKey
            key;       ///< null: the two do not meet, or both rest, or they are further apart than the margin
        Length margin; ///< how far ahead contacts of the two reach
    };
    std::vector<PairKey> pair_keys; ///< by pair
    /// Two shapes that may meet and are near, with their rows of the last tick's contact table.
    struct Near {
        ContactKey key;
        Length margin;
        std::uint32_t old_first, old_count;
        UnitVec3
            apart; ///< what parted them when last looked at, in the axes of the narrow phase's A; zero: nothing known
    };
    std::vector<Near> near, near_before; ///< the latter gives the former its hints, which change speed only
    bool near_is_cut = false;            ///< there were more such pairs than are looked at
    collide::NarrowScratch narrow;
    collide::Manifolds manifolds;

    struct Ended {
        ContactKey key;
        std::uint32_t flags; ///< solve::ContactFlags
    };
    std::vector<Ended> ended; ///< touching contacts that are gone

    /// What the narrow phase found for a pair that has contact points, or touched until now.
    struct ContactResult {
        std::uint32_t near;                 ///< index
        std::uint32_t first_row, row_count; ///< of the contact table
        std::uint32_t flags;                ///< solve::ContactFlags: what of them is the pair's
        bool was_touching;
        bool overlaps;             ///< near enough to count as touching, before the solve
        bool is_kept;              ///< its rows are those of the last tick
        std::uint32_t deepest_row; ///< of the pair's rows, the one with the deepest point
        // Of the deepest point, unless the pair was touching:
        UnitVec3 normal; ///< key a to key b
        Vec3 point;      ///< world
        Speed approach;  ///< [m/s], positive when closing
    };
    std::vector<ContactResult> results;
    ContactCopy table; ///< the contact table, from find_pairs on; the state has it when the tick is over
    std::vector<solve::Contact> contacts;
    std::uint32_t
        contacts_dropped; ///< rows that the table had no room for, and one for all pairs not looked at
    /// What a chunk of `near` makes, before it is known where it goes: rows count from the chunk's own first.
    struct NearChunk {
        std::vector<ContactMemory> memories; ///< of the pairs whose rows are new, in order
        std::vector<ContactResult> results;
        std::vector<solve::Contact> contacts;
        std::uint32_t first_row, first_contact; ///< where it goes
    };
    std::vector<NearChunk> near_chunks;
    struct RowMove {
        std::uint32_t from, to, count;
    };
    std::vector<RowMove> row_moves; ///< of kept rows of the contact table
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
    std::vector<NarrowWorker> narrow_workers;
    const solve::PairKernel* pair_kernel = solve::kernels_of(best_simd())->pairs;
    std::vector<Transform> pose_before; ///< of the bodies, by row, when the tick began

    QueryScratch query;
    SweepScratch sweep;
    SleepScratch sleep;
    CharacterScratch characters;

    std::vector<std::byte> written_row, canonical_row; ///< of a game column: to be written, as it was
    std::vector<MassPart> mass_parts;

    solve::StepConstants step{};
    solve::SolverBodies bodies;
    solve::ContactSolver solver;
    solve::JointSolver joint_solver{*solve::kernels_of(best_simd())->joints};
    std::vector<solve::Joint> joints; ///< in slot order
    std::vector<JointId> broken;
    VehicleSolver vehicle_solver;
    std::vector<FieldRow> pulls; ///< fields of acceleration, in row order
    std::vector<std::uint32_t>
        categories; ///< by row of what is awake, of its shapes; empty while no pull looks at them
    FluidSolver fluids;
};

struct Data {
    Data(const WorldDef& def, const GameSchema& schema, std::shared_ptr<const AssetLibrary> assets);
    Data(const Data& other); ///< the state; fresh scratch, no journal, no tasks

    WorldDef def;
    GameSchema schema;
    Manifest m;
    State state;
    Scratch scratch;

    Tasks* tasks = nullptr; ///< null: all on one thread
    Journal* journal = nullptr;
    bool phase_hashes_on = false;
    std::vector<PhaseHash> phase_hashes;
    std::vector<Event> events;
    std::vector<World::ContactPoint>
        contact_points;               ///< of the last tick, once find_contact_points() made them
    bool contact_points_wait = false; ///< they are not made yet
    PhaseObserver* observer = nullptr;

    const Header& header() const { return state.rows(m.header)[0]; }
    Header& edit_header() { return state.edit_row(m.header, 0); }
    /// The columns of what is awake.
    solve::BodyColumns body_columns() {
        const std::uint32_t awake = header().bodies_awake;
        return {state.rows(m.body_info).first(awake), state.rows(m.body_traits.row),
                state.rows(m.body_push).first(awake), state.rows(m.force),
                state.edit(m.body_pose, 0, awake),    state.edit(m.body_velocity, 0, awake)};
    }
    /// Of all bodies.
    solve::MassView masses() const { return {state.rows(m.body_info), state.rows(m.body_traits.row)}; }
    const BodyTraits& traits_of(const BodyInfo& info) const {
        return state.rows(m.body_traits.row)[info.traits];
    }
    const ShapeTraits& traits_of(const ShapeRow& shape) const {
        return state.rows(m.shape_traits.row)[shape.traits];
    }
    const BodyMass& mass_of(std::uint32_t body_row) const {
        return traits_of(state.rows(m.body_info)[body_row]).mass;
    }
    /// Row of a living body or shape; `count` of the table when the id is dead.
    std::uint32_t row_of(BodyId id) const { return row_of(state.rows(m.body_slot), id.index, id.generation); }
    std::uint32_t row_of(ShapeId id) const {
        return row_of(state.rows(m.shape_slot), id.index, id.generation);
    }
    std::uint32_t row_of(FieldId id) const {
        return row_of(state.rows(m.field_slot), id.index, id.generation);
    }
    std::uint32_t row_of(JointId id) const {
        return row_of(state.rows(m.joint_slot), id.index, id.generation);
    }
    std::uint32_t row_of(CharacterId id) const {
        return row_of(state.rows(m.character_slot), id.index, id.generation);
    }
    std::uint32_t row_of(VehicleId id) const {
        return row_of(state.rows(m.vehicle_slot), id.index, id.generation);
    }
    static constexpr std::uint32_t dead = 0xffffffffu;

  private:
    static std::uint32_t row_of(std::span<const Slot> slots, std::uint32_t index, std::uint32_t generation) {
        if (index == 0 || index > slots.size()) return dead;
        const Slot& slot = slots[index - 1];
        return slot.is_alive() && slot.generation == generation ? slot.row : dead;
    }
};

/// The force that pushes a body in the next tick, to be added to. Valid until the state grows.
BodyForce& force_on(Data& w, std::uint32_t body_row);
/// Nothing pushes it, or nothing pushes any body.
void forget_force(Data& w, std::uint32_t body_row);
void forget_forces(Data& w);
/// From now on a body or shape is like this. Moves rows of the state: references end.
void set_traits(Data& w, std::uint32_t body_row, const BodyTraits& traits);
void set_shape_traits(Data& w, std::uint32_t shape_row, const ShapeTraits& traits);

/// One tick: see tick.cpp.
void tick(Data& w);
/// Checks a command, applies it and tells the journal. On error nothing has changed.
Result<World::Applied> apply(Data& w, const Command& command);
/// Memory ahead of need: World::reserve.
Status reserve(Data& w, const WorldRows& rows);
/// After the state was replaced from outside: what the caches hold of it is stale, the last tick's output is gone.
void forget_derived(Data& w);
void tell_of_restore(const Data& w); ///< the journal, if there is one
/// Fills all scratch that is written before it is read with a byte; caches stay.
void poison_scratch(Data& w, std::byte with);
void disturb(Data& w, World::Leftover what, std::uint64_t seed);
/// Whether two shapes may meet: a pure function of the state.
bool may_meet(const Data& w, const ShapeRow& a, const ShapeRow& b);
/// Whether groups, categories and pair filters let two shapes of different bodies touch.
bool filters_allow(const Data& w, const ShapeRow& a, const ShapeRow& b);
/// What collision sees of a shape. Its asset was found when the shape was made, so it is there.
const shapes::Solid& solid_of(Data& w, const ShapeRow& shape);
/// Whether a state from outside can be this world's: same definition, every reference within its table.
Status check_state(Data& w, const State& state);

} // namespace lockstone::sim
