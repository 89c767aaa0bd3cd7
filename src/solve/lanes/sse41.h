// Two lanes by SSE4.1. See scalar.h for the meaning of each operation.
#pragma once

#include <cstdint>
#include <smmintrin.h>

namespace lockstone::solve {

struct Sse41 {
    static constexpr unsigned lanes = 2;
    using V = __m128i;
    using Low = V; ///< of 32-bit numbers

    static V splat(std::int64_t x) { return _mm_set1_epi64x(x); }
    static V load32(const std::int32_t* p) {
        return _mm_cvtepi32_epi64(_mm_loadl_epi64(reinterpret_cast<const V*>(p)));
    }
    static void store32(std::int32_t* p, V x) {
        _mm_storel_epi64(reinterpret_cast<V*>(p), _mm_shuffle_epi32(x, _MM_SHUFFLE(2, 0, 2, 0)));
    }
    static V load64(const std::int64_t* p) { return _mm_loadu_si128(reinterpret_cast<const V*>(p)); }
    static V from_lanes(const std::int64_t (&x)[lanes]) { return _mm_set_epi64x(x[1], x[0]); }
    static void store64(std::int64_t* p, V x) { _mm_storeu_si128(reinterpret_cast<V*>(p), x); }

    static V add(V a, V b) { return _mm_add_epi64(a, b); }
    static V sub(V a, V b) { return _mm_sub_epi64(a, b); }
    static V mul(V a, V b) { return _mm_mul_epi32(a, b); }
    static V mul64(V a, V b) {
        const V cross = add(_mm_mul_epu32(_mm_srli_epi64(a, 32), b), _mm_mul_epu32(a, _mm_srli_epi64(b, 32)));
        return add(_mm_mul_epu32(a, b), _mm_slli_epi64(cross, 32));
    }
    template <int S> static V shift_right(V x) { return _mm_srli_epi64(x, S); }
    template <int S> static V shift_right_signed(V x) {
        const V sign = _mm_set1_epi64x(INT64_MIN);
        return _mm_sub_epi64(_mm_srli_epi64(_mm_xor_si128(x, sign), S), _mm_srli_epi64(sign, S));
    }
    static V shift_left_by(V x, V by) {
        return _mm_blend_epi16(_mm_sll_epi64(x, by), _mm_sll_epi64(x, _mm_unpackhi_epi64(by, by)), 0xf0);
    }
    template <int S> static V shift_left(V x) { return _mm_slli_epi64(x, S); }
    static V shift_right_logical_by(V x, V by) {
        return _mm_blend_epi16(_mm_srl_epi64(x, by), _mm_srl_epi64(x, _mm_unpackhi_epi64(by, by)), 0xf0);
    }
    // flips the sign bit, so that no value is negative, and subtracts it again
    static V shift_right_by(V x, V by) {
        const V sign = _mm_set1_epi64x(INT64_MIN);
        return _mm_sub_epi64(shift_right_logical_by(_mm_xor_si128(x, sign), by),
                             shift_right_logical_by(sign, by));
    }

    static V max32(V a, V b) { return _mm_max_epi32(a, b); }
    static V min32(V a, V b) { return _mm_min_epi32(a, b); }
    static V greater32(V a, V b) { return _mm_shuffle_epi32(_mm_cmpgt_epi32(a, b), _MM_SHUFFLE(2, 2, 0, 0)); }
    /// The high halves decide, and where they are equal, the sign of b - a. That sign alone would be wrong for values
    /// that are more than 2^63 apart.
    static V greater64(V a, V b) {
        const V equal_high = _mm_and_si128(_mm_cmpeq_epi32(a, b), _mm_sub_epi64(b, a));
        const V high = _mm_or_si128(equal_high, _mm_cmpgt_epi32(a, b));
        return _mm_srai_epi32(_mm_shuffle_epi32(high, _MM_SHUFFLE(3, 3, 1, 1)), 31);
    }
    static V select(V mask, V a, V b) { // blends doubles: see avx2.h
        return _mm_castpd_si128(
            _mm_blendv_pd(_mm_castsi128_pd(b), _mm_castsi128_pd(a), _mm_castsi128_pd(mask)));
    }
    static V both(V a, V b) { return _mm_and_si128(a, b); }
    static V either(V a, V b) { return _mm_or_si128(a, b); }
    static V without(V a, V b) { return _mm_andnot_si128(b, a); }
    static unsigned lanes_of(V mask) {
        return static_cast<unsigned>(_mm_movemask_pd(_mm_castsi128_pd(mask)));
    }

    template <class Body> static void gather6(const Body* const* p, V* out) {
        for (int i = 0; i < 6; i += 2) two_words(p, i, out + i);
    }
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        V word[4];
        two_words(p, 6, word);
        word[2] = _mm_set_epi64x(words(p[1])[8], words(p[0])[8]);
        for (int i = 0; i < 3; ++i) out[2 * i] = word[i], out[2 * i + 1] = shift_right<32>(word[i]);
    }
    template <class Body> [[gnu::always_inline]] static void scatter6(Body* const* p, const V* x) {
        for (int i = 0; i < 6; i += 2) {
            store64(words(p[0]) + i, _mm_unpacklo_epi64(x[i], x[i + 1]));
            store64(words(p[1]) + i, _mm_unpackhi_epi64(x[i], x[i + 1]));
        }
    }
    static void quads(const std::int32_t* const* p, V* out) {
        const V x = load_row(p[0]), y = load_row(p[1]);
        out[0] = _mm_unpacklo_epi64(x, y), out[1] = shift_right<32>(out[0]);
        out[2] = _mm_unpackhi_epi64(x, y), out[3] = shift_right<32>(out[2]);
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        const V front = joined(x[0], x[1]), back = joined(x[2], x[3]);
        _mm_storeu_si128(reinterpret_cast<V*>(p[0]), _mm_unpacklo_epi64(front, back));
        _mm_storeu_si128(reinterpret_cast<V*>(p[1]), _mm_unpackhi_epi64(front, back));
    }

  private:
    static V load_row(const std::int32_t* p) { return _mm_loadu_si128(reinterpret_cast<const V*>(p)); }
    /// The low half of a in the low half, and the low half of b in the high half.
    static V joined(V a, V b) { return _mm_blend_epi16(a, shift_left<32>(b), 0xcc); }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
    template <class Body> static std::int64_t* words(Body* p) { return reinterpret_cast<std::int64_t*>(p); }
    template <class Body> static void two_words(const Body* const* p, int at, V* out) {
        const V x = load64(words(p[0]) + at), y = load64(words(p[1]) + at);
        out[0] = _mm_unpacklo_epi64(x, y);
        out[1] = _mm_unpackhi_epi64(x, y);
    }
};

} // namespace lockstone::solve
