// The bodies of one build, behind the interface that all builds share.
#include "reference/builds.h"
#include "reference/engine/resolve.h"

namespace reference::LOCKSTONE_REFERENCE_BUILD {
namespace {

class ThisCore final : public Core {
  public:
    ThisCore(const Law& law, std::span<const BodyStart> starts)
        : settings(law.resolver), forces{Number(law.dt), in(law.gravity), law.gyroscopic, {}},
          move(integrator_of(law.integrator)) {
        for (const Field& f : law.fields)
            forces.fields.push_back(
                {f.kind, in(f.center), Number(f.strength), Number(f.softening), in(f.acceleration)});
        for (const BodyStart& start : starts) bodies.emplace_back(start);
    }

    void set_gravity(const Vec& gravity) override { forces.gravity = in(gravity); }
    void add_force(int body, const Vec& force, const Vec& torque) override {
        at(body).force_accum += in(force);
        at(body).torque_accum += in(torque);
    }
    void add_force_at(int body, const Vec& force, const Vec& point) override {
        at(body).add_force_at_point(in(force), in(point));
    }
    void clear_forces() override {
        for (Rigidbody& body : bodies) body.force_accum = body.torque_accum = {};
    }
    void set_motion(int body, const Motion& motion) override {
        Rigidbody& b = at(body);
        b.position = in(motion.position), b.orientation = in(motion.orientation);
        b.velocity = in(motion.velocity), b.rotation = in(motion.rotation);
        b.update_derived();
    }
    Motion motion(int body) const override {
        const Rigidbody& b = bodies[static_cast<std::size_t>(body)];
        return {out(b.position), out(b.orientation), out(b.velocity), out(b.rotation)};
    }

    void integrate() override {
        for (Rigidbody& body : bodies) {
            if (body.is_movable()) {
                move(body, forces);
            } else {
                body.position += body.velocity * forces.dt;
                body.orientation = body.orientation + rate_of(body.orientation, body.rotation) * forces.dt;
            }
            body.update_derived();
        }
    }

    void resolve(std::span<const Contact> contacts, std::vector<Resolved>& log) override {
        collisions.clear();
        for (const Contact& contact : contacts) collisions.emplace_back(contact, bodies, settings);
        LOCKSTONE_REFERENCE_BUILD::resolve(collisions, settings, forces.dt, log);
    }

  private:
    Rigidbody& at(int body) { return bodies[static_cast<std::size_t>(body)]; }

    Resolver settings;
    Forces forces;
    Integrate move;
    std::vector<Rigidbody> bodies;
    std::vector<Collision> collisions;
};

} // namespace

std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies) {
    return std::make_unique<ThisCore>(law, bodies);
}

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
