#include "shader.h"

#include "image.h"

#include <glm/gtc/type_ptr.hpp>

#include <sstream>
#include <stdexcept>
#include <vector>

namespace lockstone::demo {
namespace {

/// The text of `path` with its includes. `depth` limits files that include each other.
std::string read_source(const std::filesystem::path& path, int depth = 0) {
    if (depth > 8) throw std::runtime_error("shader " + path.string() + " is included too deeply");
    const std::vector<std::uint8_t> bytes = read_file(path);
    std::istringstream lines(std::string(bytes.begin(), bytes.end()));
    std::string out;
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        constexpr std::string_view directive = "#include \"";
        if (!line.starts_with(directive)) {
            out += line + '\n';
            continue;
        }
        const std::string name =
            line.substr(directive.size(), line.find('"', directive.size()) - directive.size());
        // Included lines have their own numbers; afterwards the numbering of this file continues.
        out += "#line 1\n" + read_source(path.parent_path() / name, depth + 1);
        out += "#line " + std::to_string(number + 1) + '\n';
    }
    return out;
}

GlStage compile(GLenum kind, const std::filesystem::path& path) {
    const std::string source = read_source(path);
    GlStage stage = GlStage::make(kind);
    const char* text = source.c_str();
    glShaderSource(stage.get(), 1, &text, nullptr);
    glCompileShader(stage.get());
    GLint compiled = GL_FALSE;
    glGetShaderiv(stage.get(), GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return stage;
    GLchar log[2048] = "";
    glGetShaderInfoLog(stage.get(), sizeof log, nullptr, log);
    throw std::runtime_error("shader " + path.string() + " does not compile: " + log);
}

} // namespace

Shader Shader::load(const std::filesystem::path& vertex, const std::filesystem::path& fragment) {
    const GlStage vertex_stage = compile(GL_VERTEX_SHADER, vertex);
    const GlStage fragment_stage = compile(GL_FRAGMENT_SHADER, fragment);
    Shader shader;
    shader.program_ = GlProgram::make();
    const GLuint program = shader.program_.get();
    glAttachShader(program, vertex_stage.get());
    glAttachShader(program, fragment_stage.get());
    glLinkProgram(program);
    glDetachShader(program, vertex_stage.get());
    glDetachShader(program, fragment_stage.get());
    GLint linked = GL_FALSE;
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (linked != GL_TRUE) {
        GLchar log[2048] = "";
        glGetProgramInfoLog(program, sizeof log, nullptr, log);
        throw std::runtime_error("shaders " + vertex.string() + " and " + fragment.string() +
                                 " do not link: " + log);
    }
    shader.read_uniforms();
    check_gl("Shader::load");
    return shader;
}

void Shader::read_uniforms() {
    GLint count = 0;
    glGetProgramiv(program_.get(), GL_ACTIVE_UNIFORMS, &count);
    for (GLint i = 0; i < count; ++i) {
        GLchar name[128] = "";
        GLint size = 0;
        GLenum type = 0;
        glGetActiveUniform(program_.get(), static_cast<GLuint>(i), sizeof name, nullptr, &size, &type, name);
        locations_[name] = glGetUniformLocation(program_.get(), name);
    }
}

GLint Shader::location(std::string_view name) const {
    const auto found = locations_.find(name);
    return found == locations_.end() ? -1 : found->second; // GL ignores location -1
}

void Shader::use() const { glUseProgram(program_.get()); }

void Shader::set(std::string_view name, int value) const { glUniform1i(location(name), value); }
void Shader::set(std::string_view name, float value) const { glUniform1f(location(name), value); }
void Shader::set(std::string_view name, const glm::vec2& value) const {
    glUniform2fv(location(name), 1, glm::value_ptr(value));
}
void Shader::set(std::string_view name, const glm::vec3& value) const {
    glUniform3fv(location(name), 1, glm::value_ptr(value));
}
void Shader::set(std::string_view name, const glm::vec4& value) const {
    glUniform4fv(location(name), 1, glm::value_ptr(value));
}
void Shader::set(std::string_view name, const glm::mat4& value) const {
    glUniformMatrix4fv(location(name), 1, GL_FALSE, glm::value_ptr(value));
}

} // namespace lockstone::demo
