// Two lanes by NEON, on AArch64. See scalar.h for the meaning of each operation.
#pragma once

#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_NEON

#include <arm_neon.h>
#include <cstdint>

namespace lockstone::solve {

struct Neon {
    static constexpr unsigned lanes = 2;
    using V = int64x2_t;
    using Low = V; ///< of 32-bit numbers

    static V splat(std::int64_t x) { return vdupq_n_s64(x); }
    static V load32(const std::int32_t* p) { return vmovl_s32(vld1_s32(p)); }
    static void store32(std::int32_t* p, V x) { vst1_s32(p, vmovn_s64(x)); }
    static V load64(const std::int64_t* p) { return vld1q_s64(p); }
    static V from_lanes(const std::int64_t (&x)[lanes]) { return vsetq_lane_s64(x[1], vdupq_n_s64(x[0]), 1); }
    static void store64(std::int64_t* p, V x) { vst1q_s64(p, x); }

    static V add(V a, V b) { return vaddq_s64(a, b); }
    static V sub(V a, V b) { return vsubq_s64(a, b); }
    static V mul(V a, V b) { return vmull_s32(vmovn_s64(a), vmovn_s64(b)); }
    static V mul64(V a, V b) { // the two cross products of halves, and the product of the low halves
        const uint32x2_t a_low = vmovn_u64(bits(a)), b_low = vmovn_u64(bits(b));
        const uint32x2_t a_high = vshrn_n_u64(bits(a), 32), b_high = vshrn_n_u64(bits(b), 32);
        const uint64x2_t cross = vmlal_u32(vmull_u32(a_high, b_low), a_low, b_high);
        return vreinterpretq_s64_u64(vmlal_u32(vshlq_n_u64(cross, 32), a_low, b_low));
    }
    template <int S> static V shift_right(V x) { return vreinterpretq_s64_u64(vshrq_n_u64(bits(x), S)); }
    template <int S> static V shift_right_signed(V x) { return vshrq_n_s64(x, S); }
    static V shift_left_by(V x, V by) { return vshlq_s64(x, by); }
    template <int S> static V shift_left(V x) { return vshlq_n_s64(x, S); }
    static V shift_right_logical_by(V x, V by) {
        return vreinterpretq_s64_u64(vshlq_u64(bits(x), vnegq_s64(by)));
    }
    static V shift_right_by(V x, V by) { return vshlq_s64(x, vnegq_s64(by)); }

    static V max32(V a, V b) { return vreinterpretq_s64_s32(vmaxq_s32(words32(a), words32(b))); }
    static V min32(V a, V b) { return vreinterpretq_s64_s32(vminq_s32(words32(a), words32(b))); }
    static V greater32(V a, V b) { // copies the masks of the low halves to both halves
        const uint32x4_t greater = vcgtq_s32(words32(a), words32(b));
        return vreinterpretq_s64_u32(vtrn1q_u32(greater, greater));
    }
    static V greater64(V a, V b) { return vreinterpretq_s64_u64(vcgtq_s64(a, b)); }
    static V select(V mask, V a, V b) { return vbslq_s64(bits(mask), a, b); }
    static V both(V a, V b) { return vandq_s64(a, b); }
    static V either(V a, V b) { return vorrq_s64(a, b); }
    static V without(V a, V b) { return vbicq_s64(a, b); }
    static unsigned lanes_of(V mask) {
        return static_cast<unsigned>(vgetq_lane_s64(mask, 0) & 1) |
               static_cast<unsigned>(vgetq_lane_s64(mask, 1) & 2);
    }

    template <class Body> static void gather6(const Body* const* p, V* out) {
        for (int i = 0; i < 6; i += 2) two_words(p, i, out + i);
    }
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        V word[4];
        two_words(p, 6, word);
        word[2] = vcombine_s64(vld1_s64(words(p[0]) + 8), vld1_s64(words(p[1]) + 8));
        for (int i = 0; i < 3; ++i) out[2 * i] = word[i], out[2 * i + 1] = shift_right<32>(word[i]);
    }
    template <class Body> static void scatter6(Body* const* p, const V* x) {
        for (int i = 0; i < 6; i += 2) {
            store64(words(p[0]) + i, vzip1q_s64(x[i], x[i + 1]));
            store64(words(p[1]) + i, vzip2q_s64(x[i], x[i + 1]));
        }
    }
    static void quads(const std::int32_t* const* p, V* out) {
        const V x = vreinterpretq_s64_s32(vld1q_s32(p[0])), y = vreinterpretq_s64_s32(vld1q_s32(p[1]));
        out[0] = vzip1q_s64(x, y), out[1] = shift_right<32>(out[0]);
        out[2] = vzip2q_s64(x, y), out[3] = shift_right<32>(out[2]);
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        const V front = vsliq_n_s64(x[0], x[1], 32), back = vsliq_n_s64(x[2], x[3], 32);
        vst1q_s32(p[0], words32(vzip1q_s64(front, back)));
        vst1q_s32(p[1], words32(vzip2q_s64(front, back)));
    }

  private:
    static uint64x2_t bits(V x) { return vreinterpretq_u64_s64(x); }
    static int32x4_t words32(V x) { return vreinterpretq_s32_s64(x); }
    template <class Body> static const std::int64_t* words(const Body* p) {
        return reinterpret_cast<const std::int64_t*>(p);
    }
    template <class Body> static std::int64_t* words(Body* p) { return reinterpret_cast<std::int64_t*>(p); }
    template <class Body> static void two_words(const Body* const* p, int at, V* out) {
        const V x = load64(words(p[0]) + at), y = load64(words(p[1]) + at);
        out[0] = vzip1q_s64(x, y);
        out[1] = vzip2q_s64(x, y);
    }
};

} // namespace lockstone::solve

#endif
