// A wave of a thousand dominoes, and its theoretical speed.
#include "quality/row.h"

#include <algorithm>

namespace quality {

namespace {

struct Dominoes {
    double height = 1, thickness = 0.12, pitch = 0.45, friction = 0.25;
};

/// The wave of dominoes that turn about their lower front edges, lean on each other after a hit, and slide with
/// friction.
/// source: van Leeuwen, The domino effect, American Journal of Physics 78, 2010. Here with all leaning dominoes solved.
///
/// Domino 0 is the foremost moving one, 1 leans on it, and so on; t: their angles from upright.
///   h sin(t[k+1] - t[k]) = pitch cos t[k] - d                               corner k+1 on the back of k
///   arm of the force on the domino in front: a = h cos(t[k+1] - t[k]) - pitch sin t[k] - mu d; on the one behind: b
class Wave {
  public:
    explicit Wave(Dominoes given) : d(given), angles(1, 0.0) {}

    /// Steady speed of the wave [m/s].
    double speed() {
        double time = 0;
        rate = 1;
        for (int hit = 0; hit < 80; ++hit) {
            time = fall();
            strike();
        }
        return d.pitch / time;
    }

  private:
    static constexpr std::size_t most = 40; ///< leaning dominoes in the model; those behind hardly move
    static constexpr double g = 9.81;

    double inertia() const { return (d.height * d.height + d.thickness * d.thickness) / 3; } // per mass
    double torque(double t) const { return g / 2 * (d.height * std::sin(t) - d.thickness * std::cos(t)); }
    double lean(double t) const { return std::asin((d.pitch * std::cos(t) - d.thickness) / d.height); }
    double arm_hit(double t, double by) const {
        return d.height * std::cos(by - t) - d.pitch * std::sin(t) - d.friction * d.thickness;
    }
    double arm_hitting(double t, double by) const {
        return d.height * (std::cos(by - t) + d.friction * std::sin(by - t));
    }

    /// All angles, and their first and second derivatives by the angle of the foremost.
    void follow(double t) {
        const std::size_t count = angles.size();
        first.assign(count, 1), second.assign(count, 0);
        angles[0] = t;
        for (std::size_t k = 0; k + 1 < count; ++k) {
            const double x = angles[k], w = lean(x), s = d.pitch / d.height;
            const double dw = -s * std::sin(x) / std::cos(w), slope = 1 + dw;
            const double bend = -s * (std::cos(x) / std::cos(w) +
                                      std::sin(x) * std::sin(w) / (std::cos(w) * std::cos(w)) * dw);
            angles[k + 1] = x + w;
            first[k + 1] = slope * first[k];
            second[k + 1] = bend * first[k] * first[k] + slope * second[k];
        }
    }

    /// A sum from the last domino forwards: each passes on (load - inertia * (gain x + offset)) / b.
    /// Returns the x for which the foremost domino is in balance.
    template <class Load> double balance(Load load) const {
        double base = 0, slope = 0; // force on domino k = base + slope x
        for (std::size_t k = angles.size() - 1; k > 0; --k) {
            const auto [constant, gain] = load(k);
            const double a = k + 1 < angles.size() ? arm_hit(angles[k], angles[k + 1]) : 0;
            const double b = arm_hitting(angles[k - 1], angles[k]);
            base = (constant + base * a) / b;
            slope = (-inertia() * gain + slope * a) / b;
        }
        const auto [constant, gain] = load(0);
        const double a = angles.size() > 1 ? arm_hit(angles[0], angles[1]) : 0;
        return (constant + base * a) / (inertia() * gain - slope * a);
    }

    double acceleration(double t, double omega) {
        follow(t);
        return balance([&](std::size_t k) {
            return std::pair{torque(angles[k]) - inertia() * second[k] * omega * omega, first[k]};
        });
    }

    /// From upright until the foremost one touches the next. Returns the time.
    double fall() {
        constexpr double h = 1e-5;
        const double touch = std::asin((d.pitch - d.thickness) / d.height);
        double t = 0, time = 0;
        while (t < touch) {
            const double middle = rate + acceleration(t, rate) * h / 2;
            rate += acceleration(t + middle * h / 2, middle) * h;
            t += middle * h;
            time += h;
        }
        follow(touch);
        return time;
    }

    /// The foremost one hits the next, without a bounce.
    void strike() {
        std::vector<double> before{0};
        for (double f : first) before.push_back(f * rate);
        if (angles.size() < most) angles.push_back(0);
        follow(0);
        rate = balance([&](std::size_t k) { return std::pair{inertia() * before[k], first[k]}; });
    }

    Dominoes d;
    std::vector<double> angles, first, second;
    double rate = 0;
};

Body domino(const Dominoes& d, double x) {
    return solid(box({d.thickness / 2, d.height / 2, 0.25}), {x, d.height / 2, 0}, 600, d.friction);
}

/// Feet do not slip, because the friction of a pair is the geometric mean.
Scene domino_scene(const Dominoes& d, int count, const Plan& plan) {
    Scene scene;
    scene.add(ground(0.81 / d.friction));
    for (int i = 0; i < count; ++i) {
        const double gap = plan.plants(0) && i >= count / 2 ? 2.5 * d.height : 0;
        Body body = domino(d, d.pitch * i + gap);
        if (i == 0 || (plan.plants(1) && i == count * 3 / 4)) {
            body.spin = {0, 0, -1};
            body.velocity = {d.height / 2, d.thickness / 2, 0};
        }
        scene.add(body);
    }
    return scene;
}

/// How many stay upright, how many fall too early, and the speed of the wave. Planted: a gap; one that falls alone;
/// rougher dominoes.
Figures run_dominoes(const Contestant& contestant, const Plan& plan) {
    const Dominoes right;
    Dominoes used = right;
    if (plan.plants(2)) used.friction = 0.5;
    const int count = plan.quick ? 40 : 1000;
    const Scene scene = domino_scene(used, count, plan);
    const auto engine = make_engine(contestant, scene);
    std::vector<int> fell(static_cast<std::size_t>(count), 0);
    int from = 0, last = 0;
    for (int tick = 1; tick - last < 3 * contestant.rate && from < count; ++tick) {
        engine->advance(1);
        for (int i = from; i < count; ++i) {
            int& when = fell[static_cast<std::size_t>(i)];
            if (when != 0 || turned(engine->state(i + 1).rotation, {}) < 0.15) continue;
            when = last = tick;
        }
        while (from < count && fell[static_cast<std::size_t>(from)] != 0) ++from;
    }
    int standing = 0, disorder = 0;
    for (std::size_t i = 0; i < fell.size(); ++i) {
        if (fell[i] == 0)
            ++standing;
        else if (i > 0 && fell[i] < fell[i - 1])
            ++disorder;
    }
    const int one = count / 4, other = count * 3 / 4;
    const double time = (fell[static_cast<std::size_t>(other)] - fell[static_cast<std::size_t>(one)]) /
                        static_cast<double>(contestant.rate);
    const double speed = time > 0 ? used.pitch * (other - one) / time : 0;
    return {{static_cast<double>(standing), static_cast<double>(disorder),
             std::abs(speed / Wave(right).speed() - 1) * 100},
            engine->seconds_per_tick()};
}

} // namespace

std::vector<Row> domino_rows() {
    return {
        {"dominoes",
         "a wave of 1000 dominoes: all fall, each in its turn, at the speed of van Leeuwen's chain",
         {{"standing", "pieces", 0}, {"out of turn", "pieces", 0}, {"speed", "%", 2}},
         true,
         run_dominoes},
    };
}

} // namespace quality
