// The definition of a world: its checks, and the row that stores it.
#include "base/assert.h"
#include "base/text.h"
#include "model/fields.h"
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

constexpr std::uint32_t objects_max = 1u << 20;

WorldDef with_derived_limits(WorldDef d) {
    constexpr std::uint32_t contacts_per_shape = 8; // a heap needs half of that
    if (d.contacts_max == 0)
        d.contacts_max = std::min(objects_max, contacts_per_shape * std::max(d.bodies_max, d.shapes_max));
    return d;
}

std::string check(const WorldDef& d) {
    const std::string e = check_ranges(d);
    return e.empty() ? e : "world: " + e;
}

Config config_of(const WorldDef& d) {
    Config config;
    copy_named(d, config);
    return config;
}

} // namespace sim

} // namespace lockstone
