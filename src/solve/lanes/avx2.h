// Four lanes by AVX2. See scalar.h for the meaning of each operation.
#pragma once

#include <cstdint>
#include <immintrin.h>

namespace lockstone::solve {

struct Avx2 {
    static constexpr unsigned lanes = 4;
    using V = __m256i;
    using Low = V; ///< of 32-bit numbers

    static V splat(std::int64_t x) { return _mm256_set1_epi64x(x); }
    static V load32(const std::int32_t* p) {
        return _mm256_cvtepi32_epi64(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)));
    }
    static void store32(std::int32_t* p, V x) {
        const V packed = _mm256_permutevar8x32_epi32(x, _mm256_setr_epi32(0, 2, 4, 6, 0, 2, 4, 6));
        _mm_storeu_si128(reinterpret_cast<__m128i*>(p), _mm256_castsi256_si128(packed));
    }
    static V load64(const std::int64_t* p) { return _mm256_loadu_si256(reinterpret_cast<const V*>(p)); }
    static V from_lanes(const std::int64_t (&x)[lanes]) { return _mm256_set_epi64x(x[3], x[2], x[1], x[0]); }
    static void store64(std::int64_t* p, V x) { _mm256_storeu_si256(reinterpret_cast<V*>(p), x); }

    static V add(V a, V b) { return _mm256_add_epi64(a, b); }
    static V sub(V a, V b) { return _mm256_sub_epi64(a, b); }
    static V mul(V a, V b) { return _mm256_mul_epi32(a, b); }
    static V mul64(V a, V b) {
        const V cross =
            add(_mm256_mul_epu32(_mm256_srli_epi64(a, 32), b), _mm256_mul_epu32(a, _mm256_srli_epi64(b, 32)));
        return add(_mm256_mul_epu32(a, b), _mm256_slli_epi64(cross, 32));
    }
    template <int S> static V shift_right(V x) { return _mm256_srli_epi64(x, S); }
    template <int S> static V shift_right_signed(V x) {
        const V sign = _mm256_set1_epi64x(INT64_MIN);
        return _mm256_sub_epi64(_mm256_srli_epi64(_mm256_xor_si256(x, sign), S), _mm256_srli_epi64(sign, S));
    }
    static V shift_left_by(V x, V by) { return _mm256_sllv_epi64(x, by); }
    template <int S> static V shift_left(V x) { return _mm256_slli_epi64(x, S); }
    static V shift_right_logical_by(V x, V by) { return _mm256_srlv_epi64(x, by); }
    // flips the sign bit, so that no value is negative, and subtracts it again
    static V shift_right_by(V x, V by) {
        const V sign = _mm256_set1_epi64x(INT64_MIN);
        return _mm256_sub_epi64(_mm256_srlv_epi64(_mm256_xor_si256(x, sign), by),
                                _mm256_srlv_epi64(sign, by));
    }

    static V max32(V a, V b) { return _mm256_max_epi32(a, b); }
    static V min32(V a, V b) { return _mm256_min_epi32(a, b); }
    static V greater32(V a, V b) {
        return _mm256_shuffle_epi32(_mm256_cmpgt_epi32(a, b), _MM_SHUFFLE(2, 2, 0, 0));
    }
    static V greater64(V a, V b) { return _mm256_cmpgt_epi64(a, b); }
    /// Blends doubles: with a blend of bytes, g++ 12 compares a mask that is used twice with zero first.
    static V select(V mask, V a, V b) {
        return _mm256_castpd_si256(
            _mm256_blendv_pd(_mm256_castsi256_pd(b), _mm256_castsi256_pd(a), _mm256_castsi256_pd(mask)));
    }
    static V both(V a, V b) { return _mm256_and_si256(a, b); }
    static V either(V a, V b) { return _mm256_or_si256(a, b); }
    static V without(V a, V b) { return _mm256_andnot_si256(b, a); }
    static unsigned lanes_of(V mask) {
        return static_cast<unsigned>(_mm256_movemask_pd(_mm256_castsi256_pd(mask)));
    }

    /// Reads the numbers of a body as a row of four and a row of two, and transposes the rows.
    template <class Body> static void gather6(const Body* const* p, V* out) {
        transpose(load64(words(p[0])), load64(words(p[1])), load64(words(p[2])), load64(words(p[3])), out);
        halves(p, 4, out + 4);
    }
    /// Moves and turns since the start of the tick: six numbers of 32 bits after the velocities.
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        V pair[2];
        halves(p, 6, pair);
        const V last = _mm256_set_epi64x(words(p[3])[8], words(p[2])[8], words(p[1])[8], words(p[0])[8]);
        out[0] = pair[0], out[1] = shift_right<32>(pair[0]);
        out[2] = pair[1], out[3] = shift_right<32>(pair[1]);
        out[4] = last, out[5] = shift_right<32>(last);
    }
    template <class Body> [[gnu::always_inline]] static void scatter6(Body* const* p, const V* x) {
        V row[4];
        transpose(x[0], x[1], x[2], x[3], row);
        const V ac = _mm256_unpacklo_epi64(x[4], x[5]), bd = _mm256_unpackhi_epi64(x[4], x[5]);
        const auto tail = [&](unsigned lane, __m128i t) {
            store64(words(p[lane]), row[lane]);
            _mm_storeu_si128(reinterpret_cast<__m128i*>(words(p[lane]) + 4), t);
        };
        tail(0, _mm256_castsi256_si128(ac));
        tail(1, _mm256_castsi256_si128(bd));
        tail(2, _mm256_extracti128_si256(ac, 1));
        tail(3, _mm256_extracti128_si256(bd, 1));
    }
    static void quads(const std::int32_t* const* p, V* out) {
        const V ac = _mm256_set_m128i(load_row(p[2]), load_row(p[0])),
                bd = _mm256_set_m128i(load_row(p[3]), load_row(p[1]));
        out[0] = _mm256_unpacklo_epi64(ac, bd), out[1] = shift_right<32>(out[0]);
        out[2] = _mm256_unpackhi_epi64(ac, bd), out[3] = shift_right<32>(out[2]);
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        const V front = joined(x[0], x[1]), back = joined(x[2], x[3]);
        const V ac = _mm256_unpacklo_epi64(front, back), bd = _mm256_unpackhi_epi64(front, back);
        const auto store = [&](unsigned lane, __m128i t) {
            _mm_storeu_si128(reinterpret_cast<__m128i*>(p[lane]), t);
        };
        store(0, _mm256_castsi256_si128(ac)), store(1, _mm256_castsi256_si128(bd));
        store(2, _mm256_extracti128_si256(ac, 1)), store(3, _mm256_extracti128_si256(bd, 1));
    }

  private:
    static __m128i load_row(const std::int32_t* p) {
        return _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
    }
    /// The low half of a in the low half, and the low half of b in the high half.
    static V joined(V a, V b) { return _mm256_blend_epi32(a, shift_left<32>(b), 0xaa); }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
    template <class Body> static std::int64_t* words(Body* p) { return reinterpret_cast<std::int64_t*>(p); }
    /// Words `at` and `at` + 1 of four bodies.
    template <class Body> static void halves(const Body* const* p, int at, V* out) {
        const auto two = [&](unsigned lane) {
            return _mm_loadu_si128(reinterpret_cast<const __m128i*>(words(p[lane]) + at));
        };
        const V ac = _mm256_set_m128i(two(2), two(0)), bd = _mm256_set_m128i(two(3), two(1));
        out[0] = _mm256_unpacklo_epi64(ac, bd);
        out[1] = _mm256_unpackhi_epi64(ac, bd);
    }
    static void transpose(V a, V b, V c, V d, V* out) {
        const V ab0 = _mm256_unpacklo_epi64(a, b), ab1 = _mm256_unpackhi_epi64(a, b);
        const V cd0 = _mm256_unpacklo_epi64(c, d), cd1 = _mm256_unpackhi_epi64(c, d);
        out[0] = _mm256_permute2x128_si256(ab0, cd0, 0x20);
        out[1] = _mm256_permute2x128_si256(ab1, cd1, 0x20);
        out[2] = _mm256_permute2x128_si256(ab0, cd0, 0x31);
        out[3] = _mm256_permute2x128_si256(ab1, cd1, 0x31);
    }
};

} // namespace lockstone::solve
