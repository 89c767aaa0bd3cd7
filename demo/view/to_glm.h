#pragma once
/// Converts values of the engine to GLM, for drawing.

#include "lockstone/math/convert.h"

#include <glm/glm.hpp>

namespace lockstone::demo {

inline glm::vec3 to_glm(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }
inline glm::vec3 to_glm(Vec3 v) { return to_glm(to_float(v)); }

inline glm::mat4 to_glm(const Transform& t) {
    const std::array<float, 16> m = to_float_matrix(t);
    glm::mat4 out;
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row) out[column][row] = m[static_cast<std::size_t>(4 * column + row)];
    return out;
}

} // namespace lockstone::demo
