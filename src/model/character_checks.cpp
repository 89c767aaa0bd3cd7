// What definitions, inputs and rows of characters may say.
#include "base/text.h"
#include "lockstone/math/math.h"
#include "model/character_row.h"
#include "model/checks.h"

namespace lockstone::sim {

using base::join;

std::string check(const CharacterInput& input) {
    if (length(input.velocity) > character_speed_max) return "velocity must be at most 100 m/s long";
    if (input.jump > 1) return join("jump is ", input.jump, ", must be 0 or 1");
    if (input.crouch > 1) return join("crouch is ", input.crouch, ", must be 0 or 1");
    return {};
}

static std::string check_sizes(const CharacterDef& d) {
    if (std::string e = check_range("radius", d.radius, 0.05_r, Real(10), " m"); !e.empty()) return e;
    const Real least = d.radius * 2 + 0.01_r;
    if (std::string e = check_range("height", d.height, least, Real(50), " m"); !e.empty()) return e;
    if (std::string e = check_range("crouch_height", d.crouch_height, least, d.height, " m"); !e.empty())
        return e;
    if (std::string e = check_range("step_height", d.step_height, Real{}, Real(10), " m"); !e.empty())
        return e;
    if (std::string e = check_range("step_down", d.step_down, Real{}, Real(10), " m"); !e.empty()) return e;
    return check_range("slope_max", d.slope_max, Real{}, 1.3_r, " rad");
}

static std::string check_motion(const CharacterDef& d) {
    struct Range {
        const char* what;
        Real value, low, high;
        const char* unit;
    };
    const Range ranges[] = {{"mass", d.mass, 0.001_r, Real(1000000), " kg"},
                            {"push_force", d.push_force, Real{}, Real(100000000), " N"},
                            {"gravity", d.gravity, Real{}, Real(1000), " m/s^2"},
                            {"fall_speed_max", d.fall_speed_max, 0.1_r, Real(400), " m/s"},
                            {"jump_speed", d.jump_speed, Real{}, Real(100), " m/s"},
                            {"acceleration", d.acceleration, Real{}, Real(1000000), " m/s^2"},
                            {"air_acceleration", d.air_acceleration, Real{}, Real(1000000), " m/s^2"}};
    for (const Range& r : ranges)
        if (std::string e = check_range(r.what, r.value, r.low, r.high, r.unit); !e.empty()) return e;
    for (const auto& [what, ticks] :
         {std::pair("coyote_ticks", d.coyote_ticks), {"jump_buffer_ticks", d.jump_buffer_ticks}})
        if (ticks > 1000) return join(what, " is ", ticks, ", must be 0 to 1000");
    return {};
}

std::string check(const CharacterDef& d) {
    if (!within(d.position, position_max)) return "position must be within 1e9 m of the origin";
    if (abs(length(d.up) - unit_one) > Unit::from_raw(1 << 20))
        return "up must be a unit vector: use normalized";
    if (std::string e = check_sizes(d); !e.empty()) return e;
    return check_motion(d);
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
