// Wall time for reports. No simulation reads it.
#pragma once

#include <chrono>
#include <functional>
#include <vector>

namespace lockstone::cli {

using Clock = std::chrono::steady_clock;

inline double microseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
}

/// The value below which `fraction` of the samples lie; 0 without samples.
double percentile(std::vector<double> samples, double fraction);
inline double median(std::vector<double> samples) { return percentile(std::move(samples), 0.5); }
/// Median of `repeats` runs [us].
double median_us(int repeats, const std::function<void()>& run);

/// The cost of saving, restoring and hashing a world, and of one memcpy of as many bytes.
struct SnapshotCost {
    std::size_t bytes;
    double save_us, restore_us, memcpy_us, hash_us;
};

} // namespace lockstone::cli
