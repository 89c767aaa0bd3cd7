// Checks of definitions from outside: the range of each field (describe, fields.h), and the relations between fields.
// Each function returns an empty text if all is valid, else the error.
#pragma once

#include "lockstone/command.h"

#include <string>

namespace lockstone::sim {

inline constexpr Real position_max = Real(1000000000);
inline constexpr Real speed_max = Real(500);
inline constexpr Real spin_max = Real(4095);
inline constexpr Real force_max = Real(2000000000);
inline constexpr Real mass_min = 0.001_r, mass_max = Real(1000000000); ///< [kg]: the sum of two fits a Real
/// [m]: joints divide by it. Even the smallest shapes have more, but rounding can reduce it for a body that is 100 m
/// long and 5 mm thick.
inline constexpr Real gyration_min = 0.001_r;

bool within(Vec3 v, Real most); ///< true if each component is within -most to most
std::string check_unit(const char* what, Quat q);
std::string check_pose(const char* what, const Transform& pose, Real most);
std::string check_range(const char* what, Real value, Real low, Real high, const char* unit);
/// Returns an error if the `given` flag of a command's setting is neither 0 nor 1.
template <class C> std::string check_changes(C command) {
    std::string fault;
    describe(command, [&]<class F>(const char* what, F& field) {
        if constexpr (requires { field.given; })
            if (fault.empty() && field.given > 1) fault = std::string(what) + ".given must be 0 or 1";
    });
    return fault;
}
std::string check(const BodyDef& d);
std::string check(const ShapeDef& d, BodyKind kind);
std::string check(const FieldDef& d);
std::string check(const ExplosionDef& d);
std::string check(const JointDef& d); ///< checks its numbers only, not if its bodies exist
std::string check(const JointAxis& d, std::uint32_t index);
std::string check(const CharacterDef& d);

} // namespace lockstone::sim
