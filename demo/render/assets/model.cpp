#include "model.h"

#include <assimp/GltfMaterial.h>
#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace lockstone::demo {
namespace {

glm::vec3 to_glm(const aiVector3D& v) { return {v.x, v.y, v.z}; }

/// Keeps only the triangles of `source`; points and lines are dropped.
MeshData read_mesh(const aiMesh& source) {
    MeshData mesh;
    mesh.vertices.reserve(source.mNumVertices);
    for (unsigned i = 0; i < source.mNumVertices; ++i) {
        Vertex vertex{.anchor = to_glm(source.mVertices[i])};
        if (source.HasNormals()) vertex.normal = to_glm(source.mNormals[i]);
        if (source.HasTextureCoords(0))
            vertex.uv = {source.mTextureCoords[0][i].x, source.mTextureCoords[0][i].y};
        mesh.vertices.push_back(vertex);
    }
    for (unsigned i = 0; i < source.mNumFaces; ++i) {
        const aiFace& face = source.mFaces[i];
        if (face.mNumIndices != 3) continue;
        mesh.indices.insert(mesh.indices.end(), {face.mIndices[0], face.mIndices[1], face.mIndices[2]});
    }
    return mesh;
}

/// A texture inside the model file (GLB, FBX): compressed when its height is 0, else raw BGRA texels.
Image read_embedded(const aiTexture& source, const std::string& name) {
    if (source.mHeight == 0)
        return decode_image({reinterpret_cast<const std::uint8_t*>(source.pcData), source.mWidth}, name);
    Image image{.width = static_cast<int>(source.mWidth), .height = static_cast<int>(source.mHeight)};
    const std::size_t count = static_cast<std::size_t>(source.mWidth) * source.mHeight;
    image.pixels.reserve(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
        const aiTexel& texel = source.pcData[i];
        image.pixels.insert(image.pixels.end(), {texel.r, texel.g, texel.b, texel.a});
    }
    return image;
}

/// Converts the linear colour of the file to sRGB, as Material stores it.
glm::vec3 to_srgb(const aiColor3D& colour) {
    const auto encode = [](float value) { return std::pow(glm::clamp(value, 0.0f, 1.0f), 1 / 2.2f); };
    return {encode(colour.r), encode(colour.g), encode(colour.b)};
}

Material read_material(const aiScene& scene, const aiMaterial& source, const std::filesystem::path& path,
                       const Model::TextureLoader& load_texture) {
    Material material;
    aiColor3D colour(1, 1, 1);
    float value = 0;
    int two_sided = 0;
    // The factors of glTF are linear. The colours of OBJ and similar formats are sRGB by convention.
    if (source.Get(AI_MATKEY_BASE_COLOR, colour) == AI_SUCCESS)
        material.colour = to_srgb(colour);
    else if (source.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == AI_SUCCESS)
        material.colour = {colour.r, colour.g, colour.b};
    if (source.Get(AI_MATKEY_ROUGHNESS_FACTOR, value) == AI_SUCCESS)
        material.roughness = glm::clamp(value, 0.05f, 1.0f);
    else if (source.Get(AI_MATKEY_SHININESS, value) == AI_SUCCESS && value > 0)
        material.roughness = glm::clamp(std::pow(2 / (value + 2), 0.25f), 0.05f, 1.0f); // Blinn-Phong to GGX
    if (source.Get(AI_MATKEY_METALLIC_FACTOR, value) == AI_SUCCESS)
        material.metalness = glm::clamp(value, 0.0f, 1.0f);
    if (source.Get(AI_MATKEY_TWOSIDED, two_sided) == AI_SUCCESS) material.two_sided = two_sided != 0;

    aiString file;
    if (source.GetTexture(aiTextureType_BASE_COLOR, 0, &file) != AI_SUCCESS &&
        source.GetTexture(aiTextureType_DIFFUSE, 0, &file) != AI_SUCCESS)
        return material;
    if (const aiTexture* embedded = scene.GetEmbeddedTexture(file.C_Str()))
        material.texture =
            std::make_shared<Texture>(read_embedded(*embedded, path.string() + ":" + file.C_Str()));
    else
        material.texture = load_texture(path.parent_path() / file.C_Str());
    return material;
}

} // namespace

Model Model::load(const std::filesystem::path& path, const TextureLoader& texture) {
    Assimp::Importer importer;
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
    constexpr unsigned steps = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices |
                               aiProcess_GenSmoothNormals | aiProcess_SortByPType |
                               aiProcess_PreTransformVertices | aiProcess_FlipUVs |
                               aiProcess_ValidateDataStructure;
    const aiScene* scene = importer.ReadFile(path.string(), steps);
    if (scene == nullptr)
        throw std::runtime_error("cannot load model " + path.string() + ": " + importer.GetErrorString());
    Model model;
    for (unsigned i = 0; i < scene->mNumMeshes; ++i) {
        const aiMesh& mesh = *scene->mMeshes[i];
        if (!mesh.HasFaces() || (mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) continue;
        const aiMaterial& material = *scene->mMaterials[mesh.mMaterialIndex];
        try {
            model.add({Mesh(read_mesh(mesh)), read_material(*scene, material, path, texture)});
        } catch (const std::runtime_error& error) {
            throw std::runtime_error("cannot load model " + path.string() + ": " + error.what());
        }
    }
    if (model.parts_.empty())
        throw std::runtime_error("cannot load model " + path.string() + ": it has no triangles");
    return model;
}

Model Model::from_mesh(const MeshData& mesh, Material material) {
    Model model;
    model.add({Mesh(mesh), std::move(material)});
    return model;
}

void Model::add(Part part) {
    bounds_.add(part.mesh.bounds().min);
    bounds_.add(part.mesh.bounds().max);
    parts_.push_back(std::move(part));
}

} // namespace lockstone::demo
