// A limit of the memory that a command may take.
#pragma once

#include <cstdint>

namespace lockstone::cook {

/// While it lives, the process may take so many bytes of address space beside what it has; an allocation beyond them throws std::bad_alloc.
/// A child process has the same limit. It does nothing under sanitizers, whose shadow memory is larger than any limit, and on systems without
/// /proc/self/statm.
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
