#include "draw_list.h"

#include "render/assets/primitives.h"

#include <algorithm>
#include <utility>

namespace lockstone::demo {
namespace {

/// The width of a box's rounded edge: large enough to reflect light, too small to change the look of the shape [m].
float bevel(const glm::vec3& half_extents) {
    return std::min(0.05f * std::min({half_extents.x, half_extents.y, half_extents.z}), 0.03f);
}

glm::vec4 scale_radius(const Instance& instance) {
    const glm::vec3& size = instance.size;
    switch (instance.kind) {
    case ShapeKind::sphere:
        return {0, 0, 0, size.x};
    case ShapeKind::capsule:
        return {0, size.y, 0, size.x};
    case ShapeKind::box:
        return {size - bevel(size), bevel(size)};
    case ShapeKind::cylinder:
    case ShapeKind::cone:
        return {size.x, size.y, size.x, 0};
    case ShapeKind::plane:
        return {size.x, 1, size.z, 0};
    }
    return {size, 0};
}

/// The distance from the origin to the farthest point [m].
float bounding_radius(const Instance& instance) {
    const glm::vec3& size = instance.size;
    switch (instance.kind) {
    case ShapeKind::sphere:
        return size.x;
    case ShapeKind::capsule:
        return size.x + size.y;
    case ShapeKind::cylinder:
    case ShapeKind::cone:
        return glm::length(glm::vec2(size));
    case ShapeKind::box:
    case ShapeKind::plane:
        break;
    }
    return glm::length(size);
}

} // namespace

ShapeLibrary::ShapeLibrary()
    : box_(make_box()), capsule_(make_capsule()), cylinder_(make_cylinder()), cone_(make_cone()),
      plane_(make_plane()) {
    const auto set = [this](ShapeKind kind, Pattern pattern, float roughness) {
        Material& material = materials_[static_cast<std::size_t>(kind)];
        material.pattern = pattern;
        material.roughness = roughness;
    };
    set(ShapeKind::sphere, Pattern::octants, 0.35f);
    set(ShapeKind::capsule, Pattern::quarters, 0.40f);
    set(ShapeKind::box, Pattern::plain, 0.55f);
    set(ShapeKind::cylinder, Pattern::quarters, 0.45f);
    set(ShapeKind::cone, Pattern::quarters, 0.45f);
    set(ShapeKind::plane, Pattern::checker, 0.85f);
}

const Mesh& ShapeLibrary::mesh(ShapeKind kind) const {
    switch (kind) {
    case ShapeKind::box:
        return box_;
    case ShapeKind::cylinder:
        return cylinder_;
    case ShapeKind::cone:
        return cone_;
    case ShapeKind::plane:
        return plane_;
    case ShapeKind::sphere:
    case ShapeKind::capsule:
        break;
    }
    return capsule_; // a sphere is a capsule of length 0
}

DrawList::DrawList() : buffer_(GlBuffer::make()) {}

void DrawList::build(const Frame& frame, const ShapeLibrary& library) {
    records_.clear();
    batches_.clear();
    casters_.clear();
    add_shapes(frame, library);
    add_objects(frame);
    glBindBuffer(GL_ARRAY_BUFFER, buffer_.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(records_.size() * sizeof(GpuInstance)),
                 records_.data(), GL_STREAM_DRAW);
}

void DrawList::add_shapes(const Frame& frame, const ShapeLibrary& library) {
    std::array<std::size_t, shape_kind_count + 1> ends{};
    for (const Instance& instance : frame.instances) ++ends[static_cast<std::size_t>(instance.kind) + 1];
    for (std::size_t kind = 0; kind < shape_kind_count; ++kind) {
        ends[kind + 1] += ends[kind];
        const auto shape = static_cast<ShapeKind>(kind);
        const std::size_t count = ends[kind + 1] - ends[kind];
        if (count != 0)
            batches_.push_back({&library.mesh(shape), &library.material(shape), ends[kind], count,
                                shape != ShapeKind::plane});
    }
    records_.resize(frame.instances.size());
    for (const Instance& instance : frame.instances) {
        const std::size_t slot = ends[static_cast<std::size_t>(instance.kind)]++;
        records_[slot] = {instance.pose, scale_radius(instance),
                          glm::vec4(instance.colour, instance.highlight)};
        if (instance.kind != ShapeKind::plane)
            casters_.emplace_back(glm::vec3(instance.pose[3]), bounding_radius(instance));
    }
}

void DrawList::add_objects(const Frame& frame) {
    // Sorts by model and material, so that each part of a model is one draw call. Sorting by pointers is correct here:
    // it changes the order of calls, not the picture.
    std::vector<const Object*> sorted;
    for (const Object& object : frame.objects) sorted.push_back(&object);
    const auto key = [](const Object* object) {
        return std::pair(object->model().get(), &object->material(0));
    };
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](const Object* a, const Object* b) { return std::less<>()(key(a), key(b)); });
    for (std::size_t begin = 0; begin < sorted.size();) {
        std::size_t end = begin;
        const std::size_t first = records_.size();
        while (end < sorted.size() && key(sorted[end]) == key(sorted[begin])) {
            const Object& object = *sorted[end++];
            records_.push_back(
                {object.transform(), {1, 1, 1, 0}, glm::vec4(object.tint(), object.highlight())});
            casters_.push_back(object.bounding_sphere());
        }
        const auto& parts = sorted[begin]->model()->parts();
        for (std::size_t i = 0; i < parts.size(); ++i)
            batches_.push_back({&parts[i].mesh, &sorted[begin]->material(i), first, end - begin, true});
        begin = end;
    }
}

} // namespace lockstone::demo
