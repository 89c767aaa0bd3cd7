#include "reference/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace reference {

namespace {

/// The number of points that a panel can show.
constexpr std::size_t points_max = 150;

/// The least distance that is drawn [m]; a logarithmic axis has no 0.
constexpr double least_apart = 1e-16;

constexpr const char* our_colour = "#1b7f4d";
constexpr const char* their_colour = "#c2451e";

double size_of(const Vec& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// gnuplot changes only single quotes in a text in single quotes.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
    return out + "'";
}

/// Calls write(i) for at most about points_max indices, the last one included.
template <class Write> void for_shown(std::size_t count, Write write) {
    const std::size_t step = std::max<std::size_t>(1, count / points_max);
    for (std::size_t i = 0; i < count; i += step) write(i);
    if (count > 0 && (count - 1) % step != 0) write(count - 1);
}

/// Columns: 1 second, 2 3 separation, 4 5 energy, 6 7 momentum, 8 9 penetration [mm], 10 11 us.
std::string sample_block(const Drawn& drawn) {
    std::ostringstream out;
    out.precision(6);
    out << "$samples << EOD\n";
    // Other work of the machine makes single ticks expensive, so the plot shows the median of 15.
    const auto calm = [&](std::size_t i, double Sample::*cost) {
        std::vector<double> around;
        for (std::size_t k = i < 7 ? 0 : i - 7; k < std::min(i + 8, drawn.samples.size()); ++k)
            around.push_back(drawn.samples[k].*cost);
        std::nth_element(around.begin(), around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2),
                         around.end());
        return around[around.size() / 2];
    };
    for_shown(drawn.samples.size(), [&](std::size_t i) {
        const Sample& s = drawn.samples[i];
        out << static_cast<double>(s.tick) / drawn.tick_rate << ' ' << std::max(s.separation_max, 1e-9) << ' '
            << std::max(s.separation_mean, 1e-9) << ' ' << s.ours.energy() << ' ' << s.theirs.energy() << ' '
            << size_of(s.ours.momentum) << ' ' << size_of(s.theirs.momentum) << ' '
            << 1000 * s.ours.penetration << ' ' << 1000 * s.theirs.penetration << ' '
            << calm(i, &Sample::our_us) << ' ' << calm(i, &Sample::their_us) << '\n';
    });
    out << "EOD\n";
    return out.str();
}

std::string both(int ours, int theirs) {
    std::ostringstream out;
    out << "plot $samples using 1:" << theirs << " with lines linewidth 1.5 linecolor '" << their_colour
        << "' title 'thesis', '' using 1:" << ours << " with lines linewidth 1.5 linecolor '" << our_colour
        << "' title 'Lockstone'\n";
    return out.str();
}

std::string sample_panels() {
    std::string out =
        "set title 'how far bodies are from their counterparts'\nset ylabel 'm'\nset logscale y\n"
        "set format y '10^{%T}'\n"
        "plot $samples using 1:2 with lines linewidth 1.5 linecolor '#444444' title 'the farthest', '' "
        "using 1:3 with lines linewidth 1.5 linecolor '#999999' title 'mean'\n"
        "unset logscale y\nset format y '%g'\n";
    out += "set title 'energy'\nset ylabel 'J'\n" + both(4, 5);
    out += "set title 'momentum'\nset ylabel 'N s'\n" + both(6, 7);
    out += "set title 'deepest overlap, by FCL'\nset ylabel 'mm'\nset yrange [0:1<*]\n" + both(8, 9);
    out += "set title 'time of a tick, median of 15'\nset yrange [*:*]\nset ylabel 'µs'\nset logscale y\n" +
           both(10, 11);
    return out;
}

/// The data of a line, and the points of it that are drawn.
std::string drift_block(const Drawn& drawn, std::size_t index) {
    const DriftLine& line = drawn.drifts[index];
    std::ostringstream out;
    out.precision(4);
    out << "$drift" << index << " << EOD\n";
    for_shown(line.apart.size(), [&](std::size_t i) {
        out << static_cast<double>(i + 1) / drawn.tick_rate << ' ' << std::max(line.apart[i], least_apart)
            << '\n';
    });
    out << "EOD\n";
    return out.str();
}

bool is_ours(const DriftLine& line) { return line.name == "Lockstone"; }

std::string drift_title(const DriftLine& line) {
    const std::string who = is_ours(line) ? "Lockstone, other instructions and threads" : line.name;
    if (!line.parts_at) return who + ": never parts";
    const std::optional<std::uint64_t> seen = line.apart_by(0.001);
    return who + ": parts at tick " + std::to_string(*line.parts_at) +
           (seen ? ", 1 mm at tick " + std::to_string(*seen) : std::string());
}

/// The panel leaves out float_twin, since its line would lie under Lockstone's.
std::string drift_panel(const Drawn& drawn) {
    constexpr const char* colours[] = {"#c2451e", "#e0922f", "#7a5bb5"};
    std::string blocks, plots;
    for (std::size_t i = 0; i < drawn.drifts.size(); ++i) {
        const DriftLine& line = drawn.drifts[i];
        if (line.name == name_of(Build::float_twin)) continue;
        const std::string style = is_ours(line) ? std::string("3 linecolor '") + our_colour
                                                : std::string("1.5 linecolor '") + colours[i % 3];
        blocks += drift_block(drawn, i);
        plots += (plots.empty() ? "plot $drift" : ", $drift") + std::to_string(i) +
                 " using 1:2 with lines linewidth " + style + "' title " + quoted(drift_title(line));
    }
    return blocks +
           "set title 'one engine, built twice: how far the two worlds are apart'\nset ylabel ''\n"
           "set logscale y\nset yrange [3e-17:100]\n"
           "set ytics ('0' 1e-16, '1 pm' 1e-12, '1 nm' 1e-9, '1 µm' 1e-6, '1 mm' 1e-3, '1 m' 1)\n"
           "set key below left Left reverse vertical maxrows 5 samplen 2\n" +
           plots + "\n";
}

} // namespace

std::string plot_script(const Drawn& drawn, const std::string& file) {
    const bool alone = drawn.samples.empty();
    std::string out = std::string("set terminal svg size ") + (alone ? "760,460" : "1280,840") +
                      " font 'Helvetica,12' background 'white'\nset encoding utf8\nset output " +
                      quoted(file) +
                      "\nset grid linecolor '#dddddd'\nset border 3\nset tics nomirror\nset xlabel 's'\n"
                      "set key outside top center horizontal samplen 2\n";
    if (alone) return out + drift_panel(drawn);
    out += "set multiplot layout 2,3 title " + quoted(drawn.scene + ": the thesis' engine beside Lockstone") +
           "\n";
    return out + sample_block(drawn) + sample_panels() + drift_panel(drawn) + "unset multiplot\n";
}

} // namespace reference
