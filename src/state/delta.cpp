// Delta images. README.md beside this file specifies the format.
#include "base/assert.h"
#include "base/bytes.h"
#include "lockstone/state.h"
#include "state/envelope.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

namespace lockstone {

namespace {

using base::hex;
using base::join;
using Bytes = std::span<const std::byte>;

constexpr std::uint32_t no_row = 0xffffffffu;
/// By row of a table: the row of the base against which it is encoded; `no_row`: against zeros.
using RowMap = std::vector<std::uint32_t>;

Bytes row_of(Bytes rows, std::uint32_t row, std::uint32_t row_size) {
    return rows.subspan(std::size_t{row} * row_size, row_size);
}

/// The rows of `rows` that have no pair yet, by their bytes and then by number.
std::vector<std::uint32_t> unpaired(Bytes rows, std::uint32_t row_size, const std::vector<bool>& paired) {
    std::vector<std::uint32_t> list;
    for (std::uint32_t row = 0; row < paired.size(); ++row)
        if (!paired[row]) list.push_back(row);
    std::sort(list.begin(), list.end(), [&](std::uint32_t a, std::uint32_t b) {
        const int order =
            std::memcmp(row_of(rows, a, row_size).data(), row_of(rows, b, row_size).data(), row_size);
        return order != 0 ? order < 0 : a < b;
    });
    return list;
}

/// Finds which row of the base became which row now, from the first column of the table, which holds ids and keys:
/// rows move when other objects are created or destroyed, fall asleep or wake. Rows with equal bytes are the same
/// row; a row without an equal one is taken to have kept its place. The order of memcmp depends on the host's byte
/// order, the pairs do not.
RowMap match_rows(Bytes before, Bytes now, std::uint32_t row_size) {
    const std::uint32_t rows_before = static_cast<std::uint32_t>(before.size() / row_size),
                        rows_now = static_cast<std::uint32_t>(now.size() / row_size);
    RowMap map(rows_now, no_row);
    std::vector<bool> paired_before(rows_before), paired_now(rows_now);
    const std::uint32_t both = std::min(rows_before, rows_now);
    for (std::uint32_t row = 0; row < both; ++row) {
        map[row] = row;
        paired_before[row] = paired_now[row] =
            std::ranges::equal(row_of(before, row, row_size), row_of(now, row, row_size));
    }
    const std::vector<std::uint32_t> gone = unpaired(before, row_size, paired_before),
                                     come = unpaired(now, row_size, paired_now);
    std::size_t at = 0;
    for (const std::uint32_t row : come) {
        int order = 1;
        while (at < gone.size() && (order = std::memcmp(row_of(before, gone[at], row_size).data(),
                                                        row_of(now, row, row_size).data(), row_size)) < 0)
            ++at;
        if (at < gone.size() && order == 0) map[row] = gone[at++];
    }
    return map;
}

/// Writes the map as runs of rows that followed each other in the base, or that are new: the length, then 0 for new
/// rows or 1 + the first row.
void append_map(const RowMap& map, base::ByteWriter& out) {
    for (std::size_t first = 0, end; first < map.size(); first = end) {
        end = first + 1;
        while (
            end < map.size() &&
            (map[first] == no_row ? map[end] == no_row : map[end] != no_row && map[end] == map[end - 1] + 1))
            ++end;
        out.varint(end - first);
        out.varint(map[first] == no_row ? 0 : std::uint64_t{map[first]} + 1);
    }
}

RowMap read_map(base::ByteReader& in, std::uint32_t rows_now, std::uint32_t rows_before,
                std::string_view table) {
    RowMap map;
    while (in.ok() && map.size() < rows_now) {
        const std::size_t at = in.offset();
        const std::uint64_t length = in.varint("length of a run of rows"),
                            from = in.varint("row of the base");
        if (!in.ok()) break;
        if (length == 0 || length > rows_now - map.size()) {
            in.fail_at(at, join("table '", table, "': a run of ", length, " rows where ",
                                rows_now - map.size(), " remain"));
        } else if (from != 0 && (from > rows_before || length > rows_before - (from - 1))) {
            in.fail_at(at, join("table '", table, "': ", length, " rows from row ", from - 1,
                                " of the base, which has ", rows_before));
        } else {
            const std::size_t first = map.size();
            map.resize(first + static_cast<std::size_t>(length), no_row);
            if (from != 0)
                std::iota(map.begin() + static_cast<std::ptrdiff_t>(first), map.end(),
                          static_cast<std::uint32_t>(from - 1));
        }
    }
    return map;
}

std::uint64_t load(const std::byte* from, unsigned size) {
    const auto as = [from]<class N>(N value) {
        std::memcpy(&value, from, sizeof value);
        return std::uint64_t{value};
    };
    return size == 1   ? as(std::uint8_t{})
           : size == 2 ? as(std::uint16_t{})
           : size == 4 ? as(std::uint32_t{})
                       : as(std::uint64_t{});
}
void store(std::uint64_t value, unsigned size, std::byte* to) {
    const auto as = [to]<class N>(N narrow) { std::memcpy(to, &narrow, sizeof narrow); };
    size == 1   ? as(static_cast<std::uint8_t>(value))
    : size == 2 ? as(static_cast<std::uint16_t>(value))
    : size == 4 ? as(static_cast<std::uint32_t>(value))
                : as(value);
}

/// The difference of two fields of `size` bytes, modulo 2^(8 size), with its sign in the lowest bit: near numbers,
/// signed or not, leave the high bytes zero. Only the low 8 size bits of the result are valid.
std::uint64_t fold(std::uint64_t before, std::uint64_t now, unsigned size) {
    const std::uint64_t difference = now - before, sign = difference >> (8 * size - 1) & 1u;
    return difference << 1 ^ (std::uint64_t{0} - sign);
}
std::uint64_t unfold(std::uint64_t before, std::uint64_t folded, unsigned size) {
    const std::uint64_t mask = ~std::uint64_t{0} >> (64 - 8 * size), bits = folded & mask;
    return before + (bits >> 1 ^ (std::uint64_t{0} - (bits & 1u)));
}

/// Writes runs of zeros and of other bytes in turn: the number of zeros, the number of other bytes, and these bytes.
void append_sparse(Bytes bytes, base::ByteWriter& out) {
    // The shortest run of zeros between other bytes that is written as zeros: its two numbers cost two bytes.
    constexpr std::size_t worth = 3;
    const auto zeros_at = [&](std::size_t at) {
        std::size_t end = at;
        while (end < bytes.size() && bytes[end] == std::byte{}) ++end;
        return end - at;
    };
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t zeros = zeros_at(at);
        out.varint(zeros);
        at += zeros;
        if (at == bytes.size()) return;
        std::size_t end = at;
        while (end < bytes.size()) {
            const std::size_t gap = zeros_at(end);
            if (gap >= worth || end + gap == bytes.size()) break;
            end += gap + 1;
        }
        out.varint(end - at);
        out.bytes(bytes.subspan(at, end - at));
        at = end;
    }
}

/// `into` must be zero.
void read_sparse(base::ByteReader& in, std::span<std::byte> into) {
    for (std::size_t at = 0; at < into.size() && in.ok();) {
        const std::size_t place = in.offset();
        const std::uint64_t zeros = in.varint("number of zeros");
        if (zeros > into.size() - at)
            return in.fail_at(place, join(zeros, " zeros where ", into.size() - at, " bytes remain"));
        at += static_cast<std::size_t>(zeros);
        if (at == into.size()) return;
        const std::uint64_t others = in.varint("number of bytes");
        if (others == 0 || others > into.size() - at)
            return in.fail_at(place, join(others, " bytes where ", into.size() - at, " remain"));
        const Bytes from = in.bytes(others, "changed bytes");
        if (!in.ok()) return;
        std::memcpy(into.data() + at, from.data(), from.size());
        at += from.size();
    }
}

/// Encodes and decodes one column against the base, whose rows are `before`.
struct ColumnDelta {
    const ColumnInfo& column;
    const RowMap& map;
    Bytes before;

    /// The row of the base, or zeros.
    Bytes base_row(std::uint32_t row, Bytes zeros) const {
        return map[row] == no_row ? zeros : row_of(before, map[row], column.row_size);
    }
    std::uint32_t rows() const { return static_cast<std::uint32_t>(map.size()); }

    void append(Bytes now, base::ByteWriter& out) const {
        const std::vector<std::byte> zeros(column.row_size);
        std::vector<std::uint32_t> changed;
        for (std::uint32_t row = 0; row < rows();) {
            const auto run = [&](bool differs) {
                const std::uint32_t first = row;
                while (row < rows() &&
                       std::ranges::equal(base_row(row, zeros), row_of(now, row, column.row_size)) != differs)
                    ++row;
                out.varint(row - first);
                return first;
            };
            run(false);
            if (row == rows()) break;
            for (std::uint32_t first = run(true); first < row; ++first) changed.push_back(first);
        }
        std::vector<std::byte> planes(changed.size() * column.row_size);
        for (std::size_t i = 0; i < changed.size(); ++i) {
            const Bytes from = base_row(changed[i], zeros), to = row_of(now, changed[i], column.row_size);
            for (const LeafInfo& leaf : column.leaves) {
                const std::uint64_t folded = fold(load(from.data() + leaf.offset, leaf.size),
                                                  load(to.data() + leaf.offset, leaf.size), leaf.size);
                for (unsigned b = 0; b < leaf.size; ++b)
                    planes[(leaf.offset + b) * changed.size() + i] =
                        static_cast<std::byte>(static_cast<std::uint8_t>(folded >> (8 * b)));
            }
        }
        append_sparse(planes, out);
    }

    /// `now` already has the size of the table's rows.
    void read(base::ByteReader& in, std::span<std::byte> now) const {
        const std::vector<std::byte> zeros(column.row_size);
        for (std::uint32_t row = 0; row < rows(); ++row)
            std::ranges::copy(base_row(row, zeros),
                              now.begin() + static_cast<std::ptrdiff_t>(std::size_t{row} * column.row_size));
        const std::vector<std::uint32_t> changed = read_changed(in);
        if (!in.ok()) return;
        std::vector<std::byte> planes(changed.size() * column.row_size);
        read_sparse(in, planes);
        for (std::size_t i = 0; i < changed.size(); ++i)
            for (const LeafInfo& leaf : column.leaves) {
                std::byte* const at = now.data() + std::size_t{changed[i]} * column.row_size + leaf.offset;
                std::uint64_t folded = 0;
                for (unsigned b = 0; b < leaf.size; ++b)
                    folded |= std::to_integer<std::uint64_t>(planes[(leaf.offset + b) * changed.size() + i])
                              << (8 * b);
                store(unfold(load(at, leaf.size), folded, leaf.size), leaf.size, at);
            }
    }

    std::vector<std::uint32_t> read_changed(base::ByteReader& in) const {
        std::vector<std::uint32_t> changed;
        std::uint32_t row = 0;
        for (bool differs = false; row < rows() && in.ok(); differs = !differs) {
            const std::size_t at = in.offset();
            const std::uint64_t length = in.varint("number of rows");
            if (length > rows() - row || (differs && length == 0)) {
                in.fail_at(at, join("column '", column.name, "': ", length, " rows where ", rows() - row,
                                    " remain"));
                return {};
            }
            for (const std::uint32_t end = row + static_cast<std::uint32_t>(length); row < end; ++row)
                if (differs) changed.push_back(row);
        }
        return changed;
    }
};

/// For each table, the column by which its rows are matched; null for a table without columns.
std::vector<const ColumnInfo*> first_columns(const StateLayout& layout) {
    std::vector<const ColumnInfo*> first(layout.tables().size(), nullptr);
    for (const ColumnInfo& column : layout.columns())
        if (first[column.table] == nullptr) first[column.table] = &column;
    return first;
}

} // namespace

std::vector<std::byte> State::save_delta(const State& base) const {
    const StateLayout& layout = *shared_layout;
    LOCKSTONE_ASSERT(layout.schema_hash() == base.layout().schema_hash(), "a base of another schema");
    std::vector<std::byte> delta;
    begin_envelope(delta_envelope, delta);
    base::ByteWriter out(delta);
    out.u64(layout.schema_hash());
    out.u64(base.hash());
    out.u64(hash());
    std::vector<RowMap> maps;
    const std::vector<const ColumnInfo*> first = first_columns(layout);
    for (std::uint32_t table = 0; table < layout.tables().size(); ++table) {
        out.varint(count({table}));
        maps.emplace_back();
        if (first[table] == nullptr) continue;
        const auto index = static_cast<std::uint32_t>(first[table] - layout.columns().data());
        maps.back() = match_rows(base.bytes(index), bytes(index), first[table]->row_size);
        append_map(maps.back(), out);
    }
    for (std::uint32_t index = 0; index < layout.columns().size(); ++index) {
        const ColumnInfo& column = layout.columns()[index];
        ColumnDelta{column, maps[column.table], base.bytes(index)}.append(bytes(index), out);
    }
    seal_envelope(delta);
    return delta;
}

namespace {

/// Reads the fields before the tables, and fails if `base` is not the base of the delta. Returns the hash of the
/// result.
std::uint64_t read_delta_head(base::ByteReader& in, const State& base) {
    in.bytes(envelope_head_bytes, "header");
    const auto agree = [&](std::string_view what, std::uint64_t found, std::string_view where) {
        const std::size_t at = in.offset();
        const std::uint64_t wanted = in.u64(what);
        if (in.ok() && wanted != found)
            in.fail_at(at, join(what, " is ", hex(wanted), " in the delta, ", hex(found), where));
    };
    agree("schema hash", base.layout().schema_hash(), " in this build: the fields of some column differ");
    agree("hash of the base", base.hash(), " here: it is the difference to another state");
    return in.u64("hash of the result");
}

/// Reads the row counts and row maps, and resizes the tables of `next`.
std::vector<RowMap> read_tables(base::ByteReader& in, const State& base, State& next) {
    const StateLayout& layout = base.layout();
    const std::vector<const ColumnInfo*> first = first_columns(layout);
    std::vector<RowMap> maps;
    for (std::uint32_t table = 0; table < layout.tables().size() && in.ok(); ++table) {
        const std::string& name = layout.tables()[table].name;
        const std::size_t at = in.offset();
        const std::uint64_t rows = in.varint("row count");
        if (in.ok() && rows > next.rows_max({table}))
            in.fail_at(at, join("table '", name, "' has ", rows, " rows in the delta, but capacity for ",
                                next.rows_max({table})));
        if (!in.ok()) break;
        next.resize({table}, static_cast<std::uint32_t>(rows));
        maps.push_back(first[table] == nullptr
                           ? RowMap{}
                           : read_map(in, next.count({table}), base.count({table}), name));
    }
    return maps;
}

} // namespace

Status State::apply_delta(std::span<const std::byte> delta) {
    base::ByteReader envelope(delta, "state delta");
    check_envelope(delta_envelope, envelope, delta);
    if (!envelope.ok()) return envelope.error();

    base::ByteReader in(delta.first(delta.size() - envelope_checksum_bytes), "state delta");
    const std::uint64_t wanted = read_delta_head(in, *this);
    if (!in.ok()) return in.error();
    State next(shared_layout);
    const std::vector<RowMap> maps = read_tables(in, *this, next);
    for (std::uint32_t index = 0; index < shared_layout->columns().size() && in.ok(); ++index) {
        const ColumnInfo& column = shared_layout->columns()[index];
        ColumnDelta{column, maps[column.table], bytes(index)}.read(in, next.edit_bytes(index));
    }
    if (in.ok()) in.expect_end();
    if (in.ok() && next.hash() != wanted)
        in.fail(join("hash of the result is ", hex(wanted), " in the delta, ", hex(next.hash()), " here"));
    if (!in.ok()) return in.error();
    *this = std::move(next);
    return {};
}

} // namespace lockstone
