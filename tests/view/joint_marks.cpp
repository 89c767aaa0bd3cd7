// The viewer draws joints at their places: the tests measure the lines, by their colours.
#include "view/joint_marks.h"
#include "support/about.h"
#include "support/rigs/joint_variants.h"
#include "view/to_glm.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace lockstone;
using namespace lockstone::demo;
using namespace lockstone::test::scene;

namespace {

constexpr float near_enough = 1e-3f;

/// Two crates 1 m apart along x, joined in A's middle. The test sets the places at which they are drawn.
struct Pair {
    World world = made(World::create({}));
    BodyId body_a = add_crate(world, at(0, 5, 0)), body_b = add_crate(world, at(1, 5, 0));
    JointMark mark;
    glm::mat4 a = to_glm(world.pose(body_a)), b = to_glm(world.pose(body_b));

    explicit Pair(const JointDef& def)
        : mark(read_joint(world, made(world.create_joint(def, body_a, body_b, at(0, 5, 0))))) {}
    /// Replaces both frames of create_joint by the bodies' middles.
    Pair& from_middle_to_middle() {
        mark.frame_a = mark.frame_b = glm::mat4(1);
        return *this;
    }
    Frame lines() const {
        Frame frame;
        draw_line_joint(frame, mark, a, b);
        return frame;
    }
    Frame axes() const {
        Frame frame;
        draw_joint(frame, mark, a, b);
        return frame;
    }
    glm::vec3 middle() const { return glm::vec3(a[3]); }
};

std::vector<Line> coloured(const Frame& frame, const glm::vec3& colour) {
    std::vector<Line> found;
    for (const Line& line : frame.lines)
        if (line.colour == colour) found.push_back(line);
    return found;
}
float length(const std::vector<Line>& lines) {
    float sum = 0;
    for (const Line& line : lines) sum += glm::distance(line.from, line.to);
    return sum;
}
/// Returns whether each line begins at the end of the previous one.
bool is_one_line(const std::vector<Line>& lines) {
    for (std::size_t i = 1; i < lines.size(); ++i)
        if (glm::distance(lines[i].from, lines[i - 1].to) > near_enough) return false;
    return !lines.empty();
}

} // namespace

TEST_CASE("joint marks: draw_joint() draws every kind of joint with finite lines") {
    for (const JointVariant& variant : joint_variants()) {
        CAPTURE(std::string(variant.name));
        Pair pair(variant.def);
        pair.b[3] += glm::vec4(0.3f, 0, 0, 0);
        Frame frame = pair.lines();
        draw_joint(frame, pair.mark, pair.a, pair.b);
        CHECK_FALSE(frame.lines.empty());
        for (const Line& line : frame.lines)
            CHECK(std::isfinite(glm::length(line.from) + glm::length(line.to)));
    }
}

TEST_CASE("joint marks: a limited axis has an arc about it from limit to limit") {
    for (std::uint32_t i = about_x; i <= about_z; ++i) {
        CAPTURE(i);
        JointDef def = six_dof_joint();
        def.axis[i] = {.mode = AxisMode::limited, .lower = real(-0.5), .upper = real(1)};
        const Pair pair(def);
        const std::vector<Line> arc = coloured(pair.axes(), joint_colour::limit);
        CHECK(is_one_line(arc));
        CHECK(length(arc) == test::about(1.5f * joint_reach, 0.01));
        for (const Line& line : arc) {
            const glm::vec3 out = line.from - pair.middle();
            CHECK(glm::length(out) == test::about(joint_reach));
            CHECK(std::abs(out[static_cast<int>(i % 3)]) < near_enough);
        }
    }
}

TEST_CASE("joint marks: the hand of a limited axis turns with B between the ends of the arc") {
    JointDef def = hinge_joint();
    def.axis[about_x] = {.mode = AxisMode::limited, .lower = real(-0.5), .upper = real(1)};
    Pair pair(def);
    for (const float angle : {-0.5f, 0.0f, 1.0f}) {
        CAPTURE(angle);
        pair.b = to_glm(Transform{pair.world.pose(pair.body_b).position,
                                  from_axis_angle({unit_one, Unit{}, Unit{}}, real(angle))});
        const Frame frame = pair.axes();
        const std::vector<Line> hand = coloured(frame, joint_colour::hand),
                                arc = coloured(frame, joint_colour::limit);
        REQUIRE(hand.size() == 1);
        const glm::vec3 tip = pair.middle() + joint_reach * glm::vec3(0, std::cos(angle), std::sin(angle));
        CHECK(glm::distance(hand[0].to, tip) < near_enough);
        CHECK((glm::distance(arc.front().from, tip) < near_enough) == (angle == -0.5f));
        CHECK((glm::distance(arc.back().to, tip) < near_enough) == (angle == 1.0f));
    }
}

TEST_CASE("joint marks: locked axes that part show a line as long as their gap and free axes show none") {
    JointDef slider = slider_joint();
    for (const JointDef& def : {weld_joint(), hinge_joint(), slider}) {
        Pair pair(def);
        CHECK(length(coloured(pair.axes(), joint_colour::gap)) < near_enough);
        pair.b[3] += glm::vec4(0.3f, 0, 0, 0);
        const float along_x_gap = length(coloured(pair.axes(), joint_colour::gap));
        CHECK(along_x_gap == test::about(def.kind == JointKind::slider ? 0 : 0.3f));
        pair.b[3] += glm::vec4(0, 0.2f, 0, 0);
        CHECK(length(coloured(pair.axes(), joint_colour::gap)) > 0.19f);
    }
}

TEST_CASE("joint marks: a slider has a bar between its limits and its spring has a coil to B") {
    JointDef def = slider_joint();
    def.axis[along_x] = {.mode = AxisMode::limited,
                         .spring = 1,
                         .lower = real(-0.4),
                         .upper = real(1.2),
                         .frequency = real(2)};
    const Pair pair(def);
    const Frame frame = pair.axes();
    const std::vector<Line> bar = coloured(frame, joint_colour::limit),
                            coil = coloured(frame, joint_colour::spring);
    REQUIRE(bar.size() == 3);
    CHECK(glm::distance(bar[0].from, pair.middle() - glm::vec3(0.4f, 0, 0)) < near_enough);
    CHECK(glm::distance(bar[0].to, pair.middle() + glm::vec3(1.2f, 0, 0)) < near_enough);
    CHECK(is_one_line(coil));
    CHECK(glm::distance(coil.front().from, bar[0].to) < near_enough);
    CHECK(glm::distance(coil.back().to, pair.middle()) < near_enough);
}

TEST_CASE(
    "joint marks: rods and taut ropes are straight and slack ropes have their length and springs are coils") {
    const auto drawn = [](const JointDef& def) {
        Pair pair(def);
        const Frame frame = pair.from_middle_to_middle().lines();
        CHECK(is_one_line(frame.lines));
        CHECK(glm::distance(frame.lines.front().from, glm::vec3(pair.a[3])) < near_enough);
        CHECK(glm::distance(frame.lines.back().to, glm::vec3(pair.b[3])) < near_enough);
        return length(frame.lines);
    };
    CHECK(drawn(distance_joint(Real(1))) == test::about(1));
    CHECK(drawn(rope_joint(Real(1))) == test::about(1));
    CHECK(drawn(rope_joint(real(1.1))) == test::about(1.1, 0.01));
    // A parabola over 1 m that sags by 0.433 sqrt(1.5^2 - 1) is 1.4546 m long: a slack rope is drawn 3 % too short.
    CHECK(drawn(rope_joint(real(1.5))) == test::about(1.4546, 0.002));
    CHECK(drawn(spring_joint(Real(1), Real(2), Real(1))) > 2);
}

TEST_CASE("joint marks: wheels in gear touch and their radii have the gear ratio") {
    Pair pair(gear_joint(Real(3)));
    const std::vector<Line> circles = coloured(pair.axes(), joint_colour::gear);
    REQUIRE(circles.size() % 2 == 0);
    const float radius_a = glm::distance(circles.front().from, glm::vec3(pair.a[3])),
                radius_b = glm::distance(circles.back().to, glm::vec3(pair.b[3]));
    CHECK(radius_a + radius_b == test::about(1));
    CHECK(radius_b / radius_a == test::about(3));
}

TEST_CASE("joint marks: the pinion of a rack rolls on it without slipping") {
    const Pair pair(rack_and_pinion_joint(Real(4))); // 4 rad/m
    const std::vector<Line> lines = coloured(pair.axes(), joint_colour::gear);
    REQUIRE(lines.size() > 2);
    CHECK(glm::distance(lines.front().from, pair.middle()) == test::about(0.25f));
    const glm::vec3 teeth = lines.back().to - lines.back().from;
    CHECK(std::abs(teeth.x) == test::about(glm::length(teeth)));
}
