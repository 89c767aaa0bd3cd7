#include "dynamics/block_matrix.h"

namespace lockstone::dynamics {

namespace {

constexpr std::int64_t pivot_min = std::int64_t{1} << (block_bits - 24);
constexpr std::int64_t factor_max = std::int64_t{1} << (block_factor_bits + 13);
constexpr std::int64_t arm_max = std::int64_t{1} << (block_arm_bits + 17);
constexpr int row_bits = 28; ///< of B

/// a / 2^drop, rounded.
std::int64_t dropped(std::int64_t a, int drop) {
    return drop == 0 ? a : drop > 62 ? 0 : shift_right_rounded(a, drop);
}

int bit_length(Wide w) {
    if (w.is_negative()) return 0;
    const auto high = static_cast<std::uint64_t>(w.high_bits());
    return high != 0 ? 64 + lockstone::bit_length(high) : lockstone::bit_length(w.low_bits());
}

/// 2^96 / d of d in [2^36, 2^60]: 1 / D with its bits.
std::int64_t pivot_inverse(std::int64_t d) {
    return std::min(divide_shifted(std::int64_t{1} << 48, d, 48), block_value_max);
}

void lower_exponent(SymmetricBlock& a, int n, int exponent) {
    const int drop = exponent - a.exponent;
    if (drop == 0) return;
    for (int i = 0; i < block_index(n, 0); ++i) a.m[i] = dropped(a.m[i], drop);
    a.exponent = exponent;
}

/// Diagonal entries of a sum are up to 2^61.
void normalise(SymmetricBlock& a, int n) {
    std::int64_t most = 0;
    for (int i = 0; i < n; ++i) most = std::max(most, a.m[block_index(i, i)]);
    if (most >= std::int64_t{1} << block_bits) lower_exponent(a, n, a.exponent + 1);
}

/// x - the sum of l y over what is known already: 2^57 times 2^61, five times.
template <int Bits> struct Remainder {
    Wide sum;
    explicit Remainder(std::int64_t x) : sum(Wide::from(x) << Bits) {}
    void subtract(std::int64_t l, std::int64_t y) { sum = sum - Wide::product(l, y); }
    std::int64_t within(std::int64_t most) const {
        return std::clamp(narrow_rounded(sum, Bits), -most, most);
    }
};

/// c = L D by columns; true when every pivot is large enough or may be raised.
template <int N, bool Raise> bool factorise_rows(const SymmetricBlock& a, BlockFactor& out) {
    std::int64_t c[6][6];
    for (int j = 0; j < N; ++j) {
        for (int i = j; i < N; ++i) {
            Remainder<block_factor_bits> rest(a.m[block_index(i, j)]);
            for (int k = 0; k < j; ++k) rest.subtract(out.l[block_index(j - 1, k)], c[i][k]);
            c[i][j] = rest.within(std::int64_t{1} << block_bits);
        }
        std::int64_t pivot = c[j][j];
        if (pivot < pivot_min) {
            if (!Raise) return false;
            pivot = a.m[block_index(j, j)] == 0 ? 0 : pivot_min;
        }
        out.inverse[j] = pivot == 0 ? 0 : pivot_inverse(pivot);
        constexpr int drop = block_bits + block_inverse_bits - block_factor_bits;
        for (int i = j + 1; i < N; ++i) // 60 bits times 60
            out.l[block_index(i - 1, j)] = std::clamp(
                narrow_rounded(Wide::product(c[i][j], out.inverse[j]), drop), -factor_max, factor_max);
    }
    return true;
}

template <bool Raise> bool factorise_any(const SymmetricBlock& a, int n, BlockFactor& out) {
    switch (n) {
    case 1:
        return factorise_rows<1, Raise>(a, out);
    case 2:
        return factorise_rows<2, Raise>(a, out);
    case 3:
        return factorise_rows<3, Raise>(a, out);
    case 4:
        return factorise_rows<4, Raise>(a, out);
    case 5:
        return factorise_rows<5, Raise>(a, out);
    default:
        return factorise_rows<6, Raise>(a, out);
    }
}

template <int N, int M>
void condense_rows(const BlockFactor& a, int exponent, const std::int32_t (*b)[6], std::int64_t (*z)[6],
                   SymmetricBlock& out) {
    std::int64_t x[6][6];
    for (int c = 0; c < M; ++c)
        for (int i = 0; i < N; ++i) {
            Remainder<block_factor_bits> rest(std::int64_t{b[c][i]} << (block_arm_bits - row_bits));
            for (int k = 0; k < i; ++k) rest.subtract(a.l[block_index(i - 1, k)], x[c][k]);
            x[c][i] = rest.within(arm_max);
            z[c][i] = block_narrow(Wide::product(x[c][i], a.inverse[i]),
                                   block_arm_bits + block_inverse_bits - block_column_bits);
        }
    Wide sum[21];
    int top = 0;
    for (int r = 0; r < M; ++r)
        for (int c = 0; c <= r; ++c) { // 2^57 times 2^61, six times
            Wide& s = sum[block_index(r, c)] = Wide::from(0);
            for (int i = 0; i < N; ++i) s = s + Wide::product(x[r][i], z[c][i]);
            if (r == c) top = std::max(top, bit_length(s));
        }
    out.zero = top == 0;
    const int drop = top - block_bits;
    out.exponent = block_bits + drop - block_arm_bits - block_column_bits - exponent;
    constexpr std::int64_t one = std::int64_t{1} << block_bits;
    for (int i = 0; i < block_index(M, 0); ++i)
        out.m[i] = out.zero ? 0 : std::clamp(block_shift(sum[i], drop), -one, one);
}

} // namespace

Scaled scaled(std::int64_t v, int fraction_bits) {
    const int length = lockstone::bit_length(magnitude(v));
    if (length == 0) return {0, 0};
    const std::int64_t m = length <= block_bits ? v << (block_bits - length) : v >> (length - block_bits);
    return {m, length - fraction_bits};
}

std::int64_t block_shift(Wide sum, int shift) {
    if (shift >= 0) return block_narrow(sum, std::min(shift, 126));
    const std::int64_t v = block_narrow(sum, 0);
    return std::clamp(shift_left_saturated(v, std::min(-shift, 63)), -block_value_max, block_value_max);
}

SymmetricBlock block_of(Scaled value, int n) {
    SymmetricBlock a{};
    a.exponent = value.exponent;
    a.zero = value.m == 0;
    for (int i = 0; i < n; ++i) a.m[block_index(i, i)] = value.m;
    return a;
}

void add(SymmetricBlock& a, const SymmetricBlock& b, int n) {
    if (b.zero) return;
    if (a.zero) {
        a = b;
        return;
    }
    const int exponent = std::max(a.exponent, b.exponent), drop = exponent - b.exponent;
    lower_exponent(a, n, exponent);
    for (int i = 0; i < block_index(n, 0); ++i) a.m[i] += dropped(b.m[i], drop);
    normalise(a, n);
}

void add_diagonal(SymmetricBlock& a, const Scaled* d, int n) {
    int exponent = 0;
    bool any = false;
    for (int i = 0; i < n; ++i) {
        if (d[i].m == 0) continue;
        exponent = any ? std::max(exponent, d[i].exponent) : d[i].exponent;
        any = true;
    }
    if (!any) return;
    if (a.zero) {
        a = {};
        a.exponent = exponent;
    }
    exponent = std::max(exponent, a.exponent);
    lower_exponent(a, n, exponent);
    for (int i = 0; i < n; ++i)
        if (d[i].m != 0) a.m[block_index(i, i)] += dropped(d[i].m, exponent - d[i].exponent);
    normalise(a, n);
}

bool factorise(const SymmetricBlock& a, int n, BlockFactor& out) { return factorise_any<false>(a, n, out); }
void factorise_raised(const SymmetricBlock& a, int n, BlockFactor& out) { factorise_any<true>(a, n, out); }

void condense(const BlockFactor& a, int exponent, int n, const std::int32_t (*b)[6], int columns,
              std::int64_t (*z)[6], SymmetricBlock& out) {
    if (n == 6) {
        switch (columns) {
        case 1:
            return condense_rows<6, 1>(a, exponent, b, z, out);
        case 2:
            return condense_rows<6, 2>(a, exponent, b, z, out);
        case 3:
            return condense_rows<6, 3>(a, exponent, b, z, out);
        case 4:
            return condense_rows<6, 4>(a, exponent, b, z, out);
        case 5:
            return condense_rows<6, 5>(a, exponent, b, z, out);
        default:
            return condense_rows<6, 6>(a, exponent, b, z, out);
        }
    }
    switch (n) {
    case 1:
        return condense_rows<1, 6>(a, exponent, b, z, out);
    case 2:
        return condense_rows<2, 6>(a, exponent, b, z, out);
    case 3:
        return condense_rows<3, 6>(a, exponent, b, z, out);
    case 4:
        return condense_rows<4, 6>(a, exponent, b, z, out);
    default:
        return condense_rows<5, 6>(a, exponent, b, z, out);
    }
}

void solve_lower(const BlockFactor& a, int n, std::int64_t* x) {
    for (int i = 1; i < n; ++i) {
        Remainder<block_factor_bits> rest(x[i]);
        for (int k = 0; k < i; ++k) rest.subtract(a.l[block_index(i - 1, k)], x[k]);
        x[i] = rest.within(block_value_max);
    }
}

void solve_diagonal(const BlockFactor& a, int n, std::int64_t* x) {
    for (int i = 0; i < n; ++i) x[i] = block_narrow(Wide::product(x[i], a.inverse[i]), block_inverse_bits);
}

void solve_upper(const BlockFactor& a, int n, std::int64_t* x) {
    for (int i = n - 2; i >= 0; --i) {
        Remainder<block_factor_bits> rest(x[i]);
        for (int k = i + 1; k < n; ++k) rest.subtract(a.l[block_index(k - 1, i)], x[k]);
        x[i] = rest.within(block_value_max);
    }
}

} // namespace lockstone::dynamics
