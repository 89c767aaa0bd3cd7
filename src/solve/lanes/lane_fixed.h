// Numbers in lanes that carry their fraction bits in their type: what does not fit does not compile.
#pragma once

#include <cstdint>

namespace lockstone::solve {

/// One 32-bit number with F fraction bits in each lane of the instruction set L.
template <class L, int F> struct LaneFixed {
    typename L::V raw;

    static LaneFixed load(const std::int32_t* p) { return {L::load32(p)}; }
    static LaneFixed splat(std::int32_t x) { return {L::splat(x)}; }
    void store(std::int32_t* p) const { L::store32(p, raw); }
};

/// A sum of products with F fraction bits, 64 bits a lane.
template <class L, int F> struct LaneSum {
    typename L::V raw;

    static LaneSum splat(std::int64_t x) { return {L::splat(x)}; }
    static LaneSum load(const std::int32_t* p) { return {L::load32(p)}; }
    static LaneSum load64(const std::int64_t* p) { return {L::load64(p)}; }
    void store64(std::int64_t* p) const { L::store64(p, raw); }
};

/// All ones in the lanes where something holds.
template <class L> struct LaneMask {
    typename L::V raw;

    static LaneMask none() { return {L::splat(0)}; }
    static LaneMask all() { return {L::splat(-1)}; }
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
template <class L, int F> LaneFixed<L, F> operator-(LaneFixed<L, F> a) { return {L::sub(L::splat(0), a.raw)}; }
template <class L, int F> LaneFixed<L, F> max(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::max32(a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> min(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::min32(a.raw, b.raw)}; }
template <class L, int F> LaneMask<L> operator>(LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::greater32(a.raw, b.raw)}; }
template <class L, int F> LaneMask<L> operator>(LaneSum<L, F> a, LaneSum<L, F> b) { return {L::greater64(a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> select(LaneMask<L> mask, LaneFixed<L, F> a, LaneFixed<L, F> b) { return {L::select(mask.raw, a.raw, b.raw)}; }
template <class L, int F> LaneFixed<L, F> operator&(LaneFixed<L, F> a, LaneMask<L> mask) { return {L::both(a.raw, mask.raw)}; }
template <class L, int F> LaneSum<L, F> operator&(LaneSum<L, F> a, LaneMask<L> mask) { return {L::both(a.raw, mask.raw)}; }
template <class L, int F> LaneSum<L, F> select(LaneMask<L> mask, LaneSum<L, F> a, LaneSum<L, F> b) { return {L::select(mask.raw, a.raw, b.raw)}; }
template <class L, int F> LaneSum<L, F> operator-(LaneSum<L, F> a) { return {L::sub(L::splat(0), a.raw)}; }
/// Of whole lanes: right where the product fits into 64 bits.
template <class L, int F, int G> LaneSum<L, F + G> operator*(LaneSum<L, F> a, LaneSum<L, G> b) { return {L::mul64(a.raw, b.raw)}; }
/// Right where the value fits into 32 bits.
template <class L, int F> LaneFixed<L, F> low(LaneSum<L, F> x) { return {x.raw}; }
template <class L, int F> LaneSum<L, F> wide(LaneFixed<L, F> x) { return {L::mul(x.raw, L::splat(1))}; }
// clang-format on

/// floor(x + 1/2) with G fraction bits: right where the result fits into 32 bits.
template <int G, class L, int F> LaneFixed<L, G> rounded(LaneSum<L, F> x) {
    static_assert(F > G && F - G <= 32, "the shift keeps the low 32 bits of the result");
    return {L::template shift_right<F - G>(L::add(x.raw, L::splat(std::int64_t{1} << (F - G - 1))))};
}
/// The same, shortened to `limit` of either sign.
template <int G, class L, int F> LaneFixed<L, G> rounded_within(LaneSum<L, F> x, std::int32_t limit) {
    const typename L::V most =
        L::splat((std::int64_t{limit} << (F - G)) + (std::int64_t{1} << (F - G - 1)) - 1);
    const typename L::V least = L::splat(-(std::int64_t{limit} << (F - G)));
    const typename L::V high = L::select(L::greater64(x.raw, most), most, x.raw);
    return rounded<G>(LaneSum<L, F>{L::select(L::greater64(least, high), least, high)});
}
template <class L, int F> LaneFixed<L, F> clamp(LaneFixed<L, F> x, LaneFixed<L, F> limit) {
    return min(max(x, -limit), limit);
}
/// Within `limit` of either sign.
template <class L, int F> LaneSum<L, F> clamp(LaneSum<L, F> x, std::int64_t limit) {
    const LaneSum<L, F> most = LaneSum<L, F>::splat(limit), least = LaneSum<L, F>::splat(-limit);
    const LaneSum<L, F> high = select(x > most, most, x);
    return select(least > high, least, high);
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
