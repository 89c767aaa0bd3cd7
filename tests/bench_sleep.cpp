// Prints the time of a tick, a save, a restore with the tick after it, and a hash in a world of 200 awake bodies alone,
// and with 10,000 sleepers around them. It checks no times, because they depend on the machine. Run it on an idle core.
#include "support/sim_scenes.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr int awake_bodies = 200, rounds = 80, turns = 12;

/// Keeps balls that come to rest awake.
void keep_awake(World& w) {
    for (std::uint32_t row = 0; row < w.awake_count(); ++row)
        if (const BodyId b = w.body_at(row); w.shape(w.shapes(b)[0]).geometry.kind == ShapeKind::sphere)
            done(w.wake_body(b));
}

/// Spheres that bounce in a bowl of walls, and jointed pairs of crates that fall asleep at once.
World make_world(int sleepers) {
    WorldDef def;
    def.bodies_max = def.shapes_max = static_cast<std::uint32_t>(awake_bodies + sleepers + 8);
    def.contacts_max = 16 * def.bodies_max;
    def.joints_max = static_cast<std::uint32_t>(sleepers / 2 + 8);
    World w = made(World::create(def));
    add_floor(w);
    for (double side : {-9.0, 9.0}) {
        add_wall(w, at(side, 5, 0), vec(0.5, 5, 9.5));
        add_wall(w, at(0, 5, side), vec(9.5, 5, 0.5));
    }
    for (int i = 0; i < awake_bodies; ++i)
        add_ball(w, at(i % 8 * 2 - 7, 1 + i / 64 * 1.5, i / 8 % 8 * 2 - 7), 0.5, 1);
    BodyId below{};
    for (int i = 0; i < sleepers; ++i) {
        const Transform pose = at(30 + i / 2 % 100 * 1.5, 0.5 + i % 2, i / 200 * 1.5 - 40);
        const BodyId crate = add_crate(w, pose);
        if (i % 2 != 0) made(w.create_joint(weld_joint(), below, crate, pose));
        below = crate;
    }
    for (int t = 0; t < 90; ++t) {
        keep_awake(w);
        w.tick();
    }
    return w;
}

double median(std::vector<double>& times) {
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2),
                     times.end());
    return times[times.size() / 2];
}
template <class Work> double microseconds(Work&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

struct Samples {
    std::vector<double> tick, save, restore, resumed, hash;
    bool as_said = true; ///< true if 200 were awake in every tick
};
void measure(World& w, std::vector<Image>& ring, Samples& out) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < rounds; ++i) {
        out.save.push_back(microseconds([&] { w.save(ring[i % 8]); }));
        out.tick.push_back(microseconds([&] { w.tick(); }));
        out.hash.push_back(microseconds([&] { sum += w.hash(); }));
        out.as_said = out.as_said && w.awake_count() == awake_bodies;
        if (i % 8 != 7) continue;
        out.restore.push_back(microseconds([&] { w.restore(ring[1]); })); // seven ticks back
        out.resumed.push_back(microseconds([&] { w.tick(); }));
        keep_awake(w);
    }
    if (sum == 0) std::printf(" ");
}

} // namespace

int main() {
    World alone = make_world(0), among = make_world(10000);
    std::vector<Image> ring(8), other_ring(8);
    for (Image& image : ring) alone.save(image);
    for (Image& image : other_ring) among.save(image);
    Samples a, b;
    for (int turn = 0; turn < turns; ++turn) { // alternates, so that other load affects both
        measure(alone, ring, a);
        measure(among, other_ring, b);
    }
    for (const World* w : {&alone, &among})
        std::printf("%u awake of %u\n", w->awake_count(), w->body_count());
    std::printf("%-24s %10s %14s %8s\n", "[us]", "200 awake", "and 10,000", "ratio");
    const auto row = [](const char* what, std::vector<double>& x, std::vector<double>& y) {
        const double one = median(x), two = median(y);
        std::printf("%-24s %10.2f %14.2f %8.2f\n", what, one, two, two / one);
    };
    row("tick", a.tick, b.tick);
    row("save", a.save, b.save);
    row("restore", a.restore, b.restore);
    row("tick after a restore", a.resumed, b.resumed);
    row("hash", a.hash, b.hash);
    if (a.as_said && b.as_said) return 0;
    std::printf("the figures say nothing: not %d bodies were awake all the time\n", awake_bodies);
    return 1;
}
