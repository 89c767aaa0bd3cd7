// Eight lanes by AVX-512 (F, DQ, VL). See scalar.h for the meaning of each operation.
//
// This file includes no part of avx2.h: the linker would keep one copy of an inline function that both use, with
// instructions that a machine with the other set may lack.
#pragma once

#include <cstdint>
#include <immintrin.h>

namespace lockstone::solve {

struct Avx512 {
    static constexpr unsigned lanes = 8;
    using V = __m512i;
    using Low = V; ///< of 32-bit numbers

    static V splat(std::int64_t x) { return _mm512_set1_epi64(x); }
    static V load32(const std::int32_t* p) {
        return _mm512_cvtepi32_epi64(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(p)));
    }
    static void store32(std::int32_t* p, V x) {
        _mm256_storeu_si256(reinterpret_cast<__m256i*>(p), _mm512_cvtepi64_epi32(x));
    }
    static V load64(const std::int64_t* p) { return _mm512_loadu_si512(p); }
    static V from_lanes(const std::int64_t (&x)[lanes]) {
        return _mm512_set_epi64(x[7], x[6], x[5], x[4], x[3], x[2], x[1], x[0]);
    }
    static void store64(std::int64_t* p, V x) { _mm512_storeu_si512(p, x); }

    static V add(V a, V b) { return _mm512_add_epi64(a, b); }
    static V sub(V a, V b) { return _mm512_sub_epi64(a, b); }
    static V mul(V a, V b) { return _mm512_mul_epi32(a, b); }
    static V mul64(V a, V b) { return _mm512_mullo_epi64(a, b); }
    template <int S> static V shift_right(V x) { return _mm512_srli_epi64(x, S); }
    template <int S> static V shift_right_signed(V x) { return _mm512_srai_epi64(x, S); }
    static V shift_left_by(V x, V by) { return _mm512_sllv_epi64(x, by); }
    template <int S> static V shift_left(V x) { return _mm512_slli_epi64(x, S); }
    static V shift_right_logical_by(V x, V by) { return _mm512_srlv_epi64(x, by); }
    static V shift_right_by(V x, V by) { return _mm512_srav_epi64(x, by); }

    static V max32(V a, V b) { return _mm512_max_epi32(a, b); }
    static V min32(V a, V b) { return _mm512_min_epi32(a, b); }
    static V greater32(V a, V b) { // the high halves are undefined, so the low halves move there
        return mask_of(_mm512_cmpgt_epi64_mask(_mm512_slli_epi64(a, 32), _mm512_slli_epi64(b, 32)));
    }
    static V greater64(V a, V b) { return mask_of(_mm512_cmpgt_epi64_mask(a, b)); }
    static V select(V mask, V a, V b) { return _mm512_ternarylogic_epi64(mask, a, b, 0xca); }
    static V both(V a, V b) { return _mm512_and_si512(a, b); }
    static V either(V a, V b) { return _mm512_or_si512(a, b); }
    static V without(V a, V b) { return _mm512_andnot_si512(b, a); }
    static unsigned lanes_of(V mask) { return _mm512_movepi64_mask(mask); }

    /// Reads the numbers of a body as a row of four and a row of two, and transposes the rows, four bodies at a time.
    template <class Body> static void gather6(const Body* const* p, V* out) {
        Half low[6], high[6];
        gather_half(p, low);
        gather_half(p + 4, high);
        for (int i = 0; i < 6; ++i) out[i] = joined(low[i], high[i]);
    }
    /// Moves and turns since the start of the tick: six numbers of 32 bits after the velocities.
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        for (int i = 0; i < 3; ++i) {
            const V pair = _mm512_set_epi64(words(p[7])[6 + i], words(p[6])[6 + i], words(p[5])[6 + i],
                                            words(p[4])[6 + i], words(p[3])[6 + i], words(p[2])[6 + i],
                                            words(p[1])[6 + i], words(p[0])[6 + i]);
            out[2 * i] = pair, out[2 * i + 1] = shift_right<32>(pair);
        }
    }
    template <class Body> [[gnu::always_inline]] static void scatter6(Body* const* p, const V* x) {
        scatter_half<0>(p, x);
        scatter_half<1>(p + 4, x);
    }
    static void quads(const std::int32_t* const* p, V* out) {
        const V low = rows(p[0], p[2], p[4], p[6]), high = rows(p[1], p[3], p[5], p[7]);
        out[0] = _mm512_unpacklo_epi64(low, high), out[1] = shift_right<32>(out[0]);
        out[2] = _mm512_unpackhi_epi64(low, high), out[3] = shift_right<32>(out[2]);
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        const V front = _mm512_mask_blend_epi32(0xaaaa, x[0], shift_left<32>(x[1])),
                back = _mm512_mask_blend_epi32(0xaaaa, x[2], shift_left<32>(x[3]));
        const V even = _mm512_unpacklo_epi64(front, back), odd = _mm512_unpackhi_epi64(front, back);
        const auto store = [&](unsigned lane, __m128i t) {
            _mm_storeu_si128(reinterpret_cast<__m128i*>(p[lane]), t);
        };
        store(0, _mm512_extracti64x2_epi64(even, 0)), store(1, _mm512_extracti64x2_epi64(odd, 0));
        store(2, _mm512_extracti64x2_epi64(even, 1)), store(3, _mm512_extracti64x2_epi64(odd, 1));
        store(4, _mm512_extracti64x2_epi64(even, 2)), store(5, _mm512_extracti64x2_epi64(odd, 2));
        store(6, _mm512_extracti64x2_epi64(even, 3)), store(7, _mm512_extracti64x2_epi64(odd, 3));
    }

  private:
    using Half = __m256i;

    static V rows(const std::int32_t* a, const std::int32_t* b, const std::int32_t* c,
                  const std::int32_t* d) {
        const auto row = [](const std::int32_t* p) {
            return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
        };
        return joined(_mm256_set_m128i(row(b), row(a)), _mm256_set_m128i(row(d), row(c)));
    }

    static V mask_of(__mmask8 bits) { return _mm512_movm_epi64(bits); }
    static V joined(Half low, Half high) { return _mm512_inserti64x4(_mm512_castsi256_si512(low), high, 1); }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
    template <class Body> static std::int64_t* words(Body* p) { return reinterpret_cast<std::int64_t*>(p); }
    static Half load_half(const std::int64_t* p) {
        return _mm256_loadu_si256(reinterpret_cast<const Half*>(p));
    }
    template <class Body> static void gather_half(const Body* const* p, Half* out) {
        transpose(load_half(words(p[0])), load_half(words(p[1])), load_half(words(p[2])),
                  load_half(words(p[3])), out);
        const auto two = [&](unsigned lane) {
            return _mm_loadu_si128(reinterpret_cast<const __m128i*>(words(p[lane]) + 4));
        };
        const Half ac = _mm256_set_m128i(two(2), two(0)), bd = _mm256_set_m128i(two(3), two(1));
        out[4] = _mm256_unpacklo_epi64(ac, bd);
        out[5] = _mm256_unpackhi_epi64(ac, bd);
    }
    /// Writes lanes 4 Which to 4 Which + 3 to the bodies at p[0] ... p[3].
    template <int Which, class Body> static void scatter_half(Body* const* p, const V* x) {
        Half part[6], row[4];
        for (int i = 0; i < 6; ++i) part[i] = _mm512_extracti64x4_epi64(x[i], Which);
        transpose(part[0], part[1], part[2], part[3], row);
        const Half ac = _mm256_unpacklo_epi64(part[4], part[5]), bd = _mm256_unpackhi_epi64(part[4], part[5]);
        const __m128i tails[4] = {_mm256_castsi256_si128(ac), _mm256_castsi256_si128(bd),
                                  _mm256_extracti128_si256(ac, 1), _mm256_extracti128_si256(bd, 1)};
        for (int lane = 0; lane < 4; ++lane) {
            _mm256_storeu_si256(reinterpret_cast<Half*>(words(p[lane])), row[lane]);
            _mm_storeu_si128(reinterpret_cast<__m128i*>(words(p[lane]) + 4), tails[lane]);
        }
    }
    static void transpose(Half a, Half b, Half c, Half d, Half* out) {
        const Half ab0 = _mm256_unpacklo_epi64(a, b), ab1 = _mm256_unpackhi_epi64(a, b);
        const Half cd0 = _mm256_unpacklo_epi64(c, d), cd1 = _mm256_unpackhi_epi64(c, d);
        out[0] = _mm256_permute2x128_si256(ab0, cd0, 0x20);
        out[1] = _mm256_permute2x128_si256(ab1, cd1, 0x20);
        out[2] = _mm256_permute2x128_si256(ab0, cd0, 0x31);
        out[3] = _mm256_permute2x128_si256(ab1, cd1, 0x31);
    }
};

} // namespace lockstone::solve
