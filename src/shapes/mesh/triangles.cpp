// The triangles of meshes and height fields, whichever it is.
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

namespace lockstone::shapes {

std::uint32_t triangle_count(const Solid& solid) {
    return solid.mesh != nullptr ? solid.mesh->triangle_count() : solid.height_field->triangle_count();
}

void find_triangles(const Solid& solid, const Extent& where, std::vector<std::uint32_t>& out) {
    if (solid.mesh != nullptr)
        solid.mesh->find(where, solid.geometry.scale, out);
    else
        solid.height_field->find(where, solid.geometry.scale, out);
}

Triangle triangle_at(const Solid& solid, std::uint32_t index) {
    return solid.mesh != nullptr ? solid.mesh->triangle(index, solid.geometry.scale)
                                 : solid.height_field->triangle(index, solid.geometry.scale);
}

Face face_at(const Solid& solid, std::uint32_t index) {
    return solid.mesh != nullptr ? solid.mesh->face(index, solid.geometry.scale)
                                 : solid.height_field->face(index, solid.geometry.scale);
}

bool is_two_sided(const Solid& solid) { return solid.mesh != nullptr && solid.mesh->is_two_sided(); }

} // namespace lockstone::shapes
