#pragma once
/// How a match is found: the room's code, the relay's address and the relay's public key, in one word.

#include "lockstone/net.h"

namespace lockstone {

struct Invitation {
    std::string code; ///< of the lobby; empty: a room is opened
    NetAddress relay;
    NetKey key; ///< the relay's public one
};

/// "ABCDEFGH@192.0.2.7:7700#KEY", KEY of 64 hexadecimal digits; without "ABCDEFGH@" the code is empty.
Result<Invitation> parse_invitation(std::string_view text);
std::string to_string(const Invitation& invitation);

} // namespace lockstone
