#include "field_marks.h"

#include "to_glm.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {

FieldMark read_field(const World& world, FieldId field) {
    const FieldDef def = world.field(field);
    const glm::vec3 half = to_glm(def.region.half_extent);
    FieldMark mark{.is_water = def.kind == FieldKind::fluid && def.density > Real(10) &&
                               def.region.kind == RegionKind::box,
                   .surface = to_glm(def.region.pose),
                   .half = {half.x, half.z}};
    mark.surface[3] += mark.surface[1] * half.y;
    return mark;
}

void draw_field(Frame& frame, const FieldMark& field) {
    if (!field.is_water) return;
    constexpr float mesh = 0.5f; ///< [m] between threads
    constexpr int threads_max = 80;
    const glm::vec3 net_colour(0.25f, 0.6f, 0.95f), rim_colour(0.55f, 0.85f, 1.0f);
    const auto at = [&](float x, float z) { return glm::vec3(field.surface * glm::vec4(x, 0, z, 1)); };
    const auto thread = [&](const glm::vec3& from, const glm::vec3& to, bool is_rim) {
        frame.lines.push_back({.from = from,
                               .to = to,
                               .colour = is_rim ? rim_colour : net_colour,
                               .width = is_rim ? 2.5f : 1.0f});
    };
    const auto count = [&](float half) {
        return std::clamp(static_cast<int>(std::lround(2 * half / mesh)), 1, threads_max);
    };
    const int along_x = count(field.half.x), along_z = count(field.half.y);
    for (int i = 0; i <= along_x; ++i) {
        const float x = field.half.x * (2 * static_cast<float>(i) / static_cast<float>(along_x) - 1);
        thread(at(x, -field.half.y), at(x, field.half.y), i == 0 || i == along_x);
    }
    for (int i = 0; i <= along_z; ++i) {
        const float z = field.half.y * (2 * static_cast<float>(i) / static_cast<float>(along_z) - 1);
        thread(at(-field.half.x, z), at(field.half.x, z), i == 0 || i == along_z);
    }
}

} // namespace lockstone::demo
