// Four lanes by pairs of the 128-bit vectors of WebAssembly. See scalar.h for the meaning of each operation.
//
// WebAssembly multiplies 32-bit numbers that are side by side: the low halves or the high halves of two vectors. So
// `Low` keeps them side by side, and code that has them in lanes packs them (`packed`) where it multiplies. The
// shuffles are those of the compiler, and not intrinsics: so spreading a number and packing it again costs nothing.
#pragma once

#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_WASM128

#include <cstdint>
#include <wasm_simd128.h>

namespace lockstone::solve {

struct Wasm128 {
    static constexpr unsigned lanes = 4;
    using Low = std::int32_t __attribute__((vector_size(16))); ///< side by side
    using Two = std::int64_t __attribute__((vector_size(16))); ///< two lanes
    struct V {
        Two low, high; ///< lanes 0 and 1, lanes 2 and 3
    };

    static V splat(std::int64_t x) { return {Two{x, x}, Two{x, x}}; }
    static Low splat_low(std::int32_t x) { return Low{x, x, x, x}; }
    static V load32(const std::int32_t* p) { return spread(load_low(p)); }
    static Low load_low(const std::int32_t* p) { return wasm_v128_load(p); }
    static void store32(std::int32_t* p, Low x) { wasm_v128_store(p, x); }
    static void store32(std::int32_t* p, V x) { store32(p, packed(x)); }
    static V load64(const std::int64_t* p) { return {two_at(p), two_at(p + 2)}; }
    static V from_lanes(const std::int64_t (&x)[lanes]) { return {Two{x[0], x[1]}, Two{x[2], x[3]}}; }
    static void store64(std::int64_t* p, V x) { wasm_v128_store(p, x.low), wasm_v128_store(p + 2, x.high); }

    /// packed(): the low halves of lanes, side by side. spread(): numbers that are side by side, in both halves of
    /// their lanes.
    static Low packed(V x) {
        return __builtin_shufflevector(reinterpret_cast<Low>(x.low), reinterpret_cast<Low>(x.high), 0, 2, 4,
                                       6);
    }
    static V spread(Low x) {
        return {reinterpret_cast<Two>(__builtin_shufflevector(x, x, 0, 0, 1, 1)),
                reinterpret_cast<Two>(__builtin_shufflevector(x, x, 2, 2, 3, 3))};
    }

    static V add(V a, V b) { return {wasm_i64x2_add(a.low, b.low), wasm_i64x2_add(a.high, b.high)}; }
    static V sub(V a, V b) { return {wasm_i64x2_sub(a.low, b.low), wasm_i64x2_sub(a.high, b.high)}; }
    static Low add(Low a, Low b) { return wasm_i32x4_add(a, b); }
    static Low sub(Low a, Low b) { return wasm_i32x4_sub(a, b); }
    static V mul(V a, V b) { return mul(packed(a), packed(b)); }
    static V mul(Low a, Low b) {
        const bool turned = is_turned(a ^ b);
        const Low x = turned ? b : a, y = turned ? a : b;
        return {wasm_i64x2_extmul_low_i32x4(x, y), wasm_i64x2_extmul_high_i32x4(x, y)};
    }
    static V mul64(V a, V b) { return {wasm_i64x2_mul(a.low, b.low), wasm_i64x2_mul(a.high, b.high)}; }
    static V extended(Low x) { return {wasm_i64x2_extend_low_i32x4(x), wasm_i64x2_extend_high_i32x4(x)}; }
    template <int S> static V shift_right(V x) {
        return {wasm_u64x2_shr(x.low, S), wasm_u64x2_shr(x.high, S)};
    }
    // x86 has no such instruction, so this shifts the halves of a lane one by one
    template <int S> static V shift_right_signed(V x) {
        const auto shifted = [](Two two) -> Two {
            const Low signs = wasm_i32x4_shr(two, S < 32 ? S : 31);
            if constexpr (S < 32)
                return __builtin_shufflevector(Low(wasm_u64x2_shr(two, S)), signs, 0, 5, 2, 7);
            return __builtin_shufflevector(Low(wasm_i32x4_shr(two, S & 31)), signs, 1, 5, 3, 7);
        };
        return {shifted(x.low), shifted(x.high)};
    }
    template <int S> static V shift_left(V x) {
        return {wasm_i64x2_shl(x.low, S), wasm_i64x2_shl(x.high, S)};
    }
    // WebAssembly shifts a vector by one count, so lanes with different counts are shifted one by one. Bodies of one
    // kind have equal counts.
    static bool are_alike(V by) {
        const Two turned = __builtin_shufflevector(by.low, by.low, 1, 0);
        return !wasm_v128_any_true((by.low ^ by.high) | (by.low ^ turned));
    }
    static std::uint32_t first_shift(V by) { return static_cast<std::uint32_t>(by.low[0]); } // modulo 64
    static V shift_left_by(V x, V by) {
        if (are_alike(by))
            return {wasm_i64x2_shl(x.low, first_shift(by)), wasm_i64x2_shl(x.high, first_shift(by))};
        const auto shifted = [](Two x, Two by) { return Two{x[0] << (by[0] & 63), x[1] << (by[1] & 63)}; };
        return {shifted(x.low, by.low), shifted(x.high, by.high)};
    }
    static V shift_right_logical_by(V x, V by) {
        if (are_alike(by))
            return {wasm_u64x2_shr(x.low, first_shift(by)), wasm_u64x2_shr(x.high, first_shift(by))};
        const auto shifted = [](Two x, Two by) {
            const auto lane = [&](int i) {
                return static_cast<std::int64_t>(static_cast<std::uint64_t>(x[i]) >> (by[i] & 63));
            };
            return Two{lane(0), lane(1)};
        };
        return {shifted(x.low, by.low), shifted(x.high, by.high)};
    }
    static V shift_right_by(V x, V by) {
        if (are_alike(by))
            return {wasm_i64x2_shr(x.low, first_shift(by)), wasm_i64x2_shr(x.high, first_shift(by))};
        const auto shifted = [](Two x, Two by) { return Two{x[0] >> (by[0] & 63), x[1] >> (by[1] & 63)}; };
        return {shifted(x.low, by.low), shifted(x.high, by.high)};
    }

    static Low max32(Low a, Low b) { return wasm_i32x4_max(a, b); }
    static Low min32(Low a, Low b) { return wasm_i32x4_min(a, b); }
    static Low greater32(Low a, Low b) { return wasm_i32x4_gt(a, b); }
    static V greater32(V a, V b) { return spread(greater32(packed(a), packed(b))); }
    static V greater64(V a, V b) { return {wasm_i64x2_gt(a.low, b.low), wasm_i64x2_gt(a.high, b.high)}; }
    /// True if -2^k <= x < 2^k in all lanes. Where numbers are rarely clamped, this test costs half as much as
    /// clamping.
    static bool all_within(V x, int k) {
        const V from_least = add(x, splat(std::int64_t{1} << k));
        return !wasm_v128_any_true(
            wasm_u64x2_shr(wasm_v128_or(from_least.low, from_least.high), static_cast<std::uint32_t>(k + 1)));
    }
    static V select(V mask, V a, V b) {
        return {wasm_v128_bitselect(a.low, b.low, mask.low), wasm_v128_bitselect(a.high, b.high, mask.high)};
    }
    static Low select(Low mask, Low a, Low b) { return wasm_v128_bitselect(a, b, mask); }
    static V both(V a, V b) { return {wasm_v128_and(a.low, b.low), wasm_v128_and(a.high, b.high)}; }
    static V either(V a, V b) { return {wasm_v128_or(a.low, b.low), wasm_v128_or(a.high, b.high)}; }
    static V without(V a, V b) { return {wasm_v128_andnot(a.low, b.low), wasm_v128_andnot(a.high, b.high)}; }
    static Low both(Low a, Low b) { return wasm_v128_and(a, b); }
    static Low either(Low a, Low b) { return wasm_v128_or(a, b); }
    static Low without(Low a, Low b) { return wasm_v128_andnot(a, b); }
    static unsigned lanes_of(Low mask) { return static_cast<unsigned>(wasm_i32x4_bitmask(mask)); }
    static unsigned lanes_of(V mask) { return lanes_of(packed(mask)); }

    template <class Body> static void gather6(const Body* const* p, V* out) {
        for (int i = 0; i < 6; i += 2) {
            const Two a = two_at(words(p[0]) + i), b = two_at(words(p[1]) + i), c = two_at(words(p[2]) + i),
                      d = two_at(words(p[3]) + i);
            out[i] = {first_of(a, b), first_of(c, d)};
            out[i + 1] = {second_of(a, b), second_of(c, d)};
        }
    }
    /// Six numbers of 32 bits after the velocities.
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        const std::int32_t* front[lanes];
        Two back[lanes];
        for (unsigned k = 0; k < lanes; ++k) {
            front[k] = reinterpret_cast<const std::int32_t*>(words(p[k]) + 6);
            back[k] = wasm_v128_load64_zero(words(p[k]) + 8);
        }
        quads(front, out);
        const Low ab = first_of(back[0], back[1]), cd = first_of(back[2], back[3]);
        out[4] = spread(__builtin_shufflevector(ab, cd, 0, 2, 4, 6));
        out[5] = spread(__builtin_shufflevector(ab, cd, 1, 3, 5, 7));
    }
    template <class Body> static void scatter6(Body* const* p, const V* x) {
        for (int i = 0; i < 6; i += 2) {
            const V a = x[i], b = x[i + 1];
            wasm_v128_store(words(p[0]) + i, first_of(a.low, b.low));
            wasm_v128_store(words(p[1]) + i, second_of(a.low, b.low));
            wasm_v128_store(words(p[2]) + i, first_of(a.high, b.high));
            wasm_v128_store(words(p[3]) + i, second_of(a.high, b.high));
        }
    }
    static void quads(const std::int32_t* const* p, V* out) {
        Low x[4] = {load_low(p[0]), load_low(p[1]), load_low(p[2]), load_low(p[3])};
        transpose(x);
        for (int i = 0; i < 4; ++i) out[i] = spread(x[i]);
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        Low row[4] = {packed(x[0]), packed(x[1]), packed(x[2]), packed(x[3])};
        transpose(row);
        for (int i = 0; i < 4; ++i) wasm_v128_store(p[i], row[i]);
    }

  private:
    static Two two_at(const std::int64_t* p) { return wasm_v128_load(p); }
    /// Always false, but clang cannot infer that, so it treats the factors of each product as new numbers. Otherwise it
    /// would extend a factor of several products once, ahead of their loop or branch, and then multiply whole lanes:
    /// eight instructions of x86 in place of three. WebAssembly engines remove the selection. `both`, which depends on
    /// both factors, makes products different from each other: volatile assembly would do so too, but around it clang
    /// stores and loads memory again. The selection is between the two factors: a selection of zero would be extended
    /// as if there were none.
    static bool is_turned(Low both) {
        std::int32_t nothing = 0;
        asm("" : "+r"(nothing) : "r"(both[0]));
        return nothing != 0;
    }
    static Two first_of(Two a, Two b) { return __builtin_shufflevector(a, b, 0, 2); }
    static Two second_of(Two a, Two b) { return __builtin_shufflevector(a, b, 1, 3); }
    static void transpose(Low (&x)[4]) {
        const Low ab0 = __builtin_shufflevector(x[0], x[1], 0, 4, 1, 5),
                  ab2 = __builtin_shufflevector(x[0], x[1], 2, 6, 3, 7),
                  cd0 = __builtin_shufflevector(x[2], x[3], 0, 4, 1, 5),
                  cd2 = __builtin_shufflevector(x[2], x[3], 2, 6, 3, 7);
        x[0] = first_of(ab0, cd0), x[1] = second_of(ab0, cd0);
        x[2] = first_of(ab2, cd2), x[3] = second_of(ab2, cd2);
    }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
    template <class Body> static std::int64_t* words(Body* p) { return reinterpret_cast<std::int64_t*>(p); }
};

} // namespace lockstone::solve

#endif
