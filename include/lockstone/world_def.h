// The definition of a world, the game's own columns, and the fault counters.
#pragma once

#include "lockstone/math/formats.h"
#include "lockstone/state.h"

#include <span>
#include <string>
#include <vector>

namespace lockstone {

/// Integration scheme of free motion. Order: that of the global error in the step, under smooth forces.
enum class Integrator : std::uint32_t {
    semi_implicit_euler, ///< order 1, symplectic, the cheapest
    verlet,              ///< order 2: position Verlet (drift, kick, drift)
    velocity_verlet,     ///< order 2: kick, drift, kick
    runge_kutta_4,       ///< order 4, not symplectic
};
/// "semi_implicit_euler"; "unknown" for any other value. Static string.
const char* name_of(Integrator integrator);

/// Definition of a world. World::create() checks the ranges. Part of the state and of the hash.
struct WorldDef {
    std::uint32_t tick_rate = 60;       ///< ticks per second [1/s], 1..1000
    std::uint32_t substeps = 4;         ///< solver steps in each tick, 1..16; see precise()
    Vec3 gravity = {0_r, -9.81_r, 0_r}; ///< [m/s^2], each component within 1000
    Integrator integrator = Integrator::semi_implicit_euler; ///< integration scheme of free motion
    /// 0..8. The broad phase has a resolution of 2^(shift-16) m and is exact within 2^(15+shift) m of the
    /// origin.
    std::uint32_t bounds_shift = 0;
    // Limits of the number of objects. A high limit costs no memory, because tables grow with their content.
    // Limits bound the memory that a file can claim. They are part of the hash; the present capacity is not.
    std::uint32_t bodies_max = 8192; ///< 1..2^20
    std::uint32_t shapes_max = 8192; ///< 1..2^20
    /// Limit of shape pairs that touch or nearly touch, 1..2^20; a shape of several parts counts several
    /// pairs. 0: eight times the larger of bodies_max and shapes_max, enough for heaps. Pairs beyond the
    /// limit are dropped: see EventKind::contacts_dropped.
    std::uint32_t contacts_max = 0;
    std::uint32_t fields_max = 256;        ///< 1..1024
    std::uint32_t pair_filters_max = 8192; ///< body pairs with contacts disabled, 1..2^20
    std::uint32_t joints_max = 8192;       ///< 1..2^20
    std::uint32_t characters_max = 256;    ///< 1..65536
    std::uint32_t vehicles_max = 256;      ///< 1..65536
    std::uint32_t continuous = 1; ///< 1: continuous collision; 0: fast bodies may pass through thin shapes
    std::uint32_t sleeping = 1;   ///< 1: islands at rest fall asleep; 0: they are simulated
    Real restitution_speed_min = Real(1); ///< slower impacts do not bounce [m/s], 0..500
    /// Stiffness of contacts [Hz], 1..4000. The solver uses at most 3/16 of the substep rate.
    Real contact_hertz = Real(90);
    Real contact_damping = Real(10); ///< damping ratio of contacts, 0.1..100
    /// Maximum speed at which contacts push overlapping bodies apart [m/s], 0..500. A tenth of it for bodies
    /// with joints, because joints do not remove that speed afterwards.
    Real push_speed_max = Real(3);
    /// Speed limit of a body at rest [m/s], 0..10. A body is at rest while no point of it is faster. It is
    /// also at rest while no point is four times as fast and none is farther than sleep_speed * sleep_time
    /// from its place when the rest began. Position correction counts as speed. At the surface of a fluid the
    /// limit is a 16th.
    Real sleep_speed = 0.03_r;
    Real sleep_time = 0.5_r; ///< an island falls asleep after this time at rest [s], 0..3600
    std::uint64_t seed = 1;  ///< any value for the game's random streams; part of the state

    /// Defaults with 8 substeps: for towers, heavy loads and long chains. A tick costs less than twice as
    /// much.
    static WorldDef precise() {
        WorldDef def;
        def.substeps = 8;
        return def;
    }
};

/// Field list of WorldDef with ranges; see lockstone/row.h.
template <class V> constexpr void describe(WorldDef& d, V&& v) {
    constexpr std::int64_t objects_max = 1 << 20;
    field(v, "tick_rate", d.tick_rate, in(1, 1000));
    field(v, "substeps", d.substeps, in(1, 16));
    field(v, "gravity", d.gravity, EachIn{Real(1000), "m/s^2"});
    field(v, "integrator", d.integrator, in(0, 3));
    field(v, "bounds_shift", d.bounds_shift, in(0, 8));
    field(v, "bodies_max", d.bodies_max, in(1, objects_max));
    field(v, "shapes_max", d.shapes_max, in(1, objects_max));
    field(v, "contacts_max", d.contacts_max, in(0, objects_max));
    field(v, "fields_max", d.fields_max, in(1, 1024));
    field(v, "pair_filters_max", d.pair_filters_max, in(1, objects_max));
    field(v, "joints_max", d.joints_max, in(1, objects_max));
    field(v, "characters_max", d.characters_max, in(1, 65536));
    field(v, "vehicles_max", d.vehicles_max, in(1, 65536));
    field(v, "continuous", d.continuous, no_or_yes);
    field(v, "sleeping", d.sleeping, no_or_yes);
    field(v, "restitution_speed_min", d.restitution_speed_min, in(0_r, 500_r));
    field(v, "contact_hertz", d.contact_hertz, in(1_r, 4000_r));
    field(v, "contact_damping", d.contact_damping, in(0.1_r, 100_r));
    field(v, "push_speed_max", d.push_speed_max, in(0_r, 500_r));
    field(v, "sleep_speed", d.sleep_speed, in(0_r, 10_r));
    field(v, "sleep_time", d.sleep_time, in(0_r, 3600_r));
    v("seed", d.seed);
}

/// Numbers of objects: those that World::reserve() allocates memory for, or that World::capacity() has.
struct WorldRows {
    std::uint32_t bodies = 0, ///< bodies
        shapes = 0,           ///< shapes
        contacts = 0,         ///< shape pairs that touch or nearly touch
        fields = 0,           ///< force fields
        pair_filters = 0,     ///< disabled body pairs
        joints = 0,           ///< joints
        characters = 0,       ///< characters
        vehicles = 0;         ///< vehicles
};

/// The game's own columns. They lie in the state block: World saves, restores, hashes and compares them with
/// its own. Names must differ from each other and from the engine's ("body.pose"); otherwise the program
/// ends. A recording holds at most 256 game columns, with rows of at most 65,536 bytes. The returned Column
/// is for World::read() and World::write() only. State uses other indices: StateLayout::find_column() finds a
/// column by its name.
class GameSchema {
  public:
    /// Adds a column with one row for each body. A new body's row is zero.
    template <StateRow T> Column<T> add_body_column(std::string name) {
        return {add({std::move(name), true, sizeof(T), leaves_of<T>()})};
    }
    /// Adds a record: one row for the whole game, such as score or random streams. It begins as zero.
    template <StateRow T> Column<T> add_record(std::string name) {
        return {add({std::move(name), false, sizeof(T), leaves_of<T>()})};
    }
    /// A column or record.
    struct Entry {
        std::string name;             ///< "game.health"
        bool per_body;                ///< true: a row for each body; false: a record
        std::size_t row_size;         ///< bytes of a row
        std::vector<LeafInfo> leaves; ///< numbers of a row, in memory order
    };
    /// Adds a column and returns its index. A repeated name ends the program.
    std::uint32_t add(Entry entry);
    /// In order of addition. Valid until the next one.
    std::span<const Entry> entries() const { return list; }

  private:
    std::vector<Entry> list;
};

/// The tables and columns of a world's state, for tools that read states without a world. Does not check
/// `def`. Thread-safe.
std::shared_ptr<const StateLayout> state_layout_of(const WorldDef& def, const GameSchema& schema);

/// Counts of clamped values and dropped pairs since the world was created. Part of the state.
struct Faults {
    std::uint64_t speed_clamped;    ///< a linear or angular velocity reached its limit
    std::uint64_t position_clamped; ///< a position reached the end of its range, 1e9 m
    /// Pairs dropped because contacts_max was reached, the last in pair order. Near pairs beyond 1024 + 2
    /// contacts_max are dropped untested and count as one in each tick.
    std::uint64_t contacts_dropped;
    std::uint64_t impulse_clamped; ///< a contact impulse reached the end of its format
    /// All counts are equal.
    friend bool operator==(const Faults&, const Faults&) = default;
};

/// Field list of Faults; see lockstone/row.h.
template <class V> constexpr void describe(Faults& f, V&& v) {
    v("speed_clamped", f.speed_clamped), v("position_clamped", f.position_clamped);
    v("contacts_dropped", f.contacts_dropped), v("impulse_clamped", f.impulse_clamped);
}

} // namespace lockstone
