// The world: bodies, shapes, joints and force fields, advanced in ticks.
//
//   World world = World::create({.gravity = {0_r, -9.81_r, 0_r}}).value();
//   BodyId ball = world.create_body({.pose = {.position = {0_r, 5_r, 0_r}}}).value();
//   world.create_shape(ball, {.geometry = sphere(0.5_r)}).value();
//   world.tick();
//   Image image;
//   world.save(image);      ...      world.restore(image);
//
// A tick is a pure function of the state and of the commands since the last tick. It has no time step
// parameter: the definition fixes the tick rate. A function that can fail returns an Error with a sentence
// and leaves the world as it was.
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

/// The Lockstone library.
namespace lockstone {

class Tasks; // lockstone/tasks.h
namespace testing {
struct Access; // lockstone/testing.h
}

/// A physics world. Movable; clone() copies.
///
/// Errors. A command with a wrong argument returns an error that names the argument, and changes nothing. A
/// read function requires a living id, a row below the count and a column of this world's schema; anything
/// else ends the program with a message, in every build. Any use of a moved-from world does so too. A query
/// with an invalid argument returns an empty result. Ids carry no world tag: an id of another world may alias
/// a live object here.
///
/// Threads. Several threads may call const members at the same time, except state(), while no thread calls a
/// non-const member. Const members keep their caches behind a lock.
class World {
  public:
    /// Creates a world without bodies. `assets` holds the hulls, meshes, height fields and compounds that
    /// shapes may use (lockstone/asset.h); null: none. Errors: a field of `def` is out of range. Two game
    /// columns with one name end the program.
    static Result<World> create(const WorldDef& def, const GameSchema& schema = {},
                                std::shared_ptr<const AssetLibrary> assets = {});
    /// Upper bounds of the memory of a world [bytes], with all tables full and without its assets.
    struct Memory {
        std::uint64_t state; ///< The state block and its hashes. Each further copy takes as much.
        std::uint64_t work;  ///< Everything else: scratch memory, caches, trees.
        /// Sum of both.
        std::uint64_t all() const { return state + work; }
    };
    /// Memory that a world of this definition may take at most. Check it before you create a world from a
    /// definition that came in a file. Errors as create().
    static Result<Memory> memory_of(const WorldDef& def, const GameSchema& schema = {});
    World(World&&) noexcept;            ///< The other world is unusable afterwards.
    World& operator=(World&&) noexcept; ///< Frees the present state first.
    ~World();                           ///< Invalidates all references into this world.
    /// An independent copy of the state. It shares the assets and has no journal, no tasks, no observer and
    /// no events.
    World clone() const;
    /// Allocates memory for at least `rows` objects, so that later ticks and commands rarely allocate.
    /// Without it tables grow by a quarter or more at a time. No hash, image or result depends on it. Ring
    /// images get their memory at the next save. Invalidates references into the state. Errors: a count above
    /// the limit of the definition.
    Status reserve(const WorldRows& rows);
    WorldRows capacity() const; ///< Number of objects that fit into the memory allocated now.
    /// Expires when this object is destroyed. A move of the state to another object does not expire it.
    std::weak_ptr<const void> lifetime();

    // ---- time ----
    /// Advances the world by one tick of 1 / tick_rate seconds. Replaces events() and contacts() by those of
    /// this tick. Game::advance() has the order of commands, tick, events and game columns.
    void tick();
    std::uint64_t tick_count() const; ///< Ticks of this state; restore() sets it back.
    const WorldDef& def() const;      ///< The definition, contacts_max filled in. Valid as long as the world.
    /// The assets given to create(). Valid as long as the world.
    const AssetLibrary& assets() const;
    std::shared_ptr<const AssetLibrary> assets_shared() const; ///< assets(), shared. Never null.

    // ---- commands: each builds a Command and applies it ----
    /// Ids of the objects that a command created; null where it created none.
    struct Applied {
        BodyId body{};           ///< CreateBody, CreateCharacter
        ShapeId shape{};         ///< CreateShape, CreateCharacter
        FieldId field{};         ///< CreateField
        JointId joint{};         ///< CreateJoint
        CharacterId character{}; ///< CreateCharacter
        VehicleId vehicle{};     ///< CreateVehicle
    };
    /// Applies a command. Errors: a value out of range, a dead or null id, a full table. The error names the
    /// command and the field, and the world is as before. This holds for all functions of this section.
    Result<Applied> apply(const Command& command);
    /// Creates a body without shapes.
    Result<BodyId> create_body(const BodyDef& def);
    /// Adds a shape to a body, updates its mass and wakes it, unless it started asleep and never woke.
    Result<ShapeId> create_shape(BodyId body, const ShapeDef& def);
    Result<FieldId> create_field(const FieldDef& def); ///< Creates a force field. Wakes all bodies.
    Result<JointId> create_joint(const JointDef& def); ///< Creates a joint and wakes its bodies.
    /// Joins two bodies in their present poses. Both frames are set to `at` [world]. `a` null: the world.
    Result<JointId> create_joint(JointDef def, BodyId a, BodyId b, const Transform& at);
    /// Destroys a body with its shapes, joints, pair filters, character and vehicle. Wakes what touched it.
    Status destroy(BodyId body);
    /// Destroys a shape and updates the mass of its body. Errors also: the shape is a character's capsule.
    Status destroy(ShapeId shape);
    Status destroy(FieldId field); ///< Destroys a force field. Wakes all bodies.
    /// Replaces a field's definition. Wakes all bodies.
    Status set_field(FieldId field, const FieldDef& def);
    /// Changes the velocities of the bodies it reaches, and wakes them.
    Status explode(const ExplosionDef& def);
    Status destroy(JointId joint); ///< Destroys a joint and wakes its bodies.
    /// Creates a character with its own kinematic body and capsule.
    Result<CharacterId> create_character(const CharacterDef& def);
    Status destroy(CharacterId character); ///< Destroys a character with its body.
    /// Sets the input that a character follows in all later ticks.
    Status set_character_input(CharacterId character, const CharacterInput& input);
    /// Replaces one axis of a joint and wakes its bodies.
    Status set_joint_axis(JointId joint, JointAxisIndex index, const JointAxis& axis);
    /// Replaces both frames of a joint, as in JointDef, and wakes its bodies.
    Status set_joint_frames(JointId joint, const Transform& frame_a, const Transform& frame_b);
    /// Turns a dynamic body into the chassis of a vehicle. Errors also: the body already has a vehicle.
    Result<VehicleId> create_vehicle(const VehicleDef& def);
    Status destroy(VehicleId vehicle); ///< Destroys a vehicle; its chassis remains as a body.
    /// Sets the input of a vehicle for all later ticks. Wakes the chassis if the input differs.
    Status set_vehicle_input(VehicleId vehicle, const VehicleInput& input);
    /// Teleports a body's origin. Velocities remain. Position within 1e9 m on each axis.
    Status set_pose(BodyId body, const Transform& pose);
    /// Sets the velocity of the centre of mass [m/s, at most 500 long] and the angular velocity [rad/s, each
    /// component within 4095]. Locked axes stay at zero.
    Status set_velocity(BodyId body, Vec3 linear, Vec3 angular);
    /// Adds a force [N] at the centre of mass and a torque [N m] for the next tick only. Each component
    /// within 2e9. This and the next three have no effect on static and kinematic bodies.
    Status add_force(BodyId body, Vec3 force, Vec3 torque = {});
    /// Force [N] at a world point [m], next tick only.
    Status add_force_at(BodyId body, Vec3 force, Vec3 point);
    /// Changes the velocities at once: impulse [N s] at the centre of mass, angular impulse [N m s].
    Status add_impulse(BodyId body, Vec3 linear, Vec3 angular = {});
    /// Impulse [N s] at a world point [m], at once.
    Status add_impulse_at(BodyId body, Vec3 impulse, Vec3 point);
    /// Changes damping, locks and flags of a body. Fields that are not set keep their value.
    Status set_body_parameters(const SetBodyParameters& parameters);
    /// Changes the surface of a shape; unset fields remain.
    Status set_material(const SetMaterial& material);
    Status set_filter(const SetFilter& filter); ///< Changes the collision filter of a shape.
    /// Enables (the default) or disables contacts between two bodies. Errors also: the same body twice.
    Status set_pair_filter(BodyId a, BodyId b, bool collide);
    Status set_mass(const SetMass& mass); ///< Overrides the mass properties of a dynamic body.
    Status set_gravity(Vec3 gravity);     ///< [m/s^2], each component within 1000. Wakes all bodies.
    /// Wakes a body and its island. For a static or kinematic body: the islands that touch it. Every command
    /// on a body does this, apart from WriteGame and the creation of shapes on a body that never woke.
    Status wake_body(BodyId body);
    /// Replaces a body's row of a game column. Wakes nothing.
    template <StateRow T> Status write(Column<T> column, BodyId body, const T& value) {
        return write_bytes(column.index, body, std::as_bytes(std::span(&value, 1)));
    }
    /// Replaces a game record.
    template <StateRow T> Status write(Column<T> record, const T& value) {
        return write(record, BodyId{}, value);
    }

    // ---- reading: the id must be alive, otherwise the program ends ----
    bool is_alive(BodyId body) const;          ///< False for an id that is null, dead or was never created.
    bool is_alive(ShapeId shape) const;        ///< As for bodies.
    bool is_alive(JointId joint) const;        ///< As for bodies.
    bool is_alive(VehicleId vehicle) const;    ///< As for bodies.
    bool is_alive(FieldId field) const;        ///< As for bodies.
    std::uint32_t field_count() const;         ///< Number of force fields.
    FieldId field_at(std::uint32_t row) const; ///< The field in a row; row < field_count().
    FieldDef field(FieldId field) const;       ///< The present definition of a field.
    /// The part of a body of any kind that is in fluid fields at its present pose. Fluids without a density,
    /// such as wind(), and fluids whose mask excludes a shape do not count; BodyDef::enable_fields does not
    /// matter. Whether a shape is in a region, see lockstone/field.h. Each convex part of a shape counts with
    /// the fluid that covers most of it: for parallel surfaces this is the part below the highest. Volumes of
    /// parts add up, overlaps twice. Sensors, meshes, height fields and planes have no volume. Error of the
    /// fraction of each part: 1e-6 for spheres, boxes and hulls, 0.004 for cylinders, cones and capsules; for
    /// rounded parts at most radius / (size of the core) where their faces are not level.
    Submersion submersion(BodyId body) const;
    std::vector<BodyId> bodies() const; ///< All bodies in row order. Allocates.
    /// True for a dynamic body that is not asleep, and for a static or kinematic body that moves or that a
    /// command changed since the last tick.
    bool is_awake(BodyId body) const;
    std::uint32_t awake_count() const; ///< Number of awake bodies of all kinds. O(1).
    std::uint32_t body_count() const;  ///< Number of bodies.
    /// The body in a row; row < body_count(). Rows change when a body is destroyed, falls asleep or wakes.
    BodyId body_at(std::uint32_t row) const;
    Transform pose(BodyId body) const;          ///< Pose of the body's origin [m].
    Vec3 center_of_mass(BodyId body) const;     ///< World position of the centre of mass [m].
    Vec3 linear_velocity(BodyId body) const;    ///< Velocity of the centre of mass [m/s].
    Vec3 angular_velocity(BodyId body) const;   ///< [rad/s], world axes.
    Real mass(BodyId body) const;               ///< [kg]; 0 for static and kinematic bodies.
    BodyKind kind(BodyId body) const;           ///< Static, kinematic or dynamic.
    std::uint64_t user_key(BodyId body) const;  ///< BodyDef::user_key.
    BodyDef body(BodyId body) const;            ///< The definition that would create the body as it is now.
    SetMass mass_properties(BodyId body) const; ///< The present mass properties as a set_mass argument.
    bool may_touch(BodyId a, BodyId b) const;   ///< False after set_pair_filter(a, b, false).
    Vec3 gravity() const;                       ///< [m/s^2]; that of def() until set_gravity().
    std::vector<ShapeId> shapes(BodyId body) const;    ///< The body's shapes in order of creation. Allocates.
    ShapeDef shape(ShapeId shape) const;               ///< The present definition of a shape.
    BodyId body_of(ShapeId shape) const;               ///< The body that has the shape.
    bool is_alive(CharacterId character) const;        ///< As for bodies.
    std::uint32_t character_count() const;             ///< Number of characters.
    CharacterId character_at(std::uint32_t row) const; ///< The character in a row; row < character_count().
    BodyId body_of(CharacterId character) const;       ///< The character's body. Its origin is at the feet.
    CharacterDef character(CharacterId character) const;         ///< The definition, `up` normalised.
    CharacterInput character_input(CharacterId character) const; ///< The last input that was set.
    CharacterState character_state(CharacterId character) const; ///< Its state after the last tick.
    std::uint32_t joint_count() const;                           ///< Number of joints.
    /// The joint in a row; row < joint_count(). Rows change as of bodies.
    JointId joint_at(std::uint32_t row) const;
    JointDef joint(JointId joint) const; ///< The present definition of a joint.
    /// Coordinates of a joint in the present poses, and its forces of the last tick.
    JointState joint_state(JointId joint) const;
    std::vector<JointId> joints(BodyId body) const; ///< The body's joints, newest first. Allocates.
    std::uint32_t vehicle_count() const;            ///< Number of vehicles.
    VehicleId vehicle_at(std::uint32_t row) const;  ///< The vehicle in a row; row < vehicle_count().
    /// Valid until the state changes or reserve() is called.
    const VehicleDef& vehicle(VehicleId vehicle) const;
    VehicleInput vehicle_input(VehicleId vehicle) const; ///< The last input that was set.
    VehicleState vehicle_state(VehicleId vehicle) const; ///< Wheels, engine and gearbox after the last tick.
    Real kinetic_energy() const; ///< [J], sum over all dynamic bodies. Saturates at the range of Real.
    /// A body's row of a game column. Valid until the next command, tick, restore or reserve.
    template <StateRow T> const T& read(Column<T> column, BodyId body) const {
        return *reinterpret_cast<const T*>(row_bytes(column.index, body, sizeof(T)).data());
    }
    /// A game record. Valid until the next command, tick, restore or reserve.
    template <StateRow T> const T& read(Column<T> record) const { return read(record, BodyId{}); }
    Faults faults() const; ///< Counts of clamped values and dropped contacts, since the world was created.

    /// The events of the last tick, sorted by `precedes`. Valid until the next tick or restore. Empty after a
    /// restore, and in a clone: they are not part of the state. Rules read them after tick() and before they
    /// return, see Game::advance(). Sounds and particles of a session read SessionRunner::events().
    std::span<const Event> events() const;

    /// A contact point of the last tick.
    using ContactPoint = lockstone::ContactPoint;
    /// All contact points of the last tick. They are not part of the state. The first call after a tick
    /// computes them. Valid until the next tick or restore.
    std::span<const ContactPoint> contacts() const;
    /// Replaces `points` by the contact points of one body in the same order; none for a body that did not
    /// exist in that tick. The first call after a tick sorts all points by body; later calls cost only their
    /// own points.
    void contacts(BodyId body, std::vector<ContactPoint>& points) const;

    // ---- queries ---- see lockstone/query.h; they change no state and no hash
    /// The first hit of a ray; empty: none.
    std::optional<QueryHit> cast_ray(const Ray& ray, const QueryFilter& filter = {}) const;
    /// True if the ray hits anything. Faster than cast_ray().
    bool cast_ray_any(const Ray& ray, const QueryFilter& filter = {}) const;
    /// Replaces `hits` by all hits of a ray, sorted: at most one for each shape.
    void cast_ray_all(const Ray& ray, const QueryFilter& filter, std::vector<QueryHit>& hits) const;
    /// cast_ray() of each ray: hits[i] is that of rays[i]. Stops at the end of the shorter span.
    void cast_rays(std::span<const Ray> rays, const QueryFilter& filter,
                   std::span<std::optional<QueryHit>> hits) const;
    /// The first hit of a convex shape or compound that starts at `pose` and moves by `translation` [m]
    /// without rotation; empty: none.
    std::optional<QueryHit> cast_shape(const Geometry& geometry, const Transform& pose, Vec3 translation,
                                       const QueryFilter& filter = {}) const;
    /// True if the moving shape hits anything.
    bool cast_shape_any(const Geometry& geometry, const Transform& pose, Vec3 translation,
                        const QueryFilter& filter = {}) const;
    /// Replaces `hits` by all hits of the moving shape, sorted: at most one for each shape.
    void cast_shape_all(const Geometry& geometry, const Transform& pose, Vec3 translation,
                        const QueryFilter& filter, std::vector<QueryHit>& hits) const;
    /// Replaces `shapes` by the shapes that touch or overlap the geometry, in ascending order of id.
    void overlap(const Geometry& geometry, const Transform& pose, const QueryFilter& filter,
                 std::vector<ShapeId>& shapes) const;
    /// The nearest shape within `limit` [m], with the nearest point on it; empty: none. `normal` points from
    /// the shape to the geometry.
    std::optional<QueryHit> nearest(const Geometry& geometry, const Transform& pose, Real limit,
                                    const QueryFilter& filter = {}) const;
    /// Distance of two shapes. Empty if both are planes, meshes or height fields, or if the distance is more
    /// than query_length_max.
    std::optional<ShapeDistance> distance(ShapeId a, ShapeId b) const;

    // ---- state ----
    std::uint64_t hash() const;    ///< Hash of everything that can affect a later tick. Cached for each page.
    void save(Image& image) const; ///< Replaces the content of any image. Copies only the pages that differ.
    /// Replaces the state by that of an image that can_restore() accepts; any other image ends the program
    /// before a byte has changed. Clears events, contact points and phase hashes.
    void restore(const Image& image);
    /// Checks that restore() accepts the image: a world with the same definition, schema and assets saved it.
    /// The error names the difference.
    Status can_restore(const Image& image) const;
    /// The state as bytes for files and packets, on any machine.
    std::vector<std::byte> save_portable() const;
    /// Replaces the state by bytes of save_portable(). Errors: anything but a valid state of a world with
    /// this definition, schema and assets; the world is then as before.
    Status restore_portable(std::span<const std::byte> image);
    /// The state as the difference to `base`, a ring image of a world with the same definition, schema and
    /// assets. The receiver needs an image of the same state. Small when little changed. A base that
    /// can_restore() refuses ends the program.
    std::vector<std::byte> save_delta(const Image& base) const;
    /// Replaces the state by `base` plus `delta`. Errors: a base that can_restore() refuses or that
    /// save_delta() did not use, or damaged bytes; the world is then as before.
    Status restore_delta(const Image& base, std::span<const std::byte> delta);
    const State& state() const; ///< The columns, for tools. One thread at a time. Valid as long as the world.
    const GameSchema& schema() const; ///< The schema given to create(). Valid as long as the world.

    // ---- workers ----
    /// Task scheduler used by tick() and queries. Not owned: it must outlive its use. Null (default) runs
    /// single-threaded. Not part of the state, not cloned.
    void set_tasks(Tasks* tasks);
    /// Selects the instruction set; default: best_simd(). No bit depends on it. False, without effect, if
    /// this build or machine lacks it. A clone uses the default.
    bool set_simd(Simd level);

    // ---- diagnosis ----
    /// Receives all later commands and ticks. Null detaches. Not owned, not cloned.
    void set_journal(Journal* journal);
    /// Receives the end of each phase of a tick. Null detaches. Not owned, not cloned.
    void observe_phases(PhaseObserver* observer);
    void record_phase_hashes(bool on); ///< Default: off. Costs one hash for each phase. Not cloned.
    /// Hashes after the phases of the last tick; empty if they are off. Valid until the next tick or restore.
    std::span<const PhaseHash> phase_hashes() const;

  private:
    friend struct testing::Access;
    struct Impl;
    /// Ends the program with a message when a moved-from world is used.
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
    std::shared_ptr<const char> life; ///< Lifetime of this object; created by the first lifetime().
};

} // namespace lockstone
