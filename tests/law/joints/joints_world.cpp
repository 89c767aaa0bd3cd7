// Joints as objects of a world: refusals, lists, destruction with their bodies, joints between sleeping or touching
// bodies.
#include "support/about.h"
#include "support/refusal.h"
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

JointDef between(BodyId a, BodyId b, JointDef def = ball_joint()) {
    def.body_a = a, def.body_b = b;
    return def;
}
template <class Change> JointDef changed(BodyId a, BodyId b, Change&& change) {
    JointDef def = between(a, b);
    change(def);
    return def;
}

int touching(const World& w, BodyId a, BodyId b) {
    int count = 0;
    for (const World::ContactPoint& p : w.contacts()) {
        const BodyId x = w.body_of(p.shape_a), y = w.body_of(p.shape_b);
        count += (x == a && y == b) || (x == b && y == a);
    }
    return count;
}

} // namespace

TEST_CASE("the world rejects an invalid joint with a sentence that names the field") {
    World w = bare_world();
    const BodyId a = add_crate(w, at(-1, 0, 0)), b = add_crate(w, at(1, 0, 0)),
                 gone = add_crate(w, at(5, 0, 0));
    done(w.destroy(gone));
    const auto refused = [&](const JointDef& def, const std::string& words) {
        CHECK(refusal_fault(w, CreateJoint{def}, words) == "");
    };
    refused(between(a, {}), "body_b");
    refused(between(a, gone), "is not alive");
    refused(between(gone, b), "body_a");
    refused(between(a, a), "the same body");
    for (JointKind kind : {JointKind::pulley, JointKind::gear, JointKind::rack_and_pinion})
        refused(between({}, b, plain_joint(kind)), "needs a body_a");
    refused(changed(a, b, [](JointDef& d) { d.axis[3].lower = Real(1); }), "axis[3].lower is 1");
    refused(changed(a, b, [](JointDef& d) { d.axis[4].upper = Real(4); }), "axis[4].upper");
    refused(changed(a, b, [](JointDef& d) { d.ratio = Real(0); }), "ratio is 0");
    const JointId joint = made(w.create_joint(between(a, b)));
    CHECK(refusal_fault(w, SetJointAxis{joint, 6, 0, {}}, "index is 6") == "");
    CHECK(refusal_fault(w, SetJointAxis{{9, 1}, 0, 0, {}}, "is not alive") == "");
    CHECK(refusal_fault(w, SetJointFrames{{9, 1}, Transform::identity(), Transform::identity()},
                        "is not alive") == "");
    CHECK(refusal_fault(w, DestroyJoint{{}}, "is not alive") == "");
    CHECK(refusal_fault(w, SetJointAxis{joint, 0, 0, {.lower = Real(1)}}, "lower is 1") == "");
    CHECK(refusal_fault(w, CreateJoint{between(a, b)}, "") ==
          "create_joint was accepted"); // planted: a valid one
}

TEST_CASE("after random creation and destruction of joints and bodies every list holds exactly its joints") {
    World w = bare_world();
    Random random = Random::seeded(5);
    std::vector<BodyId> bodies;
    std::vector<std::pair<JointId, JointDef>> joints;
    for (int i = 0; i < 600; ++i) {
        const std::uint32_t what = random.below(8);
        if (what == 0 && bodies.size() < 12) bodies.push_back(add_ball(w, at(3 * i, 0, 0)));
        if (what == 1 && bodies.size() > 3) {
            const std::size_t k = random.below(static_cast<std::uint32_t>(bodies.size()));
            done(w.destroy(bodies[k]));
            std::erase_if(joints, [&](const auto& j) {
                const bool is_gone = j.second.body_a == bodies[k] || j.second.body_b == bodies[k];
                CHECK(w.is_alive(j.first) != is_gone);
                return is_gone;
            });
            bodies.erase(bodies.begin() + static_cast<std::ptrdiff_t>(k));
        }
        if (what >= 2 && what < 6 && bodies.size() > 1 && joints.size() < 16) {
            const auto n = static_cast<std::uint32_t>(bodies.size());
            const std::uint32_t a = random.below(n), b = random.below(n);
            if (a == b) continue;
            const JointDef def = between(what == 2 ? BodyId{} : bodies[a], bodies[b]);
            joints.emplace_back(made(w.create_joint(def)), def);
        }
        if (what == 6 && !joints.empty()) {
            const std::size_t k = random.below(static_cast<std::uint32_t>(joints.size()));
            done(w.destroy(joints[k].first));
            joints.erase(joints.begin() + static_cast<std::ptrdiff_t>(k));
        }
        REQUIRE(w.joint_count() == joints.size());
        for (BodyId body : bodies) {
            std::vector<JointId> expected;
            for (const auto& [id, def] : joints)
                if (def.body_a == body || def.body_b == body) expected.insert(expected.begin(), id);
            REQUIRE((w.joints(body) == expected));
        }
    }
}

TEST_CASE(
    "jointed bodies touch each other only if collide_connected is set or after their joint is destroyed") {
    for (std::uint32_t collide : {0u, 1u}) {
        World w = bare_world();
        const BodyId a = add_crate(w, at(0, 0, 0)), b = add_crate(w, at(0.8, 0, 0)); // 0.2 m of overlap
        JointDef def = weld_joint();
        def.collide_connected = collide;
        const JointId joint = made(w.create_joint(def, a, b, at(0.4, 0, 0)));
        w.tick();
        CHECK((touching(w, a, b) > 0) == (collide == 1));
        done(w.destroy(joint));
        w.tick(), w.tick();
        CHECK(touching(w, a, b) > 0);
    }
}

TEST_CASE("set_joint_frames() moves the frames of a joint and a weld to the world follows") {
    World w = heavy_world();
    const BodyId b = add_crate(w, at(0, 0, 0));
    const JointId joint = made(w.create_joint(weld_joint(Real(3)), {}, b, at(0, 0, 0)));
    done(w.set_joint_frames(joint, at(2, 1, 0), Transform::identity()));
    for (int t = 0; t < 240; ++t) w.tick();
    CHECK(position(w, b)[0] == test::about(2, 0.01));
    CHECK(position(w, b)[1] == test::about(1, 0.05)); // it gives way a little
    CHECK((w.joint(joint).frame_a == at(2, 1, 0)));
}

// ---- sleep ----------------------------------------------------------------------------------------------------

namespace {

struct Chain {
    World world;
    std::vector<BodyId> bodies;
};
/// Crates side by side on a floor, each joined to the next one half way between them.
Chain chain_on_floor(int count, bool joined) {
    WorldDef def = small_def();
    def.sleeping = 1;
    Chain c{made(World::create(def)), {}};
    add_floor(c.world);
    for (int i = 0; i < count; ++i) {
        c.bodies.push_back(add_crate(c.world, at(1.5 * i, 0.5, 0)));
        if (joined && i > 0)
            made(c.world.create_joint(ball_joint(), c.bodies[static_cast<std::size_t>(i) - 1],
                                      c.bodies.back(), at(1.5 * i - 0.75, 0.5, 0)));
    }
    return c;
}

} // namespace

TEST_CASE("jointed bodies fall asleep in the same tick and wake together") {
    for (bool joined : {true, false}) {
        Chain c = chain_on_floor(5, joined);
        for (int t = 0; t < 20; ++t) c.world.tick();
        done(c.world.add_impulse(c.bodies[4],
                                 vec(0, 0, 200))); // moves the last one; joints keep the others awake
        int first = -1, last = -1;
        for (int t = 20; t < 300 && last < 0; ++t) {
            c.world.tick();
            const auto asleep =
                std::ranges::count_if(c.bodies, [&](BodyId b) { return !c.world.is_awake(b); });
            if (asleep > 0 && first < 0) first = t;
            if (asleep == 5) last = t;
        }
        REQUIRE(last > 0);
        CHECK((first == last) == joined);
        done(c.world.add_impulse(c.bodies[0], vec(0, 0, 500)));
        for (BodyId b : c.bodies) CHECK(c.world.is_awake(b) == (joined || b == c.bodies[0]));
    }
}

TEST_CASE("a hanging weight sleeps and any change of its joint or its holder wakes it") {
    for (int how = 0; how < 4; ++how) {
        WorldDef def = bare_def();
        def.sleeping = 1, def.gravity = vec(0, -9.81, 0);
        World w = made(World::create(def));
        const BodyId holder =
            add(w, {.kind = BodyKind::static_}, {.geometry = box(Real(1), real(0.1), Real(1))});
        const BodyId b = add_crate(w, at(0, -1, 0));
        const JointId joint = made(w.create_joint(ball_joint(), holder, b, at(0, 0, 0)));
        for (int t = 0; t < 120; ++t) w.tick();
        REQUIRE(!w.is_awake(b));
        if (how == 0) done(w.destroy(joint));
        if (how == 1) done(w.set_joint_frames(joint, at(0, 0.5, 0), at(0, 1, 0)));
        if (how == 2) done(w.set_pose(holder, at(0.5, 0, 0)));
        if (how == 3) done(w.destroy(holder));
        CHECK(w.is_awake(b));
        const D3 before = position(w, b);
        for (int t = 0; t < 20; ++t) w.tick();
        INFO("how ", how);
        CHECK(length(position(w, b) - before) > 0.05);
    }
}
