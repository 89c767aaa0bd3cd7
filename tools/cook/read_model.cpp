#include "cook/read_model.h"

#include "cook/import.h"

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace lockstone::cook {
namespace {

constexpr unsigned steps = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                           aiProcess_PreTransformVertices;

void leave_out_lines(Assimp::Importer& importer) {
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
}

Result<Soup> soup_of(const Assimp::Importer& importer, const aiScene* scene) {
    if (scene == nullptr) return Error{importer.GetErrorString()};
    Soup soup;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const aiMesh& mesh = *scene->mMeshes[m];
        const auto base = static_cast<std::uint32_t>(soup.vertices.size());
        if (soup.vertices.size() + mesh.mNumVertices > import_vertices_max ||
            soup.triangles.size() + mesh.mNumFaces > import_triangles_max)
            return Error{"it has more than " + std::to_string(import_triangles_max) + " triangles"};
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            const aiVector3D& v = mesh.mVertices[i];
            soup.vertices.push_back(
                {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
        }
        for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
            const aiFace& face = mesh.mFaces[i];
            if (face.mNumIndices == 3)
                soup.triangles.push_back(
                    {base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
        }
    }
    if (soup.triangles.empty()) return Error{"it has no triangles"};
    return soup;
}

} // namespace

Result<Soup> read_model(const std::string& path) {
    Assimp::Importer importer;
    leave_out_lines(importer);
    return soup_of(importer, importer.ReadFile(path, steps));
}

Result<Soup> read_model(std::span<const std::byte> bytes, const std::string& extension) {
    Assimp::Importer importer;
    leave_out_lines(importer);
    return soup_of(importer,
                   importer.ReadFileFromMemory(bytes.data(), bytes.size(), steps, extension.c_str()));
}

} // namespace lockstone::cook
