#include "reference/reference.h"

#include "reference/collide.h"

#include <algorithm>
#include <cmath>

namespace reference {

using lockstone::Error, lockstone::Result, lockstone::Status;

namespace {

std::string text_of(double number) {
    std::string text = std::to_string(number);
    while (text.find('.') != std::string::npos && (text.back() == '0' || text.back() == '.')) {
        const bool was_point = text.back() == '.';
        text.pop_back();
        if (was_point) break;
    }
    return text;
}

/// Range check; NaN is outside of every range.
Status check_range(const char* name, double value, double low, double high) {
    if (value >= low && value <= high) return {};
    return Error{std::string(name) + " is " + text_of(value) + ", must be " + text_of(low) + " to " +
                 text_of(high)};
}

Status check(const Settings& s) {
    const struct {
        const char* name;
        double value, low, high;
    } ranges[] = {{"substeps", double(s.substeps), 0, 64},
                  {"position iterations", double(s.position_iterations), 1, 1e6},
                  {"velocity iterations", double(s.velocity_iterations), 1, 1e6},
                  {"position epsilon", s.position_epsilon, 0, 1},
                  {"velocity epsilon", s.velocity_epsilon, 0, 10},
                  {"bounce speed", s.bounce_speed_min, -1, 1000},
                  {"angular limit", s.angular_limit, 0, 10}};
    for (const auto& range : ranges)
        if (Status good = check_range(range.name, range.value, range.low, range.high); !good) return good;
    if (!is_available(s.build))
        return Error{std::string("this machine cannot run the build ") + name_of(s.build)};
    return {};
}

} // namespace

struct Engine::Impl {
    Settings settings;
    Start start;
    Law law;
    int substeps = 1;
    std::unique_ptr<Collider> collider;
    std::unique_ptr<Core> core;
    std::vector<Body> bodies;
    std::vector<Contact> contacts;
    std::vector<Resolved> resolved;
    std::uint64_t ticks = 0;
    bool touched = false;

    void read_back() {
        for (std::size_t i = 0; i < bodies.size(); ++i) {
            const Motion m = core->motion(static_cast<int>(i));
            bodies[i].center = m.position;
            bodies[i].pose = {m.position - rotate(m.orientation, start.bodies[i].local_center),
                              m.orientation};
            bodies[i].velocity = m.velocity, bodies[i].rotation = m.rotation;
        }
    }

    void step() {
        core->integrate();
        read_back();
        contacts = find_contacts(bodies);
        touched = touched || !contacts.empty();
        std::vector<Contact> seen = contacts;
        if (settings.on_contacts) settings.on_contacts(seen);
        resolved.clear();
        core->resolve(seen, resolved);
    }

    std::vector<Contact> find_contacts(std::span<const Body> at) const {
        std::vector<Pose> poses;
        for (const Body& body : at) poses.push_back(body.pose);
        return collider->contacts(poses);
    }

    double potential_of(const Body& body, const BodyStart& is) const {
        const double mass = 1 / is.mass_inv;
        double sum = -mass * is.gravity_scale * dot(law.gravity, body.center);
        if (!is.in_fields) return sum;
        for (const Field& f : law.fields) {
            const Vec away = body.center - f.center;
            const double r = std::sqrt(dot(away, away) + f.softening * f.softening);
            if (f.kind == Attraction::uniform) sum -= mass * dot(f.acceleration, body.center);
            if (f.kind == Attraction::spring) sum += mass * f.strength * dot(away, away) / 2;
            if (f.kind == Attraction::point_gravity && r > 0) sum -= mass * f.strength / r;
        }
        return sum;
    }

    void add_to(Measures& sum, const Body& body, const BodyStart& is) const {
        const double mass = 1 / is.mass_inv;
        const Turn axes = body.pose.rotation * is.principal;
        const Vec w = rotate(conjugate(axes), body.rotation);
        const auto per = [](double x, double inverse) { return inverse > 0 ? x / inverse : 0; };
        const Vec spin{per(w.x, is.inertia_inv.x), per(w.y, is.inertia_inv.y), per(w.z, is.inertia_inv.z)};
        sum.kinetic += mass * dot(body.velocity, body.velocity) / 2 + dot(w, spin) / 2;
        sum.potential += potential_of(body, is);
        sum.momentum = sum.momentum + body.velocity * mass;
        sum.angular_momentum =
            sum.angular_momentum + cross(body.center, body.velocity) * mass + rotate(axes, spin);
    }

    Measures measure(std::span<const Body> all) const {
        Measures sum;
        for (std::size_t i = 0; i < all.size(); ++i)
            if (start.bodies[i].start.mass_inv > 0) add_to(sum, all[i], start.bodies[i].start);
        return sum;
    }
    double penetration(std::span<const Body> all) const {
        double worst = 0;
        for (const Contact& contact : find_contacts(all)) worst = std::max(worst, contact.depth);
        return worst;
    }

    /// The index of a living body of the start; -1 for other ids.
    int index_of(lockstone::BodyId id) const {
        for (std::size_t i = 0; i < bodies.size(); ++i)
            if (bodies[i].id == id) return static_cast<int>(i);
        return -1;
    }
    double mass_inv(int body) const { return start.bodies[static_cast<std::size_t>(body)].start.mass_inv; }

    /// Changes the velocities by an impulse at the centre of mass and an angular impulse.
    void add_impulse(int body, const Vec& linear, const Vec& angular) {
        const BodyStart& is = start.bodies[static_cast<std::size_t>(body)].start;
        Motion m = core->motion(body);
        const Turn axes = m.orientation * is.principal;
        const Vec local = rotate(conjugate(axes), angular);
        const Vec turned{local.x * is.inertia_inv.x, local.y * is.inertia_inv.y, local.z * is.inertia_inv.z};
        m.velocity = m.velocity + linear * is.mass_inv;
        m.rotation = m.rotation + rotate(axes, turned);
        core->set_motion(body, m);
    }

    void act(int body, const lockstone::AddForce& c) {
        if (mass_inv(body) > 0) core->add_force(body, vec(c.force), vec(c.torque));
    }
    void act(int body, const lockstone::AddForceAt& c) {
        if (mass_inv(body) > 0) core->add_force_at(body, vec(c.force), vec(c.point));
    }
    void act(int body, const lockstone::AddImpulse& c) { add_impulse(body, vec(c.linear), vec(c.angular)); }
    void act(int body, const lockstone::AddImpulseAt& c) {
        const Vec arm = vec(c.point) - core->motion(body).position;
        add_impulse(body, vec(c.impulse), cross(arm, vec(c.impulse)));
    }
    void act(int body, const lockstone::SetVelocity& c) {
        Motion m = core->motion(body);
        m.velocity = vec(c.linear), m.rotation = vec(c.angular);
        core->set_motion(body, m);
    }
    void act(int body, const lockstone::SetPose& c) {
        Motion m = core->motion(body);
        m.orientation = turn(c.pose.rotation);
        m.position = vec(c.pose.position) +
                     rotate(m.orientation, start.bodies[static_cast<std::size_t>(body)].local_center);
        core->set_motion(body, m);
    }
};

Engine::Engine(std::unique_ptr<Impl> made) : impl(std::move(made)) {}
Engine::Engine(Engine&&) noexcept = default;
Engine& Engine::operator=(Engine&&) noexcept = default;
Engine::~Engine() = default;

Result<Engine> Engine::create(const lockstone::World& world, const Settings& settings) {
    if (const Status good = check(settings); !good) return good.error();
    Result<Start> start = read_start(world);
    if (!start) return start.error();
    Result<std::unique_ptr<Collider>> collider = Collider::create(*start, world, settings.box_ground);
    if (!collider) return collider.error();
    auto made = std::make_unique<Impl>();
    const lockstone::WorldDef& def = world.def();
    made->settings = settings;
    made->substeps = settings.substeps > 0 ? settings.substeps : static_cast<int>(def.substeps);
    made->law = {.dt = 1.0 / (double(def.tick_rate) * made->substeps),
                 .gravity = vec(world.gravity()),
                 .integrator = settings.integrator,
                 .gyroscopic = settings.gyroscopic,
                 .resolver = {settings.position_iterations, settings.velocity_iterations,
                              settings.position_epsilon, settings.velocity_epsilon,
                              settings.bounce_speed_min < 0 ? lockstone::to_double(def.restitution_speed_min)
                                                            : settings.bounce_speed_min,
                              settings.angular_limit},
                 .fields = start->fields};
    std::vector<BodyStart> starts;
    for (const StartedBody& body : start->bodies) {
        starts.push_back(body.start);
        made->bodies.push_back({body.id, {}, {}, {}, {}});
    }
    made->start = std::move(*start);
    made->collider = std::move(*collider);
    made->core = make_core(settings.build, made->law, starts);
    made->read_back();
    return Engine(std::move(made));
}

Status Engine::apply(const lockstone::Command& command) {
    return std::visit(
        [&](const auto& c) -> Status {
            using C = std::decay_t<decltype(c)>;
            if constexpr (std::is_same_v<C, lockstone::WriteGame> || std::is_same_v<C, lockstone::WakeBody>) {
                return {};
            } else if constexpr (std::is_same_v<C, lockstone::SetGravity>) {
                impl->law.gravity = vec(c.gravity);
                impl->core->set_gravity(impl->law.gravity);
                return {};
            } else if constexpr (requires(Impl & i) { i.act(0, c); }) {
                const int body = impl->index_of(c.body);
                if (body < 0)
                    return Error{std::string(name_of(command)) +
                                 ": names a body that was not there at the start"};
                impl->act(body, c);
                impl->read_back();
                return {};
            } else {
                return Error{std::string(name_of(command)) + ": nothing that the thesis' engine can do"};
            }
        },
        command);
}

/// Section 3.1: "the main loop calls the update function on a fixed time step for each object", then collisions are
/// resolved.
void Engine::tick() {
    impl->touched = false;
    for (int i = 0; i < impl->substeps; ++i) impl->step();
    impl->core->clear_forces();
    impl->read_back();
    ++impl->ticks;
}

std::uint64_t Engine::tick_count() const { return impl->ticks; }
std::span<const Body> Engine::bodies() const { return impl->bodies; }
std::span<const lockstone::ShapeDef> Engine::shapes(std::size_t body) const {
    return impl->start.bodies[body].shapes;
}
bool Engine::is_dynamic(std::size_t body) const { return impl->start.bodies[body].start.mass_inv > 0; }
double Engine::energy() const { return impl->measure(impl->bodies).energy(); }
Vec Engine::momentum() const { return impl->measure(impl->bodies).momentum; }
double Engine::penetration() const { return impl->penetration(impl->bodies); }

Measures Engine::measure() const {
    Measures sum = impl->measure(impl->bodies);
    sum.penetration = impl->penetration(impl->bodies);
    return sum;
}

Measures Engine::measure(const lockstone::World& world) const {
    std::vector<Body> all;
    for (const Body& body : impl->bodies)
        all.push_back({body.id, pose(world.pose(body.id)), vec(world.center_of_mass(body.id)),
                       vec(world.linear_velocity(body.id)), vec(world.angular_velocity(body.id))});
    Measures sum = impl->measure(all);
    sum.penetration = impl->penetration(all);
    return sum;
}

std::span<const Contact> Engine::contacts() const { return impl->contacts; }
bool Engine::touched() const { return impl->touched; }
std::span<const Resolved> Engine::resolved() const { return impl->resolved; }

} // namespace reference
