// Vehicles keep the contract: a world that is saved and restored at any tick, in any way, goes on to the same bits.
#include "lockstone/testing.h"
#include "support/rigs/vehicle_rig.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::vehicle;

namespace {

Result<AssetBytes> bake_hills() {
    std::vector<Length> heights;
    for (int row = 0; row < 41; ++row)
        for (int column = 0; column < 41; ++column)
            heights.push_back(quantize<Length>(0.6 * std::sin(row * 0.5) * std::cos(column * 0.4)));
    return bake_height_field({.columns = 41, .rows = 41, .spacing = to<Length>(2_r), .heights = heights});
}

/// Two cars and a tank on hills, with crates in their way.
World start() {
    AssetLibrary library;
    const AssetId hills = made(library.add(made(bake_hills())));
    const Geometry ground = made(library.geometry(hills));
    World w = made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    add(w, {.kind = BodyKind::static_, .pose = at(-40, 0, -40)}, {.geometry = ground});
    for (int i = 0; i < 6; ++i) add_crate(w, at(-3 + 1.2 * i, 1.5, 6), 0.4);
    for (int i = 0; i < 2; ++i) {
        const BodyId body =
            add(w, {.pose = at(-3 + 6 * i, 2, 0), .mass = 1200_r}, {.geometry = box(0.8_r, 0.3_r, 2_r)});
        VehicleDef def = four_wheels(body, {0.75_r, -0.3_r, 1.4_r});
        def.cast = i == 0 ? WheelCast::sphere : WheelCast::ray;
        def.anti_roll[0] = {0, 1, 10000_r};
        def.differential[0] = {DifferentialKind::limited, 4, 8, 0, 100_r, 0.5_r};
        def.steer_speed = 3_r;
        made(w.create_vehicle(def));
    }
    const BodyId body =
        add(w, {.pose = at(0, 2.5, -8), .mass = 20000_r}, {.geometry = box(1.4_r, 0.5_r, 2.8_r)});
    made(w.create_vehicle(two_tracks(body, {1.5_r, -0.5_r, 2.4_r}, 3)));
    return w;
}

void step(World& w) {
    const std::uint64_t t = w.tick_count();
    if (t % 20 == 0)
        for (std::uint32_t row = 0; row < w.vehicle_count(); ++row) {
            const std::uint64_t k = (t / 20 * 7 + row * 3) % 11;
            VehicleInput input;
            input.throttle = k < 8 ? 1_r : 0_r;
            input.brake = k == 9 ? 1_r : 0_r;
            input.hand_brake = k == 8 ? 1_r : 0_r;
            input.steer = Real(static_cast<std::int64_t>(k) - 5) / 5_r;
            input.gear = k == 4 ? -1 : 1;
            done(w.set_vehicle_input(w.vehicle_at(row), input));
        }
    w.tick();
}

int run_length() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 900 : 240; }

struct Run {
    std::vector<Image> images;
    std::vector<std::uint64_t> hashes;
};
Run straight_run(int ticks) {
    World w = start();
    Run run;
    for (int t = 0; t < ticks; ++t) {
        w.save(run.images.emplace_back());
        run.hashes.push_back(w.hash());
        step(w);
    }
    return run;
}

/// The first tick at which a run from image `from` is another, or -1.
int departs(const Run& run, World& w, std::size_t from, std::size_t ticks) {
    for (std::size_t t = from; t < std::min(run.hashes.size(), from + ticks); ++t) {
        if (w.hash() != run.hashes[t]) return static_cast<int>(t);
        step(w);
    }
    return -1;
}

} // namespace

TEST_CASE("vehicles survive a rollback at every tick") {
    const Run run = straight_run(run_length());
    World w = start();
    for (std::size_t i = 0; i < run.images.size(); ++i) {
        const std::size_t t = i % 2 == 0 ? i : run.images.size() - 1 - i;
        w.restore(run.images[t]);
        REQUIRE(departs(run, w, t, 8) == -1);
    }
}

TEST_CASE("vehicles survive being moved to another world, as a clone and as a portable image") {
    const Run run = straight_run(run_length());
    World w = start();
    for (std::size_t t = 0; t < run.images.size(); t += 10) {
        w.restore(run.images[t]);
        World copy = w.clone();
        REQUIRE(departs(run, copy, t, 12) == -1);
        World fresh = start();
        done(fresh.restore_portable(w.save_portable()));
        REQUIRE(departs(run, fresh, t, 12) == -1);
    }
}

TEST_CASE(
    "a vehicle that lost a wheel's memory goes another way") { // planted: what the tests above would see
    const Run run = straight_run(72);
    World w = start(), straight = start();
    w.restore(run.images[60]);
    straight.restore(run.images[60]);
    State& state = testing::state_of(w);
    for (std::uint32_t i = 0; i < state.layout().columns().size(); ++i) {
        const ColumnInfo& column = state.layout().columns()[i];
        if (column.name != "vehicle.memory") continue;
        const std::span<std::byte> row = state.edit_bytes(i, 0, 1);
        for (const LeafInfo& leaf : column.leaves)
            if (leaf.name == "wheel[0].spin") std::fill_n(row.begin() + leaf.offset, leaf.size, std::byte{});
    }
    REQUIRE(same_motion(w, straight));
    step(w), step(straight);
    CHECK_FALSE(same_motion(w, straight));
}
