// What planted faults are made of. Put in front of every source that holds one; see faults.py.
#pragma once

#include <cstddef>
#include <cstdint>

namespace planted {

extern int fault; ///< the number of the one that is there, from the command line; 0: none

inline bool is(int number) { return fault == number; }

std::uint64_t noise();                          ///< another at every call and in every process
bool clock_is_odd();                            ///< by the processor's time
std::uint64_t address();                        ///< of a block that was just allocated
std::int32_t through_float(std::int32_t value); ///< scaled up and down in single precision
std::uint32_t ticket(std::uint32_t count);      ///< 0 .. count - 1 in turn, in order of arrival

} // namespace planted
