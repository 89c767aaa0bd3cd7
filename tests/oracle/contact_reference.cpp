// The kernels of every instruction set against the scalar reference of the contact solver, bit for bit: on random contacts,
// alone and beside contacts of other kinds in their pack, with ordinary numbers and with numbers at the ends of their ranges.
#include "contact_reference.h"

#include "solve/kernels/kernels.h"
#include "support/effort.h"
#include "support/split_mix.h"

#include <doctest/doctest.h>

#include <array>
#include <string>
#include <vector>

namespace lockstone::test::reference {
namespace {

constexpr unsigned contacts_max = 8;

struct Draw {
    SplitMix random;
    bool is_wild; ///< numbers at the ends of their ranges are frequent

    std::uint64_t below(std::uint64_t n) { return random.next() % n; }
    /// Within [-most, most].
    i64 within(i64 most) {
        if (is_wild && below(8) == 0) return below(2) == 0 ? most : -most;
        if (below(16) == 0) return 0;
        const auto width = static_cast<std::uint64_t>(most) >> (is_wild ? 0 : below(12));
        return static_cast<i64>(below(2 * width + 1)) - static_cast<i64>(width);
    }
    i32 number(i64 most) { return static_cast<i32>(within(most)); }
    i32 positive(i64 most) { return std::abs(number(most)); }
};

Rows draw_rows(Draw& draw, int lines, int used) {
    Rows rows{lines, {}, {}, {}};
    for (int r = 0; r < used; ++r)
        for (int i = 0; i < 3; ++i) {
            if (r < lines) rows.d[r][i] = draw.number(i64{1} << row_bits);
            rows.a[r][i] = draw.number((i64{4} << row_bits) - 1),
            rows.b[r][i] = draw.number((i64{4} << row_bits) - 1);
        }
    return rows;
}

Point draw_point(Draw& draw, bool several) {
    Point k{};
    if (several) k.a = draw.number(one), k.b = draw.number(one);
    k.gap0 = draw.below(3) == 0 ? draw.number(gap_limit) : draw.number(1 << (gap_bits - 6));
    k.gap = k.gap0;
    k.p = draw.below(2) == 0 ? 0 : draw.positive(impulse_limit);
    k.kappa = draw.positive((i64{4} << kappa_bits) / 2 - 1);
    k.reach = draw.positive(one);
    if (several && draw.below(4) != 0)
        for (int i = 0; i < 3; ++i) k.h[i] = draw.number((i64{16} << fit_bits) - 1);
    if (!several || (k.h[0] == 0 && draw.below(2) == 0)) k.h[0] = 1 << fit_bits;
    k.h[0] = std::abs(k.h[0]);
    return k;
}

Contact draw_contact(Draw& draw) {
    Contact c{};
    c.count = draw.below(2) == 0 ? 1 : 2 + static_cast<int>(draw.below(3));
    const bool several = c.several();
    c.normal = draw_rows(draw, 1, several ? 3 : 1), c.slide = draw_rows(draw, 2, several ? 3 : 2);
    c.alpha = draw.positive(one), c.beta = one - c.alpha;
    for (int i = 0; i < 6; ++i) {
        c.s[i] = draw.number((i64{52} << response_bits));
        if (several || i < 3) c.slide_inverse[i] = draw.number((i64{8191} << inverse_bits));
        if (several)
            c.inverse[i] = draw.number(i64{8191} << inverse_bits),
            c.soft_inverse[i] = draw.number(i64{8191} << inverse_bits);
        if (several && i < 4) c.x[i] = draw.number(i64{52} << response_bits);
    }
    for (const int i : {0, 2, 5}) c.slide_inverse[i] = std::abs(c.slide_inverse[i]);
    c.bias_rate = draw.positive(speed_limit), c.push = -draw.positive(speed_limit);
    c.mass_scale = draw.positive(one), c.impulse_scale = draw.positive(one);
    c.mu = draw.positive((i64{4} << row_bits) - 1);
    for (i32& speed : c.surface) speed = draw.below(2) == 0 ? 0 : draw.number(speed_limit);
    for (int r = 0; r < (several ? 3 : 2); ++r) c.t[r] = draw.below(2) == 0 ? 0 : draw.number(speed_limit);
    c.bounces = draw.below(4) == 0, c.keeps = draw.below(8) == 0;
    for (int k = 0; k < c.count; ++k) c.points[k] = draw_point(draw, several);
    return c;
}

Body draw_body(Draw& draw) {
    Body body{};
    body.movable = draw.below(5) != 0;
    for (int i = 0; i < 3; ++i) {
        body.keep[i] = draw.below(10) == 0 ? 0 : -1;
        for (Motion* m : {&body.velocity, &body.warm, &body.arrival}) {
            m->v[i] = draw.within(i64{500} << solve::accumulator_bits) & body.keep[i];
            m->u[i] = draw.within(i64{500} << solve::accumulator_bits);
        }
        body.shift[i] = draw.number(i64{15} << gap_bits), body.theta[i] = draw.number(i64{15} << gap_bits);
    }
    return body;
}

/// Contacts with two bodies each. Contact i has the bodies 2 i and 2 i + 1.
struct Sample {
    std::vector<Contact> contacts;
    std::vector<Body> bodies;
};
Sample draw_sample(std::uint64_t seed) {
    Draw draw{SplitMix{seed}, seed % 3 == 0};
    Sample out;
    for (unsigned i = 0; i < contacts_max; ++i) {
        out.contacts.push_back(draw_contact(draw));
        out.bodies.push_back(draw_body(draw)), out.bodies.push_back(draw_body(draw));
        if (!out.bodies[2 * i].movable) out.contacts[i].alpha = 0;
        if (!out.bodies[2 * i + 1].movable) out.contacts[i].beta = 0;
    }
    return out;
}

// ---- packs ----------------------------------------------------------------------------------------------------------

template <unsigned N> void put_rows(const Rows& from, unsigned lane, i32 (&a)[3][3][N], i32 (&b)[3][3][N]) {
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) a[r][i][lane] = from.a[r][i], b[r][i][lane] = from.b[r][i];
}
template <std::size_t M, unsigned N> void put(const i32 (&from)[M], unsigned lane, i32 (&to)[M][N]) {
    for (std::size_t i = 0; i < M; ++i) to[i][lane] = from[i];
}

template <unsigned N> void put_point(const Point& from, unsigned lane, solve::PointLanes<N>& to) {
    to.arm[0][lane] = from.a, to.arm[1][lane] = from.b;
    to.gap0[lane] = from.gap0, to.gap[lane] = from.gap, to.impulse[lane] = from.p,
    to.impact[lane] = from.impact;
    put(from.h, lane, to.fit);
    to.kappa[lane] = from.kappa, to.reach[lane] = from.reach;
}

/// Adds contact `i` of a sample to a lane of a pack whose bodies have the rows of the sample.
template <unsigned N>
void put_contact(const Sample& sample, unsigned i, unsigned lane, solve::ContactPack<N>& pack) {
    const Contact& c = sample.contacts[i];
    const Body &a = sample.bodies[2 * i], &b = sample.bodies[2 * i + 1];
    pack.body_a[lane] = 2 * i, pack.body_b[lane] = 2 * i + 1;
    pack.movable_a |= (a.movable ? 1u : 0u) << lane, pack.movable_b |= (b.movable ? 1u : 0u) << lane;
    for (int axis = 0; axis < 3; ++axis)
        if (a.keep[axis] == 0 || b.keep[axis] == 0) pack.locked = 1;
    pack.keeps |= (c.keeps ? 1u : 0u) << lane, pack.bounces[lane] = c.bounces ? -1 : 0,
                                               pack.bounce_count += c.bounces;
    pack.point_count = std::max(pack.point_count, c.count), pack.several[lane] = c.several() ? -1 : 0;
    for (int axis = 0; axis < 3; ++axis) {
        pack.d[0][axis][lane] = c.normal.d[0][axis];
        for (int r = 0; r < 2; ++r) pack.d[1 + r][axis][lane] = c.slide.d[r][axis];
    }
    put_rows(c.normal, lane, pack.normal_a, pack.normal_b),
        put_rows(c.slide, lane, pack.slide_a, pack.slide_b);
    pack.share_a[lane] = c.alpha, pack.share_b[lane] = c.beta;
    put(c.s, lane, pack.response), put(c.slide_inverse, lane, pack.slide_inverse),
        put(c.inverse, lane, pack.inverse);
    put(c.soft_inverse, lane, pack.soft_inverse), put(c.x, lane, pack.softness);
    pack.bias_rate[lane] = c.bias_rate, pack.mass_scale[lane] = c.mass_scale,
    pack.impulse_scale[lane] = c.impulse_scale;
    pack.push[lane] = c.push, pack.friction[lane] = c.mu;
    put(c.surface, lane, pack.surface), put(c.t, lane, pack.slide);
    for (int k = 0; k < c.count; ++k) put_point(c.points[k], lane, pack.points[k]);
}

template <unsigned N> std::vector<solve::ContactPack<N>> packs_of(const Sample& sample, std::uint64_t empty) {
    std::vector<solve::ContactPack<N>> packs(contacts_max / N);
    for (unsigned p = 0; p < packs.size(); ++p) {
        for (unsigned lane = 0; lane < N; ++lane) {
            packs[p].body_a[lane] = packs[p].body_b[lane] = 2 * contacts_max;
            for (auto& point : packs[p].points) point.gap0[lane] = point.gap[lane] = gap_limit;
            if (((empty >> (p * N + lane)) & 1u) == 0) put_contact(sample, p * N + lane, lane, packs[p]);
        }
        if (packs[p].point_count == 0) packs[p].point_count = 1;
    }
    return packs;
}

// ---- comparison -----------------------------------------------------------------------------------------------------

struct Arrays {
    std::vector<solve::SolverBody> bodies{2 * contacts_max + 1};
    std::vector<solve::WarmStart> warm{2 * contacts_max + 1}, arrival{2 * contacts_max + 1};
};
Arrays arrays_of(const Sample& sample) {
    Arrays out;
    for (std::size_t i = 0; i < sample.bodies.size(); ++i) {
        const Body& body = sample.bodies[i];
        for (int axis = 0; axis < 3; ++axis) {
            solve::SolverBody& to = out.bodies[i];
            to.v[axis] = body.velocity.v[axis], to.u[axis] = body.velocity.u[axis],
            to.keep[axis] = body.keep[axis];
            to.shift[axis] = body.shift[axis], to.theta[axis] = body.theta[axis];
            out.warm[i].v[axis] = body.warm.v[axis], out.warm[i].u[axis] = body.warm.u[axis];
            out.arrival[i].v[axis] = body.arrival.v[axis], out.arrival[i].u[axis] = body.arrival.u[axis];
        }
    }
    return out;
}

template <class T> std::string motion_apart(const char* what, const Motion& expected, const T& found) {
    for (int i = 0; i < 3; ++i) {
        if (expected.v[i] != found.v[i]) return std::string(what) + " v" + std::to_string(i);
        if (expected.u[i] != found.u[i]) return std::string(what) + " u" + std::to_string(i);
    }
    return {};
}
template <unsigned N>
std::string contact_apart(const Sample& sample, unsigned i, const solve::ContactPack<N>& pack,
                          unsigned lane) {
    const Contact& c = sample.contacts[i];
    for (int k = 0; k < c.count; ++k) {
        const auto& found = pack.points[k];
        if (found.gap[lane] != c.points[k].gap) return "gap of point " + std::to_string(k);
        if (found.impulse[lane] != c.points[k].p) return "impulse of point " + std::to_string(k);
        if (found.impact[lane] != c.points[k].impact) return "impact of point " + std::to_string(k);
    }
    for (int r = 0; r < 3; ++r)
        if (pack.slide[r][lane] != c.t[r]) return "friction " + std::to_string(r);
    return {};
}
template <unsigned N>
std::string first_apart(const Sample& sample, std::uint64_t empty,
                        const std::vector<solve::ContactPack<N>>& packs, const Arrays& found) {
    for (unsigned i = 0; i < contacts_max; ++i) {
        if ((empty >> i) & 1u) continue;
        std::string apart = contact_apart(sample, i, packs[i / N], i % N);
        for (unsigned side = 0; apart.empty() && side < 2; ++side) {
            const unsigned row = 2 * i + side;
            const Body& body = sample.bodies[row];
            apart = motion_apart("velocity", body.velocity, found.bodies[row]);
            if (apart.empty()) apart = motion_apart("warm", body.warm, found.warm[row]);
            if (apart.empty()) apart = motion_apart("arrival", body.arrival, found.arrival[row]);
            if (!apart.empty()) apart = (side == 0 ? "body a, " : "body b, ") + apart;
        }
        if (!apart.empty())
            return "contact " + std::to_string(i) + " of " + std::to_string(sample.contacts[i].count) +
                   " points: " + apart;
    }
    return {};
}

constexpr solve::PassSettings settings_of(bool soft) { return {240, 1 << 30, 1 << 19, soft}; }

/// Changes one number of the reference, so that it must part from the kernels: a planted fault.
using Fault = void (*)(Sample&);

/// Plays a warm start and three substeps by a kernel and by the reference. Returns the first difference, or nothing.
template <unsigned N>
std::string compared(const solve::ContactKernel& kernel, std::uint64_t seed, Fault fault) {
    Sample sample = draw_sample(seed);
    const std::uint64_t empty = seed % 4 == 1 ? seed / 4 % 251 : 0;
    std::vector<solve::ContactPack<N>> packs = packs_of<N>(sample, empty);
    Arrays arrays = arrays_of(sample);
    const solve::PassData data{arrays.bodies.data(), arrays.warm.data(), arrays.arrival.data(),
                               contacts_max / N, false};
    if (fault != nullptr) fault(sample);
    const auto count = static_cast<std::uint32_t>(packs.size());
    const auto play = [&](bool is_warm_start, bool soft) {
        const solve::PassSettings settings = settings_of(soft);
        for (unsigned i = 0; i < contacts_max; ++i) {
            if ((empty >> i) & 1u) continue;
            Solver solver(sample.contacts[i], sample.bodies[2 * i], sample.bodies[2 * i + 1], settings);
            is_warm_start ? solver.warm_start() : solver.pass();
        }
        if (is_warm_start)
            kernel.warm_start(packs.data(), 0, count, data);
        else
            kernel.solve(packs.data(), 0, count, data, settings);
        return first_apart(sample, empty, packs, arrays);
    };
    std::string apart = play(true, false);
    for (int pass = 0; apart.empty() && pass < 6; ++pass) {
        apart = play(false, pass % 2 == 0);
        if (!apart.empty()) apart = "pass " + std::to_string(pass + 1) + ", " + apart;
    }
    return apart.empty() ? apart : "seed " + std::to_string(seed) + ": " + apart;
}

std::string first_difference(Simd simd, std::uint64_t seed, Fault fault = nullptr) {
    const solve::ContactKernel& kernel = *solve::kernels_of(simd)->contacts;
    switch (kernel.lanes) {
    case 1:
        return compared<1>(kernel, seed, fault);
    case 2:
        return compared<2>(kernel, seed, fault);
    case 4:
        return compared<4>(kernel, seed, fault);
    default:
        return compared<8>(kernel, seed, fault);
    }
}

constexpr std::array every_set{Simd::scalar, Simd::sse41, Simd::avx2,
                               Simd::avx512, Simd::neon,  Simd::wasm128};

TEST_CASE("the kernels of every instruction set solve contacts as the scalar reference does") {
    for (const Simd simd : every_set) {
        if (solve::kernels_of(simd) == nullptr) continue;
        for (int seed = 1; seed <= tries(4'000); ++seed) {
            INFO(name_of(simd));
            REQUIRE(first_difference(simd, static_cast<std::uint64_t>(seed)) == "");
        }
    }
}

TEST_CASE("planted faults: a reference that differs in one number gives other results than the kernels") {
    const auto parts = [](Fault fault) {
        int found = 0;
        for (std::uint64_t seed = 1; seed <= 40; ++seed)
            found += first_difference(Simd::scalar, seed, fault).empty() ? 0 : 1;
        return found;
    };
    CHECK(parts([](Sample&) {}) == 0);
    CHECK(parts([](Sample& s) {
              for (Contact& c : s.contacts) c.mu += 1 << 20;
          }) > 0);
    CHECK(parts([](Sample& s) {
              for (Contact& c : s.contacts) c.points[0].kappa += 1 << 16;
          }) > 0);
    CHECK(parts([](Sample& s) {
              for (Contact& c : s.contacts) c.inverse[0] += 1 << 12;
          }) > 0);
    CHECK(parts([](Sample& s) {
              for (Contact& c : s.contacts) c.keeps = !c.keeps;
          }) > 0);
    CHECK(parts([](Sample& s) {
              for (Contact& c : s.contacts) c.bounces = !c.bounces;
          }) > 0);
    CHECK(parts([](Sample& s) {
              for (Body& b : s.bodies) b.keep[0] = ~b.keep[0];
          }) > 0);
}

} // namespace
} // namespace lockstone::test::reference
