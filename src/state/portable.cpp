// Portable images. README.md beside this file specifies the format.
#include "base/bytes.h"
#include "lockstone/state.h"
#include "state/canonical.h"
#include "state/envelope.h"

namespace lockstone {

namespace {

using base::hex;
using base::join;

/// The contents of a valid image; the spans point into it.
struct Contents {
    std::vector<std::uint32_t> counts;
    std::vector<std::span<const std::byte>> rows; ///< by column, canonical
};

/// Records an error if two values differ.
void expect_equal(base::ByteReader& in, std::size_t at, std::string_view what, std::uint64_t found,
                  std::uint64_t wanted) {
    if (found != wanted)
        in.fail_at(at, join(what, " is ", found, " in the image, ", wanted, " in this build"));
}
void expect_equal(base::ByteReader& in, std::size_t at, std::string_view what, std::string_view found,
                  std::string_view wanted) {
    if (found != wanted)
        in.fail_at(at, join(what, " is '", found, "' in the image, '", wanted, "' in this build"));
}

std::uint32_t read_table(base::ByteReader& in, const TableInfo& table) {
    const std::size_t name_at = in.offset();
    const std::string_view name = in.text("table name");
    if (in.ok()) expect_equal(in, name_at, "table name", name, table.name);
    const std::size_t count_at = in.offset();
    const std::uint32_t count = in.u32("row count");
    if (in.ok() && count > table.rows_max)
        in.fail_at(count_at, join("table '", table.name, "' has ", count,
                                  " rows in the image, but capacity for ", table.rows_max));
    return count;
}

std::span<const std::byte> read_column(base::ByteReader& in, const ColumnInfo& column,
                                       std::span<const std::uint32_t> counts) {
    const std::size_t at = in.offset();
    const std::string_view name = in.text("column name");
    const std::uint32_t table = in.u32("column table"), group = in.u32("column group"),
                        size = in.u32("row size");
    if (!in.ok()) return {};
    expect_equal(in, at, "column name", name, column.name);
    expect_equal(in, at, join("table of column '", column.name, "'"), table, column.table);
    expect_equal(in, at, join("group of column '", column.name, "'"), group,
                 static_cast<std::uint32_t>(column.group));
    expect_equal(in, at, join("row size of column '", column.name, "'"), size, column.row_size);
    if (!in.ok()) return {};
    return in.bytes(std::uint64_t{counts[column.table]} * column.row_size,
                    join("rows of column '", name, "'"));
}

/// Reads and checks the whole image before anything is written.
Result<Contents> parse(std::span<const std::byte> image, const StateLayout& layout) {
    base::ByteReader in(image, "state image");
    check_envelope(image_envelope, in, image);
    if (!in.ok()) return in.error();

    base::ByteReader body(image.first(image.size() - envelope_checksum_bytes), "state image");
    body.bytes(envelope_head_bytes, "header");
    const std::size_t schema_at = body.offset();
    const std::uint64_t schema = body.u64("schema hash");
    const std::size_t numbers_at = body.offset();
    const std::uint32_t tables = body.u32("number of tables"), columns = body.u32("number of columns");
    if (body.ok()) expect_equal(body, numbers_at, "number of tables", tables, layout.tables().size());
    if (body.ok()) expect_equal(body, numbers_at + 4, "number of columns", columns, layout.columns().size());

    Contents contents;
    for (const TableInfo& table : layout.tables())
        if (body.ok()) contents.counts.push_back(read_table(body, table));
    for (const ColumnInfo& column : layout.columns())
        if (body.ok()) contents.rows.push_back(read_column(body, column, contents.counts));
    if (body.ok()) body.expect_end();
    // Last, as a differing name says more than two differing hashes.
    if (body.ok() && schema != layout.schema_hash())
        body.fail_at(schema_at,
                     join("schema hash is ", hex(schema), " in the image, ", hex(layout.schema_hash()),
                          " in this build: the fields of some column differ"));
    if (!body.ok()) return body.error();
    return contents;
}

} // namespace

std::vector<std::byte> State::save_portable() const {
    std::vector<std::byte> image;
    begin_envelope(image_envelope, image);
    base::ByteWriter out(image);
    out.u64(shared_layout->schema_hash());
    out.u32(static_cast<std::uint32_t>(shared_layout->tables().size()));
    out.u32(static_cast<std::uint32_t>(shared_layout->columns().size()));
    for (std::uint32_t table = 0; table < shared_layout->tables().size(); ++table) {
        out.text(shared_layout->tables()[table].name);
        out.u32(count({table}));
    }
    for (std::uint32_t index = 0; index < shared_layout->columns().size(); ++index) {
        const ColumnInfo& column = shared_layout->columns()[index];
        out.text(column.name);
        out.u32(column.table);
        out.u32(static_cast<std::uint32_t>(column.group));
        out.u32(column.row_size);
        append_canonical(bytes(index), column.leaves, image);
    }
    seal_envelope(image);
    return image;
}

Status State::restore_portable(std::span<const std::byte> image) {
    const Result<Contents> contents = parse(image, *shared_layout);
    if (!contents) return contents.error();
    make_room_for(contents->counts);
    for (std::uint32_t table = 0; table < contents->counts.size(); ++table)
        resize({table}, contents->counts[table]);
    for (std::uint32_t index = 0; index < contents->rows.size(); ++index)
        read_canonical(contents->rows[index], shared_layout->columns()[index].leaves, edit_bytes(index));
    return {};
}

} // namespace lockstone
