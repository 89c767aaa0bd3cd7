// Every kind of joint alone, and what kinds are also used for: rolled back at every tick, before and after it breaks; and
// what a joint remembers matters in the tick after.
#include "lockstone/testing.h"
#include "support/rigs/joint_variants.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr int run_length = 40;

/// The joint with everything on its free axes that an axis can have; slow springs are made quick and slack ropes short.
JointDef driven(JointDef def) {
    for (std::uint32_t i = 0; i < joint_axis_count; ++i) {
        JointAxis& axis = def.axis[i];
        if (axis.frequency > Real{}) axis.frequency = Real(3);
        if (axis.mode == AxisMode::free && i % 2 == 0)
            axis.motor_speed = Real(1), axis.motor_force = Real(300);
        if (axis.mode == AxisMode::free && i % 2 == 1) axis.friction = Real(200);
    }
    if (def.axis[along_x].mode == AxisMode::limited) def.axis[along_x].upper -= real(0.95);
    return def;
}
Jointed start(const JointVariant& v, double break_force, double break_torque) {
    JointDef def = driven(v.def);
    def.break_force = real(break_force), def.break_torque = real(break_torque);
    return join_two(def.kind, def, turned(axis_y, 20));
}
/// Loads that depend on the tick alone and keep ropes taut, and now and then another motor speed.
void step(Jointed& j) {
    const std::uint64_t tick = j.world.tick_count();
    Loads loads = loads_of(100 + tick, 8000, 3000);
    loads.apply(j.world, j.a), loads.apply(j.world, j.b);
    done(j.world.add_force(j.a, vec(-5000, -5000, 0)));
    done(j.world.add_force(j.b, vec(5000, -5000, 0)));
    if (tick % 13 == 7 && j.world.is_alive(j.joint)) {
        JointAxis axis = j.world.joint(j.joint).axis[about_x];
        axis.motor_speed = -axis.motor_speed;
        done(j.world.set_joint_axis(j.joint, about_x, axis));
    }
    j.world.tick();
}

struct Run {
    std::vector<Image> images;
    std::vector<std::uint64_t> hashes;
    std::vector<char> broke; ///< in the tick before
    double force, torque;    ///< most
};
bool broke(const World& w) {
    return std::ranges::any_of(w.events(), [](const Event& e) { return e.kind == EventKind::joint_break; });
}
Run run_of(Jointed& j) {
    Run run{};
    for (int t = 0; t <= run_length; ++t) {
        j.world.save(run.images.emplace_back());
        run.hashes.push_back(j.world.hash());
        run.broke.push_back(t > 0 && broke(j.world) ? 1 : 0);
        if (j.world.is_alive(j.joint)) {
            const JointState s = j.world.joint_state(j.joint);
            run.force = std::max(run.force, length(to_double(s.force)));
            run.torque = std::max(run.torque, length(to_double(s.torque)));
        }
        if (t < run_length) step(j);
    }
    return run;
}

void forget(World& w) {
    State& s = testing::state_of(w);
    const ColumnInfo* info = s.layout().find_column("joint.memory");
    REQUIRE(info != nullptr);
    std::ranges::fill(s.edit_bytes(static_cast<std::uint32_t>(info - s.layout().columns().data())),
                      std::byte{});
}

/// Rolled back to every tick, the last first, and played on for eight.
std::string rollback_fault(Jointed& j, const Run& run) {
    for (std::size_t from = run.images.size() - 1; from-- > 0;) {
        j.world.restore(run.images[from]);
        for (std::size_t t = from + 1; t < std::min(from + 9, run.images.size()); ++t) {
            step(j);
            const std::string where = "from tick " + std::to_string(from) + ", at " + std::to_string(t);
            if (broke(j.world) != (run.broke[t] != 0))
                return where + ": broken in one run, whole in the other";
            if (j.world.hash() != run.hashes[t]) return where + ": another hash";
        }
    }
    return {};
}

/// In how many ticks B ends elsewhere if the joint begins them without its memory.
int ticks_that_remember(Jointed& j, const Run& run) {
    const auto place_after = [&](const Image& image, bool without) {
        j.world.restore(image);
        if (without) forget(j.world);
        step(j);
        return j.world.pose(j.b);
    };
    return static_cast<int>(std::ranges::count_if(
        run.images, [&](const Image& i) { return place_after(i, true) != place_after(i, false); }));
}

} // namespace

TEST_CASE("every kind of joint, rolled back to any tick, goes on to the same hashes") {
    for (const JointVariant& v : joint_variants()) {
        Jointed j = start(v, 0, 0);
        const Run run = run_of(j);
        INFO(std::string(v.name));
        CHECK(rollback_fault(j, run) == "");
        CHECK(ticks_that_remember(j, run) > 0); // planted: a rollback that forgets it
    }
}

TEST_CASE("every kind of joint that breaks after a rollback breaks in the tick in which it broke before") {
    for (const JointVariant& v : joint_variants()) {
        Jointed whole = start(v, 0, 0);
        const Run straight = run_of(whole);
        INFO(std::string(v.name));
        REQUIRE(std::max(straight.force, straight.torque) > 0);
        Jointed j = start(v, 0.95 * straight.force, 0.95 * straight.torque);
        Run run = run_of(j);
        REQUIRE(std::ranges::count(run.broke, 1) == 1);
        CHECK(!j.world.is_alive(j.joint));
        CHECK(rollback_fault(j, run) == "");
        j.world.restore(run.images[0]);
        CHECK(j.world.is_alive(j.joint));
        std::ranges::rotate(run.broke,
                            run.broke.end() - 1); // planted: it is said to have broken a tick later
        CHECK(rollback_fault(j, run).find("broken in one run") != std::string::npos);
    }
}
