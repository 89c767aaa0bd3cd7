#include "bench/profile.h"

#include "bench/clock.h"
#include "engines/lockstone_engine.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>

namespace lockstone::bench {
namespace {

constexpr int traced_ticks = 60;

/// Reads the clock at the end of each phase.
class PhaseClock final : public PhaseObserver {
  public:
    struct Span {
        const char* phase;
        double from_us, to_us;
    };
    void start() { last = microseconds_of(CLOCK_MONOTONIC); }
    void on_phase(const char* phase) override {
        const double now = microseconds_of(CLOCK_MONOTONIC);
        spans.push_back({phase, last, now});
        last = now;
    }
    std::vector<Span> spans = {}; ///< since the list was cleared

  private:
    double last = 0;
};

/// A complete event (with its duration) of a Chrome trace.
Json event_of(const PhaseClock::Span& span, std::size_t scene) {
    return {{"name", span.phase}, {"ph", "X"}, {"ts", span.from_us}, {"dur", span.to_us - span.from_us},
            {"pid", scene + 1},   {"tid", 1}};
}

Json profile_scene(const BenchScene& scene, const engines::Contestant& who, int ticks, std::size_t index,
                   Json& events) {
    const auto engine = make_lockstone(who, scene.scene);
    World& world = world_of(*engine);
    PhaseClock clock;
    world.observe_phases(&clock);
    std::map<std::string, std::vector<double>> spent; // by phase, then by tick
    for (int tick = 0; tick < ticks; ++tick) {
        if (scene.script) scene.script(*engine, tick);
        clock.spans.clear();
        clock.start();
        timed_act(scene, *engine, tick);
        std::map<std::string, double> sums; // a phase may run several times in a tick
        for (const PhaseClock::Span& span : clock.spans) {
            sums[span.phase] += span.to_us - span.from_us;
            if (tick >= ticks - traced_ticks) events.push_back(event_of(span, index));
        }
        for (const auto& [phase, us] : sums) spent[phase].push_back(us);
    }
    world.observe_phases(nullptr);
    std::vector<std::pair<std::string, double>> ordered;
    for (const auto& [phase, us] : spent) ordered.emplace_back(phase, percentile(us, 0.5));
    std::ranges::sort(ordered, std::greater<>{}, [](const auto& phase) { return phase.second; });
    Json phases = Json::object();
    double whole = 0;
    for (const auto& [phase, us] : ordered) phases[phase] = us, whole += us;
    return {{"scene", scene.name}, {"ticks", ticks}, {"tick_us", whole}, {"phases", phases}};
}

} // namespace

Result<Json> profile(const std::vector<BenchScene>& scenes, const engines::Contestant& who, int ticks,
                     const std::string& file) {
    Json rows = Json::array(), events = Json::array();
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        events.push_back(
            {{"name", "process_name"}, {"ph", "M"}, {"pid", i + 1}, {"args", {{"name", scenes[i].name}}}});
        rows.push_back(profile_scene(scenes[i], who, ticks != 0 ? ticks : scenes[i].ticks, i, events));
    }
    std::ofstream out(file);
    out << Json{{"traceEvents", events}, {"displayTimeUnit", "ms"}}.dump(1) << '\n';
    if (!out.flush()) return Error{file + ": cannot write: " + std::strerror(errno)};
    return rows;
}

} // namespace lockstone::bench
