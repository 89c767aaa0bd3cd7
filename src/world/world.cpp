// World: the public face. Each mutator builds a command; readers read the columns directly.
#include "lockstone/world.h"

#include "base/assert.h"
#include "base/hash.h"
#include "base/text.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "model/sleep.h"
#include "world/world_impl.h"

#include <algorithm>
#include <cstring>

namespace lockstone {

using base::join;

// ---- creation --------------------------------------------------------------------------------------------------

namespace {

/// Identifies the definition and the assets of a world; State::can_restore compares it. Valid within this process
/// only.
std::uint64_t origin_of(const WorldDef& def, const AssetLibrary& assets) {
    base::HashStream hash;
    const sim::Config config = sim::config_of(def);
    hash.add(std::as_bytes(std::span(&config, 1)));
    for (const AssetId id : assets.ids()) hash.add(id.value);
    return hash.digest() | 1; // 0 means a layout without an origin
}

} // namespace

namespace sim {

Data::Data(const WorldDef& d, const GameSchema& s, std::shared_ptr<const AssetLibrary> assets)
    : Model(with_derived_limits(d), s, origin_of(with_derived_limits(d), *assets)),
      placed(std::move(assets)) {
    placed.solids.use(solve::kernels_of(best_simd())->hulls);
    placed.kernel = solve::kernels_of(best_simd())->bounds;
    state.resize(m.world, 1);
    state.resize(m.records, 1);
    edit_header().gravity = def.gravity;
    state.edit_row(m.config, 0) = config_of(def);
}

Data::Data(const Data& other) : Data(other.def, other.schema, other.placed.solids.library()) {
    state = other.state;
    placed.fit(state.capacity(m.shape_slots));
}

} // namespace sim

World::World(std::unique_ptr<Impl> i) : impl(std::move(i)) {}
World::World(World&& other) noexcept : impl(std::move(other.impl)) {} // each object has its own `life`
World& World::operator=(World&& other) noexcept {
    impl = std::move(other.impl);
    return *this;
}
World::~World() = default;

World::Inside::Inside(std::unique_ptr<Impl> i) : held(std::move(i)) {}
World::Impl* World::Inside::moved_from() {
    base::assertion_failed("a world that is used holds a state", "this one was moved from", __FILE__,
                           __LINE__);
}

std::weak_ptr<const void> World::lifetime() {
    if (life == nullptr) life = std::make_shared<const char>();
    return life;
}

Result<World> World::create(const WorldDef& def, const GameSchema& schema,
                            std::shared_ptr<const AssetLibrary> assets) {
    if (std::string e = sim::check(def); !e.empty()) return Error{std::move(e)};
    if (assets == nullptr) assets = std::make_shared<const AssetLibrary>();
    return World(std::make_unique<Impl>(def, schema, std::move(assets)));
}

namespace {

/// Memory that one row costs the solver, the broad phase and the lists of a tick, in addition to the state [bytes].
/// The attack test `bombs` compares it with worlds whose tables are full, and with crowds, whose pairs contacts_max
/// limits; tick/pairs.cpp.
constexpr std::uint64_t per_body = 1024, per_shape = 6144, per_contact = 3072, per_joint = 4096,
                        per_character = 1024, per_vehicle = 8192, per_world = std::uint64_t{2} << 20;

} // namespace

Result<World::Memory> World::memory_of(const WorldDef& given, const GameSchema& schema) {
    if (std::string e = sim::check(given); !e.empty()) return Error{std::move(e)};
    const WorldDef def = sim::with_derived_limits(given);
    const sim::Manifest manifest = sim::make_manifest(def, schema);
    Memory memory{std::uint64_t{1} << 16, per_world};
    for (const ColumnInfo& column : manifest.layout->columns())
        memory.state += std::uint64_t{manifest.layout->tables()[column.table].rows_max} * column.row_size;
    memory.state += memory.state / 64; // a version and a hash for each page of 4 kB
    memory.work += memory.state;       // while the block grows, the old one still exists
    memory.work += per_body * def.bodies_max + per_shape * def.shapes_max + per_contact * def.contacts_max +
                   per_joint * def.joints_max + per_character * def.characters_max +
                   per_vehicle * def.vehicles_max;
    return memory;
}

World World::clone() const {
    const base::Holds holds(impl->query.lock);
    return World(std::make_unique<Impl>(*impl));
}

void World::tick() { sim::tick(*impl); }
std::uint64_t World::tick_count() const { return impl->header().tick; }
const WorldDef& World::def() const { return impl->def; }
const AssetLibrary& World::assets() const { return *impl->placed.solids.library(); }
std::shared_ptr<const AssetLibrary> World::assets_shared() const { return impl->placed.solids.library(); }

// ---- commands --------------------------------------------------------------------------------------------------

Result<World::Applied> World::apply(const Command& command) { return sim::apply(*impl, command); }

Result<BodyId> World::create_body(const BodyDef& def) {
    const Result<Applied> applied = apply(CreateBody{def});
    if (!applied) return applied.error();
    return applied->body;
}
Result<ShapeId> World::create_shape(BodyId body, const ShapeDef& def) {
    const Result<Applied> applied = apply(CreateShape{body, def});
    if (!applied) return applied.error();
    return applied->shape;
}
Result<FieldId> World::create_field(const FieldDef& def) {
    const Result<Applied> applied = apply(CreateField{def});
    if (!applied) return applied.error();
    return applied->field;
}
Result<JointId> World::create_joint(const JointDef& def) {
    const Result<Applied> applied = apply(CreateJoint{def});
    if (!applied) return applied.error();
    return applied->joint;
}
Result<JointId> World::create_joint(JointDef def, BodyId a, BodyId b, const Transform& at) {
    const auto frame_in = [&](BodyId body) {
        if (!is_alive(body)) return at; // a null body is the world; the command refuses a dead body
        const Transform p = pose(body);
        const Quat back = conjugate(p.rotation);
        return Transform{rotate(back, at.position - p.position), normalized(back * at.rotation)};
    };
    def.body_a = a;
    def.body_b = b;
    def.frame_a = frame_in(a);
    def.frame_b = frame_in(b);
    return create_joint(def);
}
Status World::destroy(JointId joint) { return status_of(apply(DestroyJoint{joint})); }
Status World::set_joint_axis(JointId joint, JointAxisIndex index, const JointAxis& axis) {
    return status_of(apply(SetJointAxis{joint, index, 0, axis}));
}
Status World::set_joint_frames(JointId joint, const Transform& frame_a, const Transform& frame_b) {
    return status_of(apply(SetJointFrames{joint, frame_a, frame_b}));
}
Status World::destroy(BodyId body) { return status_of(apply(DestroyBody{body})); }
Status World::destroy(ShapeId shape) { return status_of(apply(DestroyShape{shape})); }
Status World::set_field(FieldId field, const FieldDef& def) { return status_of(apply(SetField{field, def})); }
Status World::explode(const ExplosionDef& def) { return status_of(apply(Explode{def})); }
Status World::destroy(FieldId field) { return status_of(apply(DestroyField{field})); }
Status World::set_pose(BodyId body, const Transform& pose) { return status_of(apply(SetPose{body, pose})); }
Status World::set_velocity(BodyId body, Vec3 linear, Vec3 angular) {
    return status_of(apply(SetVelocity{body, linear, angular}));
}
Status World::add_force(BodyId body, Vec3 force, Vec3 torque) {
    return status_of(apply(AddForce{body, force, torque}));
}
Status World::add_force_at(BodyId body, Vec3 force, Vec3 point) {
    return status_of(apply(AddForceAt{body, force, point}));
}
Status World::add_impulse(BodyId body, Vec3 linear, Vec3 angular) {
    return status_of(apply(AddImpulse{body, linear, angular}));
}
Status World::add_impulse_at(BodyId body, Vec3 impulse, Vec3 point) {
    return status_of(apply(AddImpulseAt{body, impulse, point}));
}
Status World::set_body_parameters(const SetBodyParameters& parameters) {
    return status_of(apply(parameters));
}
Status World::set_material(const SetMaterial& material) { return status_of(apply(material)); }
Status World::set_filter(const SetFilter& filter) { return status_of(apply(filter)); }
Status World::set_pair_filter(BodyId a, BodyId b, bool collide) {
    return status_of(apply(SetPairFilter{a, b, collide ? 1u : 0u}));
}
Status World::set_mass(const SetMass& mass) { return status_of(apply(mass)); }
Status World::wake_body(BodyId body) { return status_of(apply(WakeBody{body})); }
Status World::set_gravity(Vec3 gravity) { return status_of(apply(SetGravity{gravity})); }

namespace {
/// The entry of a game column with rows of this size. A Column<T> of another schema is a programmer's error.
const GameSchema::Entry& game_column(const sim::Model& w, std::uint32_t column, std::size_t row_size) {
    LOCKSTONE_ASSERT(column < w.m.game.size(), "game column ", column, " of ", w.m.game.size());
    const GameSchema::Entry& entry = w.schema.entries()[column];
    LOCKSTONE_ASSERT(entry.row_size == row_size, "game column ", entry.name, " has rows of ", entry.row_size,
                     " bytes, not of ", row_size, ": it is of another schema");
    return entry;
}
} // namespace

Status World::write_bytes(std::uint32_t column, BodyId body, std::span<const std::byte> row) {
    game_column(*impl, column, row.size());
    std::vector<std::byte>& canonical = impl->written_row;
    canonical.clear();
    append_canonical(row, impl->schema.entries()[column].leaves, canonical);
    for (std::size_t offset = 0; offset < canonical.size(); offset += WriteGame{}.data.size()) {
        WriteGame piece{};
        piece.column = column;
        piece.body = body;
        piece.offset = offset;
        piece.size = static_cast<std::uint32_t>(std::min(piece.data.size(), canonical.size() - offset));
        std::memcpy(piece.data.data(), canonical.data() + offset, piece.size);
        if (Status s = status_of(apply(piece)); !s) return s;
    }
    return {};
}

// ---- reading ---------------------------------------------------------------------------------------------------

namespace {
std::uint32_t living(const sim::Model& w, BodyId id) {
    const std::uint32_t row = w.row_of(id);
    LOCKSTONE_ASSERT(row != sim::Model::dead, "body ", id.index, ":", id.generation, " is not alive");
    return row;
}
std::uint32_t living(const sim::Model& w, ShapeId id) {
    const std::uint32_t row = w.row_of(id);
    LOCKSTONE_ASSERT(row != sim::Model::dead, "shape ", id.index, ":", id.generation, " is not alive");
    return row;
}
std::uint32_t living(const sim::Model& w, JointId id) {
    const std::uint32_t row = w.row_of(id);
    LOCKSTONE_ASSERT(row != sim::Model::dead, "joint ", id.index, ":", id.generation, " is not alive");
    return row;
}
} // namespace

bool World::is_alive(BodyId body) const { return impl->row_of(body) != sim::Model::dead; }
bool World::is_alive(ShapeId shape) const { return impl->row_of(shape) != sim::Model::dead; }
bool World::is_alive(JointId joint) const { return impl->row_of(joint) != sim::Model::dead; }
bool World::is_alive(FieldId field) const { return impl->row_of(field) != sim::Model::dead; }
std::uint32_t World::field_count() const { return impl->state.count(impl->m.fields); }
FieldId World::field_at(std::uint32_t row) const {
    return sim::checked_row(impl->state.rows(impl->m.field), row, "field").id;
}
FieldDef World::field(FieldId field) const {
    const std::uint32_t row = impl->row_of(field);
    LOCKSTONE_ASSERT(row != sim::Model::dead, "field ", field.index, ":", field.generation, " is not alive");
    return impl->state.rows(impl->m.field)[row].def;
}
Submersion World::submersion(BodyId body) const {
    const std::uint32_t row = living(*impl, body);
    const base::Holds holds(impl->query.lock);
    return sim::submersion(*impl, impl->placed, row);
}
bool World::is_awake(BodyId body) const { return sim::is_awake(*impl, living(*impl, body)); }
std::uint32_t World::awake_count() const { return impl->header().bodies_awake; }
std::uint32_t World::body_count() const { return impl->state.count(impl->m.bodies); }
BodyId World::body_at(std::uint32_t row) const {
    return sim::checked_row(impl->state.rows(impl->m.body_info), row, "body").id;
}

std::vector<BodyId> World::bodies() const {
    std::vector<BodyId> out;
    for (const sim::BodyInfo& info : impl->state.rows(impl->m.body_info)) out.push_back(info.id);
    return out;
}

Transform World::pose(BodyId body) const { return sim::body_origin(*impl, living(*impl, body)); }
Vec3 World::center_of_mass(BodyId body) const {
    return impl->state.rows(impl->m.body_pose)[living(*impl, body)].position;
}
Vec3 World::linear_velocity(BodyId body) const {
    return to<Real>(impl->state.rows(impl->m.body_velocity)[living(*impl, body)].linear);
}
Vec3 World::angular_velocity(BodyId body) const {
    return to<Real>(impl->state.rows(impl->m.body_velocity)[living(*impl, body)].angular);
}
Real World::mass(BodyId body) const { return impl->mass_of(living(*impl, body)).mass; }
BodyKind World::kind(BodyId body) const {
    return impl->state.rows(impl->m.body_info)[living(*impl, body)].kind;
}
std::uint64_t World::user_key(BodyId body) const {
    return impl->state.rows(impl->m.body_info)[living(*impl, body)].user_key;
}

BodyDef World::body(BodyId body) const { return sim::body_def(*impl, living(*impl, body)); }
SetMass World::mass_properties(BodyId body) const {
    const sim::BodyMass& mass = impl->mass_of(living(*impl, body));
    return {body, mass.mass, mass.center, mass.gyration, mass.principal};
}
bool World::may_touch(BodyId a, BodyId b) const {
    living(*impl, a), living(*impl, b);
    const std::span<const sim::PairFilterRow> rows = impl->state.rows(impl->m.pair_filter);
    return !std::binary_search(rows.begin(), rows.end(), sim::PairFilterRow{std::min(a, b), std::max(a, b)});
}
Vec3 World::gravity() const { return impl->header().gravity; }

std::vector<ShapeId> World::shapes(BodyId body) const {
    const State& state = impl->state;
    const std::span<const sim::Slot> slots = state.rows(impl->m.shape_slot);
    const std::span<const sim::ShapeRow> shapes = state.rows(impl->m.shape);
    std::vector<ShapeId> out;
    std::uint32_t slot = state.rows(impl->m.body_info)[living(*impl, body)].first_shape;
    for (; slot != 0; slot = shapes[slots[slot - 1].row].next_shape)
        out.push_back(shapes[slots[slot - 1].row].id);
    std::reverse(out.begin(), out.end());
    return out;
}
ShapeDef World::shape(ShapeId shape) const { return sim::shape_def(*impl, living(*impl, shape)); }
BodyId World::body_of(ShapeId shape) const {
    return impl->state.rows(impl->m.shape)[living(*impl, shape)].body;
}

std::uint32_t World::joint_count() const { return impl->state.count(impl->m.joints); }
JointId World::joint_at(std::uint32_t row) const {
    return sim::checked_row(impl->state.rows(impl->m.joint), row, "joint").id;
}
JointDef World::joint(JointId joint) const {
    return impl->state.rows(impl->m.joint)[living(*impl, joint)].def;
}

JointState World::joint_state(JointId joint) const {
    const std::uint32_t row = living(*impl, joint);
    const JointDef& def = impl->state.rows(impl->m.joint)[row].def;
    const sim::JointMemory& memory = impl->state.rows(impl->m.joint_memory)[row];
    const auto frame = [&](BodyId body, const Transform& local) {
        if (!is_alive(body)) return local;
        const Transform p = pose(body);
        return Transform{p.position + rotate(p.rotation, local.position),
                         normalized(p.rotation * local.rotation)};
    };
    return {solve::joint_coordinates(def, frame(def.body_a, def.frame_a), frame(def.body_b, def.frame_b),
                                     memory.twist),
            memory.force, memory.torque};
}

std::vector<JointId> World::joints(BodyId body) const {
    const std::span<const sim::Slot> slots = impl->state.rows(impl->m.joint_slot);
    const std::span<const sim::JointRow> joints = impl->state.rows(impl->m.joint);
    std::vector<JointId> out;
    std::uint32_t slot = impl->state.rows(impl->m.body_info)[living(*impl, body)].first_joint;
    while (slot != 0) {
        const sim::JointRow& r = joints[slots[slot - 1].row];
        out.push_back(r.id);
        slot = r.def.body_a == body ? r.next_a : r.next_b;
    }
    return out;
}

Real World::kinetic_energy() const {
    const State& state = impl->state;
    Real sum{};
    for (std::uint32_t row = 0; row < body_count(); ++row) {
        const sim::BodyMass& mass = impl->mass_of(row);
        if (mass.mass == Real{}) continue;
        const sim::Velocity& v = state.rows(impl->m.body_velocity)[row];
        const Rotation axes = to_rotation(state.rows(impl->m.body_pose)[row].rotation * mass.principal);
        const Vec3 w = mul_transposed<Real>(axes, to<Real>(v.angular));
        const Vec3 u{w.x * mass.gyration.x, w.y * mass.gyration.y, w.z * mass.gyration.z};
        sum += half(mass.mass * (dot<Real>(v.linear, v.linear) + dot<Real>(u, u)));
    }
    return sum;
}

std::span<const std::byte> World::row_bytes(std::uint32_t column, BodyId body, std::size_t size) const {
    const GameSchema::Entry& entry = game_column(*impl, column, size);
    const std::uint32_t row = entry.per_body ? living(*impl, body) : 0;
    return impl->state.bytes(impl->m.game[column]).subspan(row * entry.row_size, entry.row_size);
}

Faults World::faults() const { return impl->state.rows(impl->m.faults)[0]; }
std::span<const Event> World::events() const { return impl->output.events; }
std::span<const World::ContactPoint> World::contacts() const {
    const base::Holds holds(impl->query.lock);
    sim::find_contact_points(*impl);
    return impl->output.contact_points.list;
}

void World::contacts(BodyId body, std::vector<ContactPoint>& points) const {
    const base::Holds holds(impl->query.lock);
    sim::find_contact_points(*impl);
    points.clear();
    sim::points_of(impl->output.contact_points, body, points);
}

// ---- state -----------------------------------------------------------------------------------------------------

std::uint64_t World::hash() const {
    const base::Holds holds(impl->query.lock);
    return impl->state.hash();
}
void World::save(Image& image) const { impl->state.save(image); }

Status World::can_restore(const Image& image) const {
    if (Status s = impl->state.can_restore(image); !s) return Error{"restore: " + s.error().message};
    return {};
}
void World::restore(const Image& image) {
    const Status good = can_restore(image);
    LOCKSTONE_ASSERT(good.ok(), good.error().message);
    impl->state.restore(image);
    sim::forget_derived(*impl);
    sim::tell_of_restore(*impl);
}
std::vector<std::byte> World::save_portable() const { return impl->state.save_portable(); }

namespace {
/// Replaces the state of a world by one from outside, if the check accepts it.
Status take_over(sim::Data& w, State&& loaded) {
    if (Status s = sim::check_state(w, w.placed.solids, loaded); !s) return s;
    w.state = std::move(loaded);
    sim::forget_derived(w);
    sim::tell_of_restore(w);
    return {};
}
} // namespace

Status World::restore_portable(std::span<const std::byte> image) {
    State loaded(impl->state.layout_shared());
    if (Status s = loaded.restore_portable(image); !s) return s;
    return take_over(*impl, std::move(loaded));
}

std::vector<std::byte> World::save_delta(const Image& base) const {
    const Status good = can_restore(base);
    LOCKSTONE_ASSERT(good.ok(), good.error().message);
    State before(impl->state.layout_shared());
    before.restore(base);
    const base::Holds holds(impl->query.lock);
    return impl->state.save_delta(before);
}

Status World::restore_delta(const Image& base, std::span<const std::byte> delta) {
    if (Status s = can_restore(base); !s) return s;
    State loaded(impl->state.layout_shared());
    loaded.restore(base);
    if (Status s = loaded.apply_delta(delta); !s) return s;
    return take_over(*impl, std::move(loaded));
}

const State& World::state() const { return impl->state; }
const GameSchema& World::schema() const { return impl->schema; }
void World::set_journal(Journal* journal) { impl->journal = journal; }
void World::set_tasks(Tasks* tasks) { impl->hooks.tasks = tasks; }
void World::observe_phases(PhaseObserver* observer) { impl->hooks.observer = observer; }
bool World::set_simd(Simd level) {
    sim::TickScratch& s = impl->scratch;
    const solve::Kernels* kernels = solve::kernels_of(level);
    if (kernels == nullptr) return false;
    s.bodies.kernel = kernels->bodies, s.contact_scratch.pair_kernel = kernels->pairs;
    impl->placed.solids.use(kernels->hulls), impl->placed.kernel = kernels->bounds;
    for (sim::PlacedShapes::Shape& shape : impl->placed.shape) shape.solid.kernel = kernels->hulls;
    return s.contacts.use(level) && s.joint_solver.use(kernels->joints);
}
void World::record_phase_hashes(bool on) { impl->hooks.phase_hashes = on; }
std::span<const PhaseHash> World::phase_hashes() const { return impl->output.phase_hashes; }

} // namespace lockstone
