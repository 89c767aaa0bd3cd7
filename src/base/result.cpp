// Ends the program when a caller takes the value of an error.
#include "lockstone/result.h"

#include "base/assert.h"

namespace lockstone::detail {

void stop_without_value(const Error& error) {
    base::assertion_failed("a result that is used has a value", error.message, "lockstone/result.h", 0);
}

void stop_without_error() {
    base::assertion_failed("a result whose error is taken has one", "", "lockstone/result.h", 0);
}

} // namespace lockstone::detail
