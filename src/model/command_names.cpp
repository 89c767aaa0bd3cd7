// The names of commands, as recordings, reports and tables print them.
#include "lockstone/command.h"

#include <iterator>
#include <variant>

namespace lockstone {

const char* name_of(const Command& command) {
    static constexpr const char* names[] = {
        "create_body",         "destroy_body",        "create_shape",      "destroy_shape",
        "create_field",        "destroy_field",       "set_pose",          "set_velocity",
        "add_force",           "add_force_at",        "add_impulse",       "add_impulse_at",
        "set_body_parameters", "set_material",        "set_gravity",       "write_game",
        "set_filter",          "set_pair_filter",     "set_mass",          "create_joint",
        "destroy_joint",       "set_joint_axis",      "set_joint_frames",  "wake_body",
        "create_vehicle",      "destroy_vehicle",     "set_vehicle_input", "create_character",
        "destroy_character",   "set_character_input", "set_field",         "explode"};
    static_assert(std::size(names) == std::variant_size_v<Command>);
    return names[command.index()];
}

} // namespace lockstone
