// The constants of a world's step, all derived from its definition: times, limits, contact softness.
#pragma once

#include "lockstone/math/vec.h"

namespace lockstone::solve {

/// A spring-damper as solver coefficients. source: Catto, Soft Constraints, GDC 2011; Solver2D, 2024
struct Softness {
    Speed bias_rate;    ///< [1/s]: overlap -> push speed
    Unit mass_scale;    ///< of the effective mass
    Unit impulse_scale; ///< of the accumulated impulse
    /// Impulse_scale / mass_scale, at most 1: how much of its impulse a contact yields in a substep
    Unit ease;
};

/// A spring of a joint. As Softness, but stiffer: up to 1000 Hz.
struct SpringSoftness {
    Real rate; ///< [1/s]
    Unit mass_scale, impulse_scale;
};

struct StepConstants {
    std::int32_t ticks_per_second;
    std::int32_t substeps;
    std::int64_t substeps_per_second; ///< ticks_per_second * substeps
    Unit substep_time, tick_time;     ///< [s], at most 1
    Speed linear_speed_max;           ///< [m/s]: 500, and 15 m in a tick
    Speed tip_speed_max;              ///< [m/s]: 170 of u = K w, and 2 m in a tick
    Speed push_speed_max;             ///< [m/s]
    Speed push_jointed;               ///< [m/s]: of bodies that joints hold, see step_constants()
    Speed restitution_speed_min;      ///< [m/s]
    Softness soft, soft_static;       ///< against dynamic bodies; against what does not move
    SpringSoftness joint;             ///< of locks that are solved one after another
    Real tree_rate;                   ///< [1/s]: error -> push speed, of locks that are solved at once
    /// Trees whose bodies carry more than this in masses of their own are solved at once; joint_tree.h
    Real tree_load;
    Real joint_push_max; ///< [m/s] or [rad/s]: most that a lock is pushed by its error
    Real tree_arc_max;   ///< [m/s]: most that the bias of a lock of a tree looks ahead along an arc
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
