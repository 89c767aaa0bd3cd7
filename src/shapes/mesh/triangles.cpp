// Functions for solids with triangles: calls those of the mesh or of the height field.
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
    const Face face = face_at(solid, index);
    const FaceEdges edges = edges_at(solid, face);
    return {{face.corner[0], face.corner[1], face.corner[2]},
            face.normal,
            index,
            solid.mesh != nullptr ? solid.mesh->material_of(index) : solid.height_field->material_of(index),
            edges.sharp,
            {edges.beyond[0], edges.beyond[1], edges.beyond[2]}};
}

Face face_at(const Solid& solid, std::uint32_t index) {
    return solid.mesh != nullptr ? solid.mesh->face(index, solid.geometry.scale)
                                 : solid.height_field->face(index, solid.geometry.scale);
}

FacePlane plane_at(const Solid& solid, std::uint32_t index) {
    if (solid.mesh != nullptr && solid.geometry.scale == scale_one) return solid.mesh->plane(index);
    const Face face = face_at(solid, index);
    return {face.corner[0], face.normal};
}

FaceEdges edges_at(const Solid& solid, const Face& face) {
    return solid.mesh != nullptr ? solid.mesh->edges(face, solid.geometry.scale)
                                 : solid.height_field->edges(face, solid.geometry.scale);
}

bool is_two_sided(const Solid& solid) { return solid.mesh != nullptr && solid.mesh->is_two_sided(); }

} // namespace lockstone::shapes
