#include "mesh.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace lockstone::demo {
namespace {

/// Attribute `index` of the bound buffer: `floats` values at `offset`. GL takes buffer offsets as pointers.
void attribute(GLuint index, GLint floats, std::size_t stride, std::size_t offset, GLuint divisor) {
    glVertexAttribPointer(index, floats, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(stride),
                          reinterpret_cast<const void*>(offset));
    glEnableVertexAttribArray(index);
    glVertexAttribDivisor(index, divisor);
}

template <class T> void upload(GLenum target, const GlBuffer& buffer, const std::vector<T>& items) {
    glBindBuffer(target, buffer.get());
    glBufferData(target, static_cast<GLsizeiptr>(items.size() * sizeof(T)), items.data(), GL_STATIC_DRAW);
}

void check(const MeshData& data) {
    if (data.indices.size() < 3 || data.indices.size() % 3 != 0)
        throw std::runtime_error("a mesh of " + std::to_string(data.indices.size()) +
                                 " indices is no triangle list");
    if (data.indices.size() > static_cast<std::size_t>(std::numeric_limits<GLsizei>::max()))
        throw std::runtime_error("a mesh of " + std::to_string(data.indices.size()) +
                                 " indices is too large");
    const std::uint32_t largest = *std::max_element(data.indices.begin(), data.indices.end());
    if (largest >= data.vertices.size())
        throw std::runtime_error("mesh index " + std::to_string(largest) + " exceeds its " +
                                 std::to_string(data.vertices.size()) + " vertices");
}

} // namespace

Mesh::Mesh(const MeshData& data) {
    check(data);
    array_ = GlVertexArray::make();
    vertices_ = GlBuffer::make();
    indices_ = GlBuffer::make();
    glBindVertexArray(array_.get());
    upload(GL_ARRAY_BUFFER, vertices_, data.vertices);
    upload(GL_ELEMENT_ARRAY_BUFFER, indices_, data.indices);
    attribute(0, 3, sizeof(Vertex), offsetof(Vertex, anchor), 0);
    attribute(1, 3, sizeof(Vertex), offsetof(Vertex, offset), 0);
    attribute(2, 3, sizeof(Vertex), offsetof(Vertex, normal), 0);
    attribute(3, 2, sizeof(Vertex), offsetof(Vertex, uv), 0);
    glBindVertexArray(0);
    index_count_ = static_cast<GLsizei>(data.indices.size());
    for (const Vertex& vertex : data.vertices) bounds_.add(vertex.anchor);
    check_gl("Mesh");
}

void Mesh::draw(const GlBuffer& instances, std::size_t first, std::size_t count) const {
    if (count == 0) return;
    glBindVertexArray(array_.get());
    glBindBuffer(GL_ARRAY_BUFFER, instances.get());
    // GL 3.3 has no base instance: the first record is chosen by moving the attributes' start.
    const std::size_t start = first * sizeof(GpuInstance);
    for (GLuint column = 0; column < 4; ++column) {
        const std::size_t offset = start + offsetof(GpuInstance, pose) + column * sizeof(glm::vec4);
        attribute(4 + column, 4, sizeof(GpuInstance), offset, 1);
    }
    attribute(8, 4, sizeof(GpuInstance), start + offsetof(GpuInstance, scale_radius), 1);
    attribute(9, 4, sizeof(GpuInstance), start + offsetof(GpuInstance, colour_highlight), 1);
    glDrawElementsInstanced(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr,
                            static_cast<GLsizei>(count));
    glBindVertexArray(0);
}

} // namespace lockstone::demo
