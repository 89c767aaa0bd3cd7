#include "bench/plot.h"

#include <algorithm>
#include <sstream>

namespace lockstone::bench {
namespace {

/// The most telling figure of a scene's quality: the widest joint if the scene has joints, else the overlap.
double worst_of(const Json& scene, const Json& run) {
    if (scene.at("joints").as_int() > 0) return run.at("joint_worst_mm").as_double();
    return run.at(scene.at("scene").as_text() == "S3" ? "overlap_static_mm" : "overlap_mm").as_double();
}

std::string title_of(const Json& scene) {
    const char* worst = scene.at("joints").as_int() > 0 ? "widest joint" : "worst overlap";
    return scene.at("scene").as_text() + ", " + worst;
}

/// The least value that is drawn [mm]. A logarithmic axis has no 0, and smaller values mean no visible difference.
constexpr double least_mm = 0.01;

/// A line "cost worst label" for each engine of a scene whose name begins with `product`. The rest of the name is the
/// label.
std::string points_of(const Json& scene, const std::string& product) {
    std::ostringstream out;
    for (const Json& run : scene.at("engines")) {
        const auto name = run.at("engine").as_text();
        if (!name.starts_with(product)) continue;
        out << run.at("mean_ms").as_double() << ' ' << std::max(least_mm, worst_of(scene, run)) << " \""
            << name.substr(std::min(name.size(), product.size() + 1)) << "\"\n";
    }
    return out.str();
}

/// A panel for each scene: the time of a tick on the x axis, millimetres on the y axis, both logarithmic. Points near
/// the lower left corner are better.
std::string front_script(const Json& front) {
    std::ostringstream out;
    out << "set multiplot layout 2,3 title 'Cost against quality: Lockstone by substeps, Bullet by "
           "iterations'\n"
        << "set logscale xy\nset grid\nset xlabel 'ms a tick'\nset ylabel 'mm'\nset key top right\n";
    int panel = 0;
    for (const Json& scene : front) {
        ++panel;
        std::string sources;
        for (const char* product : {"Lockstone", "Bullet"}) {
            const std::string points = points_of(scene, product);
            if (points.empty()) continue;
            const std::string block = "$" + std::string(product) + std::to_string(panel);
            out << block << " << EOD\n" << points << "EOD\n";
            sources += (sources.empty() ? "" : ", ") + block +
                       " using 1:2 with linespoints pointtype 7 pointsize 0.5 title '" + product + "', " +
                       block + " using 1:2:3 with labels offset 0.8,0.6 font ',9' notitle";
        }
        out << "set title '" << title_of(scene)
            << "'\nset autoscale\nset offsets graph 0.15, graph 0.15, graph 0.15, graph 0.15\n"
            << "plot " << sources << '\n';
    }
    out << "unset multiplot\n";
    return out.str();
}

/// A group of bars for each scene: the measured ratio, its bound and the goal.
std::string ratio_script(const Json& scenes) {
    std::ostringstream out;
    out << "$ratios << EOD\n";
    for (const Json& scene : scenes) {
        if (scene.at("bullet_per_ours").is_null()) continue;
        double must = 0, goal = 0;
        for (const Json& verdict : scene.at("verdicts"))
            if (verdict.contains("goal"))
                must = verdict.at("must").as_double(), goal = verdict.at("goal").as_double();
        out << scene.at("scene").dump() << ' ' << scene.at("bullet_per_ours").at("mean").as_double() << ' '
            << must << ' ' << goal << '\n';
    }
    out << "EOD\nset title 'Time of Bullet / time of Lockstone, default settings, one thread'\n"
        << "set style data histogram\nset style histogram clustered\nset style fill solid 0.7\nset grid "
           "ytics\n"
        << "set yrange [0:*]\nset key top right\n"
        << "plot $ratios using 2:xtic(1) title 'measured', '' using 3 title 'must', '' using 4 title "
           "'goal'\n";
    return out.str();
}

/// gnuplot changes only single quotes in a text in single quotes.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
    return out + "'";
}

} // namespace

Result<std::string> plot_script(const Json& results, const std::string& file) {
    const bool has_front = results.contains("front");
    if (!has_front && !results.contains("scenes"))
        return Error{"--plot " + file + ": there is nothing to draw: choose scenes, or 'front'"};
    return "set terminal svg size 1200,700 background 'white'\nset output " + quoted(file) + "\n" +
           (has_front ? front_script(results.at("front")) : ratio_script(results.at("scenes")));
}

} // namespace lockstone::bench
