#include "object.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace lockstone::demo {

Object::Object(std::shared_ptr<const Model> model, const glm::mat4& transform)
    : model_(std::move(model)), transform_(transform) {
    assert(model_ && "an object needs a model");
}

const Material& Object::material(std::size_t index) const {
    return material_ ? *material_ : model_->parts()[index].material;
}

glm::vec4 Object::bounding_sphere() const {
    const Bounds& bounds = model_->bounds();
    const float scale =
        std::max({glm::length(glm::vec3(transform_[0])), glm::length(glm::vec3(transform_[1])),
                  glm::length(glm::vec3(transform_[2]))});
    return {glm::vec3(transform_ * glm::vec4(bounds.centre(), 1)), scale * bounds.radius()};
}

} // namespace lockstone::demo
