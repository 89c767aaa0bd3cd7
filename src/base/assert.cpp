#include "base/assert.h"

#include <cstdio>
#include <cstdlib>

namespace lockstone::base {

void assertion_failed(std::string_view condition, std::string_view values, std::string_view file, int line) {
    const std::string message = join("lockstone: broken rule: ", condition, values.empty() ? "" : ": ",
                                     values, " [", file, ":", line, "]\n");
    std::fputs(message.c_str(), stderr);
    std::fflush(stderr);
    std::abort();
}

} // namespace lockstone::base
