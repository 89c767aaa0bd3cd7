#include "reference/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace reference {

using lockstone::Error, lockstone::Status;

namespace {

/// As many points as a panel can show.
constexpr std::size_t points_max = 240;

/// On a logarithmic axis there is no 0: what is less is drawn here [m].
constexpr double least_apart = 1e-16;

constexpr const char* our_colour = "#1b7f4d";
constexpr const char* their_colour = "#c2451e";

double size_of(const Vec& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

/// In single quotes gnuplot takes everything as it is, but for those.
std::string quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("''") : std::string(1, c);
    return out + "'";
}

/// Calls write(i) for so many indices as can be shown, the last included.
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
    // A processor that does something else for a moment costs one tick a lot: the median of 15 tells more.
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
    out += "set title 'deepest overlap, by FCL'\nset ylabel 'mm'\n" + both(8, 9);
    out += "set title 'time of a tick, median of 15'\nset ylabel '{/Symbol m}s'\nset logscale y\n" +
           both(10, 11);
    return out;
}

/// A line's data, and what is drawn of it.
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

std::string drift_title(const DriftLine& line) {
    const bool is_ours = line.name == "Lockstone";
    const std::string parts =
        line.parts_at ? "parts at tick " + std::to_string(*line.parts_at) : std::string("never parts");
    return is_ours ? "Lockstone, other instructions, 3 threads: " + parts : line.name + ": " + parts;
}

std::string drift_panel(const Drawn& drawn) {
    constexpr const char* colours[] = {"#c2451e", "#e0922f", "#7a5bb5", "#8a8a8a"};
    std::string out;
    for (std::size_t i = 0; i < drawn.drifts.size(); ++i) out += drift_block(drawn, i);
    out +=
        "set title 'the same engine, built twice: distance between the two'\nset ylabel 'm'\nset logscale y\n"
        "set yrange [3e-17:100]\nset ytics add ('0' 1e-16)\nset format y '10^{%T}'\n"
        "set ytics ('0' 1e-16, '10^{-12}' 1e-12, '10^{-9}' 1e-9, '10^{-6}' 1e-6, '1 mm' 1e-3, '1 m' 1)\n"
        "set key bottom right width -2\n";
    for (std::size_t i = 0; i < drawn.drifts.size(); ++i) {
        const bool is_ours = drawn.drifts[i].name == "Lockstone",
                   is_twin = drawn.drifts[i].name == name_of(Build::float_twin);
        const std::string style = is_ours ? std::string("linewidth 3 linecolor '") + our_colour + "'"
                                          : std::string(is_twin ? "dashtype 2 " : "") +
                                                "linewidth 1.5 linecolor '" + colours[i % 4] + "'";
        out += (i == 0 ? "plot $drift" : ", $drift") + std::to_string(i) + " using 1:2 with lines " + style +
               " title " + quoted(drift_title(drawn.drifts[i]));
    }
    return out + "\n";
}

std::string script_of(const Drawn& drawn, const std::string& file) {
    const bool alone = drawn.samples.empty();
    std::string out =
        std::string("set terminal svg size ") + (alone ? "760,420" : "1280,760") +
        " font 'Helvetica,12' background 'white'\nset output " + quoted(file) +
        "\nset grid linecolor '#dddddd'\nset border 3\nset tics nomirror\nset xlabel 's'\nset key top left\n";
    if (alone) return out + drift_panel(drawn);
    out += "set multiplot layout 2,3 title " + quoted(drawn.scene + ": the thesis' engine beside Lockstone") +
           "\n";
    return out + sample_block(drawn) + sample_panels() + drift_panel(drawn) + "unset multiplot\n";
}

} // namespace

Status plot(const Drawn& drawn, const std::string& file) {
    const std::string script = script_of(drawn, file);
    std::FILE* gnuplot = popen("gnuplot", "w");
    bool good = gnuplot != nullptr && std::fwrite(script.data(), 1, script.size(), gnuplot) == script.size();
    if (gnuplot != nullptr) good = pclose(gnuplot) == 0 && good;
    if (!good) return Error{"--plot " + file + ": gnuplot failed; the Debian package is gnuplot-nox"};
    return {};
}

} // namespace reference
