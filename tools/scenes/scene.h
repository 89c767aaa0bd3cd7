// What all scenes share: name, options, content id, and a builder that keeps the first error.
#pragma once

#include "lockstone/play/ragdoll.h"
#include "scenes/scenes.h"

namespace lockstone::scenes_detail {

/// What the rules of a scene do to the world in one tick. The first command that fails is kept and ends the tick's run; what
/// the rules do after it is no longer of use.
class Turn {
  public:
    explicit Turn(World& played) : world(played) {}
    World& world;
    void must(const Status& done) {
        if (status) status = done;
    }
    /// The tick, unless a command has failed.
    Status finish() {
        if (status) world.tick();
        return status;
    }

  private:
    Status status;
};

/// What a scene's check of a loaded state finds; the first sentence stays.
class StateCheck {
  public:
    explicit StateCheck(const World& checked, std::string_view column) : world(checked), where(column) {}
    /// `what` names the field; an id of something that lives.
    template <class Id> StateCheck& alive(Id id, std::string_view what) {
        return holds(world.is_alive(id), what, "names nothing that lives");
    }
    /// A body that lives and that forces move.
    StateCheck& dynamic(BodyId id, std::string_view what) {
        alive(id, what);
        return holds(!world.is_alive(id) || world.kind(id) == BodyKind::dynamic, what,
                     "names a body that no force moves");
    }
    StateCheck& holds(bool condition, std::string_view what, std::string_view why);
    Status finish() const { return status; }

  private:
    const World& world;
    std::string_view where;
    Status status;
};

/// A scene with its options filled in. Scenes without players need `start` alone.
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

    /// See controls_of; only for players that there are.
    virtual Controls controls(std::uint32_t) const { return {}; }
    /// See scripted_input; `input` is zero on entry.
    virtual void script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                        std::span<std::byte> input) const;

  protected:
    /// The commands before the tick.
    virtual void play(Turn&, std::span<const PlayerInput>) const {}

    const SceneInfo& info;
    const SceneOptions options; ///< nothing is left at "the scene's own"
    const std::uint32_t rules_version;
};

/// The assets of a scene, baked as it starts; after the first error the rest is skipped and `finish` returns it.
class Shelf {
  public:
    Shelf() = default;
    explicit Shelf(AssetLibrary with) : library(std::move(with)) {}
    Geometry add(const Result<AssetBytes>& baked); ///< with the kind that it has
    Result<std::shared_ptr<const AssetLibrary>> finish() &&;

  private:
    AssetLibrary library;
    Status status;
};

/// Makes a world body by body; after the first error the rest is skipped and `finish` returns it.
class Builder {
  public:
    explicit Builder(const WorldDef& def, const GameSchema& schema = {},
                     std::shared_ptr<const AssetLibrary> assets = nullptr);

    BodyId body(const BodyDef& def, const ShapeDef& shape);
    void shape(BodyId body, const ShapeDef& shape);
    BodyId ground(); ///< a plane through the origin
    /// Between two bodies where they stand, the first of which may be null; see World::create_joint.
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

/// A world that holds `dynamic_bodies` bodies of one shape, the scenery, and their contacts.
WorldDef world_for(std::uint32_t dynamic_bodies, std::uint64_t seed);

/// Placed upright at a point.
Transform at(Vec3 position);
Transform at(Vec3 position, Quat rotation);

// One per scene; the registry in scenes.cpp lists them.
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
