// Worlds whose definitions and commands are at and between the limits of every field, for runs under sanitizers.
//
//   worlds FIRST LAST      a line for each seed: seed, digest of the hashes of all its ticks and of the results of
//                          queries
//
// A refused definition is a valid result. An accepted one must tick without undefined behaviour.
#include "values.h"

#include <cstdio>
#include <cstdlib>
#include <memory>

using namespace lockstone;
using attack::Values;

namespace {

class Attacked {
  public:
    Attacked(std::uint64_t seed, std::shared_ptr<const AssetLibrary> assets)
        : v(seed), library(std::move(assets)), world(made(v, library)) {
        center = place(v);
        reach = v.between(Real{}, Real(400), Real(3));
        const std::uint32_t bodies = 3 + v.below(16);
        for (std::uint32_t i = 0; i < bodies; ++i) add_body();
        for (std::uint32_t i = v.below(8); i > 0; --i) add_joint();
        if (v.chance(3)) add_vehicle();
        if (v.chance(3)) add_character();
        for (std::uint32_t i = v.chance(2) ? v.below(4) : 0; i > 0; --i)
            told(world.create_field(attack::field_def(v, center)));
    }
    std::uint64_t run() {
        const std::uint32_t ticks = 2 + v.below(5);
        for (std::uint32_t t = 0; t < ticks; ++t) {
            for (std::uint32_t i = v.below(4); i > 0; --i) command();
            world.tick();
            note(world.hash());
            if (v.chance(3)) ask();
        }
        return digest;
    }

  private:
    static World made(Values& v, const std::shared_ptr<const AssetLibrary>& assets) {
        const std::uint32_t wildness = v.below(8);
        v.set_wildness(wildness);
        return World::create(attack::world_def(v), {}, assets).value();
    }
    /// The place of the world's bodies: mostly near the origin, else anywhere in the range.
    static Vec3 place(Values& v) {
        if (v.chance(2)) return {};
        return v.chance(2) ? v.each_within(Real(40000)) : v.each_within(Real(1000000000));
    }
    template <class T> void told(const Result<T>& result) { note(result ? 1 : 2); }
    void note(std::uint64_t word) {
        digest = (digest ^ word) * 0x9e3779b97f4a7c15u;
        digest ^= digest >> 29;
    }
    BodyId body() { return world.body_at(v.below(world.body_count())); }
    ShapeId shape() {
        const std::vector<ShapeId> shapes = world.shapes(body());
        return shapes.empty() ? ShapeId{} : shapes[v.below(static_cast<std::uint32_t>(shapes.size()))];
    }

    void add_body() {
        const BodyDef def = attack::body_def(v, v.near(center, reach));
        const Result<BodyId> made = world.create_body(def);
        told(made);
        if (!made) return;
        for (std::uint32_t i = 1 + (v.chance(4) ? v.below(3) : 0); i > 0; --i)
            told(world.create_shape(*made, attack::shape_def(v, def.kind, *library)));
    }
    void add_joint() {
        JointDef def = attack::joint_def(v);
        const BodyId a = v.chance(5) ? BodyId{} : body(), b = body();
        if (v.chance(2)) { // at their places
            const Transform at = v.near(center, reach);
            return told(world.create_joint(def, a, b, at));
        }
        def.body_a = a, def.body_b = b;
        told(world.create_joint(def));
    }
    void add_vehicle() {
        const Result<VehicleId> made = world.create_vehicle(attack::vehicle_def(v, body()));
        told(made);
        if (made) told(world.set_vehicle_input(*made, attack::vehicle_input(v)));
    }
    void add_character() {
        const Vec3 at = v.near(center, reach).position;
        const Result<CharacterId> made = world.create_character(attack::character_def(v, at));
        told(made);
        if (!made) return;
        CharacterInput input;
        input.velocity = v.as_long_as(character_speed_max);
        input.jump = v.below(2), input.crouch = v.below(2);
        told(world.set_character_input(*made, input));
    }

    void command() {
        const Real force = Real(2000000000);
        switch (v.below(14)) {
        case 0: {
            const BodyId which = body();
            const Transform to = v.near(center, reach);
            return told(world.set_pose(which, to));
        }
        case 1: {
            const BodyId which = body();
            const Vec3 linear = v.as_long_as(Real(500)), angular = v.each_within(Real(4095));
            return told(world.set_velocity(which, linear, angular));
        }
        case 2: {
            const BodyId which = body();
            const Vec3 push = v.each_within(force), torque = v.each_within(force);
            return told(world.add_force(which, push, torque));
        }
        case 3: {
            const BodyId which = body();
            const Vec3 push = v.each_within(force), point = v.each_within(Real(1000000000), center);
            return told(world.add_force_at(which, push, point));
        }
        case 4: {
            const BodyId which = body();
            const Vec3 push = v.each_within(force), spin = v.each_within(force);
            return told(world.add_impulse(which, push, spin));
        }
        case 5: {
            const BodyId which = body();
            const Vec3 push = v.each_within(force), point = v.each_within(Real(1000000000), center);
            return told(world.add_impulse_at(which, push, point));
        }
        default:
            return more_commands();
        }
    }
    void more_commands() {
        switch (v.below(9)) {
        case 0: {
            const BodyDef d = attack::body_def(v, Transform::identity());
            return told(
                world.set_body_parameters({body(), d.linear_damping, d.angular_damping, d.gravity_scale,
                                           d.locks, d.gyroscopic, d.bullet, d.enable_fields, d.drag_scale}));
        }
        case 1: {
            SetMass m{body(), v.between(0.001_r, Real(1000000000), Real(1)), {}, {}, {}};
            m.center = v.each_within(Real(64));
            Vec3 gyration;
            for (int i = 0; i < 3; ++i) gyration[i] = v.between(0.001_r, Real(100), Real(1));
            m.gyration = gyration;
            m.principal = v.turn();
            return told(world.set_mass(m));
        }
        case 2:
            return told(world.set_gravity(v.each_within(Real(1000))));
        case 3:
            return told(world.explode(attack::explosion_def(v, center)));
        case 4: {
            const ShapeDef d = attack::shape_def(v, BodyKind::dynamic, *library);
            return told(world.set_material(
                {shape(), d.friction, d.restitution, d.rolling_resistance, d.surface_velocity}));
        }
        case 5:
            return add_body();
        case 6:
            return add_joint();
        case 7:
            return world.body_count() > 1 ? told(world.destroy(body())) : void();
        default:
            return told(world.restore_portable(world.save_portable()));
        }
    }

    void note(const std::optional<QueryHit>& hit) {
        note(hit ? static_cast<std::uint64_t>(hit->distance.raw) ^ hit->feature : 3);
        if (hit) note(hit->part.source), note(hit->part.material);
    }
    void ask() {
        const Vec3 from = v.near(center, reach + reach).position;
        const Vec3 way = v.as_long_as(query_length_max);
        note(world.cast_ray({from, way}));
        const Geometry g = attack::geometry(v, BodyKind::dynamic, *library);
        const Transform pose = v.near(center, reach);
        note(world.cast_shape(g, pose, way));
        std::vector<ShapeId> shapes;
        world.overlap(g, pose, {}, shapes);
        note(shapes.size());
        note(world.nearest(g, pose, v.between(Real{}, query_length_max, Real(1))));
        const ShapeId a = shape(), b = shape();
        if (const auto d = world.distance(a, b)) note(static_cast<std::uint64_t>(d->distance.raw));
        note(static_cast<std::uint64_t>(world.kinetic_energy().raw));
        for (std::uint32_t i = 0; i < world.joint_count(); ++i)
            note(static_cast<std::uint64_t>(world.joint_state(world.joint_at(i)).position[0].raw));
        for (std::uint32_t i = 0; i < world.vehicle_count(); ++i)
            note(static_cast<std::uint64_t>(world.vehicle_state(world.vehicle_at(i)).rpm.raw));
    }

    Values v;
    std::shared_ptr<const AssetLibrary> library;
    World world;
    Vec3 center{};
    Real reach{};
    std::uint64_t digest = 0;
};

} // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "worlds FIRST LAST\n");
        return 2;
    }
    const std::uint64_t first = std::strtoull(argv[1], nullptr, 10),
                        last = std::strtoull(argv[2], nullptr, 10);
    const auto assets = std::make_shared<const AssetLibrary>(attack::assets_at_limits());
    for (std::uint64_t seed = first; seed <= last; ++seed) {
        std::printf("%llu ", static_cast<unsigned long long>(seed));
        std::fflush(stdout); // names the seed that stops the program
        std::printf("%016llx\n", static_cast<unsigned long long>(Attacked(seed, assets).run()));
    }
    return 0;
}
