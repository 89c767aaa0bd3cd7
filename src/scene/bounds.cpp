// World poses, margins and bounds of shapes, and their leaves in the broad phase.
#include "base/parallel.h"
#include "base/prefetch.h"
#include "model/sleep.h"
#include "scene/placed_shapes.h"

#include "base/assert.h"
#include "lockstone/math/math.h"

#include <algorithm>
#include <array>
#include <bit>

namespace lockstone::sim {

namespace {

/// Most shapes have the position and the axes of their body; the function then skips the products.
Transform shape_pose(const ShapeTraits& shape, const Transform& body, const BodyMass& mass) {
    const bool is_turned = shape.local.rotation != Quat::identity();
    return {shape.local.position == mass.center
                ? body.position
                : body.position + rotate(body.rotation, shape.local.position - mass.center),
            is_turned ? normalized(body.rotation * shape.local.rotation) : body.rotation};
}

/// A fast body gets contacts before it arrives, as far ahead as its own size, so it lands on surfaces; twice as far
/// ahead if it has a joint, as the joints lose a body that only the sweep stops. Rotation moves the ends of a thin
/// shape farther than its inner radius, and the sweep lets a touching shape rotate into the other shape, so the margin
/// includes the path of the ends.
Length margin_of(const PlacedShapes::Shape& at, const BodyInfo& info, const Velocity& velocity,
                 std::uint32_t tick_rate) {
    const Length ahead = ahead_of(velocity.linear, tick_rate),
                 most = info.first_joint != 0 ? at.inner + at.inner : at.inner;
    return margin_base + min(ahead, most) + turn_ahead_of(at, velocity.angular, tick_rate);
}

/// The columns that the work on every shape reads, looked up once.
struct PlaceView {
    std::span<const ShapeRow> shapes;
    std::span<const Slot> slots;
    std::span<const ShapeTraits> traits;
    std::span<const BodyInfo> info;
    std::span<const BodyTraits> body_traits;
    std::span<const Transform> poses;
    std::span<const Velocity> velocities;
    std::uint32_t tick_rate;
    int shift;

    explicit PlaceView(const Model& w)
        : shapes(w.state.rows(w.m.shape)), slots(w.state.rows(w.m.shape_slot)),
          traits(w.state.rows(w.m.shape_traits.row)), info(w.state.rows(w.m.body_info)),
          body_traits(w.state.rows(w.m.body_traits.row)), poses(w.state.rows(w.m.body_pose)),
          velocities(w.state.rows(w.m.body_velocity)), tick_rate(w.config().tick_rate),
          shift(static_cast<int>(w.config().bounds_shift)) {}
};

/// Sets the pose and the margin of a shape whose solid is known.
void set_pose(const PlaceView& v, const ShapeTraits& shape, std::uint32_t body_row, PlacedShapes::Shape& at) {
    const BodyInfo& info = v.info[body_row];
    const Geometry& geometry = at.solid.geometry;
    at.pose = shape_pose(shape, v.poses[body_row], v.body_traits[info.traits].mass);
    at.margin = info.kind == BodyKind::static_ ? margin_base
                                               : margin_of(at, info, v.velocities[body_row], v.tick_rate);
    at.has_axes = geometry.kind != ShapeKind::sphere || geometry.half_extent != LengthVec3{};
}

/// Computes the axes and bounds at the shape's pose.
void set_bounds(const PlaceView& v, PlacedShapes::Shape& at) {
    const Geometry& geometry = at.solid.geometry;
    if (!at.has_axes) {
        at.bounds = collide::bounds_of_ball(geometry, at.pose.position, at.margin, v.shift);
        return;
    }
    at.axes = to_rotation(at.pose.rotation);
    if (geometry.kind != ShapeKind::plane)
        at.bounds = collide::bounds_of(at.solid, at.pose.position, at.axes, at.margin, v.shift);
}

/// Passes a shape to the broad phase. Resting shapes are in its still tree; the broad phase makes no pairs of two of
/// them.
void hand_over(const Model& w, PlacedShapes& s, const ShapeRow& shape, std::uint32_t body_row) {
    const std::uint32_t slot = shape.id.index - 1;
    PlacedShapes::Shape& at = s.shape[slot];
    at.rests = !is_awake(w, body_row);
    if (at.solid.geometry.kind == ShapeKind::plane) {
        // Before a restore, a shape with bounds may have had this slot and generation.
        if (s.proxy_generation[slot] != 0) s.broad_phase.remove(slot);
        s.proxy_generation[slot] = 0;
        return;
    }
    s.broad_phase.set(slot, at.bounds, at.rests);
    s.proxy_generation[slot] = shape.id.generation;
    if (!at.rests) return;
    at.resting_local = w.traits_of(shape).local;
    at.resting_at = w.state.rows(w.m.body_pose)[body_row];
    at.resting_center = w.mass_of(body_row).center;
}

void set_proxy(const Model& w, PlacedShapes& s, const ShapeRow& shape, std::uint32_t body_row) {
    PlacedShapes::Shape& at = s.shape[shape.id.index - 1];
    at.rests = false;
    solid_of(w, s, shape);
    const PlaceView v(w);
    set_pose(v, w.traits_of(shape), body_row, at);
    set_bounds(v, at);
    hand_over(w, s, shape, body_row);
}

/// Like set_proxy(), but returns early if the broad phase already holds the resting shape at this place.
void set_resting_proxy(const Model& w, PlacedShapes& s, const ShapeRow& shape, std::uint32_t body_row) {
    const PlacedShapes::Shape& at = s.shape[shape.id.index - 1];
    const bool is_there = at.rests && s.proxy_generation[shape.id.index - 1] == shape.id.generation &&
                          at.solid.geometry == w.traits_of(shape).geometry &&
                          at.resting_local == w.traits_of(shape).local &&
                          at.resting_at == w.state.rows(w.m.body_pose)[body_row] &&
                          at.resting_center == w.mass_of(body_row).center;
    if (!is_there) set_proxy(w, s, shape, body_row);
}

template <class Visit> void for_each_shape(const Model& w, std::uint32_t body_row, Visit&& visit) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    for (std::uint32_t slot = w.state.rows(w.m.body_info)[body_row].first_shape; slot != 0;) {
        const ShapeRow& shape = shapes[slots[slot - 1].row];
        slot = shape.next_shape;
        visit(shape);
    }
}

constexpr std::uint32_t bodies_per_chunk = 32;

/// Equal to operator==, in fewer steps: a geometry has no padding.
bool is_same(const Geometry& a, const Geometry& b) {
    using Words = std::array<std::uint64_t, sizeof(Geometry) / sizeof(std::uint64_t)>;
    const Words x = std::bit_cast<Words>(a), y = std::bit_cast<Words>(b);
    std::uint64_t other = 0;
    for (std::size_t i = 0; i < x.size(); ++i) other |= x[i] ^ y[i];
    return other == 0;
}

/// Places shapes whose solids are known. Writes only to these shapes.
class Placing {
  public:
    Placing(const PlaceView& view, const collide::BoundsKernel* bounds_kernel, const base::Paths& taken)
        : v(view), kernel(bounds_kernel), paths(taken) {}

    void add(const ShapeTraits& traits, std::uint32_t row, PlacedShapes::Shape& at) {
        at.is_placed = is_same(at.solid.geometry, traits.geometry);
        if (!at.is_placed) return;
        set_pose(v, traits, row, at);
        const bool is_in_lanes = kernel != nullptr && is_round_box(traits.geometry);
        paths.take(is_in_lanes, base::Path::shapes_one_by_one, base::Path::shapes_in_lanes);
        if (!is_in_lanes) return set_bounds(v, at);
        put(at);
        if (count == collide::RoundBoxes::room) finish();
    }
    /// Computes axes and bounds of the shapes that are still in the batch.
    void finish() {
        if (count == 0) return;
        fill_up();
        std::uint32_t left = kernel->place(boxes, count, collide::bounds_drop(v.shift));
        paths.take(left != 0, base::Path::shapes_none_left, base::Path::shapes_left_by_lanes);
        for (; left != 0; left &= left - 1) set_bounds(v, *shape[std::countr_zero(left)]);
        count = 0;
    }

  private:
    /// Returns true if the kernel supports the geometry.
    static bool is_round_box(const Geometry& g) {
        return (g.kind == ShapeKind::capsule || g.kind == ShapeKind::box) && g.scale.x == scale_one.x;
    }
    void put(PlacedShapes::Shape& at) {
        const Geometry& g = at.solid.geometry;
        const bool is_box = g.kind == ShapeKind::box; // only a box has an extent along x and z
        shape[count] = &at;
        boxes.rotation[count] = &at.pose.rotation.x.raw;
        boxes.axes[count] = &at.axes.x.x.raw, boxes.bounds[count] = &at.bounds.lower.x.raw;
        for (int i = 0; i < 3; ++i) boxes.position[i][count] = at.pose.position[i].raw;
        boxes.margin[count] = at.margin.raw + collide::bounds_guard;
        boxes.radius[count] = g.radius.raw;
        boxes.half[0][count] = is_box ? g.half_extent.x.raw : 0;
        boxes.half[1][count] = g.half_extent.y.raw;
        boxes.half[2][count] = is_box ? g.half_extent.z.raw : 0;
        ++count;
    }
    /// Fills the unused lanes of the kernel. The code ignores their results.
    void fill_up() {
        for (std::uint32_t i = count; i % collide::RoundBoxes::lanes_max != 0; ++i) {
            boxes.rotation[i] = &unturned.x.raw, boxes.axes[i] = boxes.bounds[i] = spare;
            boxes.margin[i] = boxes.radius[i] = 0;
            for (int k = 0; k < 3; ++k) boxes.position[k][i] = 0, boxes.half[k][i] = 0;
        }
    }

    const PlaceView& v;
    const collide::BoundsKernel* kernel;
    const base::Paths& paths;
    std::uint32_t count = 0;
    PlacedShapes::Shape* shape[collide::RoundBoxes::room];
    const Quat unturned = Quat::identity();
    std::int32_t spare[9];
    collide::RoundBoxes boxes;
};

/// The distance that a body moves in a tick at its velocity.
Vector3<Bound> motion_of(const PlaceView& v, std::uint32_t row) {
    const SpeedVec3& velocity = v.velocities[row].linear;
    const auto one = [&](Speed s) {
        constexpr int drop = Speed::fraction_bits - Bound::fraction_bits;
        return Bound::from_raw((s.raw >> (drop + v.shift)) / static_cast<std::int32_t>(v.tick_rate));
    };
    return {one(velocity.x), one(velocity.y), one(velocity.z)};
}

/// Passes a shape that has left its leaf, or has none, to the broad phase. Resolves its solid if that is not known:
/// this changes data that all workers share, so it happens here, on one thread.
void hand_over_moved(const Model& w, const PlaceView& v, PlacedShapes& s, const ShapeRow& shape,
                     std::uint32_t row) {
    const std::uint32_t slot = shape.id.index - 1;
    PlacedShapes::Shape& at = s.shape[slot];
    if (!at.is_placed) return set_proxy(w, s, shape, row);
    if (at.solid.geometry.kind == ShapeKind::plane) return hand_over(w, s, shape, row);
    at.rests = false;
    s.paths.take(base::Path::leaves_left);
    s.broad_phase.set(slot, at.bounds, false, motion_of(v, row));
    s.proxy_generation[slot] = shape.id.generation;
}

/// Updates a shape of an awake body in the broad phase if it stays within its leaf. Returns false, and changes
/// nothing, if it does not.
inline bool hand_over_within(PlacedShapes& s, const ShapeRow& shape) {
    const std::uint32_t slot = shape.id.index - 1;
    PlacedShapes::Shape& at = s.shape[slot];
    if (!at.is_placed || at.filter.kind == ShapeKind::plane || !s.broad_phase.move_within(slot, at.bounds))
        return false;
    at.rests = false;
    s.paths.take(base::Path::leaves_kept);
    s.proxy_generation[slot] = shape.id.generation;
    return true;
}

/// Workers place the shapes of the awake bodies. Then one thread passes those that have left their leaves to the
/// broad phase, in order.
void update_awake(const Model& w, PlacedShapes& s, Tasks* tasks) {
    const std::uint32_t awake = w.header().bodies_awake;
    const PlaceView v(w);
    const auto for_each = [&v](std::uint32_t row, auto&& visit) {
        for (std::uint32_t slot = v.info[row].first_shape; slot != 0;) {
            const ShapeRow& shape = v.shapes[v.slots[slot - 1].row];
            visit(shape, slot - 1);
            slot = shape.next_shape;
        }
    };
    const auto place = [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        Placing placing(v, s.kernel, s.paths);
        for (std::uint32_t row = first; row < last; ++row) {
            if (row + 3 < awake && v.info[row + 3].first_shape != 0)
                base::prefetch(s.shape[v.info[row + 3].first_shape - 1]);
            for_each(row, [&](const ShapeRow& shape, std::uint32_t slot) {
                placing.add(v.traits[shape.traits], row, s.shape[slot]);
            });
        }
        placing.finish();
    };
    const auto tell = [&](std::uint32_t row) {
        for_each(row, [&](const ShapeRow& shape, std::uint32_t) {
            if (!hand_over_within(s, shape)) hand_over_moved(w, v, s, shape, row);
        });
    };
    s.paths.take(base::is_shared(tasks, awake, bodies_per_chunk), base::Path::bounds_by_one,
                 base::Path::bounds_by_workers);
    if (tasks == nullptr) {
        for (std::uint32_t first = 0; first < awake; first += bodies_per_chunk) { // while shapes are cached
            const std::uint32_t last = std::min(first + bodies_per_chunk, awake);
            place(first, last, 0);
            for (std::uint32_t row = first; row < last; ++row) tell(row);
        }
        return;
    }
    s.is_told.assign(awake, 0);
    base::for_chunks(tasks, awake, bodies_per_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
                         place(first, last, worker);
                         for (std::uint32_t row = first; row < last; ++row) {
                             bool all = true;
                             for_each(row, [&](const ShapeRow& shape, std::uint32_t) {
                                 all = hand_over_within(s, shape) && all;
                             });
                             s.is_told[row] = all ? 1 : 0;
                         }
                     });
    for (std::uint32_t row = 0; row < awake; ++row)
        if (s.is_told[row] == 0) tell(row);
}

bool is_living_plane(const Model& w, std::uint32_t slot) {
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    return slot < slots.size() && slots[slot].is_alive() &&
           w.traits_of(w.state.rows(w.m.shape)[slots[slot].row]).geometry.kind == ShapeKind::plane;
}

void drop_if_dead(const Model& w, PlacedShapes& s, std::uint32_t slot) {
    if (s.proxy_generation[slot] == 0) return;
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    if (slot < slots.size() && slots[slot].is_alive() && slots[slot].generation == s.proxy_generation[slot])
        return;
    s.broad_phase.remove(slot);
    s.proxy_generation[slot] = 0;
}

void set_resting_proxies(const Model& w, PlacedShapes& s, std::uint32_t first_body, std::uint32_t end_body) {
    for (std::uint32_t row = std::max(first_body, w.header().bodies_awake); row < end_body; ++row)
        for_each_shape(w, row, [&](const ShapeRow& shape) { set_resting_proxy(w, s, shape, row); });
}

/// Handles a shape that may be new.
void meet_shape(const Model& w, PlacedShapes& s, const ShapeRow& shape) {
    std::vector<std::uint32_t>& planes = s.planes;
    const std::uint32_t slot = shape.id.index - 1, body_row = w.row_of(shape.body);
    if (w.traits_of(shape).geometry.kind == ShapeKind::plane) {
        const auto at = std::lower_bound(planes.begin(), planes.end(), slot);
        if (at == planes.end() || *at != slot) planes.insert(at, slot);
    }
    if (!is_awake(w, body_row)) set_resting_proxy(w, s, shape, body_row);
}

/// Passes on which shapes belong to static bodies: two of them never meet. Every command that adds a shape to a body,
/// or removes one, edits the body's row of body_info; `s.changed` has the rows that changed.
void take_kinds(const Model& w, PlacedShapes& s) {
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    for (const RowRange& range : s.changed)
        for (std::uint32_t row = range.first; row < range.end; ++row)
            for_each_shape(w, row, [&](const ShapeRow& shape) {
                s.broad_phase.set_never_moves(shape.id.index - 1, info[row].kind == BodyKind::static_);
            });
}

/// Updates the filters of the shapes that may have changed since the last call. Leaves the changed rows of the table
/// of shapes in `s.changed`.
void take_shape_changes(const Model& w, PlacedShapes& s) {
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const auto note = [&](std::uint32_t first, std::uint32_t end) {
        for (const ShapeRow& shape : shapes.subspan(first, end - first)) {
            const ShapeTraits& is = w.traits_of(shape);
            s.shape[shape.id.index - 1].filter = {
                shape.id.generation, shape.body.index - 1,           shape.traits, is.category, is.mask,
                is.geometry.kind,    is.sensor == 0 && is.group == 0};
        }
    };
    w.state.take_changes(w.m.shape_traits.row.index, s.proxies_of, s.changed);
    if (!s.changed.empty()) note(0, static_cast<std::uint32_t>(shapes.size()));
    w.state.take_changes(w.m.shape.index, s.proxies_of, s.changed);
    for (const RowRange& range : s.changed) note(range.first, range.end);
}

/// Updates the proxies of resting shapes, and the list of planes, after any change of the state. If the pages of a
/// shape and of its body have not changed since the last call, and the body rested then too, the proxy is still
/// right.
void update_resting(const Model& w, PlacedShapes& s) {
    const State& state = w.state;
    const std::uint32_t slots_before = state.take_changes(w.m.shape_slot.index, s.proxies_of, s.changed);
    for (const RowRange& range : s.changed)
        for (std::uint32_t slot = range.first; slot < range.end; ++slot) drop_if_dead(w, s, slot);
    for (std::uint32_t slot = state.count(w.m.shape_slots); slot < slots_before; ++slot)
        drop_if_dead(w, s, slot);
    std::erase_if(s.planes, [&](std::uint32_t slot) { return !is_living_plane(w, slot); });

    take_shape_changes(w, s);
    for (const RowRange& range : s.changed)
        for (std::uint32_t row = range.first; row < range.end; ++row)
            meet_shape(w, s, state.rows(w.m.shape)[row]);
    for (const std::uint32_t column : {w.m.body_info.index, w.m.body_pose.index}) {
        state.take_changes(column, s.proxies_of, s.changed);
        if (column == w.m.body_info.index) take_kinds(w, s);
        for (const RowRange& range : s.changed) set_resting_proxies(w, s, range.first, range.end);
    }
    // Bodies that were awake then and rest now: their pages may be from before that call.
    set_resting_proxies(w, s, w.header().bodies_awake, std::min(s.awake_before, state.count(w.m.bodies)));
    for (const std::uint32_t slot : s.solids_replaced)
        if (slot < state.count(w.m.shape_slots) && state.rows(w.m.shape_slot)[slot].is_alive())
            meet_shape(w, s, state.rows(w.m.shape)[state.rows(w.m.shape_slot)[slot].row]);
    s.solids_replaced.clear();
}

/// Skips the changes of resting shapes: used when only awake bodies, and the set of awake bodies, have changed.
void pass_over_changes(const Model& w, PlacedShapes& s) {
    take_shape_changes(w, s);
    w.state.take_changes(w.m.body_info.index, s.proxies_of, s.changed);
    take_kinds(w, s);
    for (const std::uint32_t column : {w.m.shape_slot.index, w.m.body_pose.index})
        w.state.take_changes(column, s.proxies_of, s.changed);
}

} // namespace

void PlacedShapes::fit(std::uint32_t shape_slots) {
    if (shape_slots <= shape.size()) return;
    shape.reserve(shape_slots), shape.resize(shape_slots); // not more than needed: the state grows in steps
    proxy_generation.reserve(shape_slots), proxy_generation.resize(shape_slots, 0);
    broad_phase.grow(shape_slots);
}

void PlacedShapes::reserve(std::uint32_t shape_slots) {
    fit(shape_slots);
    broad_phase.reserve(shape_slots);
    solids_replaced.reserve(shape_slots);
}

namespace {

/// A bound of at least the length of a vector and at most an eighth more, within the range of a Speed: margins end
/// far below that.
std::int64_t length_bound(SpeedVec3 v) {
    const auto size = [](Speed s) { return static_cast<std::int64_t>(magnitude(s.raw)); };
    const std::int64_t x = size(v.x), y = size(v.y), z = size(v.z), widest = std::max(x, std::max(y, z));
    return std::min(widest + ((x + y + z - widest + 1) >> 1), std::int64_t{Speed::max().raw});
}

/// The distance covered in a tick at a speed [m/s, Length], rounded up to steps.
Length in_steps(std::int64_t speed, std::uint32_t tick_rate) {
    // Tests 2 ahead <= margin_base without a division: most bodies are slow.
    if (speed < std::int64_t{margin_base.raw / 2} * tick_rate) return Length{};
    const std::int64_t ahead = speed / tick_rate + 1;
    const std::int64_t steps = (ahead + margin_base.raw - 1) / margin_base.raw;
    // Up to eight, every number of steps is possible; up to sixteen, every second one; and so on.
    const int coarser =
        std::max(0, static_cast<int>(std::bit_width(static_cast<std::uint64_t>(steps - 1))) - 3);
    return to<Length>(Coordinate::from_raw(margin_base.raw * ((((steps - 1) >> coarser) + 1) << coarser)));
}

} // namespace

Length ahead_of(SpeedVec3 velocity, std::uint32_t tick_rate) {
    constexpr int finer = Length::fraction_bits - Speed::fraction_bits;
    return in_steps(length_bound(velocity) << finer, tick_rate);
}

Length turn_ahead_of(const PlacedShapes::Shape& at, SpeedVec3 angular, std::uint32_t tick_rate) {
    if (!is_thin(at) || angular == SpeedVec3{}) return Length{};
    const std::int64_t reach = std::min<std::int64_t>(at.reach.raw, Length::max().raw);
    const Length turned =
        in_steps(length_bound(angular) * reach >> Speed::fraction_bits, tick_rate); // products below 2^63
    return min(turned, Length::from_raw(static_cast<std::int32_t>(reach)));
}

const shapes::Solid& solid_of(const Model& w, PlacedShapes& s, const ShapeRow& shape) {
    PlacedShapes::Shape& at = s.shape[shape.id.index - 1];
    if (at.solid.geometry == w.traits_of(shape).geometry) return at.solid;
    Result<shapes::Solid> solid = s.solids.resolve(w.traits_of(shape).geometry);
    LOCKSTONE_ASSERT(solid.ok(), "shape ", shape.id.index, ": ", solid.ok() ? "" : solid.error().message);
    if (at.rests) s.solids_replaced.push_back(shape.id.index - 1);
    at.rests = false; // its bounds belong to the other solid
    at.solid = *solid;
    at.has_pieces = at.solid.mesh != nullptr || at.solid.height_field != nullptr;
    at.reach = at.solid.geometry.kind == ShapeKind::plane ? Coordinate{} : shapes::reach_of(at.solid);
    at.inner = shapes::inner_radius(at.solid);
    return at.solid;
}

void update_bounds(const Model& w, PlacedShapes& s, Tasks* tasks) {
    s.fit(w.state.capacity(w.m.shape_slots));
    s.paths.take(s.structure_stale, base::Path::resting_kept, base::Path::resting_looked_at);
    if (s.structure_stale)
        update_resting(w, s);
    else
        pass_over_changes(w, s);
    s.structure_stale = false, s.is_current = true;
    s.awake_before = w.header().bodies_awake;
    update_awake(w, s, tasks);
}

} // namespace lockstone::sim
