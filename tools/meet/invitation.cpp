#include "meet/invitation.h"

namespace lockstone {

Result<Invitation> parse_invitation(std::string_view text) {
    const std::string all(text);
    const auto refuse = [&](const std::string& why) {
        return Error{"'" + all + "' is no invitation: " + why};
    };
    const std::size_t at = text.find('@'), hash = text.find('#');
    if (hash == std::string_view::npos)
        return refuse("write CODE@ADDRESS:PORT#KEY as the host shows it, a relay's without CODE@");
    Invitation made;
    const std::size_t begin = at == std::string_view::npos ? 0 : at + 1;
    if (hash < begin) return refuse("the code comes first: CODE@ADDRESS:PORT#KEY");
    if (begin > 0) made.code = text.substr(0, at);
    const Result<NetAddress> relay = parse_address(text.substr(begin, hash - begin));
    if (!relay) return refuse(relay.error().message);
    const Result<NetKey> key = parse_key(text.substr(hash + 1));
    if (!key) return refuse(key.error().message);
    made.relay = *relay, made.key = *key;
    return made;
}

std::string to_string(const Invitation& invitation) {
    return (invitation.code.empty() ? "" : invitation.code + "@") + to_string(invitation.relay) + "#" +
           to_string(invitation.key);
}

} // namespace lockstone
