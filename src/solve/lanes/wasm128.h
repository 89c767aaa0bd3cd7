// Two lanes by the 128-bit vectors of WebAssembly. See scalar.h for what each operation means.
#pragma once

#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_WASM128

#include <cstdint>
#include <wasm_simd128.h>

namespace lockstone::solve {

struct Wasm128 {
    static constexpr unsigned lanes = 2;
    using V = v128_t;

    static V splat(std::int64_t x) { return wasm_i64x2_splat(x); }
    static V load32(const std::int32_t* p) { return wasm_i64x2_load32x2(p); }
    static void store32(std::int32_t* p, V x) { wasm_v128_store64_lane(p, low_halves(x), 0); }
    static V load64(const std::int64_t* p) { return wasm_v128_load(p); }
    static void store64(std::int64_t* p, V x) { wasm_v128_store(p, x); }

    static V add(V a, V b) { return wasm_i64x2_add(a, b); }
    static V sub(V a, V b) { return wasm_i64x2_sub(a, b); }
    static V mul(V a, V b) { return wasm_i64x2_extmul_low_i32x4(low_halves(a), low_halves(b)); }
    static V mul64(V a, V b) { return wasm_i64x2_mul(a, b); }
    template <int S> static V shift_right(V x) { return wasm_u64x2_shr(x, S); }
    template <int S> static V shift_right_signed(V x) { return wasm_i64x2_shr(x, S); }
    template <int S> static V shift_left(V x) { return wasm_i64x2_shl(x, S); }
    static V shift_left_by(V x, V by) { // of all lanes by one count: so one after the other
        return wasm_i64x2_make(wasm_i64x2_extract_lane(wasm_i64x2_shl(x, count(by, 0)), 0),
                               wasm_i64x2_extract_lane(wasm_i64x2_shl(x, count(by, 1)), 1));
    }
    static V shift_right_by(V x, V by) {
        return wasm_i64x2_make(wasm_i64x2_extract_lane(x, 0) >> count(by, 0),
                               wasm_i64x2_extract_lane(x, 1) >> count(by, 1));
    }

    static V max32(V a, V b) { return wasm_i32x4_max(a, b); }
    static V min32(V a, V b) { return wasm_i32x4_min(a, b); }
    static V greater32(V a, V b) { // what the low halves say, in both
        const V greater = wasm_i32x4_gt(a, b);
        return wasm_i32x4_shuffle(greater, greater, 0, 0, 2, 2);
    }
    static V greater64(V a, V b) { return wasm_i64x2_gt(a, b); }
    static V select(V mask, V a, V b) { return wasm_v128_bitselect(a, b, mask); }
    static V both(V a, V b) { return wasm_v128_and(a, b); }
    static V either(V a, V b) { return wasm_v128_or(a, b); }
    static V without(V a, V b) { return wasm_v128_andnot(a, b); }
    static unsigned lanes_of(V mask) { return static_cast<unsigned>(wasm_i64x2_bitmask(mask)); }

    template <class Body> static void gather6(const Body* const* p, V* out) {
        for (int i = 0; i < 6; i += 2) two_words(p, i, out + i);
    }
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        V word[4];
        two_words(p, 6, word);
        word[2] = wasm_i64x2_make(words(p[0])[8], words(p[1])[8]);
        for (int i = 0; i < 3; ++i) out[2 * i] = word[i], out[2 * i + 1] = shift_right<32>(word[i]);
    }
    template <class Body> static void scatter6(Body* const* p, const V* x) {
        for (int i = 0; i < 6; i += 2) {
            store64(words(p[0]) + i, wasm_i64x2_shuffle(x[i], x[i + 1], 0, 2));
            store64(words(p[1]) + i, wasm_i64x2_shuffle(x[i], x[i + 1], 1, 3));
        }
    }
    static void quads(const std::int32_t* const* p, V* out) {
        const V x = wasm_v128_load(p[0]), y = wasm_v128_load(p[1]);
        out[0] = wasm_i64x2_shuffle(x, y, 0, 2), out[1] = shift_right<32>(out[0]);
        out[2] = wasm_i64x2_shuffle(x, y, 1, 3), out[3] = shift_right<32>(out[2]);
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        const V front = wasm_i32x4_shuffle(x[0], x[1], 0, 4, 2, 6),
                back = wasm_i32x4_shuffle(x[2], x[3], 0, 4, 2, 6);
        wasm_v128_store(p[0], wasm_i64x2_shuffle(front, back, 0, 2));
        wasm_v128_store(p[1], wasm_i64x2_shuffle(front, back, 1, 3));
    }

  private:
    static V low_halves(V x) { return wasm_i32x4_shuffle(x, x, 0, 2, 0, 2); }
    static std::uint32_t count(V by, int lane) {
        return static_cast<std::uint32_t>(lane == 0 ? wasm_i64x2_extract_lane(by, 0)
                                                    : wasm_i64x2_extract_lane(by, 1));
    }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
    template <class Body> static std::int64_t* words(Body* p) { return reinterpret_cast<std::int64_t*>(p); }
    template <class Body> static void two_words(const Body* const* p, int at, V* out) {
        const V x = load64(words(p[0]) + at), y = load64(words(p[1]) + at);
        out[0] = wasm_i64x2_shuffle(x, y, 0, 2);
        out[1] = wasm_i64x2_shuffle(x, y, 1, 3);
    }
};

} // namespace lockstone::solve

#endif
