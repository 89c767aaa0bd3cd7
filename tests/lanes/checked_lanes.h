// Four lanes that track their meaningful bits, and record every operation that reads other bits.
//
// The high half of a lane with a 32-bit number is unspecified (src/solve/lanes/scalar.h). Each instruction set has some
// value there, often the sign. A kernel that reads it works on one machine and fails on another. Here the half is a
// rotated copy of the low half, which is no sign, and each read of it is recorded, as memory checkers record reads of
// unwritten memory.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstdint>

namespace lockstone::test {

/// Counts reads of unspecified bits by all threads since the start.
struct LaneFaults {
    static inline std::atomic<std::uint64_t> count{0};
    static inline std::atomic<const char*> first{nullptr}; ///< the first such operation; null: none

    static void note(bool is_right, const char* operation) {
        if (is_right) return;
        const char* none = nullptr;
        first.compare_exchange_strong(none, operation);
        ++count;
    }
    static void forget() { count = 0, first = nullptr; }
};

/// An instruction set with packed 32-bit numbers, like that of WebAssembly. src/solve/lanes/scalar.h defines each
/// operation.
struct CheckedLanes {
    static constexpr unsigned lanes = 4;
    struct Low {
        std::array<std::int32_t, lanes> at;
    };
    static constexpr std::uint64_t every_bit = ~std::uint64_t{0}, low_half = 0xffffffff;
    struct V {
        std::array<std::int64_t, lanes> at;
        std::array<std::uint64_t, lanes> known = {every_bit, every_bit, every_bit,
                                                  every_bit}; ///< the meaningful bits
    };

    static V splat(std::int64_t x) { return {{x, x, x, x}}; }
    static Low splat_low(std::int32_t x) { return {{x, x, x, x}}; }
    static Low load_low(const std::int32_t* p) { return {{p[0], p[1], p[2], p[3]}}; }
    static V load32(const std::int32_t* p) { return spread(load_low(p)); }
    static void store32(std::int32_t* p, Low x) { std::ranges::copy(x.at, p); }
    static void store32(std::int32_t* p, V x) { store32(p, packed(x)); }
    static V load64(const std::int64_t* p) { return {{p[0], p[1], p[2], p[3]}}; }
    static V from_lanes(const std::int64_t (&x)[lanes]) { return load64(x); }
    static void store64(std::int64_t* p, V x) { std::ranges::copy(whole(x, "store64").at, p); }

    static Low packed(V x) {
        for (const std::uint64_t known : x.known) LaneFaults::note((known & low_half) == low_half, "packed");
        return each<Low>([&](unsigned k) { return static_cast<std::int32_t>(x.at[k]); });
    }
    /// A mask of a 32-bit number is valid as a mask of the whole lane.
    static V spread(Low x) {
        V all = each<V>([&](unsigned k) {
            const std::uint32_t bits = static_cast<std::uint32_t>(x.at[k]);
            return signed_of(std::uint64_t{std::rotl(bits, 13)} << 32 | bits);
        });
        if (!is_mask(x)) all.known.fill(low_half);
        return all;
    }
    static V extended(Low x) {
        return each<V>([&](unsigned k) { return std::int64_t{x.at[k]}; });
    }

    static V add(V a, V b) {
        return carried(a, b, [](std::uint64_t x, std::uint64_t y) { return x + y; });
    }
    static V sub(V a, V b) {
        return carried(a, b, [](std::uint64_t x, std::uint64_t y) { return x - y; });
    }
    static Low add(Low a, Low b) {
        return of_both(a, b, [](std::uint32_t x, std::uint32_t y) { return x + y; });
    }
    static Low sub(Low a, Low b) {
        return of_both(a, b, [](std::uint32_t x, std::uint32_t y) { return x - y; });
    }
    static V mul(V a, V b) { return mul(packed(a), packed(b)); }
    static V mul(Low a, Low b) {
        return each<V>([&](unsigned k) { return std::int64_t{a.at[k]} * b.at[k]; });
    }
    static V mul64(V a, V b) {
        return carried(a, b, [](std::uint64_t x, std::uint64_t y) { return x * y; });
    }

    template <int S> static V shift_right(V x) {
        V all = each<V>([&](unsigned k) { return signed_of(bits(x.at[k]) >> S); });
        for (unsigned k = 0; k < lanes; ++k) all.known[k] = x.known[k] >> S | ~(every_bit >> S);
        return all;
    }
    template <int S> static V shift_right_signed(V x) {
        whole(x, "shift_right_signed");
        return each<V>([&](unsigned k) { return x.at[k] >> S; });
    }
    template <int S> static V shift_left(V x) { return shift_left_by(x, splat(S)); }
    static V shift_left_by(V x, V by) {
        check_counts(by);
        V all = each<V>([&](unsigned k) { return signed_of(bits(x.at[k]) << (by.at[k] & 63)); });
        for (unsigned k = 0; k < lanes; ++k) all.known[k] = ~(~x.known[k] << (by.at[k] & 63));
        return all;
    }
    static V shift_right_logical_by(V x, V by) {
        check_counts(by), whole(x, "shift_right_logical_by");
        return each<V>([&](unsigned k) { return signed_of(bits(x.at[k]) >> (by.at[k] & 63)); });
    }
    static V shift_right_by(V x, V by) {
        check_counts(by), whole(x, "shift_right_by");
        return each<V>([&](unsigned k) { return x.at[k] >> (by.at[k] & 63); });
    }

    static Low max32(Low a, Low b) {
        return each<Low>([&](unsigned k) { return std::max(a.at[k], b.at[k]); });
    }
    static Low min32(Low a, Low b) {
        return each<Low>([&](unsigned k) { return std::min(a.at[k], b.at[k]); });
    }
    static Low greater32(Low a, Low b) {
        return each<Low>([&](unsigned k) { return a.at[k] > b.at[k] ? -1 : 0; });
    }
    static V greater32(V a, V b) { return spread(greater32(packed(a), packed(b))); }
    static V greater64(V a, V b) {
        whole(a, "greater64"), whole(b, "greater64");
        return each<V>([&](unsigned k) { return std::int64_t{a.at[k] > b.at[k] ? -1 : 0}; });
    }
    static bool all_within(V x, int k) {
        whole(x, "all_within");
        return std::ranges::all_of(x.at,
                                   [&](std::int64_t lane) { return lane >> k == 0 || lane >> k == -1; });
    }
    static V select(V mask, V a, V b) {
        check_mask(mask, "select");
        V all = each<V>([&](unsigned k) { return mask.at[k] != 0 ? a.at[k] : b.at[k]; });
        for (unsigned k = 0; k < lanes; ++k) all.known[k] = mask.at[k] != 0 ? a.known[k] : b.known[k];
        return all;
    }
    static Low select(Low mask, Low a, Low b) {
        LaneFaults::note(is_mask(mask), "select by no mask");
        return each<Low>([&](unsigned k) { return mask.at[k] != 0 ? a.at[k] : b.at[k]; });
    }
    /// A known 0 bit decides the result alone.
    static V both(V a, V b) {
        V all = each<V>([&](unsigned k) { return a.at[k] & b.at[k]; });
        for (unsigned k = 0; k < lanes; ++k)
            all.known[k] =
                (a.known[k] & b.known[k]) | (a.known[k] & ~bits(a.at[k])) | (b.known[k] & ~bits(b.at[k]));
        return all;
    }
    static V either(V a, V b) { return inverted(both(inverted(a), inverted(b))); }
    static V without(V a, V b) { return both(a, inverted(b)); }
    static Low both(Low a, Low b) {
        return of_both(a, b, [](std::uint32_t x, std::uint32_t y) { return x & y; });
    }
    static Low either(Low a, Low b) {
        return of_both(a, b, [](std::uint32_t x, std::uint32_t y) { return x | y; });
    }
    static Low without(Low a, Low b) {
        return of_both(a, b, [](std::uint32_t x, std::uint32_t y) { return x & ~y; });
    }
    static unsigned lanes_of(Low mask) {
        LaneFaults::note(is_mask(mask), "lanes_of no mask");
        unsigned set = 0;
        for (unsigned k = 0; k < lanes; ++k) set |= (mask.at[k] != 0 ? 1u : 0u) << k;
        return set;
    }
    static unsigned lanes_of(V mask) {
        check_mask(mask, "lanes_of");
        return lanes_of(packed(mask));
    }

    template <class Body> static void gather6(const Body* const* p, V* out) {
        for (int i = 0; i < 6; ++i) out[i] = each<V>([&](unsigned k) { return words(p[k])[i]; });
    }
    /// Six numbers of 32 bits that follow the velocities.
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        for (int i = 0; i < 6; ++i)
            out[i] = spread(each<Low>(
                [&](unsigned k) { return reinterpret_cast<const std::int32_t*>(words(p[k]) + 6)[i]; }));
    }
    template <class Body> static void scatter6(Body* const* p, const V* x) {
        for (int i = 0; i < 6; ++i) {
            whole(x[i], "scatter6");
            for (unsigned k = 0; k < lanes; ++k) reinterpret_cast<std::int64_t*>(p[k])[i] = x[i].at[k];
        }
    }
    static void quads(const std::int32_t* const* p, V* out) {
        for (int i = 0; i < 4; ++i) out[i] = spread(each<Low>([&](unsigned k) { return p[k][i]; }));
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        for (int i = 0; i < 4; ++i) {
            const Low row = packed(x[i]);
            for (unsigned k = 0; k < lanes; ++k) p[k][i] = row.at[k];
        }
    }

  private:
    template <class T, class Lane> static T each(const Lane& lane) {
        T all{};
        for (unsigned k = 0; k < lanes; ++k) all.at[k] = lane(k);
        return all;
    }
    static V inverted(V x) {
        for (std::int64_t& lane : x.at) lane = ~lane;
        return x;
    }
    /// Result bits below the lowest unspecified bit do not depend on it.
    template <class F> static V carried(V a, V b, F f) {
        V all = each<V>([&](unsigned k) { return signed_of(f(bits(a.at[k]), bits(b.at[k]))); });
        for (unsigned k = 0; k < lanes; ++k) {
            const int count = std::countr_one(a.known[k] & b.known[k]);
            all.known[k] = count == 64 ? every_bit : (std::uint64_t{1} << count) - 1;
        }
        return all;
    }
    template <class F> static Low of_both(Low a, Low b, F f) {
        return each<Low>([&](unsigned k) {
            return static_cast<std::int32_t>(
                f(static_cast<std::uint32_t>(a.at[k]), static_cast<std::uint32_t>(b.at[k])));
        });
    }
    static V whole(V x, const char* operation) {
        LaneFaults::note(is_known(x), operation);
        return x;
    }
    static bool is_known(V x) {
        return std::ranges::all_of(x.known, [](std::uint64_t known) { return known == every_bit; });
    }
    static bool is_mask(Low x) {
        return std::ranges::all_of(x.at, [](std::int32_t lane) { return lane == 0 || lane == -1; });
    }
    static void check_mask(V mask, const char* operation) {
        LaneFaults::note(
            is_known(mask) &&
                std::ranges::all_of(mask.at, [](std::int64_t lane) { return lane == 0 || lane == -1; }),
            operation);
    }
    static void check_counts(V by) {
        LaneFaults::note(
            is_known(by) &&
                std::ranges::all_of(by.at, [](std::int64_t count) { return 0 <= count && count <= 63; }),
            "a count of places");
    }
    static std::uint64_t bits(std::int64_t x) { return static_cast<std::uint64_t>(x); }
    static std::int64_t signed_of(std::uint64_t x) { return static_cast<std::int64_t>(x); }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
};

} // namespace lockstone::test
