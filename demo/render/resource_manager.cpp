#include "resource_manager.h"

#include <stdexcept>
#include <utility>
#include <vector>

namespace lockstone::demo {
namespace {

/// The resource at `key`; calls `load` if it does not exist yet.
template <class T, class Load>
std::shared_ptr<const T> find_or_load(std::map<std::string, std::shared_ptr<const T>>& cache,
                                      const std::string& key, Load&& load) {
    const auto found = cache.find(key);
    if (found != cache.end()) return found->second;
    auto resource = std::make_shared<const T>(load());
    cache.emplace(key, resource);
    return resource;
}

} // namespace

std::filesystem::path find_demo_root() {
    std::vector<std::filesystem::path> candidates;
    std::error_code error;
    const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    if (!error) {
        const std::filesystem::path folder = program.parent_path();
        candidates.push_back(folder);
        candidates.push_back(folder / "demo");
        candidates.push_back(folder.parent_path() / "share" / "lockstone" / "demo");
    }
#ifdef LOCKSTONE_DEMO_DIR
    candidates.emplace_back(LOCKSTONE_DEMO_DIR);
#endif
    std::string looked;
    for (const std::filesystem::path& candidate : candidates) {
        if (std::filesystem::is_directory(candidate / "shaders", error) &&
            std::filesystem::is_directory(candidate / "assets", error))
            return candidate;
        looked += (looked.empty() ? "" : ", ") + candidate.string();
    }
    throw std::runtime_error("cannot find the demo's folders shaders and assets; looked in " + looked);
}

ResourceManager::ResourceManager(std::filesystem::path root) : root_(std::move(root)) {}

std::shared_ptr<const Texture> ResourceManager::texture(const std::string& name) {
    const std::filesystem::path path = asset_path(name);
    return find_or_load(textures_, path.lexically_normal().string(), [&] { return Texture::load(path); });
}

std::shared_ptr<const Model> ResourceManager::model(const std::string& name) {
    return find_or_load(models_, name, [&] {
        return Model::load(asset_path(name),
                           [this](const std::filesystem::path& path) { return texture(path); });
    });
}

std::shared_ptr<const Shader> ResourceManager::shader(const std::string& vertex,
                                                      const std::string& fragment) {
    return find_or_load(shaders_, vertex + '+' + fragment, [&] {
        const std::filesystem::path folder = root_ / "shaders";
        return Shader::load(folder / (vertex + ".vert.glsl"), folder / (fragment + ".frag.glsl"));
    });
}

std::shared_ptr<const Model> ResourceManager::add_model(const std::string& name, Model model) {
    auto shared = std::make_shared<const Model>(std::move(model));
    models_[name] = shared;
    return shared;
}

} // namespace lockstone::demo
