#pragma once
/// The invitation to a match in one word: the room's code, the relay's address and the relay's public key.

#include "lockstone/net.h"

namespace lockstone {

struct Invitation {
    std::string code; ///< of the room in the lobby; empty: open a new room
    NetAddress relay;
    NetKey key; ///< the relay's public key
};

/// Parses "ABCDEFGH@192.0.2.7:7700#KEY", where KEY has 64 hexadecimal digits. Without "ABCDEFGH@" the code is empty.
Result<Invitation> parse_invitation(std::string_view text);
std::string to_string(const Invitation& invitation);

} // namespace lockstone
