// N integers at a time: the solver is written once over these, and its bits are the same for every N.
#pragma once

#include <cstdint>

namespace lockstone::dynamics {

template <unsigned N> struct Int32 { std::int32_t lane[N]; };
template <unsigned N> struct Int64 { std::int64_t lane[N]; };

// clang-format off
/// Sums wrap; the bounds of the formats keep them from it.
template <unsigned N> inline Int64<N> operator+(Int64<N> a, Int64<N> b) {
    Int64<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = static_cast<std::int64_t>(static_cast<std::uint64_t>(a.lane[i]) + static_cast<std::uint64_t>(b.lane[i]));
    return r;
}
template <unsigned N> inline Int64<N> operator-(Int64<N> a, Int64<N> b) {
    Int64<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = static_cast<std::int64_t>(static_cast<std::uint64_t>(a.lane[i]) - static_cast<std::uint64_t>(b.lane[i]));
    return r;
}
template <unsigned N> inline Int64<N> operator*(Int32<N> a, Int32<N> b) { ///< whole product
    Int64<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = std::int64_t{a.lane[i]} * b.lane[i];
    return r;
}
template <unsigned N> inline Int32<N> operator+(Int32<N> a, Int32<N> b) {
    Int32<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = static_cast<std::int32_t>(static_cast<std::uint32_t>(a.lane[i]) + static_cast<std::uint32_t>(b.lane[i]));
    return r;
}
template <unsigned N> inline Int32<N> operator-(Int32<N> a, Int32<N> b) {
    Int32<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = static_cast<std::int32_t>(static_cast<std::uint32_t>(a.lane[i]) - static_cast<std::uint32_t>(b.lane[i]));
    return r;
}
template <unsigned N> inline Int32<N> max(Int32<N> a, Int32<N> b) {
    Int32<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = a.lane[i] < b.lane[i] ? b.lane[i] : a.lane[i];
    return r;
}
template <unsigned N> inline Int32<N> min(Int32<N> a, Int32<N> b) {
    Int32<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = b.lane[i] < a.lane[i] ? b.lane[i] : a.lane[i];
    return r;
}
/// a where the condition is positive, else b.
template <unsigned N> inline Int32<N> where_positive(Int32<N> condition, Int32<N> a, Int32<N> b) {
    Int32<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = condition.lane[i] > 0 ? a.lane[i] : b.lane[i];
    return r;
}
/// floor(x / 2^Shift + 1/2), its low 32 bits.
template <int Shift, unsigned N> inline Int32<N> rounded(Int64<N> x) {
    Int32<N> r;
    constexpr std::uint64_t half = std::uint64_t{1} << (Shift - 1);
    for (unsigned i = 0; i < N; ++i) r.lane[i] = static_cast<std::int32_t>((static_cast<std::uint64_t>(x.lane[i]) + half) >> Shift);
    return r;
}
template <unsigned N> inline Int32<N> splat(std::int32_t x) {
    Int32<N> r;
    for (unsigned i = 0; i < N; ++i) r.lane[i] = x;
    return r;
}
// clang-format on

} // namespace lockstone::dynamics
