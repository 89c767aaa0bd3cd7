// The secret of a relay, in a file.
#pragma once

#include "lockstone/net.h"

namespace lockstone::cli {

/// 64 hexadecimal digits. The error names the file and the reason.
Result<NetKey> key_in(const std::string& file);
/// `is_new`: makes the file first, for its owner to read; it must not be there.
Result<NetKey> key_of(const std::string& file, bool is_new);

} // namespace lockstone::cli
