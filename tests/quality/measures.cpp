#include "quality/row.h"

#include <algorithm>

namespace quality {

double turned(Turn a, Turn b) {
    const double c = std::abs(a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w);
    return 2 * std::acos(std::min(c, 1.0));
}

double drift(const Scene& scene, const Engine& engine) {
    double most = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].mass == 0) continue;
        const V3 moved = engine.state(static_cast<int>(i)).position - scene.bodies[i].position;
        most = std::max(most, std::hypot(moved.x, moved.z));
    }
    return most;
}

int fallen(const Scene& scene, const Engine& engine, double drop) {
    int count = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Body& body = scene.bodies[i];
        if (body.mass == 0) continue;
        const State s = engine.state(static_cast<int>(i));
        const bool stands =
            body.position.y - s.position.y <= drop && turned(s.rotation, body.rotation) <= radians(20);
        if (!stands) ++count;
    }
    return count;
}

} // namespace quality
