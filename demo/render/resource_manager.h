#pragma once
/// Loads shared textures, shaders and models by name. Each file is read once. The folders `shaders/` and `assets/` are
/// searched next to the program, in `../share/lockstone/demo` relative to the program, and in the source tree.

#include "render/assets/model.h"
#include "render/gl/shader.h"
#include "render/gl/texture.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>

namespace lockstone::demo {

/// The folder that holds shaders/ and assets/: next to the program (or in its share/lockstone/demo), else the source
/// folder LOCKSTONE_DEMO_DIR. Throws std::runtime_error with the list of searched folders.
std::filesystem::path find_demo_root();

/// Loads at the first use and keeps everything until its destruction, which needs the GL context. Every failure is a
/// std::runtime_error that names the file and the reason.
class ResourceManager {
  public:
    explicit ResourceManager(std::filesystem::path root = find_demo_root());

    /// assets/NAME.
    std::shared_ptr<const Texture> texture(const std::string& name);

    /// assets/NAME in any format that assimp reads, or a model of add_model.
    std::shared_ptr<const Model> model(const std::string& name);

    /// shaders/VERTEX.vert.glsl with shaders/FRAGMENT.frag.glsl.
    std::shared_ptr<const Shader> shader(const std::string& vertex, const std::string& fragment);

    /// Registers a generated model; it replaces one of that name.
    std::shared_ptr<const Model> add_model(const std::string& name, Model model);

    /// The full path of assets/NAME; an absolute name is returned as it is.
    std::filesystem::path asset_path(const std::string& name) const { return root_ / "assets" / name; }

  private:
    std::filesystem::path root_;
    std::map<std::string, std::shared_ptr<const Texture>> textures_;
    std::map<std::string, std::shared_ptr<const Model>> models_;
    std::map<std::string, std::shared_ptr<const Shader>> shaders_;
};

} // namespace lockstone::demo
