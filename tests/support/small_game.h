// A small complete game for tests of sessions and replays: each of two players pushes a ball over a floor with three
// crates. The game stores a score and a generation per body in its own columns, and sometimes throws a crate in, so
// that every part of the state changes: ids, contacts, game columns.
#pragma once

#include "lockstone/game.h"
#include "lockstone/input.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"

#include <array>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace lockstone::test {

struct SmallInput {
    std::int8_t x, z;      ///< push along the axes [4 N]
    std::uint16_t buttons; ///< bit 0: jump; bit 1: throw a crate in
};
template <class V> constexpr void describe(SmallInput& p, V&& v) {
    v("x", p.x), v("z", p.z), v("buttons", p.buttons);
}

struct SmallScore {
    std::array<BodyId, 2> balls;
    std::uint32_t pushes;
    std::uint32_t crates;
    friend bool operator==(const SmallScore&, const SmallScore&) = default;
};
template <class V> constexpr void describe(SmallScore& s, V&& v) {
    v("balls", s.balls), v("pushes", s.pushes), v("crates", s.crates);
}
struct SmallMark {
    std::uint32_t touched; ///< tick of the last jump
};
template <class V> constexpr void describe(SmallMark& m, V&& v) { v("touched", m.touched); }

template <class T> T must(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
}
inline void must(const Status& status) {
    if (!status) throw std::runtime_error(status.error().message);
}

class SmallGame : public Game {
  public:
    static constexpr std::uint64_t never = std::numeric_limits<std::uint64_t>::max();
    /// From tick `other_rules_from` on a jump is a little higher, under an unchanged content id: a planted fault.
    explicit SmallGame(std::uint64_t other_rules_from = never) : fault_tick(other_rules_from) {}

    std::string name() const override { return "small-game"; }
    std::uint64_t content_id() const override { return 0x5a11; }
    std::uint32_t player_count() const override { return 2; }
    std::uint32_t input_size() const override { return input_size_of<SmallInput>; }

    Result<World> start() const override {
        GameSchema schema;
        const auto score = schema.add_record<SmallScore>("small.score");
        schema.add_body_column<SmallMark>("small.mark");
        WorldDef def;
        def.bodies_max = def.shapes_max = 32;
        def.contacts_max = 256;
        def.fields_max = 4;
        World world = must(World::create(def, schema));
        const BodyId floor = must(world.create_body({.kind = BodyKind::static_}));
        must(world.create_shape(floor, {.geometry = plane()}));
        SmallScore s{};
        for (std::uint32_t p = 0; p < 2; ++p) {
            s.balls[p] = must(world.create_body({.pose = at(Real(p == 0 ? -3 : 3), 0.5_r, Real{})}));
            must(world.create_shape(s.balls[p], {.geometry = sphere(0.5_r), .density = 20_r}));
        }
        for (int i = 0; i < 3; ++i) add_crate(world, at(Real(i - 1), 0.5_r, 0.25_r));
        must(world.write(score, s));
        return world;
    }

    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        const Column<SmallScore> score{0};
        const Column<SmallMark> mark{1};
        SmallScore s = world.read(score);
        for (std::uint32_t p = 0; p < 2; ++p) {
            if (inputs[p].status == InputStatus::disconnected) continue;
            const SmallInput in = decode_input<SmallInput>(inputs[p]);
            const Vec3 push{Real(in.x) * 4_r, Real{}, Real(in.z) * 4_r};
            if (push != Vec3{}) must(world.add_force(s.balls[p], push));
            if (push != Vec3{}) ++s.pushes;
            if ((in.buttons & 1u) != 0) {
                const Real up = world.tick_count() >= fault_tick ? 40.001_r : 40_r;
                must(world.add_impulse(s.balls[p], {Real{}, up, Real{}}));
                must(world.write(mark, s.balls[p], {static_cast<std::uint32_t>(world.tick_count())}));
            }
            if ((in.buttons & 2u) != 0) throw_crate(world, s);
        }
        if (s != world.read(score)) must(world.write(score, s));
        world.tick();
        return {};
    }

    /// The inputs of two active players at a tick, equal on all machines.
    static std::array<SmallInput, 2> script(std::uint64_t tick) {
        std::array<SmallInput, 2> pads{};
        for (std::uint64_t p = 0; p < 2; ++p) {
            const std::uint64_t phase = tick / (11 + 6 * p) + 5 * p;
            pads[p].x = static_cast<std::int8_t>(static_cast<int>(phase * 29 % 21) - 10);
            pads[p].z = static_cast<std::int8_t>(static_cast<int>(phase * 17 % 15) - 7);
            if (tick % 37 == 10 + p) pads[p].buttons |= 1u;
            if (tick % 90 == 45 * p) pads[p].buttons |= 2u;
        }
        return pads;
    }

  private:
    static Transform at(Real x, Real y, Real z) { return {{x, y, z}, Quat::identity()}; }
    static BodyId add_crate(World& world, const Transform& pose) {
        const BodyId crate = must(world.create_body({.pose = pose}));
        must(world.create_shape(crate, {.geometry = box(0.5_r, 0.5_r, 0.5_r), .density = 10_r}));
        return crate;
    }
    /// Destroys the oldest thrown crate if there are too many.
    static void throw_crate(World& world, SmallScore& s) {
        constexpr std::uint32_t fixed_bodies = 6, crates_max = 4;
        if (world.body_count() >= fixed_bodies + crates_max) must(world.destroy(world.body_at(fixed_bodies)));
        add_crate(world, at(Real(static_cast<int>(s.crates % 5) - 2), 4_r,
                            Real(static_cast<int>(s.crates % 3) - 1)));
        ++s.crates;
    }
    std::uint64_t fault_tick;
};

/// Inputs of a tick, and the bytes to which they point.
struct SmallInputs {
    std::array<std::array<std::byte, 4>, 2> bytes;
    std::array<PlayerInput, 2> list;
    explicit SmallInputs(const std::array<SmallInput, 2>& pads) {
        for (std::size_t p = 0; p < 2; ++p) {
            bytes[p] = encode_input(pads[p]);
            list[p] = {bytes[p], InputStatus::confirmed};
        }
    }
    SmallInputs(const SmallInputs&) = delete;
    SmallInputs& operator=(const SmallInputs&) = delete;
};

} // namespace lockstone::test
