// Counts allocations through operator new during its lifetime, on the thread that made it.
//
//   AllocationCounter counter;
//   world.save(image);
//   CHECK(counter.count() == 0);
//
// Link allocation_counter.cpp once: it replaces the global operator new of the test program.
#pragma once

#include <cstdint>

namespace lockstone::test {

class AllocationCounter {
  public:
    AllocationCounter();
    std::uint64_t count() const; ///< allocations since construction

  private:
    std::uint64_t start;
};

} // namespace lockstone::test
