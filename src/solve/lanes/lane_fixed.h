// Numbers in lanes with their fraction bits in the type: formats that do not match do not compile.
#pragma once

#include <bit>
#include <cstdint>

namespace lockstone::solve {

/// True if an instruction set keeps 32-bit numbers side by side, and not in the low halves of lanes.
template <class L>
concept SideBySide = requires(typename L::V x) {
    L::packed(x);
};

/// packed(): 32-bit numbers from the low halves of lanes. spread(): the opposite; the high halves are undefined.
template <class L> typename L::Low packed(typename L::V x) {
    if constexpr (!SideBySide<L>)
        return x;
    else
        return L::packed(x);
}
template <class L> typename L::V spread(typename L::Low x) {
    if constexpr (!SideBySide<L>)
        return x;
    else
        return L::spread(x);
}
/// extended(): sign-extends the low halves of lanes to 64 bits. signed_lanes(): the same for numbers whose high half
/// already holds the sign in most instruction sets: numbers from memory, and their sums and selections.
template <class L> typename L::V extended(typename L::V x) {
    if constexpr (!SideBySide<L>)
        return L::mul(x, L::splat(1));
    else
        return L::extended(L::packed(x));
}
template <class L> typename L::V signed_lanes(typename L::Low x) {
    if constexpr (!SideBySide<L>)
        return x;
    else
        return L::extended(x);
}
template <class L> typename L::Low load_low(const std::int32_t* p) {
    if constexpr (!SideBySide<L>)
        return L::load32(p);
    else
        return L::load_low(p);
}
template <class L> typename L::V load_extended(const std::int32_t* p) {
    return signed_lanes<L>(load_low<L>(p));
}

/// One 32-bit number with F fraction bits in each lane of the instruction set L.
template <class L, int F> struct LaneFixed {
    typename L::Low raw;

    static LaneFixed load(const std::int32_t* p) { return {load_low<L>(p)}; }
    static LaneFixed of(typename L::V low) { return {packed<L>(low)}; }
    static LaneFixed splat(std::int32_t x) {
        if constexpr (!SideBySide<L>)
            return {L::splat(x)};
        else
            return {L::splat_low(x)};
    }
    void store(std::int32_t* p) const { L::store32(p, raw); }
    typename L::V lanes() const { return spread<L>(raw); } ///< the high halves are undefined
};

/// A sum of products with F fraction bits, 64 bits a lane.
template <class L, int F> struct LaneSum {
    typename L::V raw;

    static LaneSum splat(std::int64_t x) { return {L::splat(x)}; }
    static LaneSum load(const std::int32_t* p) { return {load_extended<L>(p)}; }
    static LaneSum load64(const std::int64_t* p) { return {L::load64(p)}; }
    static LaneSum from_lanes(const std::int64_t (&x)[L::lanes]) { return {L::from_lanes(x)}; }
    void store64(std::int64_t* p) const { L::store64(p, raw); }
};

/// All ones in the lanes where a condition holds.
template <class L> struct LaneMask {
    typename L::Low raw;

    static LaneMask none() { return of(L::splat(0)); }
    static LaneMask all() { return of(L::splat(-1)); }
    static LaneMask of(typename L::V mask) { return {packed<L>(mask)}; }
    static LaneMask load(const std::int32_t* p) { return {load_low<L>(p)}; }
    typename L::V whole() const { return spread<L>(raw); }
    unsigned lanes() const { return L::lanes_of(raw); }
    bool any() const { return lanes() != 0; }
    friend LaneMask operator&(LaneMask a, LaneMask b) { return {L::both(a.raw, b.raw)}; }
    friend LaneMask operator|(LaneMask a, LaneMask b) { return {L::either(a.raw, b.raw)}; }
    friend LaneMask operator~(LaneMask a) { return {L::without(all().raw, a.raw)}; }
};

// clang-format off
template <class L, int F, int G> LaneSum<L, F + G> operator*(LaneFixed<L, F> a, LaneFixed<L, G> b) { return {L::mul(a.raw, b.raw)}; }
template <class L, int F> LaneSum<L, F> operator+(LaneSum<L, F> a, LaneSum<L, F> b) { return {L::add(a.raw, b.raw)}; }
template <class L, int F> LaneSum<L, F> operator-(LaneSum<L, F> a, LaneSum<L, F> b) { return {L::sub(a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> operator+(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::add(a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> operator-(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::sub(a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> operator-(LaneFixed<L, F> a) { return {L::sub(LaneFixed<L, F>::splat(0).raw, a.raw)}; }
template <class L, int F> LaneFixed<L, F> max(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::max32(a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> min(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::min32(a.raw, b.raw)}; }
template <class L, int F> LaneMask<L> operator>(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::greater32(a.raw, b.raw)}; }
template <class L, int F> LaneMask<L> operator>(LaneSum<L, F> a, LaneSum<L, F> b) { return LaneMask<L>::of(L::greater64(a.raw, b.raw)); }
template <class L, int F> LaneFixed<L, F> select(LaneMask<L> mask, LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::select(mask.raw, a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> operator&(LaneFixed<L, F> a, LaneMask<L> mask) { return {L::both(a.raw, mask.raw)}; }
template <class L, int F> LaneSum<L, F> operator&(LaneSum<L, F> a, LaneMask<L> mask) { return {L::both(a.raw, mask.whole())}; }
template <class L, int F> LaneSum<L, F> select(LaneMask<L> mask, LaneSum<L, F> a, LaneSum<L, F> b) { return {L::select(mask.whole(), a.raw, b.raw)}; }
template <class L, int F> LaneSum<L, F> operator-(LaneSum<L, F> a) { return {L::sub(L::splat(0), a.raw)}; }
/// The product of whole lanes; correct where it fits into 64 bits.
template <class L, int F, int G> LaneSum<L, F + G> operator*(LaneSum<L, F> a, LaneSum<L, G> b) { return {L::mul64(a.raw, b.raw)}; }
/// Correct where the value fits into 32 bits.
template <class L, int F> LaneFixed<L, F> low(LaneSum<L, F> x) { return LaneFixed<L, F>::of(x.raw); }
template <class L, int F> LaneSum<L, F> wide(LaneFixed<L, F> x) { return {extended<L>(x.lanes())}; }
// clang-format on

/// floor(x + 1/2) with G fraction bits; correct where the result fits into 32 bits.
template <int G, class L, int F> LaneFixed<L, G> rounded(LaneSum<L, F> x) {
    static_assert(F > G && F - G <= 32, "the shift keeps the low 32 bits of the result");
    return LaneFixed<L, G>::of(
        L::template shift_right<F - G>(L::add(x.raw, L::splat(std::int64_t{1} << (F - G - 1)))));
}
/// The exponent of the largest power of two that is at most x, for a positive x.
template <class L> constexpr int power_within(std::int64_t x) {
    return 63 - std::countl_zero(static_cast<std::uint64_t>(x));
}
/// Like rounded(), clamped to [-limit, limit].
template <int G, class L, int F> LaneFixed<L, G> rounded_within(LaneSum<L, F> x, std::int32_t limit) {
    if constexpr (requires { L::all_within(x.raw, 0); })
        if (L::all_within(x.raw, power_within<L>(std::int64_t{limit} << (F - G)))) [[likely]]
            return rounded<G>(x);
    const typename L::V most =
        L::splat((std::int64_t{limit} << (F - G)) + (std::int64_t{1} << (F - G - 1)) - 1);
    const typename L::V least = L::splat(-(std::int64_t{limit} << (F - G)));
    const typename L::V high = L::select(L::greater64(x.raw, most), most, x.raw);
    return rounded<G>(LaneSum<L, F>{L::select(L::greater64(least, high), least, high)});
}
template <class L, int F> LaneFixed<L, F> clamp(LaneFixed<L, F> x, LaneFixed<L, F> limit) {
    return min(max(x, -limit), limit);
}
/// Clamps to [-limit, limit].
template <class L, int F> LaneSum<L, F> clamp(LaneSum<L, F> x, std::int64_t limit) {
    if constexpr (requires { L::all_within(x.raw, 0); })
        if (L::all_within(x.raw, power_within<L>(limit))) [[likely]]
            return x;
    const typename L::V most = L::splat(limit), least = L::splat(-limit);
    const typename L::V high = L::select(L::greater64(x.raw, most), most, x.raw);
    return {L::select(L::greater64(least, high), least, high)};
}
/// floor(x) with G fraction bits, and floor(x + 1/2).
template <int G, class L, int F> LaneSum<L, G> floor_to(LaneSum<L, F> x) {
    static_assert(F > G);
    return {L::template shift_right_signed<F - G>(x.raw)};
}
template <int G, class L, int F> LaneSum<L, G> round_to(LaneSum<L, F> x) {
    static_assert(F > G);
    return floor_to<G>(x + LaneSum<L, F>::splat(std::int64_t{1} << (F - G - 1)));
}

} // namespace lockstone::solve
