#include "solve/joints/axis_with_point.h"

namespace lockstone::solve {

namespace {

/// C and the row entries must be below 4, and A^-1 C below 8; otherwise the point is left out.
constexpr std::int64_t entry_limit = std::int64_t{1} << 30, answer_limit = std::int64_t{1} << 31;

template <std::size_t Count> bool are_below(const std::int64_t (&x)[Count], std::int64_t limit) {
    std::uint64_t any = 0;
    for (const std::int64_t one : x) any |= magnitude(one);
    return any < static_cast<std::uint64_t>(limit);
}

/// x minus `answer` times the entries of the three point rows. Returns false if the result does not fit.
bool take(const std::int64_t (&answer)[3], const std::int32_t (&first)[6], const std::int32_t (&second)[6],
          const std::int32_t (&third)[6], std::int32_t (&x)[6]) {
    std::int64_t rest[6];
    for (int i = 0; i < 6; ++i) // 31 bits times 30, three times
        rest[i] = x[i] - shift_right_rounded(
                             answer[0] * first[i] + answer[1] * second[i] + answer[2] * third[i], row_bits);
    if (!are_below(rest, entry_limit)) return false;
    for (int i = 0; i < 6; ++i) x[i] = static_cast<std::int32_t>(rest[i]);
    return true;
}

} // namespace

JointPoint point_of(JointTick& tick, const JointWork& work, const SolverBodies& bodies) {
    JointPoint point{nullptr, &work.shares, &bodies.body[work.a.body], &bodies.body[work.b.body]};
    for (std::uint32_t i = 0; i < work.block_count; ++i)
        if (JointBlock& block = tick.blocks[work.first_block + i]; block.kind[0] == RowKind::point_x)
            point.block = &block;
    return point;
}

AxisWithPoint::AxisWithPoint(JointPoint of, const Row& axis, const Inverse& alone)
    : point(of), row(axis), along(alone) {
    if (!point.exists()) return;
    if (!find(axis)) point = {}, row = axis;
}

bool AxisWithPoint::find(const Row& axis) {
    const Row* const rows = point.block->row;
    std::int64_t c[3];
    for (int r = 0; r < 3; ++r)
        c[r] = shift_right_rounded(turning_product(rows[r], axis), mobility_bits - row_bits);
    if (!are_below(c, entry_limit)) return false;
    const Inverse& inverse = point.block->inverse;
    for (int r = 0; r < 3; ++r) {
        std::int64_t sum = 0; // 30 bits times 30, three times
        for (int s = 0; s < 3; ++s) sum += inverse.m[inverse_index[r][s]] * c[s];
        answer[r] = shifted(sum, inverse.shift);
    }
    if (!are_below(answer, answer_limit) || !take(answer, rows[0].ja, rows[1].ja, rows[2].ja, row.ja) ||
        !take(answer, rows[0].jb, rows[1].jb, rows[2].jb, row.jb))
        return false;
    set_responses(row, *point.shares, *point.a, *point.b);
    along = invert_mobility(std::max(mobility(row), turning_product(axis, axis) >> least_part_bits));
    return true;
}

std::uint64_t AxisWithPoint::push(std::int32_t change, Motion& m) const {
    std::uint32_t any = solve::push(&row, &change, 1, m);
    std::uint64_t clamped = 0;
    for (int r = 0; r < 3 && point.exists(); ++r) {
        std::int32_t& p = point.block->impulse[r];
        const std::int64_t wanted = p - shift_right_rounded(answer[r] * change, row_bits),
                           next = std::clamp<std::int64_t>(wanted, -joint_impulse_max, joint_impulse_max);
        clamped += next != wanted ? 1u : 0u;
        any |= static_cast<std::uint32_t>(magnitude(next - p));
        p = static_cast<std::int32_t>(next);
    }
    if (any >= static_cast<std::uint32_t>(small_impulse)) clamp_motion(m);
    return clamped;
}

} // namespace lockstone::solve
