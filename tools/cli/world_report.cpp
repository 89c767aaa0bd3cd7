#include "cli/world_report.h"

#include "cli/text.h"
#include "lockstone/math/convert.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace lockstone::cli {
namespace {

double penetration(const World& world) {
    double deepest = 0;
    for (const World::ContactPoint& c : world.contacts())
        deepest = std::max(deepest, -to_double(c.separation));
    return deepest;
}

} // namespace

double percentile(std::vector<double> samples, double fraction) {
    if (samples.empty()) return 0;
    const auto rank = static_cast<std::ptrdiff_t>(fraction * static_cast<double>(samples.size() - 1));
    std::nth_element(samples.begin(), samples.begin() + rank, samples.end());
    return samples[static_cast<std::size_t>(rank)];
}

double median_us(int repeats, const std::function<void()>& run) {
    std::vector<double> samples;
    for (int i = 0; i < repeats; ++i) {
        const auto start = Clock::now();
        run();
        samples.push_back(microseconds_since(start));
    }
    return median(std::move(samples));
}

SnapshotCost measure_snapshot(const World& world) {
    constexpr int repeats = 31;
    // As in a rollback, each measurement follows a tick and works on the data that this tick has written.
    World other = world.clone();
    Image image;
    other.save(image); // allocates once
    SnapshotCost cost{};
    cost.bytes = image.size();
    const std::vector<std::byte> from(cost.bytes, std::byte{1});
    std::vector<std::byte> to(cost.bytes);
    volatile std::uint64_t kept = 0; // keeps the compiler from removing the hashes
    std::vector<double> saving, restoring, hashing;
    for (int i = 0; i < repeats; ++i) {
        other.tick();
        hashing.push_back(median_us(1, [&] { kept = other.hash(); }));
        saving.push_back(median_us(1, [&] { other.save(image); }));
        other.tick();
        restoring.push_back(median_us(1, [&] { other.restore(image); }));
    }
    cost.save_us = median(std::move(saving));
    cost.restore_us = median(std::move(restoring));
    cost.hash_us = median(std::move(hashing));
    cost.memcpy_us = median_us(repeats, [&] {
        std::memcpy(to.data(), from.data(), cost.bytes);
        kept = kept + std::to_integer<std::uint64_t>(to[cost.bytes / 2]);
    });
    return cost;
}

WorldReport::WorldReport(const World& start) {
    for (const BodyId body : start.bodies())
        if (start.kind(body) == BodyKind::dynamic) start_positions[body] = start.pose(body).position;
}

void WorldReport::add_tick(double microseconds, const World& world) {
    tick_us.push_back(microseconds);
    penetration_ever = std::max(penetration_ever, penetration(world));
}

json::Value WorldReport::json(World& end) const {
    double drift = 0, displacement = 0;
    std::size_t awake = 0;
    for (const auto& [body, from] : start_positions) {
        if (!end.is_alive(body)) continue;
        const auto [x, y, z] = to_double(end.pose(body).position - from);
        drift = std::max(drift, std::hypot(x, z));
        displacement = std::max(displacement, std::hypot(x, y, z));
        awake += end.is_awake(body) ? 1u : 0u;
    }
    const std::size_t contacts = end.contacts().size();
    const double penetration_now = penetration(end);
    const SnapshotCost cost = measure_snapshot(end);
    return {{"bodies", end.body_count()},
            {"awake", awake},
            {"contacts", contacts},
            {"penetration_max_m", penetration_now},
            {"penetration_ever_m", penetration_ever},
            {"drift_max_m", drift},
            {"displacement_max_m", displacement},
            {"kinetic_energy_j", to_double(end.kinetic_energy())},
            {"tick_us_median", median(tick_us)},
            {"tick_us_p99", percentile(tick_us, 0.99)},
            {"snapshot_bytes", cost.bytes},
            {"save_us", cost.save_us},
            {"restore_us", cost.restore_us},
            {"memcpy_us", cost.memcpy_us},
            {"hash_us", cost.hash_us},
            {"hash", hash_text(end.hash())}};
}

} // namespace lockstone::cli
