// Runs one operation of an instruction set on numbers in memory.
//
// A file for each instruction set includes this and is compiled for that set, so this header uses no inline functions of
// other headers: the linker would keep one copy of them, with instructions that a machine may lack.
#pragma once

#include "lockstone/compiler.h"

#include <cstdint>

#if LOCKSTONE_GNU && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized" // g++ 12 reports its own AVX-512 intrinsics
#endif

namespace lockstone::test {

enum class LaneOp : unsigned {
    add,
    sub,
    mul,
    mul64,
    shift_left_1,
    shift_left_37,
    shift_right_1,
    shift_right_19,
    shift_right_30,
    shift_right_45,
    shift_right_signed_1,
    shift_right_signed_19,
    shift_right_signed_32,
    shift_right_signed_47,
    shift_left_by,
    shift_right_by,
    shift_right_logical_by,
    greater64,
    select,
    both,
    either,
    without,
    // On 32-bit numbers: the low halves of the results are compared.
    max32,
    min32,
    greater32,
    add_low,
    sub_low,
    lanes_of, ///< of greater64: bit per lane, in out[0]
    all_within,
    count,
};

struct LaneOps {
    unsigned lanes;
    /// Writes the results of `lanes` lanes. `a`, `b`, `c`: [lanes].
    void (*run)(LaneOp op, const std::int64_t* a, const std::int64_t* b, const std::int64_t* c,
                std::int64_t* out);
};

/// Null where the build lacks the instruction set.
extern const LaneOps *const sse41_lane_ops,
    *const avx2_lane_ops, *const avx512_lane_ops, *const neon_lane_ops, *const wasm128_lane_ops;

template <class L> struct LaneRunner {
    using V = typename L::V;

    static typename L::Low low(V x) {
        if constexpr (requires { L::packed(x); })
            return L::packed(x);
        else
            return x;
    }
    template <class T> static void store_low(T x, std::int64_t* out) {
        std::int32_t narrow[L::lanes];
        L::store32(narrow, x);
        for (unsigned i = 0; i < L::lanes; ++i) out[i] = narrow[i];
    }
    static V by_shift(LaneOp op, V a, V c) {
        switch (op) {
        case LaneOp::shift_left_1:
            return L::template shift_left<1>(a);
        case LaneOp::shift_left_37:
            return L::template shift_left<37>(a);
        case LaneOp::shift_right_1:
            return L::template shift_right<1>(a);
        case LaneOp::shift_right_19:
            return L::template shift_right<19>(a);
        case LaneOp::shift_right_30:
            return L::template shift_right<30>(a);
        case LaneOp::shift_right_45:
            return L::template shift_right<45>(a);
        case LaneOp::shift_right_signed_1:
            return L::template shift_right_signed<1>(a);
        case LaneOp::shift_right_signed_19:
            return L::template shift_right_signed<19>(a);
        case LaneOp::shift_right_signed_32:
            return L::template shift_right_signed<32>(a);
        case LaneOp::shift_right_signed_47:
            return L::template shift_right_signed<47>(a);
        case LaneOp::shift_left_by:
            return L::shift_left_by(a, c);
        case LaneOp::shift_right_by:
            return L::shift_right_by(a, c);
        default:
            return L::shift_right_logical_by(a, c);
        }
    }
    static bool is_within(V x) {
        if constexpr (requires { L::all_within(x, 40); })
            return L::all_within(x, 40);
        else {
            const V least = L::splat(-(std::int64_t{1} << 40)), most = L::splat((std::int64_t{1} << 40) - 1);
            return L::lanes_of(L::either(L::greater64(least, x), L::greater64(x, most))) == 0;
        }
    }
    static void run(LaneOp op, const std::int64_t* pa, const std::int64_t* pb, const std::int64_t* pc,
                    std::int64_t* out) {
        const V a = L::load64(pa), b = L::load64(pb), c = L::load64(pc);
        switch (op) {
        case LaneOp::add:
            return L::store64(out, L::add(a, b));
        case LaneOp::sub:
            return L::store64(out, L::sub(a, b));
        case LaneOp::mul:
            return L::store64(out, L::mul(a, b));
        case LaneOp::mul64:
            return L::store64(out, L::mul64(a, b));
        case LaneOp::greater64:
            return L::store64(out, L::greater64(a, b));
        case LaneOp::select:
            return L::store64(out, L::select(L::greater64(a, b), b, a));
        case LaneOp::both:
            return L::store64(out, L::both(a, b));
        case LaneOp::either:
            return L::store64(out, L::either(a, b));
        case LaneOp::without:
            return L::store64(out, L::without(a, b));
        case LaneOp::max32:
            return store_low(L::max32(low(a), low(b)), out);
        case LaneOp::min32:
            return store_low(L::min32(low(a), low(b)), out);
        case LaneOp::greater32:
            return store_low(L::greater32(low(a), low(b)), out);
        case LaneOp::add_low:
            return store_low(L::add(low(a), low(b)), out);
        case LaneOp::sub_low:
            return store_low(L::sub(low(a), low(b)), out);
        case LaneOp::lanes_of:
            out[0] = L::lanes_of(L::greater64(a, b));
            return;
        case LaneOp::all_within:
            out[0] = is_within(a) ? 1 : 0;
            return;
        default:
            return L::store64(out, by_shift(op, a, c));
        }
    }
    static constexpr LaneOps table{L::lanes, run};
};

} // namespace lockstone::test
