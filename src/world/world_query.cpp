// World's queries.
#include "scene/query.h"
#include "world/world_impl.h"

#include <algorithm>

namespace lockstone {

std::optional<QueryHit> World::cast_ray(const Ray& ray, const QueryFilter& filter) const {
    return sim::cast_ray(impl->scene(), ray, filter);
}

bool World::cast_ray_any(const Ray& ray, const QueryFilter& filter) const {
    return sim::cast_ray_any(impl->scene(), ray, filter);
}

void World::cast_ray_all(const Ray& ray, const QueryFilter& filter, std::vector<QueryHit>& hits) const {
    hits.clear();
    sim::cast_ray_all(impl->scene(), ray, filter, hits);
}

void World::cast_rays(std::span<const Ray> rays, const QueryFilter& filter,
                      std::span<std::optional<QueryHit>> hits) const {
    for (std::size_t i = 0; i < std::min(rays.size(), hits.size()); ++i) hits[i] = cast_ray(rays[i], filter);
}

std::optional<QueryHit> World::cast_shape(const Geometry& geometry, const Transform& pose, Vec3 translation,
                                          const QueryFilter& filter) const {
    return sim::cast_shape(impl->scene(), geometry, pose, translation, filter);
}

bool World::cast_shape_any(const Geometry& geometry, const Transform& pose, Vec3 translation,
                           const QueryFilter& filter) const {
    return sim::cast_shape_any(impl->scene(), geometry, pose, translation, filter);
}

void World::cast_shape_all(const Geometry& geometry, const Transform& pose, Vec3 translation,
                           const QueryFilter& filter, std::vector<QueryHit>& hits) const {
    hits.clear();
    sim::cast_shape_all(impl->scene(), geometry, pose, translation, filter, hits);
}

void World::overlap(const Geometry& geometry, const Transform& pose, const QueryFilter& filter,
                    std::vector<ShapeId>& shapes) const {
    shapes.clear();
    sim::overlap(impl->scene(), geometry, pose, filter, shapes);
}

std::optional<QueryHit> World::nearest(const Geometry& geometry, const Transform& pose, Real limit,
                                       const QueryFilter& filter) const {
    return sim::nearest(impl->scene(), geometry, pose, limit, filter);
}

std::optional<ShapeDistance> World::distance(ShapeId a, ShapeId b) const {
    return sim::distance(impl->scene(), a, b);
}

} // namespace lockstone
