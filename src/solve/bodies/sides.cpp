#include "solve/bodies/sides.h"

#include <algorithm>
#include <array>
#include <cstdlib>

namespace lockstone::solve {

static std::int64_t mean_of(std::span<const std::int64_t> x) {
    std::int64_t sum = 0;
    for (const std::int64_t each : x) sum += each;
    return sum / static_cast<std::int64_t>(x.size());
}

/// The mean distance from the mean, minus the distance between the means of the two halves.
std::int64_t Sides::width_of(std::span<const std::int64_t> x) {
    const std::int64_t middle = mean_of(x);
    std::int64_t sum = 0;
    for (const std::int64_t each : x) sum += std::abs(each - middle);
    const std::size_t half = x.size() / 2;
    const std::int64_t apart = std::abs(mean_of(x.first(half)) - mean_of(x.subspan(half)));
    return std::max<std::int64_t>(sum / static_cast<std::int64_t>(x.size()) - apart, 0);
}

Sides::Sides(std::span<const Vec3> sample, std::uint32_t count) {
    constexpr Direction directions[] = {{1, 0, 0}, {0, 1, 0},  {0, 0, 1}, {1, 1, 0}, {1, -1, 0},
                                        {1, 0, 1}, {1, 0, -1}, {0, 1, 1}, {0, 1, -1}};
    if (sample.size() < 2) return;
    std::array<std::int64_t, samples_max> room;
    const std::span<std::int64_t> x = std::span(room).first(std::min(sample.size(), samples_max));
    const auto look_along = [&](Direction d) {
        for (std::size_t i = 0; i < x.size(); ++i) x[i] = along(sample[i], d);
    };
    std::int64_t widest = -1;
    for (const Direction d : directions) {
        look_along(d);
        const bool is_axis = d[0] * d[0] + d[1] * d[1] + d[2] * d[2] == 1;
        const std::int64_t width =
            width_of(x) / 256 * (is_axis ? 256 : 181); // the unit of a diagonal is longer by the root of two
        if (width > widest) widest = width, direction = d;
    }
    look_along(direction);
    std::sort(x.begin(), x.end());
    for (std::uint32_t c = 1; c < count; ++c) cuts[c - 1] = x[x.size() * c / count];
    cut_count = count - 1;
}

} // namespace lockstone::solve
