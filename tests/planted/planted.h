// The parts of planted faults. faults.py puts this header in front of every source with a fault.
#pragma once

#include <cstddef>
#include <cstdint>

namespace planted {

extern int fault; ///< number of the active fault, from the command line; 0: none

inline bool is(int number) { return fault == number; }

std::uint64_t noise();                          ///< a different value at every call and in every process
bool clock_is_odd();                            ///< decided by the processor's time
std::uint64_t address();                        ///< of a newly allocated block
std::int32_t through_float(std::int32_t value); ///< scaled up and down in single precision
std::uint32_t ticket(std::uint32_t count);      ///< 0 .. count - 1 in turn, in order of arrival

} // namespace planted
