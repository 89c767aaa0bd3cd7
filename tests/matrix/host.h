// The environment of a simulation: floating-point unit, memory, workers.
#pragma once

#include "lockstone/tasks.h"

#include <cstdint>
#include <memory>

namespace host {

/// From now on, fills memory with `byte` after allocation and with its complement before it is freed.
void poison(unsigned char byte);

/// Allocates and frees blocks of random sizes, and keeps some, so that later blocks have other addresses.
void move_heap(std::uint64_t seed);

/// During its lifetime: one of four rounding modes, with or without flushing of denormals, x87 at one of three
/// precisions. The tick selects them. The destructor restores the old modes, so that printing is not affected.
class FloatingPoint {
  public:
    FloatingPoint(bool on, std::uint64_t tick);
    ~FloatingPoint();
    FloatingPoint(const FloatingPoint&) = delete;
    FloatingPoint& operator=(const FloatingPoint&) = delete;

  private:
    bool active;
    int rounding = 0;
    std::uint64_t control = 0;   ///< MXCSR, FPCR or FPSCR before
    std::uint16_t precision = 0; ///< x87 control word before
};

/// A pool for `workers` above 0; one thread that runs items in random order for a `shuffle` other than 0; else null.
/// Ends the program with status 2 if threads are not available.
std::unique_ptr<lockstone::Tasks> make_tasks(std::uint32_t workers, std::uint64_t shuffle);

} // namespace host
