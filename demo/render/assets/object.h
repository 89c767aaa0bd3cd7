#pragma once
/// A model placed in the world.

#include "model.h"

#include <glm/glm.hpp>

#include <memory>
#include <optional>

namespace lockstone::demo {

/// Shares its model; cheap to copy.
class Object {
  public:
    /// `model` must not be null.
    explicit Object(std::shared_ptr<const Model> model, const glm::mat4& transform = glm::mat4(1));

    const std::shared_ptr<const Model>& model() const { return model_; }

    /// The material of part `index`: the override if one is set, else the model's own.
    const Material& material(std::size_t index) const;

    /// Draws every part with `material` in place of its own; std::nullopt restores their own.
    void set_material(std::optional<Material> material) { material_ = std::move(material); }

    /// Model frame to world, y up [m]. May scale, but not mirror.
    const glm::mat4& transform() const { return transform_; }
    void set_transform(const glm::mat4& transform) { transform_ = transform; }

    /// Multiplies the material's colour, sRGB.
    const glm::vec3& tint() const { return tint_; }
    void set_tint(const glm::vec3& tint) { tint_ = tint; }

    /// 0 .. 1: a glowing rim for selected objects.
    float highlight() const { return highlight_; }
    void set_highlight(float highlight) { highlight_ = highlight; }

    /// World bounding sphere: centre xyz, radius w [m].
    glm::vec4 bounding_sphere() const;

  private:
    std::shared_ptr<const Model> model_;
    std::optional<Material> material_;
    glm::mat4 transform_;
    glm::vec3 tint_{1};
    float highlight_ = 0;
};

} // namespace lockstone::demo
