// Checks of the definitions, inputs and rows of characters.
#include "model/character_row.h"
#include "model/fields.h"

namespace lockstone::sim {

std::string check(const CharacterInput& input) { return check_ranges(input); }

std::string check(const CharacterDef& d) {
    if (std::string e = check_ranges(d); !e.empty()) return e;
    const Real least = d.radius * 2 + 0.01_r;
    if (std::string e = check_range("height", d.height, least, Real(50), " m"); !e.empty()) return e;
    return check_range("crouch_height", d.crouch_height, least, d.height, " m");
}

std::string check(const CharacterRow& r) {
    if (std::string e = check(r.def); !e.empty()) return e;
    if (std::string e = check(r.input); !e.empty()) return e;
    const CharacterState& s = r.state;
    if (s.ground > CharacterGround::walkable) return "no such ground can be";
    if ((s.crouched | s.squeezed | s.jump_was_held | s.has_jumped) > 1) return "a flag is neither 0 nor 1";
    if (s.jump_pending > 1001 || s.air_ticks > 1u << 31) return "a count of ticks is out of range";
    if (!within(s.velocity, Real(5000)) || !within(s.ground_velocity, Real(5000)))
        return "a velocity is out of range";
    return {};
}

} // namespace lockstone::sim
