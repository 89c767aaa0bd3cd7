#pragma once
/// The state of a world for drawing: read after every tick, drawn between two ticks.

#include "field_marks.h"
#include "game_values.h"
#include "joint_marks.h"
#include "pages/page.h"
#include "render/assets/mesh.h"
#include "scenes/scenes.h"
#include "shape_meshes.h"

#include <glm/gtc/quaternion.hpp>

#include <optional>
#include <span>
#include <vector>

namespace lockstone::demo {

class SceneView {
  public:
    /// Reads the world after a tick. The current state becomes the previous one.
    void capture(const World& world);
    /// Reads the world after a jump in time. Previous and current state are then equal.
    void reset(const World& world);

    /// Adds the bodies and the elements that `stage.view` switches on. `alpha`: 0 the previous state, 1 the current
    /// one. A static box between the camera and the followed player (or all moving bodies) is drawn as its edges.
    void draw(Frame& frame, float alpha, const Stage& stage, std::optional<std::uint32_t> followed) const;

    /// The position of a player's body [m]; empty if it does not exist.
    std::optional<glm::vec3> player_position(std::uint32_t player, float alpha) const;
    std::uint32_t player_count() const;

    /// Bounds of the moving bodies, or of all bodies if none moves, together with the company [m].
    Bounds bounds() const;
    /// Sets the bounds of other objects that belong into the picture [m].
    void set_company(const Bounds& company) { company_ = company; }

    std::size_t body_count() const { return bodies_.size(); }
    std::size_t contact_count() const { return contacts_.size(); }
    const std::optional<MatchValues>& match() const { return match_; }

  private:
    struct Pose {
        glm::vec3 position{0};
        glm::quat rotation{1, 0, 0, 0};
    };
    struct Part {
        Geometry geometry;
        glm::mat4 local;
        Bounds bounds{};                      ///< in the shape's frame
        std::optional<ShapeKind> primitive{}; ///< the primitive that is drawn; empty: a mesh of its own
        glm::vec3 size{0};                    ///< of the primitive
        bool crate = false;                   ///< similar enough to a cube for the crate model
    };
    struct Body {
        BodyId id;
        Role role;
        std::uint32_t number;
        BodyKind kind;
        glm::vec3 colour;
        Pose previous, current;
        std::vector<Part> parts;
    };
    struct Touch {
        glm::vec3 point, normal;
        float impulse;
    };

    Body read_body(const World& world, BodyId id, std::uint32_t row);
    void read_wheels(const World& world);
    Part read_part(const ShapeDef& def);
    const Body* find(BodyId id, std::size_t hint) const;
    static glm::mat4 pose(const Body& body, float alpha);
    std::vector<glm::vec3> sights(std::optional<std::uint32_t> followed, float alpha) const;
    void draw_body(Frame& frame, const Body& body, float alpha, const Stage& stage,
                   std::span<const glm::vec3> sights) const;
    void draw_part(Frame& frame, const Body& body, const Part& part, const glm::mat4& place, bool as_crate,
                   const Stage& stage) const;
    void draw_contacts(Frame& frame) const;
    void draw_joints(Frame& frame, float alpha, bool all) const;
    void draw_it(Frame& frame, float alpha) const;

    std::vector<Body> bodies_; ///< by row
    std::vector<Body> wheels_; ///< of vehicles; they are no bodies of the world, `id` is the chassis
    std::vector<Touch> contacts_;
    std::vector<JointMark> joints_;
    std::vector<FieldMark> fields_;
    std::optional<MatchValues> match_;
    std::shared_ptr<const AssetLibrary> assets_;
    std::unique_ptr<ShapeMeshes> meshes_ = std::make_unique<ShapeMeshes>();
    std::uint64_t tick_ = 0;
    Bounds company_; ///< empty: none
};

} // namespace lockstone::demo
