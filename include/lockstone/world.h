// The world: bodies, shapes and force fields that tick.
//
//   World world = World::create({.gravity = {0_r, -9.81_r, 0_r}}).value();
//   BodyId ball = world.create_body({.pose = {.position = {0_r, 5_r, 0_r}}}).value();
//   world.create_shape(ball, {.geometry = sphere(0.5_r)}).value();
//   world.tick();
//   Image image;
//   world.save(image);      ...      world.restore(image);
//
// A tick is a pure function of the state and the commands since the last tick. It takes no time step: the rate is
// fixed when the world is made. Errors from outside come back as sentences and leave the world as it was.
#pragma once

#include "lockstone/asset.h"
#include "lockstone/event.h"
#include "lockstone/query.h"
#include "lockstone/simd.h"
#include "lockstone/state.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lockstone {

class Tasks; // lockstone/tasks.h

/// How bodies move between contacts. Order: of the error of position and velocity in the step under smooth fields.
enum class Integrator : std::uint32_t {
    semi_implicit_euler, ///< order 1, symplectic, the cheapest
    verlet,              ///< order 2: position Verlet (drift, kick, drift)
    velocity_verlet,     ///< order 2: kick, drift, kick
    runge_kutta_4,       ///< order 4, not symplectic
};
const char* name_of(Integrator integrator);

struct WorldDef {
    std::uint32_t tick_rate = 60; ///< ticks per second, 1..1000
    std::uint32_t substeps = 4;   ///< solver steps per tick, 1..16; see precise()
    Vec3 gravity = {Real{}, Real::from_raw(-42133629174), Real{}}; ///< -9.81 m/s^2 along y; within 1000
    Integrator integrator = Integrator::semi_implicit_euler;
    std::uint32_t bounds_shift =
        0; ///< 0..8: broad-phase step 2^(shift-16) m, exact within 2^(15+shift) m of the origin
    // Limits of what there may be at one time, 1..2^20, of fields 1..1024, of characters and vehicles 1..65536. They cost
    // nothing: a world takes memory as things come. What they bound is what a file may ask for. They are part of the
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
    Real push_speed_max = Real(3);        ///< [m/s]: how fast overlap is pushed out
    /// [m/s]: 0.03. At rest is a body of which no point is faster, or none four times as fast and none farther than
    /// sleep_speed * sleep_time from where it was.
    Real sleep_speed = Real::from_raw(128849019);
    Real sleep_time =
        Real::from_raw(std::int64_t{1} << 31); ///< [s]: 0.5; an island that long at rest falls asleep
    std::uint64_t seed = 1;                    ///< part of the state; the game's random streams start from it

    /// For towers, heavy loads and long chains: twice the substeps, at less than twice the cost of a tick.
    static WorldDef precise() {
        WorldDef def;
        def.substeps = 8;
        return def;
    }
};

/// How many there may be before a world takes more memory.
struct WorldRows {
    std::uint32_t bodies = 0, shapes = 0, contacts = 0, fields = 0, pair_filters = 0, joints = 0,
                  characters = 0, vehicles = 0;
};

/// The game's own columns, in the same block as the engine's: saved, hashed, compared and dumped with them.
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

/// How often a value had to be clamped, since the world was made. Part of the state.
struct Faults {
    std::uint64_t speed_clamped;    ///< a linear or angular velocity met its limit
    std::uint64_t position_clamped; ///< a position met the end of the documented range (1e9 m)
    /// Pairs beyond contacts_max; the last in pair order were dropped. Of more than 1024 + 2 contacts_max pairs that are
    /// near, the last are not looked at, and count as one in each tick.
    std::uint64_t contacts_dropped;
    std::uint64_t impulse_clamped; ///< a contact impulse met the end of its format
    friend bool operator==(const Faults&, const Faults&) = default;
};

template <class V> constexpr void describe(Faults& f, V&& v) {
    v("speed_clamped", f.speed_clamped), v("position_clamped", f.position_clamped);
    v("contacts_dropped", f.contacts_dropped), v("impulse_clamped", f.impulse_clamped);
}

/// Sees every command that was applied and every tick, in order. The one recording hook.
class Journal {
  public:
    virtual ~Journal() = default;
    virtual void on_command(std::uint64_t tick,
                            const Command& command) = 0; ///< applied before tick `tick` runs
    virtual void on_tick(std::uint64_t tick,
                         std::uint64_t hash) = 0; ///< tick ran; hash of the state after it
    /// The state was replaced, by whatever means but a tick or a command: the next tick is `tick`.
    virtual void on_restore(std::uint64_t tick) = 0;
};

/// Hash of the whole state after one phase of a tick, for finding where two runs part.
struct PhaseHash {
    const char* phase; ///< the phase's function name in tick.cpp
    std::uint64_t hash;
};

/// Is told what a tick has done, for profilers. It is handed no state and hands nothing back: no bit can depend on it.
class PhaseObserver {
  public:
    virtual ~PhaseObserver() = default;
    virtual void
    on_phase(const char* phase) = 0; ///< has passed; its work is what was done since the last call
};

/// Wrong arguments. Commands answer each with an error that names the argument, and change nothing. An id is two numbers:
/// one of another world is this world's id with the same numbers, if there is one, else dead. Reading takes living ids,
/// rows below the count and columns of this world's schema only: anything else ends the program with a sentence, in every
/// build, and so does any use of a world that was moved from. Queries answer what makes no sense with nothing.
///
/// Threads. Const members may be called from several threads at once while no other member runs: they keep what they find out
/// behind a lock and in memory of their own. state() is for one thread.
class World {
  public:
    /// Refuses a definition out of range, with the field's name. `assets` are what hulls, meshes, height fields and compounds are made of; see lockstone/asset.h.
    static Result<World> create(const WorldDef& def, const GameSchema& schema = {},
                                std::shared_ptr<const AssetLibrary> assets = {});
    /// Upper bounds of what a world of this definition takes [bytes], with all tables full and without its assets; for
    /// refusing what came in a file. Errors as those of create.
    struct Memory {
        std::uint64_t state; ///< the block and its hashes; each further copy takes as much
        std::uint64_t work;  ///< all else, most of it in a tick
        std::uint64_t all() const { return state + work; }
    };
    static Result<Memory> memory_of(const WorldDef& def, const GameSchema& schema = {});
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;
    ~World();
    World clone() const; ///< same state at another address; no journal
    /// Takes memory ahead of need, for so many at least. Tables grow by themselves, by half each time, and ticks and commands
    /// allocate while they do; after this they seldom have to. No hash, image or answer depends on it. Refuses more than the
    /// definition's limits, by name. Ring images take theirs at the next save.
    Status reserve(const WorldRows& rows);
    WorldRows capacity() const; ///< what there is memory for at present
    /// Expires with this object, so that who keeps a reference to it can tell. Its contents may move elsewhere before.
    std::weak_ptr<const void> lifetime();

    // ---- time ----
    void tick();                      ///< one tick of 1 / tick_rate seconds
    std::uint64_t tick_count() const; ///< ticks so far
    const WorldDef& def() const;
    const AssetLibrary& assets() const;
    std::shared_ptr<const AssetLibrary> assets_shared() const;

    // ---- commands: each builds a Command and applies it ----
    struct Applied {
        BodyId body{}; ///< of CreateBody
        ShapeId shape{};
        FieldId field{};
        JointId joint{};
        CharacterId character{};
        VehicleId vehicle{};
    };
    /// Refuses what the command's definition calls out of range, ids that are dead or null, and what there is no room for:
    /// the error names the command and the field, the world is as it was. So do all below.
    Result<Applied> apply(const Command& command);
    Result<BodyId> create_body(const BodyDef& def);
    Result<ShapeId> create_shape(BodyId body, const ShapeDef& def);
    Result<FieldId> create_field(const FieldDef& def);
    Result<JointId> create_joint(const JointDef& def);
    /// Between two bodies where they stand now: both frames are at `at`, a place in the world. `a` may be null.
    Result<JointId> create_joint(JointDef def, BodyId a, BodyId b, const Transform& at);
    Status destroy(BodyId body); ///< and its shapes and joints
    Status destroy(ShapeId shape);
    Status destroy(FieldId field);
    Status set_field(FieldId field, const FieldDef& def);
    Status explode(const ExplosionDef& def);
    Status destroy(JointId joint);
    Result<CharacterId> create_character(const CharacterDef& def);
    Status destroy(CharacterId character); ///< and its body
    Status set_character_input(CharacterId character, const CharacterInput& input);
    Status set_joint_axis(JointId joint, JointAxisIndex index, const JointAxis& axis);
    Status set_joint_frames(JointId joint, const Transform& frame_a, const Transform& frame_b);
    Result<VehicleId> create_vehicle(const VehicleDef& def);
    Status destroy(VehicleId vehicle);
    Status set_vehicle_input(VehicleId vehicle, const VehicleInput& input);
    Status set_pose(BodyId body, const Transform& pose);
    Status set_velocity(BodyId body, Vec3 linear, Vec3 angular);
    Status add_force(BodyId body, Vec3 force, Vec3 torque = {});
    Status add_force_at(BodyId body, Vec3 force, Vec3 point);
    Status add_impulse(BodyId body, Vec3 linear, Vec3 angular = {});
    Status add_impulse_at(BodyId body, Vec3 impulse, Vec3 point);
    Status set_body_parameters(const SetBodyParameters& parameters);
    Status set_material(const SetMaterial& material);
    Status set_filter(const SetFilter& filter);
    Status set_pair_filter(BodyId a, BodyId b, bool collide);
    Status set_mass(const SetMass& mass);
    Status set_gravity(Vec3 gravity);
    Status wake_body(BodyId body); ///< and the island it sleeps in; commands on a body do so too
    /// Replaces a row of a game column (`body` null for records).
    template <StateRow T> Status write(Column<T> column, BodyId body, const T& value) {
        return write_bytes(column.index, body, std::as_bytes(std::span(&value, 1)));
    }
    template <StateRow T> Status write(Column<T> record, const T& value) {
        return write(record, BodyId{}, value);
    }

    // ---- reading: living ids only (asserted); is_alive tells ----
    bool is_alive(BodyId body) const; ///< no for any id that is null, dead or was never given out
    bool is_alive(ShapeId shape) const;
    bool is_alive(JointId joint) const;
    bool is_alive(VehicleId vehicle) const;
    bool is_alive(FieldId field) const;
    std::uint32_t field_count() const;
    FieldId field_at(std::uint32_t row) const; ///< row < field_count()
    FieldDef field(FieldId field) const;
    std::vector<BodyId> bodies() const; ///< by row; allocates
    bool is_awake(BodyId body) const;   ///< static and kinematic bodies that nothing moves are not
    std::uint32_t awake_count() const;  ///< bodies of all kinds
    std::uint32_t body_count() const;
    BodyId body_at(std::uint32_t row)
        const; ///< row < body_count(); rows move when bodies are destroyed, fall asleep, wake
    Transform pose(BodyId body) const;        ///< of the body's origin
    Vec3 center_of_mass(BodyId body) const;   ///< world [m]
    Vec3 linear_velocity(BodyId body) const;  ///< of the centre of mass [m/s]
    Vec3 angular_velocity(BodyId body) const; ///< [rad/s]
    Real mass(BodyId body) const;             ///< [kg]; 0 when static or kinematic
    BodyKind kind(BodyId body) const;
    std::uint64_t user_key(BodyId body) const;
    BodyDef body(BodyId body) const;                ///< as it is now: what create_body would have to be given
    SetMass mass_properties(BodyId body) const;     ///< as set_mass would have to be given them
    bool may_touch(BodyId a, BodyId b) const;       ///< false after set_pair_filter(a, b, false)
    Vec3 gravity() const;                           ///< [m/s^2], of def() until set_gravity
    std::vector<ShapeId> shapes(BodyId body) const; ///< in order of creation; allocates
    ShapeDef shape(ShapeId shape) const;
    BodyId body_of(ShapeId shape) const;
    bool is_alive(CharacterId character) const;
    std::uint32_t character_count() const;
    CharacterId character_at(std::uint32_t row) const; ///< row < character_count()
    BodyId body_of(CharacterId character) const;       ///< its origin is at the feet
    CharacterDef character(CharacterId character) const;
    CharacterInput character_input(CharacterId character) const;
    CharacterState character_state(CharacterId character) const;
    std::uint32_t joint_count() const;
    JointId joint_at(std::uint32_t row) const; ///< row < joint_count()
    JointDef joint(JointId joint) const;
    JointState joint_state(JointId joint) const;
    std::vector<JointId> joints(BodyId body) const; ///< newest first; allocates
    std::uint32_t vehicle_count() const;
    VehicleId vehicle_at(std::uint32_t row) const;      ///< row < vehicle_count()
    const VehicleDef& vehicle(VehicleId vehicle) const; ///< valid until the state changes
    VehicleInput vehicle_input(VehicleId vehicle) const;
    VehicleState vehicle_state(VehicleId vehicle) const;
    Real kinetic_energy() const; ///< [J], of all dynamic bodies; saturates
    template <StateRow T> const T& read(Column<T> column, BodyId body) const {
        return *reinterpret_cast<const T*>(row_bytes(column.index, body, sizeof(T)).data());
    }
    template <StateRow T> const T& read(Column<T> record) const { return read(record, BodyId{}); }
    Faults faults() const;

    /// The events of the last tick, in the order of EventKind. Empty after restore.
    std::span<const Event> events() const;

    /// A contact point of the last tick, for drawing and reports; found when first asked for. Not state.
    struct ContactPoint {
        ShapeId shape_a, shape_b;
        Vec3 point;
        UnitVec3 normal;       ///< a to b
        Separation separation; ///< [m] at the start of the tick
        Speed impulse;         ///< normal impulse over reduced mass, velocity units [m/s]
        SurfacePart part_a, part_b;
    };
    std::span<const ContactPoint> contacts() const;

    // ---- queries ---- see lockstone/query.h; they change nothing that a tick or a hash could see
    std::optional<QueryHit> cast_ray(const Ray& ray, const QueryFilter& filter = {}) const; ///< the first hit
    bool cast_ray_any(const Ray& ray, const QueryFilter& filter = {}) const;
    /// All hits in order. Replaces `hits`.
    void cast_ray_all(const Ray& ray, const QueryFilter& filter, std::vector<QueryHit>& hits) const;
    /// cast_ray for each; as many as the shorter of the two spans has.
    void cast_rays(std::span<const Ray> rays, const QueryFilter& filter,
                   std::span<std::optional<QueryHit>> hits) const;
    /// A convex shape or compound that moves by `translation` without turning, from `pose` of its frame.
    std::optional<QueryHit> cast_shape(const Geometry& geometry, const Transform& pose, Vec3 translation,
                                       const QueryFilter& filter = {}) const;
    bool cast_shape_any(const Geometry& geometry, const Transform& pose, Vec3 translation,
                        const QueryFilter& filter = {}) const;
    void cast_shape_all(const Geometry& geometry, const Transform& pose, Vec3 translation,
                        const QueryFilter& filter, std::vector<QueryHit>& hits) const;
    /// The shapes that overlap or touch it, ascending. Replaces `shapes`.
    void overlap(const Geometry& geometry, const Transform& pose, const QueryFilter& filter,
                 std::vector<ShapeId>& shapes) const;
    /// The nearest shape within `limit` [m] and where; `normal` leads from it to the geometry.
    std::optional<QueryHit> nearest(const Geometry& geometry, const Transform& pose, Real limit,
                                    const QueryFilter& filter = {}) const;
    /// Of two shapes that are not both planes, meshes or height fields; empty also beyond query_length_max.
    std::optional<ShapeDistance> distance(ShapeId a, ShapeId b) const;

    // ---- state ----
    std::uint64_t hash() const;    ///< of everything that can affect a later tick
    void save(Image& image) const; ///< into any image, whatever it held
    /// An image of a world with the same definition, schema and assets; any other, or an empty one, ends the program with
    /// what can_restore says, before a byte has changed.
    void restore(const Image& image);
    /// Whether restore takes it; if not, the error says why.
    Status can_restore(const Image& image) const;
    std::vector<std::byte> save_portable() const;
    /// Refuses whatever is not a state of a world with this definition, schema and assets; then the world is as it was.
    Status restore_portable(std::span<const std::byte> image);
    /// A portable image as the difference to what `base` holds, for those who hold the same: a ring image of any world
    /// of this definition and schema, saved there or after a restore_portable. Small where little changed.
    /// Ends the program with what can_restore says where it refuses the base.
    std::vector<std::byte> save_delta(const Image& base) const;
    /// Of what save_delta gave. Refuses another base than it was saved against, or one that can_restore refuses; on error
    /// the world is as it was.
    Status restore_delta(const Image& base, std::span<const std::byte> delta);
    const State& state() const;
    const GameSchema& schema() const;

    // ---- workers ----
    /// Who runs the parts of a tick; null, the default: the caller, alone. Not owned, so it outlives the world or is set to
    /// null before; not state; a clone has none.
    void set_tasks(Tasks* tasks);
    /// The instruction set that solves contacts; the best of the machine by default. Bits do not depend on it. False, and
    /// nothing changes, where the machine lacks it.
    bool set_simd(Simd level);

    // ---- diagnosis ----
    void set_journal(Journal* journal);              ///< null detaches; not owned, not state
    void observe_phases(PhaseObserver* observer);    ///< null detaches; not owned, not state, not cloned
    void record_phase_hashes(bool on);               ///< off by default; costs a hash per phase
    std::span<const PhaseHash> phase_hashes() const; ///< of the last tick
    /// What ticks leave behind outside of the state, and no later one may see.
    enum class Leftover : std::uint32_t {
        scratch, ///< memory that is written before it is read: filled with some byte
        trees,   ///< the shapes of the broad phase's trees: made anew, in random order or wholly at random
        pairs,   ///< which pairs were found already: some are forgotten, and found again in another order
    };
    /// For tests and proofs: makes it another than it is; `seed` chooses how. No hash and no answer changes by it.
    void disturb(Leftover what, std::uint64_t seed);
    /// For tests and planted faults: the block itself. Anything written here is outside the contract.
    State& state_for_tests();

  private:
    struct Impl;
    /// Names the mistake where a plain pointer would be followed into nothing.
    class Inside {
      public:
        explicit Inside(std::unique_ptr<Impl> impl);
        Impl* operator->() const { return held ? held.get() : moved_from(); }
        Impl& operator*() const { return held ? *held : *moved_from(); }

      private:
        [[noreturn]] static Impl* moved_from();
        std::unique_ptr<Impl> held;
    };
    explicit World(std::unique_ptr<Impl> impl);
    Status write_bytes(std::uint32_t column, BodyId body, std::span<const std::byte> row);
    std::span<const std::byte> row_bytes(std::uint32_t column, BodyId body, std::size_t size) const;
    Inside impl;
    std::shared_ptr<const char> life; ///< of this object; made when first asked for
};

} // namespace lockstone
