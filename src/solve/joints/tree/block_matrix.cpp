#include "solve/joints/tree/block_matrix.h"

namespace lockstone::solve {

namespace {

constexpr std::int64_t block_pivot_min = std::int64_t{1} << (block_bits - 24);
constexpr int coupling_bits = 28; ///< fraction bits of B

/// a / 2^drop, rounded
std::int64_t dropped(std::int64_t a, int drop) {
    return drop == 0 ? a : drop > 62 ? 0 : shift_right_rounded(a, drop);
}

int wide_bit_length(Wide w) {
    if (w.is_negative()) return 0;
    const auto high = static_cast<std::uint64_t>(w.high_bits());
    return high != 0 ? 64 + bit_length(high) : bit_length(w.low_bits());
}

/// 2^96 / d for d in [2^36, 2^60]: 1 / D with block_inverse_bits
std::int64_t block_pivot_inverse(std::int64_t d) {
    return std::min(divide_shifted(std::int64_t{1} << 48, d, 48), block_value_max);
}

void lower_exponent(SymmetricBlock& a, int n, int exponent) {
    const int drop = exponent - a.exponent;
    if (drop == 0) return;
    for (int i = 0; i < block_index(n, 0); ++i) a.m[i] = dropped(a.m[i], drop);
    a.exponent = exponent;
}

/// Raises the exponent if a diagonal entry has reached 2^60. Diagonal entries of a sum are up to 2^61.
void normalise(SymmetricBlock& a, int n) {
    std::int64_t most = 0;
    for (int i = 0; i < n; ++i) most = std::max(most, a.m[block_index(i, i)]);
    if (most >= std::int64_t{1} << block_bits) lower_exponent(a, n, a.exponent + 1);
}

/// x minus a sum of products l y: five products of values and one of 2^105.
struct Remainder {
    Wide sum;
    explicit Remainder(std::int64_t x) : sum(block_product(x, std::int64_t{1} << block_factor_bits)) {}
    void subtract(std::int64_t l, std::int64_t y) { sum = sum - block_product(l, y); }
    std::int64_t value() const { return block_narrow<block_factor_bits>(sum); }
};

/// a b / 2^Shift
template <int Shift> std::int64_t product(std::int64_t a, std::int64_t b) {
    return block_narrow<Shift>(block_product(a, b));
}

/// Computes c = L D by columns. Returns true if every pivot is large enough, or if Raise is set.
template <int N, bool Raise> bool factorise_rows(const SymmetricBlock& a, BlockFactor& out) {
    std::int64_t c[6][6];
    bool good = true;
    each<N>([&](auto j) {
        each<N - j>([&](auto below) {
            constexpr int i = j + below;
            Remainder rest(a.m[block_index(i, j)]);
            each<j>([&](auto k) { rest.subtract(out.l[block_index(j - 1, k)], c[i][k]); });
            c[i][j] = rest.value();
        });
        std::int64_t pivot = c[j][j];
        if (pivot < block_pivot_min) {
            good = false;
            pivot = a.m[block_index(j, j)] == 0 ? 0 : block_pivot_min;
        }
        out.inverse[j] = pivot == 0 ? 0 : block_pivot_inverse(pivot);
        constexpr int drop = block_bits + block_inverse_bits - block_factor_bits;
        each<N - j - 1>([&](auto below) { // 61 bits times 60
            constexpr int i = j + 1 + below;
            out.l[block_index(i - 1, j)] = product<drop>(c[i][j], out.inverse[j]);
        });
    });
    return Raise || good;
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

/// B^T A^-1 B for A with N rows and B with M columns. B is J with N rows of six entries, or its transpose.
template <int N, int M, bool Transposed>
void condense(const BlockFactor& a, int exponent, const std::int32_t (*j)[6], std::int64_t (*z)[6],
              SymmetricBlock& out) {
    std::int64_t x[6][6];
    for (int c = 0; c < M; ++c)
        each<N>([&](auto i) {
            const std::int64_t b = Transposed ? j[c][i] : j[i][c];
            Remainder rest(b * (std::int64_t{1} << (block_arm_bits - coupling_bits)));
            each<i>([&](auto k) { rest.subtract(a.l[block_index(i - 1, k)], x[c][k]); });
            x[c][i] = rest.value();
            z[c][i] = product<block_arm_bits + block_inverse_bits - block_column_bits>(x[c][i], a.inverse[i]);
        });
    Wide sum[21];
    int top = 0;
    for (int r = 0; r < M; ++r)
        for (int c = 0; c <= r; ++c) { // six products of values
            Wide s = block_product(x[r][0], z[c][0]);
            each<N - 1>([&](auto i) { s = s + block_product(x[r][i + 1], z[c][i + 1]); });
            sum[block_index(r, c)] = s;
            if (r == c) top = std::max(top, wide_bit_length(s));
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
    const int length = bit_length(magnitude(v));
    if (length == 0) return {0, 0};
    const std::int64_t m = length <= block_bits ? v << (block_bits - length) : v >> (length - block_bits);
    return {m, length - fraction_bits};
}

std::int64_t block_shift_far(Wide sum, int shift) {
    if (shift < 0) {
        const std::int64_t v = std::clamp(narrow_rounded(sum, 0), -block_value_max, block_value_max);
        return std::clamp(shift_left_saturated(v, std::min(-shift, 63)), -block_value_max, block_value_max);
    }
    return std::clamp(narrow_rounded(sum, std::min(shift, 126)), -block_value_max, block_value_max);
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

void condense_rows(const BlockFactor& a, int exponent, const std::int32_t (*j)[6], int rows,
                   SymmetricBlock& out) {
    std::int64_t z[6][6];
    switch (rows) {
    case 1:
        return condense<1, 6, false>(a, exponent, j, z, out);
    case 2:
        return condense<2, 6, false>(a, exponent, j, z, out);
    case 3:
        return condense<3, 6, false>(a, exponent, j, z, out);
    case 4:
        return condense<4, 6, false>(a, exponent, j, z, out);
    case 5:
        return condense<5, 6, false>(a, exponent, j, z, out);
    default:
        return condense<6, 6, false>(a, exponent, j, z, out);
    }
}

void condense_columns(const BlockFactor& a, int exponent, const std::int32_t (*j)[6], int rows,
                      std::int64_t (*z)[6], SymmetricBlock& out) {
    switch (rows) {
    case 1:
        return condense<6, 1, true>(a, exponent, j, z, out);
    case 2:
        return condense<6, 2, true>(a, exponent, j, z, out);
    case 3:
        return condense<6, 3, true>(a, exponent, j, z, out);
    case 4:
        return condense<6, 4, true>(a, exponent, j, z, out);
    case 5:
        return condense<6, 5, true>(a, exponent, j, z, out);
    default:
        return condense<6, 6, true>(a, exponent, j, z, out);
    }
}

namespace {

template <int N> void lower(const BlockFactor& a, std::int64_t* x) {
    each<N>([&](auto i) {
        Remainder rest(x[i]);
        each<i>([&](auto k) { rest.subtract(a.l[block_index(i - 1, k)], x[k]); });
        x[i] = rest.value();
    });
}

template <int N> void upper(const BlockFactor& a, std::int64_t* x) {
    each<N>([&](auto done) {
        constexpr int i = N - 1 - done;
        Remainder rest(x[i]);
        each<done>([&](auto further) {
            constexpr int k = i + 1 + further;
            rest.subtract(a.l[block_index(k - 1, i)], x[k]);
        });
        x[i] = rest.value();
    });
}

template <int N> void solve_rows(const BlockFactor& a, std::int64_t* x) {
    lower<N>(a, x);
    for (int i = 0; i < N; ++i) x[i] = product<block_inverse_bits>(x[i], a.inverse[i]);
    upper<N>(a, x);
}

} // namespace

void solve(const BlockFactor& a, int n, std::int64_t* x) {
    switch (n) {
    case 1:
        return solve_rows<1>(a, x);
    case 2:
        return solve_rows<2>(a, x);
    case 3:
        return solve_rows<3>(a, x);
    case 4:
        return solve_rows<4>(a, x);
    case 5:
        return solve_rows<5>(a, x);
    default:
        return solve_rows<6>(a, x);
    }
}
void solve_lower(const BlockFactor& a, std::int64_t* x) { lower<6>(a, x); }
void solve_upper(const BlockFactor& a, std::int64_t* x) { upper<6>(a, x); }

} // namespace lockstone::solve
