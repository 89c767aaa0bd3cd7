// Worlds under random commands: bodies, shapes and joints are created, destroyed, thrown, teleported and get extreme
// values.
// Two builds must print equal lines; tests/soak/run compares them, and shrinks a script that differs.
//
//   soak --seeds FIRST LAST TICKS      a line for each seed: seed, digest of the hashes of all its ticks
//   soak --script-of SEED TICKS        the script of a seed
//   soak FILE                          runs a script: a line for each tick, number and hash
//
// A script has a line for each command: tick, operation, two numbers that select its target, a seed of its values.
// Its first line is "ticks N". A target may be destroyed and values may be out of range: then the world refuses the
// command.
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "lockstone/world.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

using namespace lockstone;

namespace {

struct Step {
    std::uint64_t tick;
    std::uint32_t operation, a, b;
    std::uint64_t seed;
};
struct Script {
    std::uint64_t ticks = 0;
    std::vector<Step> steps; ///< ascending by tick
};

enum Operation : std::uint32_t {
    create_body,
    destroy_body,
    create_shape,
    destroy_shape,
    create_joint,
    destroy_joint,
    set_pose,
    set_velocity,
    add_force,
    add_impulse,
    add_impulse_at,
    set_parameters,
    set_material,
    set_filter,
    set_pair_filter,
    set_gravity,
    set_mass,
    create_field,
    destroy_field,
    wake,
    roll_back,
    reload,
    operation_count,
};

Script script_of(std::uint64_t seed, std::uint64_t ticks) {
    Random random = Random::seeded(seed);
    Script script{ticks, {}};
    const auto add = [&](std::uint64_t tick, std::uint32_t operation) {
        script.steps.push_back({tick, operation, random.next_u32(), random.next_u32(), random.next_u64()});
    };
    for (int i = 0; i < 12; ++i) add(0, create_body);
    for (std::uint64_t tick = 0; tick < ticks; ++tick)
        if (random.next_u32() % 4 == 0) add(tick, random.next_u32() % operation_count);
    return script;
}

/// Values for definitions: mostly moderate, sometimes at or beyond the limits.
class Values {
  public:
    explicit Values(std::uint64_t seed) : random(Random::seeded(seed)) {}
    bool chance(std::uint32_t of) { return random.next_u32() % of == 0; }
    std::uint32_t below(std::uint32_t n) { return random.next_u32() % n; }
    /// In [-metres, metres]; one in 50 is enormous.
    Real about(std::int64_t metres) {
        const std::int64_t raw = static_cast<std::int64_t>(random.next_u64() >> 1);
        if (chance(50)) return Real::from_raw(chance(2) ? raw : -raw);
        return Real::from_raw(raw % (metres * 2 << 32) - (metres << 32));
    }
    Real up_to(std::int64_t metres) { return Real::from_raw(about(metres).raw / 2 + (metres << 31)); }
    Vec3 vector(std::int64_t metres) {
        const Real x = about(metres), y = about(metres), z = about(metres);
        return {x, y, z};
    }
    Quat turn() {
        constexpr UnitVec3 axes[] = {
            {unit_one, Unit{}, Unit{}}, {Unit{}, unit_one, Unit{}}, {Unit{}, Unit{}, unit_one}};
        const Real angle = Real::from_raw(about(3).raw % (std::int64_t{7} << 32));
        return chance(3) ? Quat::identity() : from_axis_angle(axes[below(3)], angle);
    }
    Transform pose() {
        const Vec3 at = vector(4);
        return {{at.x, at.y + Real(chance(30) ? 100000 : 4), at.z}, turn()};
    }
    Geometry geometry() {
        const Real size =
            Real::from_raw((std::int64_t{1} << 29) +
                           static_cast<std::int64_t>(random.next_u64() % (std::uint64_t{1} << 32)));
        switch (below(6)) {
        case 0:
            return sphere(size);
        case 1:
            return capsule(size, size);
        case 2:
            return cylinder(size, size);
        case 3:
            return cone(size, size);
        case 4:
            return chance(8) ? box(size * 8, size, size) : box(size, size, size);
        default:
            return box(size, Real::from_raw(size.raw / 2), size);
        }
    }

  private:
    Random random;
};

/// A world, and the objects that a script has made in it.
class Soaked {
  public:
    Soaked() : world(start()) {}
    void run(const Step& step) {
        Values v(step.seed);
        apply(step, v);
        apply_more(step, v);
    }
    void tick() { world.tick(); }
    std::uint64_t hash() const { return world.hash(); }

  private:
    static World start() {
        WorldDef def;
        def.bodies_max = 40, def.shapes_max = 60, def.contacts_max = 400, def.joints_max = 24,
        def.fields_max = 4;
        World w = World::create(def).value();
        const BodyId ground = w.create_body({.kind = BodyKind::static_}).value();
        if (!w.create_shape(ground, {.geometry = plane()})) std::abort();
        return w;
    }
    BodyId body(std::uint32_t number) const { return world.body_at(number % world.body_count()); }
    ShapeId shape(std::uint32_t number) const {
        const std::vector<ShapeId> shapes = world.shapes(body(number));
        return shapes.empty() ? ShapeId{} : shapes[number / 64 % shapes.size()];
    }
    template <class T> static void told(const Result<T>&) {} // a refusal is a result too

    void apply(const Step& s, Values& v) {
        switch (s.operation) {
        case create_body: {
            BodyDef def;
            def.kind = v.chance(8) ? BodyKind::kinematic : BodyKind::dynamic;
            def.pose = v.pose(), def.linear_velocity = v.vector(5), def.angular_velocity = v.vector(6);
            def.bullet = v.chance(6), def.locks = v.chance(8) ? v.below(64) : 0;
            const auto made = world.create_body(def);
            if (made)
                told(world.create_shape(
                    *made, {.geometry = v.geometry(),
                            .restitution = v.chance(3) ? Real::from_raw(std::int64_t{1} << 31) : Real{}}));
            return;
        }
        case destroy_body:
            return s.a % world.body_count() == 0 ? void() : told(world.destroy(body(s.a)));
        case create_shape:
            return told(world.create_shape(
                body(s.a),
                {.geometry = v.geometry(), .local = {v.vector(1), v.turn()}, .sensor = v.chance(5)}));
        case destroy_shape:
            return told(world.destroy(shape(s.a)));
        case create_joint: {
            // Separate statements: the evaluation order of a call's arguments is unspecified.
            const JointDef def = joint(v);
            return told(world.create_joint(def, body(s.a), body(s.b), v.pose()));
        }
        case destroy_joint:
            return world.joint_count() == 0 ? void()
                                            : told(world.destroy(world.joint_at(s.a % world.joint_count())));
        case set_pose:
            return told(world.set_pose(body(s.a), v.pose()));
        case set_velocity: {
            const Vec3 linear = v.vector(30);
            return told(world.set_velocity(body(s.a), linear, v.vector(20)));
        }
        case add_force:
            return told(world.add_force(body(s.a), v.vector(5000)));
        case add_impulse:
            return told(world.add_impulse(body(s.a), v.vector(500)));
        default:
            return;
        }
    }

    void apply_more(const Step& s, Values& v) {
        switch (s.operation) {
        case add_impulse_at: {
            const Vec3 impulse = v.vector(500);
            return told(world.add_impulse_at(body(s.a), impulse, v.vector(5)));
        }
        case set_parameters: {
            const Real linear = v.up_to(2), angular = v.up_to(2), scale = v.about(2);
            return told(world.set_body_parameters(
                {body(s.a), linear, angular, scale, v.chance(4) ? v.below(64) : 0, 1, v.chance(3)}));
        }
        case set_material: {
            const Real friction = v.up_to(1), bounce = v.up_to(1);
            return told(world.set_material({shape(s.a), friction, bounce, Real{}, v.vector(2)}));
        }
        case set_filter:
            return told(world.set_filter({shape(s.a), 1u << v.below(4), v.chance(2) ? ~0u : v.below(16), 0}));
        case set_pair_filter:
            return told(world.set_pair_filter(body(s.a), body(s.b), v.chance(2)));
        case set_gravity:
            return told(world.set_gravity(v.chance(2) ? WorldDef{}.gravity : v.vector(12)));
        case set_mass:
            return told(world.set_mass(
                {body(s.a), v.up_to(1000), {}, Vec3{Real(1), Real(1), Real(1)}, Quat::identity()}));
        case create_field:
            return told(
                world.create_field({.center = v.vector(5), .strength = v.about(40), .softening = Real(1)}));
        case destroy_field:
            return told(world.destroy(FieldId{s.a % 4 + 1, s.b % 4 + 1}));
        case wake:
            return told(world.wake_body(body(s.a)));
        case roll_back: // as in a rollback: the ticks in between must leave no trace
            world.save(image);
            for (std::uint32_t i = 0; i < s.a % 5; ++i) world.tick();
            return world.restore(image);
        case reload:
            return told(world.restore_portable(world.save_portable()));
        default:
            return;
        }
    }

    static JointDef joint(Values& v) {
        JointDef def = v.chance(3) ? hinge_joint() : v.chance(2) ? ball_joint() : weld_joint();
        if (v.chance(4)) def.break_force = v.up_to(5000);
        return def;
    }

    World world;
    Image image;
};

/// Calls after(tick, hash) after each tick.
template <class After> void run_script(const Script& script, After&& after) {
    Soaked soaked;
    std::size_t next = 0;
    for (std::uint64_t tick = 0; tick < script.ticks; ++tick) {
        for (; next < script.steps.size() && script.steps[next].tick <= tick; ++next)
            soaked.run(script.steps[next]);
        soaked.tick();
        after(tick, soaked.hash());
    }
}

bool read_script(const char* path, Script& script) {
    std::FILE* file = std::fopen(path, "r");
    if (file == nullptr) return false;
    unsigned long long tick, seed, ticks;
    unsigned operation, a, b;
    bool good = std::fscanf(file, "ticks %llu\n", &ticks) == 1;
    script.ticks = good ? ticks : 0;
    while (good && std::fscanf(file, "%llu %u %u %u %llu\n", &tick, &operation, &a, &b, &seed) == 5)
        script.steps.push_back({tick, operation % operation_count, a, b, seed});
    good = good && std::feof(file) != 0;
    std::fclose(file);
    return good;
}

void print_script(const Script& script) {
    std::printf("ticks %llu\n", static_cast<unsigned long long>(script.ticks));
    for (const Step& s : script.steps)
        std::printf("%llu %u %u %u %llu\n", static_cast<unsigned long long>(s.tick), s.operation, s.a, s.b,
                    static_cast<unsigned long long>(s.seed));
}

void print_digests(std::uint64_t first, std::uint64_t last, std::uint64_t ticks) {
    for (std::uint64_t seed = first; seed <= last; ++seed) {
        std::uint64_t digest = 0;
        run_script(script_of(seed, ticks), [&](std::uint64_t, std::uint64_t hash) {
            const std::uint64_t pair[] = {digest, hash};
            std::vector<std::byte> bytes;
            for (const std::uint64_t word : pair)
                for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::byte>(word >> (8 * i) & 0xffu));
            digest = hash_bytes(bytes);
        });
        std::printf("%llu %016llx\n", static_cast<unsigned long long>(seed),
                    static_cast<unsigned long long>(digest));
    }
}

} // namespace

int main(int argc, char** argv) {
    const auto number = [&](int i) { return std::strtoull(argv[i], nullptr, 10); };
    if (argc == 5 && std::strcmp(argv[1], "--seeds") == 0) {
        print_digests(number(2), number(3), number(4));
    } else if (argc == 4 && std::strcmp(argv[1], "--script-of") == 0) {
        print_script(script_of(number(2), number(3)));
    } else if (argc == 2) {
        Script script;
        if (!read_script(argv[1], script)) {
            std::fprintf(stderr, "soak: %s is no script\n", argv[1]);
            return 2;
        }
        run_script(script, [](std::uint64_t tick, std::uint64_t hash) {
            std::printf("%llu %016llx\n", static_cast<unsigned long long>(tick),
                        static_cast<unsigned long long>(hash));
        });
    } else {
        std::fprintf(stderr, "soak --seeds FIRST LAST TICKS | --script-of SEED TICKS | FILE\n");
        return 2;
    }
    return 0;
}
