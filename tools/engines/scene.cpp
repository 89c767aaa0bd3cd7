#include "engines/scene.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>

namespace engines {

namespace {

/// Sums over the tetrahedra between the origin and the triangles of a hull's faces.
struct Sums {
    double volume = 0;
    V3 first{};  ///< integral of x, y, z
    V3 second{}; ///< integral of x^2, y^2, z^2
    V3 mixed{};  ///< integral of yz, zx, xy
};

Sums sums_of(const Shape& hull) {
    Sums s;
    for (const std::vector<int>& face : hull.faces)
        for (std::size_t i = 1; i + 1 < face.size(); ++i) {
            const V3 a = hull.points[static_cast<std::size_t>(face[0])];
            const V3 b = hull.points[static_cast<std::size_t>(face[i])];
            const V3 c = hull.points[static_cast<std::size_t>(face[i + 1])];
            const double v = dot(a, cross(b, c)) / 6;
            s.volume += v;
            s.first += (a + b + c) * (v / 4);
            const auto square = [v](double p, double q, double r) {
                return v / 10 * (p * p + q * q + r * r + p * q + q * r + r * p);
            };
            s.second += V3{square(a.x, b.x, c.x), square(a.y, b.y, c.y), square(a.z, b.z, c.z)};
            const V3 sum = a + b + c;
            const auto mixed = [&](double V3::*p, double V3::*q) {
                const double own = a.*p * a.*q + b.*p * b.*q + c.*p * c.*q;
                return v / 20 * (own + sum.*p * sum.*q);
            };
            s.mixed += V3{mixed(&V3::y, &V3::z), mixed(&V3::z, &V3::x), mixed(&V3::x, &V3::y)};
        }
    return s;
}

/// Turns the points about the origin so that the largest product of inertia vanishes.
/// source: Jacobi, 1846, one rotation of his method for eigenvalues
void rotate_once(Shape& hull, const Sums& s) {
    struct Pair {
        /// The two axes of the rotation's plane, and their product of inertia.
        double V3::*p, V3::*q, V3::*mixed;
    };
    constexpr Pair pairs[] = {{&V3::y, &V3::z, &V3::x}, {&V3::z, &V3::x, &V3::y}, {&V3::x, &V3::y, &V3::z}};
    const Pair& most =
        *std::ranges::max_element(pairs, {}, [&](const Pair& pair) { return std::abs(s.mixed.*pair.mixed); });
    const double angle = std::atan2(2 * s.mixed.*most.mixed, s.second.*most.p - s.second.*most.q) / 2;
    for (V3& point : hull.points) {
        const double p = point.*most.p, q = point.*most.q;
        point.*most.p = std::cos(angle) * p + std::sin(angle) * q;
        point.*most.q = std::cos(angle) * q - std::sin(angle) * p;
    }
}

/// The faces of a hull: the triangles that have all points on one side. The quadratic search is fast enough for so few
/// points.
std::vector<std::vector<int>> faces_of(const std::vector<V3>& points) {
    std::vector<std::vector<int>> faces;
    const int count = static_cast<int>(points.size());
    const auto at = [&](int i) { return points[static_cast<std::size_t>(i)]; };
    for (int i = 0; i < count; ++i)
        for (int j = i + 1; j < count; ++j)
            for (int k = j + 1; k < count; ++k) {
                const V3 n = cross(at(j) - at(i), at(k) - at(i));
                int above = 0, below = 0;
                for (int p = 0; p < count; ++p)
                    if (p != i && p != j && p != k) (dot(n, at(p) - at(i)) > 0 ? above : below) += 1;
                if (above == 0 || below == 0) faces.push_back({i, j, k});
            }
    return faces;
}

Solid capsule_of(double r, double h) { // a cylinder of half height h and two hemispheres
    const double cylinder = pi * r * r * 2 * h, ball = 4.0 / 3 * pi * r * r * r, volume = cylinder + ball;
    const double along = (cylinder * r * r / 2 + ball * 0.4 * r * r) / volume;
    const double across =
        (cylinder * (r * r / 4 + h * h / 3) + ball * (0.4 * r * r + h * h + 0.75 * h * r)) / volume;
    return {volume, {across, along, across}};
}

double seconds_of(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

} // namespace

Solid solid_of(const Shape& shape) {
    const V3 h = shape.half;
    switch (shape.kind) {
    case Kind::sphere:
        return {4.0 / 3 * pi * h.x * h.x * h.x, V3{0.4, 0.4, 0.4} * (h.x * h.x)};
    case Kind::box:
        return {8 * h.x * h.y * h.z,
                V3{h.y * h.y + h.z * h.z, h.x * h.x + h.z * h.z, h.x * h.x + h.y * h.y} / 3};
    case Kind::capsule:
        return capsule_of(h.x, h.y);
    case Kind::cylinder: {
        const double across = h.x * h.x / 4 + h.y * h.y / 3;
        return {pi * h.x * h.x * 2 * h.y, {across, h.x * h.x / 2, across}};
    }
    case Kind::hull: {
        const Sums s = sums_of(shape);
        const V3 q = s.second / s.volume;
        return {s.volume, {q.y + q.z, q.x + q.z, q.x + q.y}};
    }
    case Kind::plane:
    case Kind::mesh:
        break;
    }
    return {0, {}};
}

Solid solid_of(const Body& body) {
    const Solid first = solid_of(body.shape);
    double volume = first.volume;
    V3 sum = first.inertia * first.volume;
    for (const Part& part : body.parts) {
        const Solid solid = solid_of(part.shape);
        const V3 i = solid.inertia, p = part.position;
        const V3 x = rotate(part.rotation, {1, 0, 0}), y = rotate(part.rotation, {0, 1, 0}),
                 z = rotate(part.rotation, {0, 0, 1});
        const V3 turned{i.x * x.x * x.x + i.y * y.x * y.x + i.z * z.x * z.x,
                        i.x * x.y * x.y + i.y * y.y * y.y + i.z * z.y * z.y,
                        i.x * x.z * x.z + i.y * y.z * y.z + i.z * z.z * z.z};
        const V3 shifted{p.y * p.y + p.z * p.z, p.x * p.x + p.z * p.z, p.x * p.x + p.y * p.y};
        volume += solid.volume;
        sum += (turned + shifted) * solid.volume;
    }
    return volume == 0 ? first : Solid{volume, sum / volume};
}

V3 center_hull(Shape& hull) {
    V3 middle{};
    for (V3 p : hull.points) middle += p / static_cast<double>(hull.points.size());
    const auto at = [&](int i) { return hull.points[static_cast<std::size_t>(i)]; };
    for (std::vector<int>& face : hull.faces)
        if (dot(cross(at(face[1]) - at(face[0]), at(face[2]) - at(face[0])), at(face[0]) - middle) < 0)
            std::ranges::reverse(face);
    const Sums s = sums_of(hull);
    const V3 center = s.first / s.volume;
    for (V3& p : hull.points) p = p - center;
    return center;
}

Shape hull_of_points(std::vector<V3> points) {
    Shape hull{.kind = Kind::hull, .points = std::move(points)};
    hull.faces = faces_of(hull.points);
    center_hull(hull);
    for (int turn = 0; turn < 16; ++turn) rotate_once(hull, sums_of(hull));
    return hull;
}

Body solid(Shape shape, V3 position, double density, double friction) {
    const double mass = density * solid_of(shape).volume;
    return {.shape = std::move(shape), .position = position, .mass = mass, .friction = friction};
}

namespace {
[[noreturn]] void cannot(const char* what) {
    std::fprintf(stderr, "engines: this engine cannot %s\n", what);
    std::exit(2);
}
} // namespace

void Engine::walk(int, V3) { cannot("walk"); }
void Engine::drive(int, double, double) { cannot("drive"); }
int Engine::add(const Body&) { cannot("add a body"); }
void Engine::replace(int, const Body&) { cannot("replace a body"); }
double Engine::cast_ray(V3, V3) const { cannot("cast a ray"); }
double Engine::cast(int, V3, V3) const { cannot("cast a shape"); }
int Engine::overlap(int, V3) const { cannot("tell overlaps"); }

void Engine::advance(int ticks) {
    const clockid_t clock = by_wall ? CLOCK_MONOTONIC : CLOCK_THREAD_CPUTIME_ID;
    const double start = seconds_of(clock);
    for (int i = 0; i < ticks; ++i) tick();
    seconds += seconds_of(clock) - start;
    ticks_done += ticks;
}

std::vector<Contestant> contestants() {
    return {{.name = "Lockstone", .product = Product::lockstone},
            {.name = "Bullet", .product = Product::bullet},
            {.name = "ODE", .product = Product::ode},
            {.name = "Bullet 8x2", .product = Product::bullet, .substeps = 8, .iterations = 2},
            {.name = "ODE 8x2", .product = Product::ode, .substeps = 8, .iterations = 2},
            {.name = "LS 16", .product = Product::lockstone, .substeps = 16, .contact_hertz = 120}};
}

#ifdef LOCKSTONE_BULLET
constexpr bool has_bullet = true;
#else
constexpr bool has_bullet = false;
std::unique_ptr<Engine> make_bullet(const Contestant&, const Scene&) { return nullptr; }
#endif
#ifdef LOCKSTONE_ODE
constexpr bool has_ode = true;
#else
constexpr bool has_ode = false;
std::unique_ptr<Engine> make_ode(const Contestant&, const Scene&) { return nullptr; }
#endif

bool is_built(Product product) {
    return product == Product::bullet ? has_bullet : product == Product::ode ? has_ode : true;
}

std::unique_ptr<Engine> make_engine(const Contestant& contestant, const Scene& scene) {
    switch (contestant.product) {
    case Product::bullet:
        return make_bullet(contestant, scene);
    case Product::ode:
        return make_ode(contestant, scene);
    case Product::lockstone:
        break;
    }
    return make_lockstone(contestant, scene);
}

double gap(const Scene& scene, const Engine& engine, const Joint& joint) {
    const auto anchor_on = [&](int body) {
        if (body < 0) return joint.anchor;
        const Body& first = scene.bodies[static_cast<std::size_t>(body)];
        const State s = engine.state(body);
        return s.position + rotate(s.rotation, rotate_inverse(first.rotation, joint.anchor - first.position));
    };
    return length(anchor_on(joint.b) - anchor_on(joint.a));
}

V3 angular_momentum(const Body& body, const State& state) {
    const V3 inertia = solid_of(body).inertia * body.mass;
    const V3 w = rotate_inverse(state.rotation, state.spin);
    return rotate(state.rotation, {inertia.x * w.x, inertia.y * w.y, inertia.z * w.z});
}

double energy(const Scene& scene, const Engine& engine) {
    double sum = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Body& body = scene.bodies[i];
        if (body.mass == 0) continue;
        const State s = engine.state(static_cast<int>(i));
        sum += body.mass * (dot(s.velocity, s.velocity) / 2 - dot(scene.gravity, s.position));
        sum += dot(angular_momentum(body, s), s.spin) / 2;
        if (scene.attraction != 0) sum -= body.mass * scene.attraction / length(s.position);
    }
    return sum;
}

double turned(Turn a, Turn b) {
    const double c = std::abs(a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w);
    return 2 * std::acos(std::min(c, 1.0));
}

double drift(const Scene& scene, const Engine& engine) {
    double most = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].mass == 0) continue;
        const V3 moved = engine.state(static_cast<int>(i)).position - scene.bodies[i].position;
        most = std::max(most, std::hypot(moved.x, moved.z));
    }
    return most;
}

int fallen(const Scene& scene, const Engine& engine, double drop) {
    int count = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Body& body = scene.bodies[i];
        if (body.mass == 0) continue;
        const State s = engine.state(static_cast<int>(i));
        const bool stands =
            body.position.y - s.position.y <= drop && turned(s.rotation, body.rotation) <= radians(20);
        if (!stands) ++count;
    }
    return count;
}

} // namespace engines
