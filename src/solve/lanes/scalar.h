// One lane of plain integers: the reference for every instruction set.
#pragma once

#include <cstdint>

namespace lockstone::solve {

/// The operations of an instruction set on N lanes of 64 bits. A 32-bit value is in the low half of its lane, and the
/// high half is undefined: products read the low half only, and the low half of a sum or of a logical shift does not
/// depend on higher bits. So a product needs no packing before the next one.
struct Scalar {
    static constexpr unsigned lanes = 1;
    using V = std::int64_t;
    /// 32-bit numbers: also lanes, unless the instruction set keeps them side by side
    using Low = V;

    static V splat(std::int64_t x) { return x; }
    static V load32(const std::int32_t* p) { return *p; }
    static void store32(std::int32_t* p, V x) { *p = static_cast<std::int32_t>(x); }
    static V load64(const std::int64_t* p) { return *p; }
    static void store64(std::int64_t* p, V x) { *p = x; }
    /// Builds a vector from numbers computed lane by lane, without memory: a load of a vector would wait for the stores
    /// of its parts.
    static V from_lanes(const std::int64_t (&x)[lanes]) { return x[0]; }

    static V add(V a, V b) { return signed_of(bits(a) + bits(b)); }
    static V sub(V a, V b) { return signed_of(bits(a) - bits(b)); }
    /// The whole product of the low halves.
    static V mul(V a, V b) {
        return std::int64_t{static_cast<std::int32_t>(a)} * static_cast<std::int32_t>(b);
    }
    /// The low 64 bits of the product of whole lanes.
    static V mul64(V a, V b) { return signed_of(bits(a) * bits(b)); }
    template <int S> static V shift_right(V x) { return signed_of(bits(x) >> S); } ///< logical
    template <int S> static V shift_right_signed(V x) { return x >> S; }           ///< arithmetic
    static V shift_right_by(V x, V by) { return x >> by; } ///< by lane, arithmetic, 0..63
    static V shift_right_logical_by(V x, V by) { return signed_of(bits(x) >> by); } ///< by lane, 0..63
    static V shift_left_by(V x, V by) { return signed_of(bits(x) << by); }          ///< by lane, 0..63
    template <int S> static V shift_left(V x) { return signed_of(bits(x) << S); }

    // On the low halves; the halves of masks are all ones or zero.
    static V max32(V a, V b) { return low(a) < low(b) ? low(b) : low(a); }
    static V min32(V a, V b) { return low(b) < low(a) ? low(b) : low(a); }
    static V greater32(V a, V b) { return low(a) > low(b) ? -1 : 0; }
    // On whole lanes.
    static V greater64(V a, V b) { return a > b ? -1 : 0; }
    static V select(V mask, V a, V b) { return (a & mask) | (b & ~mask); }
    static V both(V a, V b) { return a & b; }
    static V either(V a, V b) { return a | b; }
    static V without(V a, V b) { return a & ~b; } ///< a and not b
    /// Bit per lane: the mask is set. Reads the lowest bit, and x86 reads the highest one: so a value that is no mask
    /// gives other bits in the scalar set.
    static unsigned lanes_of(V mask) { return static_cast<unsigned>(mask & 1); }

    /// The first six numbers of 64 bits at each of p[0] ... p[lanes - 1]: velocities of bodies, or entries of matrices.
    template <class Body> static void gather6(const Body* const* p, V* out) {
        const auto* const words = reinterpret_cast<const std::int64_t*>(p[0]);
        for (int i = 0; i < 6; ++i) out[i] = words[i];
    }
    /// Moves and turns since the start of the tick, three each.
    template <class Body> static void gather_motion(const Body* const* p, V* out) {
        for (int i = 0; i < 3; ++i) out[i] = p[0]->shift[i], out[3 + i] = p[0]->theta[i];
    }
    template <class Body> static void scatter6(Body* const* p, const V* x) {
        for (int i = 0; i < 3; ++i) p[0]->v[i] = x[i], p[0]->u[i] = x[3 + i];
    }
    /// Four numbers of 32 bits from p[k] on for each lane k, and back.
    static void quads(const std::int32_t* const* p, V* out) {
        for (int i = 0; i < 4; ++i) out[i] = p[0][i];
    }
    static void store_quads(std::int32_t* const* p, const V* x) {
        for (int i = 0; i < 4; ++i) p[0][i] = low(x[i]);
    }

  private:
    static std::uint64_t bits(V x) { return static_cast<std::uint64_t>(x); }
    static V signed_of(std::uint64_t x) { return static_cast<V>(x); }
    static std::int32_t low(V x) { return static_cast<std::int32_t>(x); }
};

} // namespace lockstone::solve
