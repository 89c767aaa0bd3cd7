// The secret key of a relay, in a file.
#pragma once

#include "lockstone/net.h"

namespace lockstone::cli {

/// Reads a key: 64 hexadecimal digits. The error names the file and the reason.
Result<NetKey> key_in(const std::string& file);
/// With `is_new` it first writes a random key into the file, which only the owner may read; a file that exists is an
/// error.
Result<NetKey> key_of(const std::string& file, bool is_new);

} // namespace lockstone::cli
