// A programmer's error ends the program and prints the values that broke the rule:
//
//   LOCKSTONE_ASSERT(rows <= capacity, "rows ", rows, ", capacity ", capacity);
//
// On in every build: the checks guard memory, cost a predicted branch, and cannot change a result. No assertion may
// depend on data from outside; lockstone/result.h is for such errors.
#pragma once

#include "base/text.h"

#include <string_view>

namespace lockstone::base {

/// Prints one line to stderr and aborts.
[[noreturn]] void assertion_failed(std::string_view condition, std::string_view values, std::string_view file,
                                   int line);

} // namespace lockstone::base

#define LOCKSTONE_ASSERT(condition, ...)                                                                     \
    do {                                                                                                     \
        if (!(condition)) [[unlikely]]                                                                       \
            ::lockstone::base::assertion_failed(#condition, ::lockstone::base::join(__VA_ARGS__), __FILE__,  \
                                                __LINE__);                                                   \
    } while (false)
