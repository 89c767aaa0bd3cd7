// Checks a state from a file or a peer as a whole before a world takes it over. Every index that a tick follows must
// lie inside its table, or a crafted image could make it read outside of it.
#include "base/text.h"
#include "collide/narrow_phase.h"
#include "lockstone/math/decimal.h"
#include "model/fields.h"
#include "model/model.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace lockstone::sim {

namespace {

using base::join;

Error bad(std::string_view column, std::size_t row, std::string_view why) {
    return {join("portable image: ", column, " row ", row, ": ", why)};
}

/// Checks that living slots and rows refer to each other, and that the free list visits each free slot once.
template <class IdOfRow>
Status check_slots(std::string_view name, std::span<const Slot> slots, std::size_t rows,
                   std::uint32_t first_free, IdOfRow id_of) {
    std::size_t living = 0;
    for (std::size_t i = 0; i < slots.size(); ++i) {
        const Slot& s = slots[i];
        if (s.generation == 0 || (!s.is_alive() && s.next_free() > slots.size()))
            return bad(name, i, "no such slot can be");
        if (!s.is_alive()) continue;
        ++living;
        if (s.row >= rows) return bad(name, i, join("points to row ", s.row, " of ", rows));
        const auto id = id_of(s.row);
        if (id.index != i + 1 || id.generation != s.generation) return bad(name, i, "its row has another id");
    }
    if (living != rows) return bad(name, slots.size(), join(living, " living slots for ", rows, " rows"));
    std::size_t free = 0;
    for (std::uint32_t at = first_free; at != 0; at = slots[at - 1].next_free())
        if (at > slots.size() || slots[at - 1].is_alive() || ++free > slots.size())
            return bad(name, at, "the free list is broken");
    if (free != slots.size() - living) return bad(name, 0, "the free list misses slots");
    return {};
}

bool unit_like(Quat q) {
    const auto square = [](Unit u) { return (std::int64_t{u.raw} * u.raw) >> 2; }; // at most 2^60 each
    const std::int64_t norm = square(q.x) + square(q.y) + square(q.z) + square(q.w);
    constexpr std::int64_t one = std::int64_t{1} << 58;
    return norm > one - (one >> 10) && norm < one + (one >> 10);
}

bool unit_like(UnitVec3 v) { return unit_like(Quat{v.x, v.y, v.z, Unit{}}); }

/// Checks that free rows are zero, and that no two used rows are equal, among the rows that are compared before a new
/// one is made.
template <class T> Status check_shared_rows(std::string_view name, const State& s, const SharedTable<T>& t) {
    const std::span<const T> rows = s.rows(t.row);
    const std::span<const SharedUses> uses = s.rows(t.uses);
    constexpr std::array<std::byte, sizeof(T)> zero{};
    std::vector<std::uint32_t> used;
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        if (!uses[i].is_used() && std::memcmp(&rows[i], zero.data(), zero.size()) != 0)
            return bad(name, i, "is free, but not zero");
        if (uses[i].is_used() && i < shared_rows_compared) used.push_back(i);
    }
    const auto order = [&](std::uint32_t a, std::uint32_t b) {
        return std::memcmp(&rows[a], &rows[b], sizeof(T));
    };
    std::ranges::sort(used, [&](std::uint32_t a, std::uint32_t b) { return order(a, b) < 0; });
    const auto twice =
        std::ranges::adjacent_find(used, [&](std::uint32_t a, std::uint32_t b) { return order(a, b) == 0; });
    if (twice != used.end()) return bad(name, *twice, "is the same as another");
    return {};
}

/// Checks that each used row has as many users as it says, and that the free list visits each other row once.
/// `named`: the row of each user.
template <class T>
Status check_shared(std::string_view name, const State& s, const SharedTable<T>& t,
                    const std::vector<std::uint32_t>& named, std::uint32_t first_free) {
    const std::span<const SharedUses> uses = s.rows(t.uses);
    std::vector<std::uint32_t> found(uses.size());
    for (std::size_t i = 0; i < named.size(); ++i)
        if (named[i] >= uses.size() || ++found[named[i]] == 0)
            return bad(name, named[i], "is used, but does not exist");
    std::size_t free_rows = 0, free = 0;
    for (std::size_t i = 0; i < uses.size(); ++i) {
        if (!uses[i].is_used()) ++free_rows;
        if (uses[i].is_used() ? uses[i].count != found[i] || found[i] == 0
                              : found[i] != 0 || uses[i].next_free() > uses.size())
            return bad(name, i, join("is used ", found[i], " times, which is not what it says"));
    }
    for (std::uint32_t at = first_free; at != 0; at = uses[at - 1].next_free())
        if (at > uses.size() || uses[at - 1].is_used() || ++free > uses.size())
            return bad(name, at, "the free list is broken");
    if (free != free_rows) return bad(name, 0, "the free list misses rows");
    return check_shared_rows(name, s, t);
}

/// Returns an empty text if a body may have these traits, else the error.
std::string check_traits(const BodyTraits& t) {
    BodyDef def;
    copy_named(t, def);
    if (std::string e = check_ranges(def); !e.empty()) return e;
    if (t.mass_override != Real{} && (t.mass_override < mass_min || t.mass_override > mass_max))
        return "mass_override is out of range";
    if (t.mass_fixed > 1) return "mass_fixed is neither 0 nor 1";
    const BodyMass& mass = t.mass;
    const bool weighs = mass.mass != Real{};
    if ((weighs && (mass.mass < mass_min || mass.mass > mass_max)) || !unit_like(mass.principal))
        return "no such mass can be";
    if (!within(mass.center, Real(100000))) return "center is out of range";
    for (int axis = 0; axis < 3; ++axis) {
        const Real radius = mass.gyration[axis];
        if (radius < gyration_min || radius > Real(100000)) return "no such gyration radius can be";
    }
    return {};
}

/// Checks that each force belongs to a body that refers to it.
Status check_forces(const Manifest& m, const State& s) {
    const std::span<const std::uint32_t> pushed = s.rows(m.pushed), pushes = s.rows(m.body_push);
    const std::span<const Slot> slots = s.rows(m.body_slot);
    for (std::size_t i = 0; i < pushed.size(); ++i) {
        const std::uint32_t slot = pushed[i];
        if (slot == 0 || slot > slots.size() || !slots[slot - 1].is_alive() ||
            pushes[slots[slot - 1].row] != i + 1)
            return bad("body.pushed", i, "is a force on no body, or on one that has another");
    }
    const auto all = pushes.size() - static_cast<std::size_t>(std::ranges::count(pushes, 0u));
    if (all != pushed.size()) return bad("body.push", all, "a body is pushed by a force that is not there");
    return {};
}

Status check_bodies(const Manifest& m, const State& s) {
    const std::span<const BodyInfo> info = s.rows(m.body_info);
    const std::span<const BodyTraits> traits = s.rows(m.body_traits.row);
    const std::span<const Transform> pose = s.rows(m.body_pose);
    std::vector<std::uint32_t> named;
    for (const BodyInfo& body : info) named.push_back(body.traits);
    if (Status e =
            check_shared("body_traits.uses", s, m.body_traits, named, s.rows(m.header)[0].body_traits_free);
        !e)
        return e;
    for (std::size_t i = 0; i < traits.size(); ++i)
        if (std::string e = check_traits(traits[i]); !e.empty() && s.rows(m.body_traits.uses)[i].is_used())
            return bad("body_traits.row", i, e);
    for (std::size_t i = 0; i < info.size(); ++i) {
        if (info[i].kind > BodyKind::dynamic) return bad("body.info", i, "unknown kind");
        if (!unit_like(pose[i].rotation)) return bad("body.pose", i, "rotation is not a unit quaternion");
        if ((traits[info[i].traits].mass.mass != Real{}) != (info[i].kind == BodyKind::dynamic))
            return bad("body.info", i, "a dynamic body has a mass, others have none");
        if (!within(pose[i].position, position_max)) return bad("body.pose", i, "position is out of range");
    }
    return check_forces(m, s);
}

Status check_fields(const Manifest& m, const State& s) {
    const std::span<const FieldRow> fields = s.rows(m.field);
    for (std::size_t i = 0; i < fields.size(); ++i)
        if (std::string e = check(fields[i].def); !e.empty()) return bad("field.row", i, e);
    return {};
}

/// Returns an empty text if a shape may have these traits, else the error.
std::string check_traits(shapes::SolidCache& solids, const ShapeTraits& t) {
    if (std::string e = validate(t.geometry); !e.empty()) return e;
    if (const Result<shapes::Solid> solid = solids.resolve(t.geometry); !solid) return solid.error().message;
    ShapeDef def;
    copy_named(t, def);
    return check_ranges(def);
}

/// Returns an empty text if this kind of body can have the geometry.
std::string check_kind(const Geometry& g, BodyKind kind) {
    if (g.kind == ShapeKind::plane && kind != BodyKind::static_) return "a plane on a body that moves";
    if ((g.kind == ShapeKind::mesh || g.kind == ShapeKind::height_field) && kind == BodyKind::dynamic)
        return "a mesh or height field on a dynamic body";
    if (g.kind <= ShapeKind::box && g.scale != scale_one && kind != BodyKind::static_)
        return "a scaled primitive on a body that moves";
    return {};
}

/// Checks that each body's shape list holds exactly its own shapes.
Status check_shape_lists(const Manifest& m, const State& s) {
    const std::span<const ShapeRow> shapes = s.rows(m.shape);
    const std::span<const Slot> slots = s.rows(m.shape_slot);
    const std::span<const BodyInfo> info = s.rows(m.body_info);
    std::size_t listed = 0;
    for (std::size_t i = 0; i < info.size(); ++i)
        for (std::uint32_t slot = info[i].first_shape; slot != 0; ++listed) {
            if (slot > slots.size() || !slots[slot - 1].is_alive() || listed >= shapes.size())
                return bad("body.info", i, "its shape list is broken");
            const ShapeRow& r = shapes[slots[slot - 1].row];
            if (r.body != info[i].id) return bad("body.info", i, "its shape list holds another body's shape");
            slot = r.next_shape;
        }
    if (listed != shapes.size()) return bad("shape.row", listed, "shapes in no list");
    return {};
}

Status check_shapes(shapes::SolidCache& solids, const Manifest& m, const State& s) {
    const std::span<const ShapeRow> shapes = s.rows(m.shape);
    const std::span<const ShapeTraits> traits = s.rows(m.shape_traits.row);
    const std::span<const Slot> body_slots = s.rows(m.body_slot);
    std::vector<std::uint32_t> named;
    for (const ShapeRow& shape : shapes) named.push_back(shape.traits);
    if (Status e = check_shared("shape_traits.uses", s, m.shape_traits, named,
                                s.rows(m.header)[0].shape_traits_free);
        !e)
        return e;
    for (std::size_t i = 0; i < traits.size(); ++i) {
        if (!s.rows(m.shape_traits.uses)[i].is_used()) continue;
        if (std::string e = check_traits(solids, traits[i]); !e.empty()) return bad("shape_traits.row", i, e);
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const BodyId body = shapes[i].body;
        if (body.index == 0 || body.index > body_slots.size() || !body_slots[body.index - 1].is_alive() ||
            body_slots[body.index - 1].generation != body.generation)
            return bad("shape.row", i, "its body does not exist");
        const BodyKind kind = s.rows(m.body_info)[body_slots[body.index - 1].row].kind;
        if (std::string e = check_kind(traits[shapes[i].traits].geometry, kind); !e.empty())
            return bad("shape.row", i, e);
    }
    return check_shape_lists(m, s);
}

/// Checks that there are as many points and further rows as the contacts say, so that each contact finds its own.
Status check_contact_parts(const State& s, const ContactTables& t) {
    std::size_t points = 0, more = 0;
    const std::span<const ContactRow> rows = s.rows(t.memory);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (rows[i].count < 1 || rows[i].count > 4) return bad("contact.memory", i, "not one to 4 points");
        points += rows[i].count;
        if ((rows[i].flags & solve::contact_has_more) == 0) continue;
        const ContactMore nothing{};
        if (more < s.count(t.more) && std::memcmp(&s.rows(t.beyond)[more], &nothing, sizeof nothing) == 0)
            return bad("contact.more", more, "has nothing in it");
        ++more;
    }
    if (points != s.count(t.points))
        return bad("contact.point", points, join("the contacts have ", points, " points"));
    if (more != s.count(t.more)) return bad("contact.more", more, join(more, " contacts have a row here"));
    return {};
}

/// Returns an empty text if a row of a pair may have these flags, given the flags of the pair's first row.
std::string check_flags(std::uint32_t flags, std::uint32_t of_first, bool is_first) {
    constexpr std::uint32_t of_pair = solve::contact_sensor | solve::contact_sensor_is_b |
                                      solve::contact_flipped | solve::contact_passing,
                            known = of_pair | solve::contact_touching | solve::contact_on_face |
                                    solve::contact_has_more;
    if ((flags & ~known) != 0) return "unknown flags";
    if ((flags & (solve::contact_sensor | solve::contact_sensor_is_b)) == solve::contact_sensor_is_b)
        return "its sensor is the second shape, but none is a sensor";
    if (is_first) return {};
    if ((flags & solve::contact_touching) != 0) return "a row after the first says that the pair touches";
    if ((flags & of_pair) != (of_first & of_pair)) return "the rows of a pair differ in its flags";
    return {};
}

Status check_contacts(const Manifest& m, const State& s, const ContactTables& t) {
    const std::span<const ContactKey> keys = s.rows(t.key);
    const std::span<const ContactRow> memories = s.rows(t.memory);
    const std::span<const Slot> slots = s.rows(m.shape_slot);
    std::uint32_t rows = 0;
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const std::pair order(keys[i].a.index, keys[i].b.index);
        if (order.first >= order.second) return bad("contact.key", i, "its shapes are out of order");
        if (order.first == 0 || order.second > slots.size())
            return bad("contact.key", i, "names a shape that never was");
        rows = i > 0 && keys[i] == keys[i - 1] ? rows + 1 : 1;
        if (rows > collide::Manifolds::max) return bad("contact.key", i, "too many manifolds of one pair");
        if (i > 0 && rows == 1 && std::pair(keys[i - 1].a.index, keys[i - 1].b.index) >= order)
            return bad("contact.key", i, "the table is out of order");
        if (const std::string e = check_flags(memories[i].flags, memories[i + 1 - rows].flags, rows == 1);
            !e.empty())
            return bad("contact.memory", i, e);
        if (memories[i].margin < Length{}) return bad("contact.memory", i, "a negative margin");
        if (!unit_like(memories[i].normal) || !unit_like(memories[i].made_rotation))
            return bad("contact.memory", i, "its normal or rotation is not of unit length");
    }
    return check_contact_parts(s, t);
}

/// Checks that each body's joint list holds exactly its own joints.
Status check_joints(const Manifest& m, const State& s) {
    const std::span<const JointRow> joints = s.rows(m.joint);
    const std::span<const Slot> slots = s.rows(m.joint_slot), body_slots = s.rows(m.body_slot);
    const std::span<const BodyInfo> info = s.rows(m.body_info);
    const auto lives = [&](BodyId id) {
        return id.index != 0 && id.index <= body_slots.size() && body_slots[id.index - 1].is_alive() &&
               body_slots[id.index - 1].generation == id.generation;
    };
    std::size_t ends = 0, listed = 0;
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const JointDef& d = joints[i].def;
        if (std::string e = check(d); !e.empty()) return bad("joint.row", i, e);
        if (!lives(d.body_b) || (d.body_a && !lives(d.body_a)) || d.body_a == d.body_b)
            return bad("joint.row", i, "its bodies do not exist");
        ends += d.body_a ? 2u : 1u;
    }
    for (std::size_t i = 0; i < info.size(); ++i)
        for (std::uint32_t slot = info[i].first_joint; slot != 0; ++listed) {
            if (slot > slots.size() || !slots[slot - 1].is_alive() || listed >= ends)
                return bad("body.info", i, "its joint list is broken");
            const JointRow& r = joints[slots[slot - 1].row];
            if (r.def.body_a != info[i].id && r.def.body_b != info[i].id)
                return bad("body.info", i, "its joint list holds another body's joint");
            slot = r.def.body_a == info[i].id ? r.next_a : r.next_b;
        }
    if (listed != ends) return bad("joint.row", joints.size(), "joints in no list");
    return {};
}

/// Checks that the contacts of resting bodies belong to living shapes, and fit the table together with the other
/// contacts.
Status check_sleeping_contacts(const Manifest& m, const State& s) {
    const std::span<const ContactKey> keys = s.rows(m.sleeping_contacts.key);
    const std::span<const Slot> slots = s.rows(m.shape_slot), body_slots = s.rows(m.body_slot);
    if (keys.size() + s.count(m.contacts.contacts) > s.rows_max(m.contacts.contacts))
        return bad("sleeping_contact.key", keys.size(), "too many contacts");
    for (std::size_t i = 0; i < keys.size(); ++i)
        for (ShapeId id : {keys[i].a, keys[i].b}) {
            if (id.index == 0 || id.index > slots.size() || !slots[id.index - 1].is_alive() ||
                slots[id.index - 1].generation != id.generation)
                return bad("sleeping_contact.key", i, "its shape does not exist");
            const BodyId body = s.rows(m.shape)[slots[id.index - 1].row].body;
            if (body_slots[body.index - 1].row < s.rows(m.header)[0].bodies_awake)
                return bad("sleeping_contact.key", i, "its body is awake");
        }
    return {};
}

/// Checks that awake bodies come first, and that the rings of sleeping islands are closed.
Status check_sleep(const Manifest& m, const State& s) {
    const Header& h = s.rows(m.header)[0];
    const std::span<const BodyInfo> info = s.rows(m.body_info);
    const std::span<const BodySleep> sleep = s.rows(m.body_sleep);
    const std::span<const Slot> slots = s.rows(m.body_slot);
    if (h.bodies_awake > info.size() || h.joints_awake > s.count(m.joints))
        return bad("world.header", 0, "more is awake than there is");
    // Each member links to a higher slot, or back to the lowest slot of its island. So if no two members link to the
    // same one, the members of an island form one ring.
    std::vector<bool> is_next(slots.size());
    for (std::size_t i = 0; i < info.size(); ++i) {
        const bool in_ring = sleep[i].next != 0;
        if (in_ring && (i < h.bodies_awake || info[i].kind != BodyKind::dynamic || sleep[i].island == 0))
            return bad("body.sleep", i, "sleeps where it cannot");
        const bool moves = info[i].kind != BodyKind::static_ && s.rows(m.body_velocity)[i] != Velocity{};
        if (moves && i >= h.bodies_awake)
            return bad("body.velocity", i, "moves, but stands among resting bodies");
        if (sleep[i].still_ticks == 0 && sleep[i].moved != Velocity{})
            return bad("body.sleep", i, "has moved in no tick");
        if (sleep[i].island > slots.size()) return bad("body.sleep", i, "its island does not exist");
        if (!in_ring) continue;
        if (sleep[i].next > slots.size() || !slots[sleep[i].next - 1].is_alive())
            return bad("body.sleep", i, "its ring is broken");
        const std::uint32_t next = slots[sleep[i].next - 1].row;
        if (next < h.bodies_awake || sleep[next].island != sleep[i].island || sleep[next].next == 0 ||
            (sleep[i].next <= info[i].id.index && sleep[i].next != sleep[i].island))
            return bad("body.sleep", i, "its ring is broken");
        if (is_next[sleep[i].next - 1]) return bad("body.sleep", i, "its ring joins another");
        is_next[sleep[i].next - 1] = true;
    }
    return {};
}

/// Checks that joints with an awake body come first, and the joints of resting bodies after them.
Status check_joints_awake(const Manifest& m, const State& s) {
    const Header& h = s.rows(m.header)[0];
    const std::span<const JointRow> joints = s.rows(m.joint);
    const std::span<const Slot> slots = s.rows(m.body_slot);
    const auto is_awake = [&](BodyId body) { return body && slots[body.index - 1].row < h.bodies_awake; };
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const bool held = is_awake(joints[i].def.body_a) || is_awake(joints[i].def.body_b);
        if (held && i >= h.joints_awake)
            return bad("joint.row", i, "stands among resting joints, but a body of it is awake");
        if (!held && i < h.joints_awake)
            return bad("joint.row", i, "stands among awake joints, but no body of it is awake");
    }
    return {};
}

/// Checks that each vehicle has its own dynamic body.
Status check_vehicles(const Manifest& m, const State& s) {
    const std::span<const VehicleRow> rows = s.rows(m.vehicle);
    const std::span<const VehicleMemory> memories = s.rows(m.vehicle_memory);
    const std::span<const Slot> slots = s.rows(m.body_slot);
    std::vector<BodyId> chassis;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const VehicleDef& d = rows[i].def;
        if (std::string e = validate(d); !e.empty()) return bad("vehicle.row", i, e);
        if (std::string e = validate(rows[i].input); !e.empty()) return bad("vehicle.row", i, e);
        const bool lives = d.chassis.index != 0 && d.chassis.index <= slots.size() &&
                           slots[d.chassis.index - 1].is_alive() &&
                           slots[d.chassis.index - 1].generation == d.chassis.generation;
        if (!lives || s.rows(m.body_info)[slots[d.chassis.index - 1].row].kind != BodyKind::dynamic)
            return bad("vehicle.row", i, "its chassis is no dynamic body");
        chassis.push_back(d.chassis);
        const std::int32_t gears = static_cast<std::int32_t>(d.gearbox.forward_count);
        for (std::int32_t gear : {memories[i].gear, memories[i].gear_next})
            if (gear < -1 || gear > gears) return bad("vehicle.memory", i, "it has no such gear");
    }
    std::sort(chassis.begin(), chassis.end());
    if (std::adjacent_find(chassis.begin(), chassis.end()) != chassis.end())
        return bad("vehicle.row", rows.size(), "two vehicles have the same chassis");
    return {};
}

/// Checks that each character has a body that no other character has, and a capsule on it.
Status check_characters(const Manifest& m, const State& s) {
    const std::span<const Slot> body_slots = s.rows(m.body_slot), shape_slots = s.rows(m.shape_slot);
    const std::span<const CharacterRow> rows = s.rows(m.character);
    std::vector<std::uint8_t> has_character(body_slots.size());
    const auto row_of = [](std::span<const Slot> slots, auto id, std::uint32_t& row) {
        if (id.index == 0 || id.index > slots.size() || !slots[id.index - 1].is_alive() ||
            slots[id.index - 1].generation != id.generation)
            return false;
        row = slots[id.index - 1].row;
        return true;
    };
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const CharacterRow& r = rows[i];
        if (std::string e = check(r); !e.empty()) return bad("character.row", i, e);
        std::uint32_t body = 0, shape = 0;
        if (!row_of(body_slots, r.body, body) || !row_of(shape_slots, r.shape, shape))
            return bad("character.row", i, "its body or shape does not exist");
        if (s.rows(m.body_info)[body].kind != BodyKind::kinematic || s.rows(m.shape)[shape].body != r.body)
            return bad("character.row", i, "its body is not kinematic, or its shape not that body's");
        if (has_character[r.body.index - 1]++ != 0) return bad("character.row", i, "its body is another's");
    }
    return {};
}

Status check_filters(const Manifest& m, const State& s) {
    const std::span<const PairFilterRow> rows = s.rows(m.pair_filter);
    for (std::size_t i = 0; i < rows.size(); ++i)
        if (rows[i].a >= rows[i].b || (i > 0 && rows[i - 1] >= rows[i]))
            return bad("pair_filter.row", i, "the table is out of order");
    return {};
}

} // namespace

Status check_state(const Model& w, shapes::SolidCache& solids, const State& s) {
    const Manifest& m = w.m;
    if (s.count(m.world) != 1 || s.count(m.records) != 1) return Error{"portable image: it has no world row"};
    const Config &ours = w.state.rows(m.config)[0], &theirs = s.rows(m.config)[0];
    if (std::memcmp(&ours, &theirs, sizeof ours) != 0)
        return Error{
            "portable image: world.config differs: the image was saved by a world with another definition"};
    const Header& h = s.rows(m.header)[0];
    if (!within(h.gravity, Real(1000))) return bad("world.header", 0, "gravity is out of range");
    const auto body_id = [&](std::uint32_t row) { return s.rows(m.body_info)[row].id; };
    const auto shape_id = [&](std::uint32_t row) { return s.rows(m.shape)[row].id; };
    const auto field_id = [&](std::uint32_t row) { return s.rows(m.field)[row].id; };
    if (Status e = check_slots("body.slot", s.rows(m.body_slot), s.count(m.bodies), h.body_free, body_id); !e)
        return e;
    if (Status e = check_slots("shape.slot", s.rows(m.shape_slot), s.count(m.shapes), h.shape_free, shape_id);
        !e)
        return e;
    if (Status e = check_slots("field.slot", s.rows(m.field_slot), s.count(m.fields), h.field_free, field_id);
        !e)
        return e;
    if (Status e = check_fields(m, s); !e) return e;
    if (Status e = check_bodies(m, s); !e) return e;
    if (Status e = check_shapes(solids, m, s); !e) return e;
    const auto joint_id = [&](std::uint32_t row) { return s.rows(m.joint)[row].id; };
    if (Status e = check_slots("joint.slot", s.rows(m.joint_slot), s.count(m.joints), h.joint_free, joint_id);
        !e)
        return e;
    if (Status e = check_joints(m, s); !e) return e;
    const auto vehicle_id = [&](std::uint32_t row) { return s.rows(m.vehicle)[row].id; };
    if (Status e = check_slots("vehicle.slot", s.rows(m.vehicle_slot), s.count(m.vehicles), h.vehicle_free,
                               vehicle_id);
        !e)
        return e;
    if (Status e = check_vehicles(m, s); !e) return e;
    if (Status e = check_sleep(m, s); !e) return e;
    if (Status e = check_joints_awake(m, s); !e) return e;
    const auto character_id = [&](std::uint32_t row) { return s.rows(m.character)[row].id; };
    if (Status e = check_slots("character.slot", s.rows(m.character_slot), s.count(m.characters),
                               h.character_free, character_id);
        !e)
        return e;
    if (Status e = check_characters(m, s); !e) return e;
    if (Status e = check_filters(m, s); !e) return e;
    if (Status e = check_sleeping_contacts(m, s); !e) return e;
    if (Status e = check_contacts(m, s, m.sleeping_contacts); !e) return e;
    return check_contacts(m, s, m.contacts);
}

} // namespace lockstone::sim
