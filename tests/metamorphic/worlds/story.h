// A world as data: its definition, its start and every command with its tick. All execution modes play one story.
#pragma once

#include "lockstone/assemble.h"
#include "lockstone/world.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace worlds {

using namespace lockstone;

/// Parts of the interface that a story contains. The coverage table has a column for each.
enum class Feature : std::uint32_t {
    bounces,
    rolls,
    slides,
    locks,
    bullets,
    no_gyroscope,
    one_way,
    sensors,
    starts_asleep,
    sleeps,
    kinematic,
    hulls,
    compounds,
    meshes,
    height_fields,
    joints,
    joint_springs,
    joint_limits,
    joint_motors,
    joint_friction,
    joints_break,
    loops_of_joints,
    fields,
    fluids,
    explosions,
    vehicles,
    characters,
    ragdolls,
    pair_filters,
    groups,
    masses,
    damping,
    gravity_scales,
    integrators,
    far_away,
    comes_and_goes,
    drops_contacts,
    game_columns,
    assembled,
    wild,
    count_,
};
inline constexpr std::uint32_t feature_count = static_cast<std::uint32_t>(Feature::count_);
const char* name_of(Feature feature);

struct Step {
    std::uint64_t tick; ///< the command is applied before this tick
    Command command;
};

struct Story {
    WorldDef def;
    std::optional<Level> start; ///< assembled before the first step
    std::vector<Step> steps;    ///< ascending by tick
    std::uint64_t ticks = 0;
    std::uint64_t features = 0; ///< bits of Feature
    /// True: an id names the step that creates the object, index = step + 1. The story then remains valid when steps
    /// are removed.
    bool is_symbolic = false;

    bool has(Feature f) const { return (features >> static_cast<std::uint32_t>(f) & 1) != 0; }
    void add(Feature f) { features |= std::uint64_t{1} << static_cast<std::uint32_t>(f); }
};

/// The columns that the stories' game adds to the engine's.
const GameSchema& story_schema();
/// An empty world with this definition. Ends the program if the definition is refused.
World story_world(const WorldDef& def);
/// The assets that stories use: ordinary ones, and those at the limits of every kind. Made once.
std::shared_ptr<const AssetLibrary> story_assets();
/// The assets of a kind with the size of furniture, or of a room's ground. The last compound is a floor.
std::vector<Geometry> ordinary_assets(ShapeKind kind);

/// Calls visit(id) for each id of a command.
template <class Visit> void for_each_id(Command& command, Visit&& visit);

/// Plays the steps of a story into a world. The caller may replace the world by another one in an equal state at any
/// time.
class Teller {
  public:
    explicit Teller(const Story& story) : told(story), made(story.is_symbolic ? story.steps.size() : 0) {}
    /// A world at the start of the story. If `order` is not 0, the start is assembled in another order.
    World start(std::uint64_t order) const;
    /// Applies the commands before tick `tick`, which must not have run. Refused commands change nothing.
    void apply(World& world, std::uint64_t tick);
    /// The objects that the steps created, for a story whose ids are those of a world.
    const std::vector<World::Applied>& applied() const { return made; }
    void keep_applied() { made.resize(told.steps.size()); }

  private:
    const Story& told;
    std::vector<World::Applied> made; ///< by step; empty unless needed
};

/// A copy of the story whose ids name steps. Its start becomes steps of tick 0.
Story symbolic(const Story& story);

template <class Tag, class Visit> void visit_ids(Id<Tag>& id, Visit& visit) { visit(id); }
template <class T, class Visit> void visit_ids(T& value, Visit& visit) {
    if constexpr (Leaf<T>) {
        (void)value;
    } else if constexpr (is_std_array<T>) {
        for (auto& entry : value) visit_ids(entry, visit);
    } else {
        describe(value, [&](const char*, auto& field) { visit_ids(field, visit); });
    }
}
template <class Visit> void for_each_id(Command& command, Visit&& visit) {
    std::visit([&](auto& c) { visit_ids(c, visit); }, command);
}

} // namespace worlds
