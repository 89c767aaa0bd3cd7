#include "cook/surface.h"
#include "corpus/corpus.h"
#include "law/zoo/object.h"
#include "support/sim_scenes.h"

#include <cstdio>

namespace lockstone::corpus {
namespace {

namespace scene = test::scene;
using cook::Point;
using cook::Soup;
using test::drawn;

constexpr std::size_t balls_max = 50;
constexpr int seconds = 10;
constexpr double gravity = 9.81;

std::string in_text(const char* format, double a, double b = 0) {
    char text[200];
    std::snprintf(text, sizeof text, format, a, b);
    return text;
}

Point point_of(Vec3 v) { return {to_double(v.x), to_double(v.y), to_double(v.z)}; }

struct Ball {
    BodyId body;
    Point at;
    Point before{}; ///< two seconds before the end
    bool has_passed = false;
};

/// Returns whether the way between two points passes through a triangle, from its front or from either side.
bool leads_through(const std::array<Point, 3>& corners, Point from, Point to, bool two_sided) {
    const auto& [a, b, c] = corners;
    const Point normal = cross(b - a, c - a), way = to - from;
    const double before = dot(normal, from - a), after = dot(normal, to - a);
    if ((before > 0) == (after > 0) || (before < 0 && !two_sided)) return false;
    const Point at = from + way * (before / (before - after));
    const double sides[3] = {dot(normal, cross(b - a, at - a)), dot(normal, cross(c - b, at - b)),
                             dot(normal, cross(a - c, at - c))};
    return sides[0] >= 0 && sides[1] >= 0 && sides[2] >= 0;
}

/// A mesh, a plane below it, and balls above it in layers.
class Heap {
  public:
    Heap(const cook::Cooked& mesh, bool is_two_sided, Planted fault)
        : two_sided(is_two_sided), planted(fault) {
        auto library = std::make_shared<AssetLibrary>();
        const Geometry geometry = library->geometry(library->add(encode_assets(mesh.assets)).value()).value();
        surface = cook::to_soup(triangulate(geometry, *library));
        box = cook::bounds_of(surface.vertices);
        if (planted == Planted::holes) thin_out(*library, surface);
        WorldDef def;
        def.bodies_max = def.shapes_max = 64;
        def.contacts_max = 1024;
        if (planted == Planted::restless) def.sleeping = 0;
        const Geometry ground = planted == Planted::holes ? library->geometry(holed).value() : geometry;
        world.emplace(scene::made(World::create(def, {}, library)));
        scene::add(*world, {.kind = BodyKind::static_}, {.geometry = ground, .friction = 0.8_r});
        const double below = box.lower.y - 0.2 * box.largest();
        scene::add(*world, {.kind = BodyKind::static_, .pose = scene::at(0, below, 0)},
                   {.geometry = plane(), .friction = 0.8_r});
        radius = std::max(0.006, 0.03 * box.largest());
        add_balls();
    }

    void run(Row& row) {
        const cook::Surface near(surface);
        const double start = energy();
        double most = start;
        for (int tick = 1; tick <= seconds * 60; ++tick) {
            if (planted == Planted::lifted && tick == 60) lift();
            world->tick();
            most = std::max(most, energy());
            for (Ball& ball : balls) move(ball, near);
            if (tick == (seconds - 2) * 60)
                for (Ball& ball : balls) ball.before = ball.at;
            if (!any_awake()) {
                row.balls_asleep_at = tick / 60.0;
                break;
            }
            row.balls_asleep_at = -1;
        }
        row.balls = balls.size();
        for (const Ball& ball : balls) row.passed += ball.has_passed ? 1u : 0u;
        if (row.passed > 0)
            row.findings.push_back(
                in_text("mesh: %.0f of %.0f balls fall through", double(row.passed), double(row.balls)));
        if (row.balls_asleep_at < 0) add_awake(row);
        const double rise = (most - start) / (gravity * double(balls.size()));
        if (rise > 0.002 + 0.002 * box.largest())
            row.findings.push_back(
                in_text("mesh: the energy of the balls rises by that of %.4g m of height", rise));
    }

  private:
    void thin_out(AssetLibrary& library, const Soup& all) {
        std::vector<Vec3> vertices;
        for (const Point& p : all.vertices) vertices.push_back(scene::vec(p.x, p.y, p.z));
        std::vector<cook::Indices> triangles;
        for (std::size_t i = 0; i < all.triangles.size(); i += 2) triangles.push_back(all.triangles[i]);
        holed =
            library.add(bake_mesh({.vertices = vertices, .triangles = triangles, .two_sided = true})).value();
    }
    void add_balls() {
        test::SplitMix random(1);
        double layer = box.upper.y + 2 * radius;
        for (int tried = 1; balls.size() < balls_max; ++tried) {
            if (tried % 20 == 0) layer += 2.5 * radius;
            const Point at{drawn(random, box.lower.x, box.upper.x), layer,
                           drawn(random, box.lower.z, box.upper.z)};
            if (std::any_of(balls.begin(), balls.end(),
                            [&](const Ball& b) { return cook::length(b.at - at) < 2.2 * radius; }))
                continue;
            BodyDef def{.pose = scene::at(at.x, at.y, at.z)};
            def.mass = Real(1);
            const ShapeDef shape{.geometry = sphere(scene::real(radius)),
                                 .friction = 0.8_r,
                                 .rolling_resistance = scene::real(0.2 * radius)};
            balls.push_back({scene::add(*world, def, shape), at});
        }
    }
    /// The energy of all balls, each of 1 kg [J]. Semi-implicit Euler with steps of a length h conserves v^2 / 2 + g y
    /// - g h v_y / 2 while a body falls.
    double energy() const {
        const double step = 1.0 / (world->def().tick_rate * world->def().substeps);
        double sum = 0;
        for (const Ball& ball : balls) {
            const Point v = point_of(world->linear_velocity(ball.body)),
                        w = point_of(world->angular_velocity(ball.body));
            const double height = to_double(world->center_of_mass(ball.body).y);
            sum +=
                gravity * (height - 0.5 * step * v.y) + 0.5 * dot(v, v) + 0.2 * radius * radius * dot(w, w);
        }
        return sum;
    }
    void move(Ball& ball, const cook::Surface& near) const {
        const Point to = point_of(world->center_of_mass(ball.body));
        const double way = cook::length(to - ball.at);
        if (way > 0 && near.distance(ball.at) <= way)
            for (std::size_t i = 0; i < surface.triangles.size(); ++i)
                ball.has_passed =
                    ball.has_passed || leads_through(surface.corners(i), ball.at, to, two_sided);
        ball.at = to;
    }
    void lift() {
        for (const Ball& ball : balls) scene::done(world->add_impulse(ball.body, scene::vec(0, 20, 0)));
    }
    bool any_awake() const { return awake() > 0; }
    double awake() const {
        double count = 0;
        for (const Ball& ball : balls) count += world->is_awake(ball.body) ? 1 : 0;
        return count;
    }
    void add_awake(Row& row) const {
        double still = 0, moving = 0;
        for (const Ball& ball : balls)
            if (world->is_awake(ball.body))
                ++(cook::length(ball.at - ball.before) < 0.2 * radius ? still : moving);
        if (still > 0)
            row.findings.push_back(
                in_text("mesh: %.0f balls are awake after 10 s and stay where they are", still));
        if (moving > 0)
            row.findings.push_back(in_text("mesh: %.0f balls are awake after 10 s and move", moving));
    }

    bool two_sided;
    Planted planted;
    Soup surface;
    cook::Box box;
    AssetId holed{};
    double radius = 0;
    std::optional<World> world;
    std::vector<Ball> balls;
};

} // namespace

void drop_balls(Row& row, const Soup& model, cook::CookOptions options, Planted planted) {
    options.as = cook::Wanted::mesh;
    const Result<cook::Cooked> mesh = cook::cook(model, options);
    if (!mesh) {
        row.findings.push_back("mesh: with the flags of its notes: " + mesh.error().message);
        return;
    }
    Heap(*mesh, options.two_sided, planted).run(row);
}

void drop_hull(Row& row, const cook::Cooked& hull, Planted planted) {
    zoo::Object object = zoo::object_of(hull.assets.back(), row.model);
    if (planted == Planted::sunk)
        for (auto& corner : object.corners)
            for (double& c : corner) c *= 1 + 0.02 / object.thickness;
    std::uint64_t seed = 1;
    for (const zoo::Floor floor : {zoo::Floor::plane, zoo::Floor::box, zoo::Floor::mesh}) {
        const zoo::Drop drop = zoo::drop_of(object, floor, seed++);
        const zoo::Outcome out = zoo::play(drop);
        const auto add = [&](const std::string& fault) {
            if (!fault.empty())
                row.findings.push_back("hull on a " + std::string(zoo::name_of(floor)) + ": " + fault);
        };
        add(zoo::energy_fault(drop, out));
        add(zoo::rest_fault(drop, out));
        if (out.asleep_at >= 0) row.deepest = std::max(row.deepest, -out.lowest_at_end);
        if (row.hull_asleep_at >= 0)
            row.hull_asleep_at = out.asleep_at < 0 ? -1 : std::max(row.hull_asleep_at, out.asleep_at);
    }
}

} // namespace lockstone::corpus
