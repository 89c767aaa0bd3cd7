// A limit of the memory that a command may take.
#pragma once

#include <cstdint>

namespace lockstone::cook {

/// False in builds with a sanitizer, whose shadow memory is larger than any limit.
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

/// While it lives, the process may take so many bytes of address space beside what it has; an allocation beyond them throws std::bad_alloc.
/// A child process has the same limit. It does nothing where limits_memory is false, and on systems without /proc/self/statm.
class MemoryLimit {
  public:
    explicit MemoryLimit(std::uint64_t bytes);
    ~MemoryLimit();
    MemoryLimit(const MemoryLimit&) = delete;
    MemoryLimit& operator=(const MemoryLimit&) = delete;

    /// Bytes of address space that the process may have in all; the largest number where there is no limit.
    std::uint64_t address_space() const { return most; }

  private:
    std::uint64_t most, before; ///< [bytes] of the soft limit: now, and before
    bool is_set = false;
};

} // namespace lockstone::cook
