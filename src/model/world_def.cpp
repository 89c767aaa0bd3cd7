// The definition a world is made with: its ranges, and the row it becomes.
#include "base/assert.h"
#include "base/text.h"
#include "collide/bounds.h"
#include "lockstone/math/decimal.h"
#include "model/model.h"

#include <algorithm>

namespace lockstone {

using base::join;

const char* name_of(Integrator integrator) {
    static constexpr const char* names[] = {"semi_implicit_euler", "verlet", "velocity_verlet",
                                            "runge_kutta_4"};
    const auto index = static_cast<std::uint32_t>(integrator);
    return index < std::size(names) ? names[index] : "unknown";
}

std::uint32_t GameSchema::add(Entry entry) {
    for (const Entry& e : list)
        LOCKSTONE_ASSERT(e.name != entry.name, "two game columns are named ", entry.name);
    list.push_back(std::move(entry));
    return static_cast<std::uint32_t>(list.size() - 1);
}

namespace sim {

namespace {

std::string check_integer(const char* what, std::uint64_t value, std::uint64_t low, std::uint64_t high) {
    if (value >= low && value <= high) return {};
    return join("world: ", what, " is ", value, ", must be ", low, " to ", high);
}
std::string check_real(const char* what, Real value, Real low, Real high) {
    if (value >= low && value <= high) return {};
    return join("world: ", what, " is ", to_string(value), ", must be ", to_string(low), " to ",
                to_string(high));
}

constexpr std::uint32_t objects_max = 1u << 20;

} // namespace

/// contacts_max where the definition leaves it to the other limits.
WorldDef with_derived_limits(WorldDef d) {
    constexpr std::uint32_t contacts_per_shape = 8; // a heap has half of that
    if (d.contacts_max == 0)
        d.contacts_max = std::min(objects_max, contacts_per_shape * std::max(d.bodies_max, d.shapes_max));
    return d;
}

std::string check(const WorldDef& d) {
    const std::string checks[] = {
        check_integer("tick_rate", d.tick_rate, 1, 1000),
        check_integer("substeps", d.substeps, 1, 16),
        check_integer("integrator", static_cast<std::uint64_t>(d.integrator), 0, 3),
        check_integer("bounds_shift", d.bounds_shift, 0, collide::bounds_shift_max),
        check_integer("bodies_max", d.bodies_max, 1, objects_max),
        check_integer("shapes_max", d.shapes_max, 1, objects_max),
        check_integer("contacts_max", d.contacts_max, 0, objects_max),
        check_integer("fields_max", d.fields_max, 1, 1024),
        check_integer("pair_filters_max", d.pair_filters_max, 1, objects_max),
        check_integer("joints_max", d.joints_max, 1, objects_max),
        check_integer("characters_max", d.characters_max, 1, 65536),
        check_integer("vehicles_max", d.vehicles_max, 1, 65536),
        check_integer("continuous", d.continuous, 0, 1),
        check_integer("sleeping", d.sleeping, 0, 1),
        check_real("gravity.x", d.gravity.x, Real(-1000), Real(1000)),
        check_real("gravity.y", d.gravity.y, Real(-1000), Real(1000)),
        check_real("gravity.z", d.gravity.z, Real(-1000), Real(1000)),
        check_real("restitution_speed_min", d.restitution_speed_min, Real{}, Real(500)),
        check_real("contact_hertz", d.contact_hertz, Real(1), Real(4000)),
        check_real("contact_damping", d.contact_damping, 0.1_r, Real(100)),
        check_real("push_speed_max", d.push_speed_max, Real{}, Real(500)),
        check_real("sleep_speed", d.sleep_speed, Real{}, Real(10)),
        check_real("sleep_time", d.sleep_time, Real{}, Real(3600)),
    };
    for (const std::string& e : checks)
        if (!e.empty()) return e;
    return {};
}

Config config_of(const WorldDef& d) {
    return {d.tick_rate,        d.substeps,
            d.integrator,       d.bounds_shift,
            d.bodies_max,       d.shapes_max,
            d.contacts_max,     d.fields_max,
            d.pair_filters_max, d.joints_max,
            d.characters_max,   d.vehicles_max,
            d.continuous,       d.sleeping,
            d.gravity,          d.restitution_speed_min,
            d.contact_hertz,    d.contact_damping,
            d.push_speed_max,   d.sleep_speed,
            d.sleep_time,       d.seed};
}

} // namespace sim

} // namespace lockstone
