#include "material.h"

namespace lockstone::demo {

void Material::bind(const Shader& shader, const Texture& white) const {
    shader.set("material_colour", colour);
    shader.set("material_roughness", roughness);
    shader.set("material_metalness", metalness);
    shader.set("material_pattern", static_cast<int>(pattern));
    shader.set("material_texture", 0);
    (texture ? *texture : white).bind(0);
    if (two_sided)
        glDisable(GL_CULL_FACE);
    else
        glEnable(GL_CULL_FACE);
}

} // namespace lockstone::demo
