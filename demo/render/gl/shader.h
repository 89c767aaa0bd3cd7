#pragma once
/// A linked GLSL program.

#include "gl.h"

#include <glm/glm.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>

namespace lockstone::demo {

/// One vertex and one fragment stage, linked. Move-only.
class Shader {
  public:
    /// Reads `vertex` and `fragment` from files; a line `#include "name.glsl"` is replaced by that file of
    /// the same folder. Throws std::runtime_error with the file and the driver's log.
    static Shader load(const std::filesystem::path& vertex, const std::filesystem::path& fragment);

    void use() const;

    /// Sets a uniform; call use() first. A name that the program does not have is ignored, because drivers remove
    /// unused ones.
    void set(std::string_view name, int value) const;
    void set(std::string_view name, float value) const;
    void set(std::string_view name, const glm::vec2& value) const;
    void set(std::string_view name, const glm::vec3& value) const;
    void set(std::string_view name, const glm::vec4& value) const;
    void set(std::string_view name, const glm::mat4& value) const;

  private:
    Shader() = default;
    GLint location(std::string_view name) const;
    void read_uniforms();

    GlProgram program_;
    std::map<std::string, GLint, std::less<>> locations_;
};

} // namespace lockstone::demo
