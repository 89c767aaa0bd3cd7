#include "cook/read/read_model.h"

#include "cook/import.h"
#include "cook/read/ply_strips.h"

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>

namespace lockstone::cook {
namespace {

constexpr unsigned steps = aiProcess_Triangulate | aiProcess_JoinIdenticalVertices | aiProcess_SortByPType |
                           aiProcess_PreTransformVertices;

void leave_out_lines(Assimp::Importer& importer) {
    importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE, aiPrimitiveType_POINT | aiPrimitiveType_LINE);
}

/// The error text of the importer, or a clearer one if it speaks of internal steps.
const char* reason_of(const char* words) {
    const auto says = [&](const char* part) {
        return std::string_view(words).find(part) != std::string_view::npos;
    };
    if (says("No meshes remaining")) return "it has no triangles; it is empty, or holds only points or lines";
    if (says("all meshes are orphaned")) return "no node of its scene holds triangles";
    return *words == 0 ? "the importer gave no reason" : words;
}

/// Centimetres become metres: FBX files name their unit in centimetres. Returns metres per unit. For other formats
/// assimp has applied the unit.
double unit_of(const aiScene& scene) {
    if (scene.mMetaData == nullptr) return 1;
    double centimetres = 0;
    if (float single = 0; scene.mMetaData->Get("UnitScaleFactor", single))
        centimetres = static_cast<double>(single);
    if (double exact = 0; scene.mMetaData->Get("UnitScaleFactor", exact)) centimetres = exact;
    return centimetres > 0 ? centimetres / 100 : 1;
}

void append(const aiMesh& mesh, double unit, Soup& soup) {
    const auto base = static_cast<std::uint32_t>(soup.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
        const aiVector3D& v = mesh.mVertices[i];
        soup.vertices.push_back(
            Point{static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)} * unit);
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
        const aiFace& face = mesh.mFaces[i];
        if (face.mNumIndices == 3)
            soup.triangles.push_back(
                {base + face.mIndices[0], base + face.mIndices[1], base + face.mIndices[2]});
    }
}

Result<Soup> soup_of(const Assimp::Importer& importer, const aiScene* scene) {
    if (scene == nullptr) return Error{reason_of(importer.GetErrorString())};
    Soup soup;
    for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
        const aiMesh& mesh = *scene->mMeshes[m];
        if (soup.vertices.size() + mesh.mNumVertices > import_vertices_max ||
            soup.triangles.size() + mesh.mNumFaces > import_triangles_max)
            return Error{"it has more triangles than a mesh may have"};
        append(mesh, unit_of(*scene), soup);
    }
    if (soup.triangles.empty()) return Error{reason_of("No meshes remaining")};
    return soup;
}

bool is_off(const std::string& path) {
    std::string end = path.substr(path.size() - std::min<std::size_t>(4, path.size()));
    for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return end == ".off";
}

/// The lines of an OFF file without comments. assimp 5.2.5 reads a comment between the faces as a face and then loses a
/// real one.
std::string without_comments(const std::string& text) {
    std::istringstream in(text);
    std::string out, line;
    while (std::getline(in, line)) {
        line.resize(std::min(line.size(), line.find('#')));
        if (line.find_first_not_of(" \t\r") != std::string::npos) out += line + "\n";
    }
    return out;
}

} // namespace

Result<Soup> read_model(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (const std::optional<Result<Soup>> strips = read_ply_strips(file)) return *strips;
    if (is_off(path)) {
        file.clear();
        file.seekg(0);
        const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        return read_model(std::as_bytes(std::span(text)), "off");
    }
    Assimp::Importer importer;
    leave_out_lines(importer);
    return soup_of(importer, importer.ReadFile(path, steps));
}

Result<Soup> read_model(std::span<const std::byte> bytes, const std::string& extension) {
    std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::istringstream file(text);
    if (const std::optional<Result<Soup>> strips = read_ply_strips(file)) return *strips;
    if (is_off("." + extension)) text = without_comments(text);
    if (text.empty()) return Error{reason_of("No meshes remaining")};
    Assimp::Importer importer;
    leave_out_lines(importer);
    return soup_of(importer, importer.ReadFileFromMemory(text.data(), text.size(), steps, extension.c_str()));
}

} // namespace lockstone::cook
