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
#include "lockstone/journal.h"
#include "lockstone/query.h"
#include "lockstone/simd.h"
#include "lockstone/world_def.h"

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lockstone {

class Tasks; // lockstone/tasks.h
namespace testing {
struct Access; // lockstone/testing.h
}

/// Wrong arguments. Commands answer each with an error that names the argument, and change nothing. An id is two numbers: an
/// id of another world names what has the same numbers in this one; where nothing has, it is dead. Reading takes living ids,
/// rows below the count and columns of this world's schema only, as `write` does: anything else ends the program with a sentence, in every
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
    Status destroy(BodyId body); ///< and its shapes, joints, pair filters, character and vehicle
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
    bool is_alive(BodyId body) const; ///< false for any id that is null, dead or was never given out
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
    /// A row of a game column, or the game's record. Valid until the next command, tick or restore.
    template <StateRow T> const T& read(Column<T> column, BodyId body) const {
        return *reinterpret_cast<const T*>(row_bytes(column.index, body, sizeof(T)).data());
    }
    template <StateRow T> const T& read(Column<T> record) const { return read(record, BodyId{}); }
    Faults faults() const;

    /// The events of the last tick, in the order of EventKind. Empty after restore; valid until the next tick or restore.
    std::span<const Event> events() const;

    /// Contact points of the last tick; the first call computes them. Not state. Valid until the next tick or restore.
    using ContactPoint = lockstone::ContactPoint;
    std::span<const ContactPoint> contacts() const;
    /// The points of one body's shapes, in the same order; they replace `points`. An id that named no body in that tick has none. The first
    /// call after a tick sorts all points by body; later calls take time for the points that they return alone.
    void contacts(BodyId body, std::vector<ContactPoint>& points) const;

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
    std::span<const PhaseHash> phase_hashes() const; ///< of the last tick, valid until the next one

  private:
    friend struct testing::Access;
    struct Impl;
    /// Ends the program with a sentence where a world is used that was moved from.
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
