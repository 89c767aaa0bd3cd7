// The constants of a world's step, computed from its definition: times, limits, contact softness.
#pragma once

#include "lockstone/math/vec.h"

namespace lockstone::solve {

/// A spring-damper as solver coefficients. source: Catto, Soft Constraints, GDC 2011; Solver2D, 2024
struct Softness {
    Speed bias_rate;    ///< [1/s]: overlap -> push speed
    Unit mass_scale;    ///< of the effective mass
    Unit impulse_scale; ///< of the accumulated impulse
    /// impulse_scale / mass_scale, at most 1: the share of its impulse that a contact gives up in a substep
    Unit ease;
};

/// A spring of a joint. Like Softness, but for stiffer springs: up to 1000 Hz.
struct SpringSoftness {
    Real rate; ///< [1/s]
    Unit mass_scale, impulse_scale;
};

struct StepConstants {
    std::int32_t ticks_per_second;
    std::int32_t substeps;
    std::int64_t substeps_per_second; ///< ticks_per_second * substeps
    Unit substep_time, tick_time;     ///< [s], at most 1
    Speed linear_speed_max;           ///< [m/s]: 500, and at most 15 m in a tick
    Speed tip_speed_max;              ///< [m/s]: 170 of u = K w, and at most 2 m in a tick
    Speed push_speed_max;             ///< [m/s]
    Speed push_jointed;               ///< [m/s]: for bodies with joints, see step_constants()
    Speed restitution_speed_min;      ///< [m/s]
    Softness soft, soft_static;       ///< against dynamic bodies; against bodies that impulses do not move
    SpringSoftness joint;             ///< of locks that are solved one by one
    Real tree_rate; ///< [1/s]: error -> push speed, of locks that are solved at once, in trees
    /// Trees with a body that carries more than this times its own mass are solved at once; joint_tree.h
    Real tree_load;
    Real joint_push_max; ///< [m/s] or [rad/s]: largest push speed of a lock by its error
    Real tree_arc_max;   ///< [m/s]: largest part of the bias of a tree's lock that predicts the arc
};

struct StepSettings {
    std::int32_t ticks_per_second, substeps;
    Real contact_hertz, contact_damping, push_speed_max, restitution_speed_min;
};

StepConstants step_constants(const StepSettings& settings);
SpringSoftness spring_softness(Real hertz, Real damping, const StepConstants& step);

inline constexpr Real linear_speed_limit = Real(500); ///< [m/s]
inline constexpr Real tip_speed_limit = Real(170);    ///< [m/s] at one gyration radius

} // namespace lockstone::solve
