// Commands between ticks.
#include "drawer.h"

namespace worlds {

void Drawer::push() {
    const BodyId which = mover();
    if (!which) return;
    switch (v.below(8)) {
    case 0: {
        const Transform to{center + place(v.below(bodies)), v.turn()};
        return told(world.set_pose(which, to));
    }
    case 1: {
        const Vec3 linear = vector(Real(8)), angular = vector(Real(8));
        return told(world.set_velocity(which, linear, angular));
    }
    case 2: {
        const Vec3 force = vector(Real(3000)), torque = vector(Real(500));
        return told(world.add_force(which, force, torque));
    }
    case 3: {
        const Vec3 force = vector(Real(3000)), point = world.pose(which).position + vector(0.5_r);
        return told(world.add_force_at(which, force, point));
    }
    case 4: {
        const Vec3 linear = vector(Real(200)), angular = vector(Real(20));
        return told(world.add_impulse(which, linear, angular));
    }
    case 5: {
        const Vec3 impulse = vector(Real(200)), point = world.pose(which).position + vector(0.5_r);
        return told(world.add_impulse_at(which, impulse, point));
    }
    case 6:
        return told(world.wake_body(which));
    default:
        return told(world.set_gravity(v.chance(2) ? story.def.gravity : vector(Real(12))));
    }
}

void Drawer::change_body() {
    const BodyId which = mover();
    if (!which) return;
    switch (v.below(4)) {
    case 0: {
        const BodyDef d = body_def({});
        SetBodyParameters p{.body = which};
        if (v.chance(2)) p.linear_damping = d.linear_damping;
        if (v.chance(2)) p.angular_damping = d.angular_damping;
        if (v.chance(2)) p.gravity_scale = d.gravity_scale;
        if (v.chance(2)) p.locks = d.locks;
        if (v.chance(2)) p.gyroscopic = d.gyroscopic;
        if (v.chance(2)) p.bullet = d.bullet;
        if (v.chance(2)) p.enable_fields = d.enable_fields;
        if (v.chance(2)) p.drag_scale = d.drag_scale;
        return told(world.set_body_parameters(p));
    }
    case 1: {
        SetMass m{.body = which};
        m.mass = v.chance(8) ? Real{} : range(0.1_r, Real(300));
        if (v.chance(2)) m.center = vector(0.2_r);
        if (v.chance(2)) {
            const Real x = range(0.1_r, Real(1)), y = range(0.1_r, Real(1)), z = range(0.1_r, Real(1));
            m.gyration = Vec3{x, y, z};
        }
        if (v.chance(4)) m.principal = v.turn();
        return told(world.set_mass(m));
    }
    case 2: {
        const BodyId other = body();
        return told(world.set_pair_filter(which, other, v.chance(3)));
    }
    default: {
        const Real r = half(side) + Real(1);
        ExplosionDef d;
        d.center = world.pose(which).position, d.radius = r, d.impulse = range(Real(-300), Real(600));
        d.falloff = static_cast<Falloff>(v.below(3));
        if (has(Feature::explosions)) told(world.explode(d));
        return;
    }
    }
}

void Drawer::change_shape() {
    const ShapeId which = shape();
    if (!which) return;
    const ShapeDef d = shape_def(true);
    switch (v.below(4)) {
    case 0: {
        SetMaterial m{.shape = which};
        if (v.chance(2)) m.friction = d.friction;
        if (v.chance(2)) m.restitution = d.restitution;
        if (v.chance(2)) m.rolling_resistance = d.rolling_resistance;
        if (v.chance(2)) m.surface_velocity = d.surface_velocity;
        return told(world.set_material(m));
    }
    case 1: {
        SetFilter f{.shape = which};
        if (v.chance(2)) f.category = d.category;
        if (v.chance(2)) f.mask = d.mask;
        if (v.chance(2)) f.group = d.group;
        return told(world.set_filter(f));
    }
    case 2:
        if (world.kind(world.body_of(which)) != BodyKind::static_) told(world.destroy(which));
        return;
    default:
        if (const BodyId to = mover()) told(world.create_shape(to, d));
    }
}

void Drawer::change_actor() {
    switch (v.below(6)) {
    case 0:
        if (world.joint_count() == 0) return;
        {
            const JointId which = world.joint_at(v.below(world.joint_count()));
            const JointDef d = joint_def();
            const std::uint32_t axis = v.below(joint_axis_count);
            if (v.chance(3)) {
                JointDef now = world.joint(which);
                now.frame_a.position = now.frame_a.position + vector(0.05_r);
                return told(world.set_joint_frames(which, now.frame_a, now.frame_b));
            }
            return told(world.set_joint_axis(which, static_cast<JointAxisIndex>(axis), d.axis[axis]));
        }
    case 1:
        if (world.joint_count() == 0 || !v.chance(3)) return;
        return told(world.destroy(world.joint_at(v.below(world.joint_count()))));
    case 2:
        if (world.vehicle_count() == 0) return;
        {
            const VehicleId which = world.vehicle_at(v.below(world.vehicle_count()));
            return told(v.chance(8) ? world.destroy(which)
                                    : world.set_vehicle_input(which, attack::vehicle_input(v)));
        }
    case 3:
        if (world.character_count() == 0) return;
        {
            const CharacterId which = world.character_at(v.below(world.character_count()));
            if (v.chance(10)) return told(world.destroy(which));
            CharacterInput input;
            input.velocity = vector(Real(5));
            input.jump = v.below(2), input.crouch = v.below(2);
            return told(world.set_character_input(which, input));
        }
    case 4:
        if (world.field_count() == 0) return;
        {
            const FieldId which = world.field_at(v.below(world.field_count()));
            return told(v.chance(4) ? world.destroy(which) : world.set_field(which, field_def()));
        }
    default: {
        if (!has(Feature::game_columns)) return;
        WriteGame w{};
        w.column = v.below(2), w.size = 8;
        if (w.column == 0) w.body = body();
        for (std::uint32_t i = 0; i < 8; ++i) w.data[i] = static_cast<std::uint8_t>(v.below(256));
        told(world.apply(w));
    }
    }
}

void Drawer::come_and_go() {
    switch (v.below(6)) {
    case 0:
    case 1:
        if (const BodyId which = mover()) told(world.destroy(which));
        return;
    case 2:
    case 3: {
        Vec3 at = place(v.below(bodies));
        at.y = at.y + Real(2);
        return make(assembly(at));
    }
    case 4:
        if (has(Feature::joints)) {
            const BodyId a = v.chance(4) ? BodyId{} : mover();
            add_joint(a, mover());
        }
        return;
    default:
        if (has(Feature::ragdolls) && v.chance(2)) return add_ragdoll();
        if (has(Feature::vehicles) && v.chance(2)) return add_vehicle();
        if (has(Feature::characters) && v.chance(2)) return add_character();
        if ((has(Feature::fields) || has(Feature::fluids)) && world.field_count() < 6)
            told(world.create_field(field_def()));
    }
}

void Drawer::command() {
    if (is_now(Feature::comes_and_goes, 2)) return come_and_go();
    switch (v.below(6)) {
    case 0:
        return change_body();
    case 1:
        return change_shape();
    case 2:
        return change_actor();
    default:
        return push();
    }
}

} // namespace worlds
