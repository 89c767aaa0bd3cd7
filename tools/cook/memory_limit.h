// Limits the memory of a command.
#pragma once

#include <cstdint>

namespace lockstone::cook {

/// False in builds with a sanitizer: its shadow memory is larger than any limit.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool limits_memory = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool limits_memory = false;
#else
inline constexpr bool limits_memory = true;
#endif
#else
inline constexpr bool limits_memory = true;
#endif

/// During its lifetime the process may allocate at most `bytes` of address space beyond what it has; a larger
/// allocation throws std::bad_alloc. A child process inherits the limit. Has no effect if limits_memory is false, or on
/// systems without /proc/self/statm.
class MemoryLimit {
  public:
    explicit MemoryLimit(std::uint64_t bytes);
    ~MemoryLimit();
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

    /// The total address space that the process may have [bytes]; the largest number without a limit.
    std::uint64_t address_space() const { return most; }

  private:
    std::uint64_t most, before; ///< [bytes] of the soft limit: now, and before
    bool is_set = false;
};

} // namespace lockstone::cook
