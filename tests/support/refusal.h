// Commands that the world must refuse.
#pragma once

#include "lockstone/world.h"

#include <string>

namespace lockstone::test::scene {

/// Returns an error sentence unless the command is refused with a sentence that contains `words`, and no bit of the
/// world changes.
inline std::string refusal_fault(World& w, const Command& command, const std::string& words) {
    const std::uint64_t hash = w.hash();
    const Result<World::Applied> result = w.apply(command);
    if (result) return std::string(name_of(command)) + " was accepted";
    if (result.error().message.find(words) == std::string::npos)
        return "the error says: " + result.error().message;
    if (w.hash() != hash) return std::string(name_of(command)) + " was refused, but the world changed";
    return {};
}

} // namespace lockstone::test::scene
