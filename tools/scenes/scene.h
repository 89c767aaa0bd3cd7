// Parts that all scenes share: name, options, content id, and a builder that keeps the first error.
#pragma once

#include "lockstone/play/ragdoll.h"
#include "scenes/scenes.h"

namespace lockstone::scenes_detail {

/// One tick of a scene's rules. It keeps the error of the first command that fails. The world then does not tick, and
/// finish() returns the error.
class Turn {
  public:
    explicit Turn(World& played) : world(played) {}
    World& world;
    void must(const Status& done) {
        if (status) status = done;
    }
    /// Runs the tick, unless a command has failed.
    Status finish() {
        if (status) world.tick();
        return status;
    }

  private:
    Status status;
};

/// Collects the result of a scene's check of a loaded state. The first error sentence is kept.
class StateCheck {
  public:
    explicit StateCheck(const World& checked, std::string_view column) : world(checked), where(column) {}
    /// Checks that the id names an existing object. `what` names the field.
    template <class Id> StateCheck& alive(Id id, std::string_view what) {
        return holds(world.is_alive(id), what, "names an object that does not exist");
    }
    /// Checks that the id names an existing dynamic body.
    StateCheck& dynamic(BodyId id, std::string_view what) {
        alive(id, what);
        return holds(!world.is_alive(id) || world.kind(id) == BodyKind::dynamic, what,
                     "names a body that is not dynamic");
    }
    StateCheck& holds(bool condition, std::string_view what, std::string_view why);
    Status finish() const { return status; }

  private:
    const World& world;
    std::string_view where;
    Status status;
};

/// A scene with its options filled in. Scenes without players need to define only `start`.
class Scene : public Game {
  public:
    Scene(const SceneInfo& about, const SceneOptions& chosen, std::uint32_t version);

    std::string name() const override;
    std::uint64_t content_id() const override; ///< of the name, the options and the version of the rules
    std::uint32_t player_count() const override { return options.players; }
    std::uint32_t input_size() const override { return 0; }
    Status advance(World& world, std::span<const PlayerInput> inputs) const final {
        Turn turn(world);
        play(turn, inputs);
        return turn.finish();
    }

    /// See controls_of. Called only for players of the game.
    virtual Controls controls(std::uint32_t) const { return {}; }
    /// See scripted_input; `input` is zero on entry.
    virtual void script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                        std::span<std::byte> input) const;

  protected:
    /// Issues the commands before the tick.
    virtual void play(Turn&, std::span<const PlayerInput>) const {}

    const SceneInfo& info;
    const SceneOptions options; ///< defaults are filled in
    const std::uint32_t rules_version;
};

/// The assets of a scene, baked at its start. After the first error it skips the rest, and `finish` returns the error.
class Shelf {
  public:
    Shelf() = default;
    explicit Shelf(AssetLibrary with) : library(std::move(with)) {}
    Geometry add(const Result<AssetBytes>& baked); ///< with the kind of the asset
    Result<std::shared_ptr<const AssetLibrary>> finish() &&;

  private:
    AssetLibrary library;
    Status status;
};

/// Makes a world body by body. After the first error it skips the rest, and `finish` returns the error.
class Builder {
  public:
    explicit Builder(const WorldDef& def, const GameSchema& schema = {},
                     std::shared_ptr<const AssetLibrary> assets = nullptr);

    BodyId body(const BodyDef& def, const ShapeDef& shape);
    void shape(BodyId body, const ShapeDef& shape);
    BodyId ground(); ///< a plane through the origin
    /// Adds a joint between two bodies in their current poses. The first id may be null; see World::create_joint.
    JointId joint(const JointDef& def, BodyId a, BodyId b, const Transform& at);
    JointId joint(const JointDef& def);
    FieldId field(const FieldDef& def);
    Ragdoll ragdoll(const RagdollDef& def);
    VehicleId vehicle(const VehicleDef& def);
    CharacterId character(const CharacterDef& def);
    template <StateRow T> void record(Column<T> column, const T& value) {
        if (made.ok()) keep(made->write(column, value));
    }
    Result<World> finish() && { return std::move(made); }

  private:
    void keep(const Status& status);
    template <class T> T keep(const Result<T>& result) {
        if (result) return *result;
        made = result.error();
        return {};
    }
    Result<World> made;
};

/// A definition with capacity for `dynamic_bodies` bodies of one shape each, the scenery, and their contacts.
WorldDef world_for(std::uint32_t dynamic_bodies, std::uint64_t seed);

/// An upright pose at a point.
Transform at(Vec3 position);
Transform at(Vec3 position, Quat rotation);

// One function per scene; the registry in scenes.cpp lists them.
using MakeScene = std::unique_ptr<Scene> (*)(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_two_blocks(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_stack(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_pyramid(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_pile(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_convex_pile(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_terrain(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_washer(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_domino(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_cars(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_character(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_ragdolls(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_joint_grid(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_bridge(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_wrecking_ball(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_water(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_blast(const SceneInfo&, const SceneOptions&);
std::unique_ptr<Scene> make_rollback_arena(const SceneInfo&, const SceneOptions&);

} // namespace lockstone::scenes_detail
