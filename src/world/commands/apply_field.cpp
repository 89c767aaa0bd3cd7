// Creates, changes and destroys fields; applies explosions.
#include "world/commands/applier.h"

#include "lockstone/math/math.h"
#include "model/checks.h"
#include "model/sleep.h"
#include "scene/parts.h"
#include "shapes/shown_area.h"
#include "shapes/submerged.h"

#include <algorithm>

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

static FieldRow row_of(FieldId id, FieldDef def) {
    def.region.pose.rotation = normalized(def.region.pose.rotation);
    return {id, def};
}

Result<World::Applied> Applier::operator()(const CreateField& c) {
    if (std::string e = check(c.def); !e.empty()) return Error{"create_field: " + e};
    const std::uint32_t row = w.state.count(w.m.fields);
    if (row == w.state.rows_max(w.m.fields))
        return Error{join("create_field: the world is full: fields_max is ", row)};
    wake_all();
    w.state.make_room({w.m.field_slots, w.m.fields}, 1);
    const std::uint32_t index = take_slot(w, w.m.field_slots, w.m.field_slot, &Header::field_free, row);
    const FieldId id{index, w.state.rows(w.m.field_slot)[index - 1].generation};
    w.state.resize(w.m.fields, row + 1);
    w.state.edit_row(w.m.field, row) = row_of(id, c.def);
    return Applied{.field = id};
}

Result<World::Applied> Applier::operator()(const SetField& c) {
    const std::uint32_t row = w.row_of(c.field);
    if (row == Model::dead) return dead("set_field", "field", c.field);
    if (std::string e = check(c.def); !e.empty()) return Error{"set_field: " + e};
    wake_all();
    w.state.edit_row(w.m.field, row) = row_of(c.field, c.def);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const DestroyField& c) {
    const std::uint32_t row = w.row_of(c.field);
    if (row == Model::dead) return Error{join("destroy_field: field ", text_of(c.field), " is not alive")};
    wake_all();
    const FieldId moved = w.state.rows(w.m.field)[w.state.count(w.m.fields) - 1].id;
    remove_row(w.state, w.m.fields, row);
    w.state.edit_row(w.m.field_slot, moved.index - 1).row = row;
    free_slot(w.state, w.m.field_slot, c.field.index, w.edit_header().field_free);
    return Applied{};
}

// ---- explosions ------------------------------------------------------------------------------------------------

namespace {

/// The sum of impulses over a body's shapes, about its centre of mass.
struct Push {
    Vec3 linear{}, angular{};
};

/// Adds the impulse of a blast on a convex part at `pose`; `center`: the body's centre of mass. Both are in world
/// space.
void add_blast(const ExplosionDef& blast, const shapes::Solid& part, const Transform& pose, Vec3 center,
               Push& push) {
    const shapes::Extent extent = shapes::extent_of(part);
    const Vec3 from = inverse_mul(pose, blast.center);
    const Vec3 nearest = max(to<Real>(extent.lower), min(to<Real>(extent.upper), from));
    const Real gap = length(from - nearest);
    const Vec3 away = pose * shapes::volume_center(part) - blast.center;
    const Real distance = length(away);
    if (gap > blast.radius || distance == Real{}) return;
    Real strength = blast.impulse;
    if (blast.falloff == Falloff::linear) strength = strength * (Real(1) - gap / blast.radius);
    if (blast.falloff == Falloff::inverse_square && distance > blast.core) {
        const Real ratio = blast.core / distance;
        strength = strength * ratio * ratio;
    }
    const UnitVec3 d = normalized(away);
    const shapes::ShownArea shown =
        shapes::shown_area(part, mul_transposed<Unit>(to_rotation(pose.rotation), d));
    const Real area = min(shown.area, pi * blast.radius * blast.radius);
    const Vec3 impulse = lockstone::scale<Real>(d, clamp(strength * area, -force_max, force_max));
    push.linear += impulse;
    push.angular += cross(pose * shown.center - center, impulse);
}

Push push_on(const Model& w, PlacedShapes& placed, const ExplosionDef& blast, std::uint32_t row) {
    const Transform& pose = w.state.rows(w.m.body_pose)[row];
    const Vec3 center = w.mass_of(row).center;
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Push push;
    std::uint32_t slot = w.state.rows(w.m.body_info)[row].first_shape;
    for (; slot != 0; slot = shapes[slots[slot - 1].row].next_shape) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        if (w.traits_of(shape).sensor != 0 || (w.traits_of(shape).category & blast.mask) == 0) continue;
        const Transform local{w.traits_of(shape).local.position - center, w.traits_of(shape).local.rotation};
        for_each_part(solid_of(w, placed, shape), pose * local,
                      [&](const shapes::Solid& part, const Transform& at, std::size_t) {
                          add_blast(blast, part, at, pose.position, push);
                      });
    }
    return push;
}

} // namespace

Result<World::Applied> Applier::operator()(const Explode& c) {
    if (std::string e = check(c.def); !e.empty()) return Error{"explode: " + e};
    struct Hit {
        BodyId body;
        Push push;
    };
    std::vector<Hit> hits;
    for (std::uint32_t row = 0; row < w.state.count(w.m.bodies); ++row) {
        if (w.mass_of(row).mass == Real{}) continue;
        const Push push = push_on(w, placed, c.def, row);
        if (push.linear != Vec3{} || push.angular != Vec3{})
            hits.push_back({w.state.rows(w.m.body_info)[row].id, push});
    }
    // Waking moves rows. It happens in the order of ids, so the result does not depend on where the rows were.
    std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) { return a.body < b.body; });
    for (const Hit& hit : hits) apply_impulse(w, wake(hit.body), hit.push.linear, hit.push.angular);
    return Applied{};
}

} // namespace lockstone::sim
