// What a world is made with: its definition, the game's own columns; and what it counts.
#pragma once

#include "lockstone/math/formats.h"
#include "lockstone/state.h"

#include <span>
#include <string>
#include <vector>

namespace lockstone {

/// How bodies move between contacts. Order: of the error of position and velocity in the step under smooth fields.
enum class Integrator : std::uint32_t {
    semi_implicit_euler, ///< order 1, symplectic, the cheapest
    verlet,              ///< order 2: position Verlet (drift, kick, drift)
    velocity_verlet,     ///< order 2: kick, drift, kick
    runge_kutta_4,       ///< order 4, not symplectic
};
const char* name_of(Integrator integrator);

struct WorldDef {
    std::uint32_t tick_rate = 60;       ///< ticks per second, 1..1000
    std::uint32_t substeps = 4;         ///< solver steps per tick, 1..16; see precise()
    Vec3 gravity = {0_r, -9.81_r, 0_r}; ///< [m/s^2], each within 1000
    Integrator integrator = Integrator::semi_implicit_euler;
    std::uint32_t bounds_shift =
        0; ///< 0..8: broad-phase step 2^(shift-16) m, exact within 2^(15+shift) m of the origin
    // Limits of what there may be at one time, 1..2^20, of fields 1..1024, of characters and vehicles 1..65536. They cost
    // nothing: a world takes memory as things come. They bound what a file may ask for. They are part of the
    // definition, and so of the hash; how much memory there is at present is not.
    std::uint32_t bodies_max = 8192;
    std::uint32_t shapes_max = 8192;
    /// Shape pairs that touch or nearly do; several for a shape of many parts. 0: eight for each shape or body that there
    /// may be, which heaps do not reach. Beyond it pairs are dropped: see EventKind::contacts_dropped.
    std::uint32_t contacts_max = 0;
    std::uint32_t fields_max = 256;
    std::uint32_t pair_filters_max = 8192; ///< pairs of bodies that were told not to touch
    std::uint32_t joints_max = 8192;
    std::uint32_t characters_max = 256;
    std::uint32_t vehicles_max = 256;
    std::uint32_t continuous = 1;         ///< 0: fast bodies are not swept and may pass through what is thin
    std::uint32_t sleeping = 1;           ///< 0: bodies that rest are simulated all the same
    Real restitution_speed_min = Real(1); ///< [m/s]: slower impacts do not bounce
    Real contact_hertz = Real(90);        ///< stiffness of contacts, at most 3 / 16 of the substep rate
    Real contact_damping = Real(10);      ///< damping ratio of contacts
    /// [m/s]: how fast overlap is pushed out. Of a body that a joint holds, a tenth of it: its joints keep the speed that contacts
    /// give to it.
    Real push_speed_max = Real(3);
    /// [m/s]. A body is at rest while no point of it is faster; or while none is four times as fast, and none is farther
    /// than sleep_speed * sleep_time from where it was. A body that contacts or joints push to its place is as fast as it moves.
    /// A body at the surface of a fluid is at rest while no point of it is faster than a 16th.
    Real sleep_speed = 0.03_r;
    Real sleep_time = 0.5_r; ///< [s]: an island that long at rest falls asleep
    std::uint64_t seed = 1;  ///< part of the state; the game's random streams start from it

    /// For towers, heavy loads and long chains: twice the substeps, at less than twice the cost of a tick.
    static WorldDef precise() {
        WorldDef def;
        def.substeps = 8;
        return def;
    }
};

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

/// How many there may be before a world takes more memory.
struct WorldRows {
    std::uint32_t bodies = 0, shapes = 0, contacts = 0, fields = 0, pair_filters = 0, joints = 0,
                  characters = 0, vehicles = 0;
};

/// The game's own columns, in the same block as the engine's: saved, hashed, compared and dumped with them. Names are unique, also among
/// the engine's ("body.pose"): anything else ends the program. A recording holds at most 256 columns, whose rows have at most 65,536 bytes.
/// Its columns are for World::read and World::write. State numbers columns otherwise: StateLayout::find_column finds them by name.
class GameSchema {
  public:
    /// One row per body, created zero, removed with the body.
    template <StateRow T> Column<T> add_body_column(std::string name) {
        return {add({std::move(name), true, sizeof(T), leaves_of<T>()})};
    }
    /// One row for the whole game: score, phase, random streams.
    template <StateRow T> Column<T> add_record(std::string name) {
        return {add({std::move(name), false, sizeof(T), leaves_of<T>()})};
    }
    struct Entry {
        std::string name; ///< "game.health"
        bool per_body;
        std::size_t row_size;
        std::vector<LeafInfo> leaves;
    };
    std::uint32_t add(Entry entry);
    std::span<const Entry> entries() const { return list; }

  private:
    std::vector<Entry> list;
};

/// The tables and columns of the state of a world with this definition and these game columns. The result owns the layout. Thread-safe.
std::shared_ptr<const StateLayout> state_layout_of(const WorldDef& def, const GameSchema& schema);

/// How often a value had to be clamped, since the world was made. Part of the state.
struct Faults {
    std::uint64_t speed_clamped;    ///< a linear or angular velocity met its limit
    std::uint64_t position_clamped; ///< a position met the end of the documented range (1e9 m)
    /// Pairs beyond contacts_max; the last in pair order were dropped. Of more than 1024 + 2 contacts_max pairs that are
    /// near, the last are not looked at, and all of them count as one pair in each tick.
    std::uint64_t contacts_dropped;
    std::uint64_t impulse_clamped; ///< a contact impulse met the end of its format
    friend bool operator==(const Faults&, const Faults&) = default;
};

template <class V> constexpr void describe(Faults& f, V&& v) {
    v("speed_clamped", f.speed_clamped), v("position_clamped", f.position_clamped);
    v("contacts_dropped", f.contacts_dropped), v("impulse_clamped", f.impulse_clamped);
}

} // namespace lockstone
