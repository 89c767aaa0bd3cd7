#include "law/zoo/shrink.h"

#include "law/zoo/draw.h"

#include <algorithm>

namespace lockstone::zoo {

namespace {

/// The nearest number with this many decimal digits.
double rounded(double x, int digits) {
    if (x == 0) return 0;
    const double unit = std::pow(10.0, std::floor(std::log10(std::abs(x))) + 1 - digits);
    return std::round(x / unit) * unit;
}
Vec3 rounded(Vec3 v, int digits) {
    const D3 d = to_double3(v);
    return vec(rounded(d[0], digits), rounded(d[1], digits), rounded(d[2], digits));
}

/// The bounding box of an object's corners, if the object is centred on its origin.
Object box_for(const Object& o) {
    D3 half{};
    for (const D3& c : o.corners)
        for (std::size_t i = 0; i < 3; ++i) half[i] = std::max(half[i], std::abs(c[i]) + o.radius);
    for (double& h : half) h = std::max(0.005, rounded(h, 2));
    Object b;
    b.assets = o.assets;
    b.size = 2 * std::max({half[0], half[1], half[2]}),
    b.thickness = 2 * std::min({half[0], half[1], half[2]});
    b.geometry = box(real(half[0]), real(half[1]), real(half[2]));
    for (int k = 0; k < 8; ++k)
        b.corners.push_back(
            {(k & 1 ? 1 : -1) * half[0], (k & 2 ? 1 : -1) * half[1], (k & 4 ? 1 : -1) * half[2]});
    b.about = in_text("box of %.4g x %.4g x %.4g m", 2 * half[0], 2 * half[1], 2 * half[2]);
    return b;
}

using Step = std::function<void(Case&)>;

void add_steps_of_object(std::vector<Step>& steps, std::size_t i) {
    steps.push_back([i](Case& c) { c.objects[i].spin = {}; });
    steps.push_back([i](Case& c) { c.objects[i].velocity = {}; });
    steps.push_back([i](Case& c) { c.objects[i].velocity.x = c.objects[i].velocity.z = Real{}; });
    steps.push_back([i](Case& c) {
        if (c.objects[i].object.geometry.kind != ShapeKind::box)
            c.objects[i].object = box_for(c.objects[i].object);
    });
    steps.push_back([i](Case& c) { c.objects[i].pose.rotation = Quat::identity(); });
    steps.push_back([i](Case& c) { c.objects[i].pose.position.x = c.objects[i].pose.position.z = Real{}; });
    steps.push_back([i](Case& c) { c.objects[i].density = 1000; });
    for (const int digits : {1, 2, 3}) {
        steps.push_back(
            [i, digits](Case& c) { c.objects[i].velocity = rounded(c.objects[i].velocity, digits); });
        steps.push_back([i, digits](Case& c) { c.objects[i].spin = rounded(c.objects[i].spin, digits); });
        steps.push_back([i, digits](Case& c) {
            c.objects[i].pose.position = rounded(c.objects[i].pose.position, digits);
        });
        steps.push_back([i, digits](Case& c) {
            if (c.objects[i].object.geometry.kind != ShapeKind::box) return;
            Object& o = c.objects[i].object;
            for (D3& corner : o.corners)
                for (double& x : corner) x = rounded(x, digits);
            o = box_for(o);
        });
        steps.push_back(
            [i, digits](Case& c) { c.objects[i].mass_ratio = rounded(c.objects[i].mass_ratio, digits); });
    }
}

std::vector<Step> steps_for(const Case& c) {
    std::vector<Step> steps;
    if (c.objects.size() == 2 && c.floor) {
        steps.push_back([](Case& s) { s.objects.pop_back(); });
        steps.push_back([](Case& s) { s.objects.erase(s.objects.begin()), s.objects[0].mass_ratio = 0; });
    }
    if (c.floor)
        for (const Floor floor : {Floor::plane, Floor::box})
            steps.push_back([floor](Case& s) {
                if (*s.floor > floor) s.floor = floor;
            });
    steps.push_back([](Case& s) {
        s.ticks = s.ticks * 60 / static_cast<int>(s.def.tick_rate);
        s.def.tick_rate = 60;
    });
    steps.push_back([](Case& s) { s.def.substeps = 4; });
    for (std::size_t i = 0; i < c.objects.size(); ++i) add_steps_of_object(steps, i);
    return steps;
}

bool is_like(const Case& a, const Case& b) { return a.about() == b.about(); }

std::string code_of(const Vec3& v) {
    return "{Real::from_raw(" + std::to_string(v.x.raw) + "), Real::from_raw(" + std::to_string(v.y.raw) +
           "), Real::from_raw(" + std::to_string(v.z.raw) + ")}";
}
std::string code_of(Length x) { return "Length::from_raw(" + std::to_string(x.raw) + ")"; }
std::string code_of(const LengthVec3& v) {
    return "{" + code_of(v.x) + ", " + code_of(v.y) + ", " + code_of(v.z) + "}";
}
std::string code_of(const Quat& q) {
    const auto unit = [](Unit u) { return "Unit::from_raw(" + std::to_string(u.raw) + ")"; };
    return "{" + unit(q.x) + ", " + unit(q.y) + ", " + unit(q.z) + ", " + unit(q.w) + "}";
}

std::string geometry_code(const Object& o) {
    const Geometry& g = o.geometry;
    if (g.kind == ShapeKind::compound) {
        std::string text =
            "instance(ShapeKind::compound, library->add(bake_compound(std::vector<CompoundPart>{";
        for (const CompoundPart& part : o.parts)
            text += "{Geometry{ShapeKind::box, Length{}, " + code_of(part.geometry.half_extent) + "}, {" +
                    code_of(part.local.position) + ", " + code_of(part.local.rotation) + "}}, ";
        return text + "})).value())";
    }
    if (g.kind != ShapeKind::hull)
        return "Geometry{ShapeKind::" + std::string(name_of(g.kind)) + ", " + code_of(g.radius) + ", " +
               code_of(g.half_extent) + "}";
    std::string text = "[&] {\n        Geometry hull = instance(ShapeKind::hull, "
                       "library->add(bake_hull(std::vector<LengthVec3>{";
    for (const D3& corner : o.corners) text += code_of(length_vec(corner)) + ", ";
    return text + "})).value());\n        hull.radius = " + code_of(g.radius) +
           ";\n        return hull;\n    }()";
}

} // namespace

Case shrunk(Case c, const std::function<bool(const Case&)>& fails, int tries) {
    if (!fails(c)) return c;
    for (bool any = true; any && tries > 0;) {
        any = false;
        for (const Step& step : steps_for(c)) {
            Case smaller = c;
            step(smaller);
            if (tries == 0 || is_like(smaller, c)) continue;
            --tries;
            if (!fails(smaller)) continue;
            c = std::move(smaller), any = true;
            if (steps_for(c).size() != steps_for(smaller).size()) break;
        }
    }
    return c;
}

std::string program_of(const Case& c) {
    std::string text = "// " + c.about() + R"(
#include "law/zoo/floor.h"
#include "lockstone/math/convert.h"
#include <cstdio>
using namespace lockstone;
int main() {
    auto library = zoo::floor_library();
)";
    text += "    WorldDef def{.tick_rate = " + std::to_string(c.def.tick_rate) +
            ", .substeps = " + std::to_string(c.def.substeps) + "};\n";
    if (!c.floor) text += "    def.gravity = {};\n";
    std::string bodies;
    for (std::size_t i = 0; i < c.objects.size(); ++i) {
        const Thrown& t = c.objects[i];
        const std::string n = std::to_string(i), name = "body" + n;
        text += "    const Geometry shape" + n + " = " + geometry_code(t.object) + ";\n";
        bodies += "    BodyDef def" + n + "{.pose = {" + code_of(t.pose.position) + ", " +
                  code_of(t.pose.rotation) + "}, .linear_velocity = " + code_of(t.velocity) +
                  ", .angular_velocity = " + code_of(t.spin) + "};\n";
        if (t.mass_ratio > 0)
            bodies += "    def" + n + ".mass = quantize<Real>(" + in_text("%.9g", t.mass_ratio) +
                      " * to_double(w.mass(body0)));\n";
        bodies += "    const BodyId " + name + " = w.create_body(def" + n + ").value();\n";
        bodies += "    (void)w.create_shape(" + name + ", {.geometry = shape" + n +
                  ", .density = quantize<Real>(" + in_text("%.9g", t.density) + ")}).value();\n";
    }
    text += "    World w = World::create(def, {}, library).value();\n";
    if (c.floor)
        text += "    zoo::add_floor(w, static_cast<zoo::Floor>(" +
                std::to_string(static_cast<int>(*c.floor)) + "), {});\n";
    text += bodies + "    for (int t = 0; t <= " + std::to_string(c.ticks) + "; ++t) {\n";
    for (std::size_t i = 0; i < c.objects.size(); ++i) {
        const std::string name = "body" + std::to_string(i);
        text += "        { auto p = to_double(w.center_of_mass(" + name +
                ")), v = to_double(w.linear_velocity(" + name + ")), s = to_double(w.angular_velocity(" +
                name + "));\n";
        text +=
            R"(          std::printf("%4d centre %9.5f %9.5f %9.5f v %9.4f %9.4f %9.4f w %9.4f %9.4f %9.4f  ", t, p[0], p[1], p[2], v[0], v[1], v[2], s[0], s[1], s[2]); }
)";
    }
    return text + R"(        std::printf("E %.6g\n", to_double(w.kinetic_energy()));
        w.tick();
    }
}
)";
}

} // namespace lockstone::zoo
