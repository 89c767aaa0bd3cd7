// Random numbers: a generator is four words in a game column, saved and rolled back with the world.
//
//   struct Chance { Random loot; };                                       a game record
//   template <class V> constexpr void describe(Chance& c, V&& v) { v("loot", c.loot); }
//
//   world.write(record, Chance{Random::seeded(match_seed, stream_id)});   once, at the start
//   Chance now = world.read(record);
//   if (now.loot.chance(0.25_r)) drop(now.loot.range(1, 6));
//   world.write(record, now);                                             stores the new state
//
// Use one generator for each purpose, so that an added draw does not change other results.
#pragma once

#include "lockstone/math/math.h"

#include <cstddef>
#include <span>
#include <utility>

namespace lockstone {

/// The next number of SplitMix64; advances `state`. Source: S. Vigna, splitmix64.c, 2015.
constexpr std::uint64_t split_mix(std::uint64_t& state) {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

/// A generator xoshiro256** with period 2^256 - 1. It can be a row of a game column; all zeros, as in a new
/// column, act as seeded(0). Source: D. Blackman, S. Vigna, Scrambled Linear Pseudorandom Number Generators,
/// 2021.
struct Random {
    std::array<std::uint64_t, 4> state; ///< state of the generator

    /// Equal states.
    friend constexpr bool operator==(const Random&, const Random&) = default;

    /// A generator for a seed and a stream. Stream 0 is the seeding that the authors recommend.
    static constexpr Random seeded(std::uint64_t seed, std::uint64_t stream = 0) {
        std::uint64_t s = seed;
        if (stream != 0) s ^= split_mix(stream);
        Random r{};
        for (std::uint64_t& word : r.state) word = split_mix(s);
        return r;
    }

    /// A generator derived from the present state and a number; this one does not advance.
    constexpr Random split(std::uint64_t stream) const {
        if ((state[0] | state[1] | state[2] | state[3]) == 0) return seeded(0).split(stream);
        std::uint64_t hash = stream;
        for (std::uint64_t word : state) hash = split_mix(hash) ^ word;
        return seeded(split_mix(hash), stream);
    }

    /// Uniform 64 bits.
    constexpr std::uint64_t next_u64() {
        if ((state[0] | state[1] | state[2] | state[3]) == 0) *this = seeded(0);
        const std::uint64_t result = std::rotl(state[1] * 5, 7) * 9, t = state[1] << 17;
        state[2] ^= state[0];
        state[3] ^= state[1];
        state[1] ^= state[2];
        state[0] ^= state[3];
        state[2] ^= t;
        state[3] = std::rotl(state[3], 45);
        return result;
    }
    /// Uniform 32 bits: the upper half of next_u64().
    constexpr std::uint32_t next_u32() { return static_cast<std::uint32_t>(next_u64() >> 32); }

    /// Advances by 2^128 draws: gives up to 2^128 generators without overlap.
    constexpr void jump() {
        constexpr std::uint64_t polynomial[] = {0x180ec6d33cfd0abau, 0xd5a61266f0c9392cu, 0xa9582618e03fc9aau,
                                                0x39abdc4529b1661cu};
        std::array<std::uint64_t, 4> sum{};
        for (std::uint64_t word : polynomial)
            for (int bit = 0; bit < 64; ++bit) {
                if (((word >> bit) & 1u) != 0)
                    for (std::size_t i = 0; i < 4; ++i) sum[i] ^= state[i];
                next_u64();
            }
        state = sum;
    }

    /// Uniform in [0, 1): a multiple of 2^-32.
    constexpr Real uniform() { return Real::from_raw(next_u32()); }

    /// Uniform in [low, high), to 2^-64; low if high <= low.
    constexpr Real range(Real low, Real high) {
        const std::uint64_t draw = next_u64();
        if (high <= low) return low;
        const std::uint64_t width =
            static_cast<std::uint64_t>(high.raw) - static_cast<std::uint64_t>(low.raw);
        const Wide scaled = Wide::product_unsigned(draw, width);
        return Real::from_raw(static_cast<std::int64_t>(static_cast<std::uint64_t>(low.raw) +
                                                        static_cast<std::uint64_t>(scaled.high_bits())));
    }

    /// Uniform integer in [low, high], exactly; low if high < low.
    constexpr std::int32_t range(std::int32_t low, std::int32_t high) {
        if (high < low) return low;
        const std::uint32_t width = static_cast<std::uint32_t>(high) - static_cast<std::uint32_t>(low);
        const std::uint32_t offset = width == 0xffffffffu ? next_u32() : below(width + 1);
        return static_cast<std::int32_t>(static_cast<std::uint32_t>(low) + offset);
    }

    /// Uniform integer in [0, count), exactly; 0 for count 0. One draw, rarely more.
    /// Source: D. Lemire, Fast Random Integer Generation in an Interval, 2019
    constexpr std::uint32_t below(std::uint32_t count) {
        std::uint64_t product = std::uint64_t{next_u32()} * count;
        if (static_cast<std::uint32_t>(product) < count) {
            const std::uint32_t surplus = (0u - count) % count; // 2^32 mod count
            while (static_cast<std::uint32_t>(product) < surplus) product = std::uint64_t{next_u32()} * count;
        }
        return static_cast<std::uint32_t>(product >> 32);
    }

    /// True with probability p: never for p <= 0, always for p >= 1. Always one draw.
    template <FixedPoint T> constexpr bool chance(T p) { return std::int64_t{next_u32()} < to<Real>(p).raw; }

    /// A uniform direction, by rejection of points of a cube.
    constexpr UnitVec3 unit_vector() {
        for (;;) {
            UnitVec3 v{};
            v.x = Unit::from_raw(static_cast<std::int32_t>(next_u32()));
            v.y = Unit::from_raw(static_cast<std::int32_t>(next_u32()));
            v.z = Unit::from_raw(static_cast<std::int32_t>(next_u32()));
            const std::uint64_t n = detail::square_sum(v).low;
            if (n <= std::uint64_t{1} << 62 && n >= std::uint64_t{1} << 40) return normalized(v);
        }
    }

    /// Permutes the items; all orders are equally likely. Source: R. Durstenfeld, Algorithm 235, 1964.
    template <class T, std::size_t Extent> constexpr void shuffle(std::span<T, Extent> items) {
        for (std::size_t left = items.size(); left > 1; --left) {
            const std::size_t pick = below(static_cast<std::uint32_t>(left));
            std::swap(items[left - 1], items[pick]);
        }
    }
};

/// Field list of Random; see lockstone/row.h.
template <class Visit> constexpr void describe(Random& r, Visit&& visit) { visit("state", r.state); }

static_assert(std::is_trivially_copyable_v<Random> && std::has_unique_object_representations_v<Random>);

} // namespace lockstone
