// Draws one story while it plays it, because the possible commands depend on the content of the world.
#pragma once

#include "attack/worlds/values.h"
#include "draw.h"

#include <algorithm>

namespace worlds {

using attack::Values;

/// The initial arrangement of the bodies of a world. Each arrangement gives the graph of contacts another shape.
enum class Arrangement : std::uint32_t {
    wide_pit, ///< many bodies side by side: short chains of contacts
    deep_pit, ///< long chains of contacts
    towers,   ///< islands that do not touch each other
    wall,     ///< rows of a wall
    cloud,    ///< bodies that meet in the air
    crowd,    ///< all within a metre: each overlaps with many
    net,      ///< a grid whose neighbours joints hold, if there are joints
    count_,
};

/// One way in which a world is large. Each takes execution paths that smaller worlds do not take.
enum class Theme : std::uint32_t {
    none,  ///< an ordinary size
    mixed, ///< thousands of bodies with any features
    islands, ///< thousands of bodies in towers: contacts alone change velocities, so islands do all passes at once
    net,    ///< hundreds of joints that are one island
    crowd,  ///< more pairs than the table of contacts has room for
    driven, ///< dozens of kinematic bodies, and bodies that are fast
    count_,
};

class Drawer final : Journal {
  public:
    Drawer(std::uint64_t seed, const Extent& extent) : v(seed), most(extent), world(start(seed)) {
        world.set_journal(this);
    }
    Drawn run();

  private:
    void on_command(std::uint64_t tick, const Command& command) override {
        story.steps.push_back({tick, command});
    }
    void on_tick(std::uint64_t, std::uint64_t) override {}
    void on_restore(std::uint64_t) override {}

    World start(std::uint64_t seed);
    void choose_size();
    void choose_features();
    void keep_contacts_alone();
    void apply_theme();
    WorldDef world_def(std::uint64_t seed);
    bool has(Feature f) const { return story.has(f); }
    void drop(Feature f) { story.features &= ~(std::uint64_t{1} << static_cast<std::uint32_t>(f)); }
    /// Boxes of one size that lie on each other from the first tick on.
    bool is_stacked() const { return theme == Theme::islands; }
    /// True in one of `of` calls, in a world that has the feature.
    bool is_now(Feature f, std::uint32_t of) { return has(f) && v.chance(of); }

    Vec3 place(std::uint32_t number);
    std::int32_t net_columns() const {
        return std::max<std::int32_t>(2, static_cast<std::int32_t>(side.raw >> 31));
    }
    BodyDef body_def(Vec3 at);
    Geometry solid();
    Geometry of_asset(ShapeKind kind);
    ShapeDef shape_def(bool is_dynamic);
    Assembly assembly(Vec3 at);
    std::vector<Assembly> ground();
    JointDef joint_def();
    FieldDef field_def();

    void make(const Assembly& assembly);
    void add_joint(BodyId a, BodyId b);
    void add_joints();
    void add_net();
    void add_vehicle();
    void add_character();
    void add_ragdoll();
    void fill();
    void command();
    void push();
    void change_body();
    void change_shape();
    void change_actor();
    void come_and_go();

    BodyId body() { return world.body_at(v.below(world.body_count())); }
    /// A random body that is not static; null if there is none.
    BodyId mover() {
        for (int i = 0; i < 4; ++i)
            if (const BodyId b = body(); world.kind(b) != BodyKind::static_) return b;
        return {};
    }
    ShapeId shape() {
        const std::vector<ShapeId> shapes = world.shapes(body());
        return shapes.empty() ? ShapeId{} : shapes[v.below(static_cast<std::uint32_t>(shapes.size()))];
    }
    template <class T>
    void told(const Result<T>&) {} // worlds refuse some commands; a refusal is part of the story
    Real range(Real low, Real high) { return v.range(low, high); }
    Vec3 vector(Real most_each) {
        const Real x = range(-most_each, most_each), y = range(-most_each, most_each),
                   z = range(-most_each, most_each);
        return {x, y, z};
    }

    Story story;
    Values v;
    Extent most;
    std::uint32_t bodies = 0, activity = 0;
    Arrangement arrangement{};
    Theme theme = Theme::none;
    Vec3 center{};
    Real side{};                   ///< half of the width of what the bodies fill [m]
    std::int32_t tower = 1;        ///< bodies in a tower
    std::uint32_t drivers_of = 12; ///< one body in so many is kinematic
    std::uint64_t keys = 0;
    World world;
};

} // namespace worlds
