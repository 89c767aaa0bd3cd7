// The whole state of a simulation in one relocatable block: columns of rows, listed in one manifest
// (StateLayout).
//
// Save, restore, hash, comparison and dump all iterate over the manifest. Data outside the block cannot
// affect the next tick. Row counts are part of the state; capacities are not: tables grow on demand up to
// their limits, and states with different capacities can be equal.
#pragma once

#include "lockstone/result.h"
#include "lockstone/row.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone {

/// Group of columns: one node of the hash tree, in this order.
enum class Group : std::uint32_t {
    world,      ///< header, configuration, counters
    definition, ///< definitions of bodies, shapes, joints and the like
    motion,     ///< poses, velocities, sleep
    contact,    ///< contacts and warm-start impulses
    game        ///< the game's own columns
};
inline constexpr std::uint32_t group_count = 5; ///< number of groups
/// "world"; "unknown" for any other value. Static string.
std::string_view name_of(Group group);

/// Handle of a table: columns with a common row count. From StateLayout::add_table().
struct TableId {
    std::uint32_t index; ///< in StateLayout::tables()
};

/// Handle of a typed column. From StateLayout::add_column(), or from a GameSchema for World::read() and
/// write().
template <StateRow T> struct Column {
    std::uint32_t index; ///< in StateLayout::columns(), or in GameSchema::entries()
};

/// A table.
struct TableInfo {
    std::string name;       ///< unique
    std::uint32_t capacity; ///< number of rows that the memory holds
    std::uint32_t rows_max; ///< limit of the number of rows

    /// The capacity to grow to for `rows` rows, at most rows_max: at least 9/8 of `rows` and 5/4 of the
    /// present capacity, so that growth row by row copies each row only a few times. `capacity` if `rows` fit
    /// already.
    std::uint32_t grown(std::uint32_t rows) const;
};

/// A column.
struct ColumnInfo {
    std::string name;                 ///< "body.pose": unique
    std::uint32_t table;              ///< index in StateLayout::tables()
    Group group;                      ///< node of the hash tree
    std::uint32_t row_size;           ///< bytes of a row
    std::uint32_t rows_per_page;      ///< rows of a page, the unit of saving and hashing
    std::size_t offset;               ///< of row 0 in the block [bytes], a multiple of 64
    std::span<const LeafInfo> leaves; ///< numbers of a row; valid while any layout with this column exists
    std::uint64_t name_hash;          ///< seed of the column's hash
};

/// The manifest: tables and columns in hash order. Add tables and columns, then call finished(). Copies of a
/// state share the finished layout, which is read-only and thread-safe. Placements, sizes and the schema hash
/// exist only in a finished layout.
class StateLayout {
  public:
    /// Adds a table. The name must be unique and `capacity`, the initial number of rows in memory, at most
    /// `rows_max`; otherwise the program ends. rows_max may be 0: the columns exist and are always empty.
    TableId add_table(std::string name, std::uint32_t capacity, std::uint32_t rows_max);
    /// Adds a table whose memory is allocated at once.
    TableId add_table(std::string name, std::uint32_t capacity) {
        return add_table(std::move(name), capacity, capacity);
    }
    /// Adds a column. A repeated name ends the program.
    template <StateRow T> Column<T> add_column(TableId table, std::string name, Group group) {
        return {add_column(table, std::move(name), group, sizeof(T), leaves_of<T>())};
    }
    /// Adds a column without a row type; returns the index of the column. The leaves must cover every byte of
    /// a row.
    std::uint32_t add_column(TableId table, std::string name, Group group, std::size_t row_size,
                             std::vector<LeafInfo> leaves);
    /// Computes placements and the schema hash, and moves the layout into the result.
    std::shared_ptr<const StateLayout> finished() &&;
    bool is_finished() const { return has_places; } ///< True for a result of finished().

    std::span<const TableInfo> tables() const { return table_infos; }    ///< By TableId::index.
    std::span<const ColumnInfo> columns() const { return column_infos; } ///< By column index.
    /// Place of a column in the block: ColumnInfo without the names, for fast iteration.
    struct Placement {
        std::size_t offset;          ///< of row 0 in the block [bytes]
        std::uint32_t row_size,      ///< bytes of a row
            table;                   ///< index in tables()
        std::uint32_t rows_per_page; ///< rows of a page
        std::size_t first_page;      ///< first page number of the column; a multiple of pages_per_chunk
    };
    std::span<const Placement> placements() const { return column_placements; } ///< By column index.
    /// The columns of a table [column index], ascending. Valid as long as the layout.
    std::span<const std::uint32_t> columns_of(TableId table) const {
        return std::span(columns_by_table)
            .subspan(columns_begin[table.index], columns_begin[table.index + 1] - columns_begin[table.index]);
    }
    /// Number of pages with a common version.
    static constexpr std::size_t pages_per_chunk = 16;
    /// Pages of all columns at capacity, rounded up to whole chunks for each column.
    std::size_t page_count() const { return pages_total; }
    /// Bytes of the block: counts, then every column at capacity.
    std::size_t size_bytes() const { return block_size; }
    /// State::image_bytes() of a state whose tables are filled to capacity.
    std::size_t image_bytes_max() const { return image_size_max; }
    /// A finished layout of the same columns with other capacities [one for each table], each at most the
    /// table's rows_max; otherwise the program ends.
    std::shared_ptr<const StateLayout> with_capacities(std::span<const std::uint32_t> capacities) const;
    /// XXH3 of all names, sizes and formats, without capacities. Comparing and loading require equal hashes.
    std::uint64_t schema_hash() const { return schema; }
    /// The column of this name; null: none. Valid as long as the layout.
    const ColumnInfo* find_column(std::string_view name) const;
    /// Hash of the definition and assets that the rows belong to; a ring image of another origin is refused.
    /// Not part of the schema. Default: 0.
    std::uint64_t origin() const { return made_for; }
    void set_origin(std::uint64_t origin) { made_for = origin; } ///< Call before finished().

  private:
    void list_columns();
    void place_columns();

    std::vector<TableInfo> table_infos;
    std::vector<ColumnInfo> column_infos;
    std::vector<std::shared_ptr<const std::vector<LeafInfo>>> leaf_lists; ///< owns ColumnInfo::leaves
    std::vector<Placement> column_placements;
    std::vector<std::uint32_t> columns_by_table; ///< column indices, sorted by table
    std::vector<std::uint32_t> columns_begin; ///< by table: its first place in columns_by_table; and the end
    std::size_t block_size = 0;
    std::size_t image_size_max = 0;
    std::size_t pages_total = 0;
    std::uint64_t schema = 0;
    std::uint64_t made_for = 0;
    bool has_places = false;
};

namespace detail {
/// Uninitialised bytes, aligned to a cache line.
class Block {
  public:
    Block() = default;
    explicit Block(std::size_t size);
    std::byte* get() const { return memory.get(); }

  private:
    struct Free {
        void operator()(std::byte* p) const;
    };
    std::unique_ptr<std::byte[], Free> memory;
};

/// Dirty tracking. A version number identifies the content of a page, a chunk of pages or a column: two
/// places with equal versions of the same owner hold equal live rows. Never hashed or sent. 0: no content.
struct Versions {
    std::vector<std::uint64_t> pages;   ///< as in StateLayout::Placement::first_page
    std::vector<std::uint64_t> chunks;  ///< by page / StateLayout::pages_per_chunk
    std::vector<std::uint64_t> columns; ///< by column index
};
/// Identity of the state that assigned the versions. Shared ownership keeps the address unique.
using Owner = std::shared_ptr<const std::byte>;
} // namespace detail

/// A ring image: the rows of a state at one time, for this process only; save_portable() is for files and
/// packets. It allocates as much memory as the state has, and touches only the part that had live rows.
/// Saving into an older image of the state, and restoring from one, copies only the pages that differ.
class Image {
  public:
    /// State::image_bytes() at the time of the save; 0: empty.
    std::size_t size() const { return packed_size; }
    /// StateLayout::origin() of the state; 0 for an empty image.
    std::uint64_t origin() const { return layout == nullptr ? 0 : layout->origin(); }
    /// Equal schema, counts and rows.
    friend bool operator==(const Image& left, const Image& right);

  private:
    friend class State;
    std::span<const std::uint32_t> counts() const {
        return {reinterpret_cast<const std::uint32_t*>(block.get()), layout->tables().size()};
    }
    std::shared_ptr<const StateLayout> layout;
    /// Laid out as the state; zero from the last live row to the end of its cache line.
    detail::Block block;
    detail::Owner owner;
    detail::Versions versions;
    std::size_t packed_size = 0;
};

/// A table and a number of rows.
struct TableRows {
    TableId table;      ///< the table
    std::uint32_t rows; ///< number of rows
};

/// Rows [first, end) of a table.
struct RowRange {
    std::uint32_t first, ///< first row
        end;             ///< row after the last
};

/// A reader's position in the changes of a state: see State::take_changes(). A new one has seen nothing.
class ChangeMark {
    friend class State;
    std::shared_ptr<const StateLayout> layout;
    detail::Owner owner;
    detail::Versions versions;       ///< that the reader saw; 0: the page was not live
    std::vector<std::uint32_t> rows; ///< row count of each column
};

/// Difference::field of a different row count. Fields have no space in their names.
inline constexpr const char* row_count_field = "row count";
/// A place where two states differ, ready to print.
struct Difference {
    std::string column; ///< "body.velocity"; the table's name for row counts
    std::uint32_t row;  ///< row of the column; 0 for row counts
    std::string field;  ///< "linear.x"; row_count_field for row counts
    std::string left,   ///< value of the left state, decimal and raw: "-1.25 (raw 0xfff60000)"
        right;          ///< value of the right state
};
/// One line: "column body.velocity, row 7, linear.x: 1 (raw 0x80000) against 2 (raw 0x100000)".
std::string to_string(const Difference& difference);

/// The hash tree of a state. Two peers compare theirs from the root down to a column and a page.
struct HashTree {
    std::uint64_t root;                            ///< State::hash()
    std::array<std::uint64_t, group_count> groups; ///< [group]
    std::vector<std::uint64_t> columns;            ///< [column]
    std::vector<std::vector<std::uint64_t>> pages; ///< [column][page]
    std::vector<std::uint32_t> row_counts;         ///< [column]
    std::vector<std::uint32_t> rows_per_page;      ///< [column]
};

/// A page of a column.
struct PageRef {
    std::uint32_t column, ///< column index
        page,             ///< page of the column
        first_row,        ///< first row of the page
        last_row;         ///< last row of the page, included

    /// Equal members.
    friend bool operator==(const PageRef&, const PageRef&) = default;
};
/// Pages with different hashes or in one tree only, by column, then page. The trees must have one schema.
std::vector<PageRef> differing_pages(const HashTree& left, const HashTree& right);

/// The rows of a simulation. One thread at a time, for const members too, because hash() writes a cache.
class State {
  public:
    explicit State(std::shared_ptr<const StateLayout> layout); ///< Empty tables. The layout must be finished.
    State(const State& other);                                 ///< A copy in memory of its own.
    /// Copies all rows. The schemas must be equal and the row counts within this state's limits; otherwise
    /// the program ends.
    State& operator=(const State& other);
    State(State&&) noexcept = default;            ///< Moves the block; views of rows remain valid.
    State& operator=(State&&) noexcept = default; ///< Moves the block; views of the old rows end.

    /// The present layout. Growth replaces it by one with other capacities; handles and schema remain valid.
    const StateLayout& layout() const { return *shared_layout; }
    /// layout(), shared.
    const std::shared_ptr<const StateLayout>& layout_shared() const { return shared_layout; }

    /// Number of live rows.
    std::uint32_t count(TableId table) const { return counts()[table.index]; }
    /// Number of rows that the memory holds. Not part of any hash, image or comparison.
    std::uint32_t capacity(TableId table) const { return shared_layout->tables()[table.index].capacity; }
    /// Limit of the number of rows.
    std::uint32_t rows_max(TableId table) const { return shared_layout->tables()[table.index].rows_max; }
    /// Sets the number of live rows; more than rows_max ends the program. New rows are zero. Grows the memory
    /// if it is too small.
    void resize(TableId table, std::uint32_t rows);
    /// Allocates memory for `more` further rows in each of the tables, in one growth. Never beyond rows_max.
    void make_room(std::initializer_list<TableId> tables, std::uint32_t more);
    /// Allocates memory for at least these rows in all, in one growth. Numbers above rows_max end the program.
    void make_room_for(std::initializer_list<TableRows> tables);
    /// Raises capacities to at least these [one for each table]; one above rows_max ends the program. Growth
    /// copies the block. It changes no hash, no image and no result of take_changes().
    void reserve(std::span<const std::uint32_t> capacities);

    /// The live rows of a column. Valid until the state grows or is assigned to, or the table is resized.
    template <StateRow T> std::span<const T> rows(Column<T> column) const {
        const std::span<const std::byte> all = bytes(column.index);
        return {reinterpret_cast<const T*>(all.data()), all.size() / sizeof(T)};
    }
    /// The live rows as bytes. Inline, because a tick calls it very often.
    std::span<const std::byte> bytes(std::uint32_t column) const {
        const StateLayout::Placement& place = shared_layout->placements()[column];
        return {block.get() + place.offset, std::size_t{counts()[place.table]} * place.row_size};
    }

    // ---- writing: these functions mark the returned rows as changed ----
    // Use the result at once. It is valid until the state grows or is assigned to, or the table is resized.
    // Writes through it after a save, a restore or a hash are not detected.
    /// All live rows.
    template <StateRow T> std::span<T> edit(Column<T> column) { return as_rows<T>(edit_bytes(column.index)); }
    /// `count` live rows from row `first`; rows that are not live end the program.
    template <StateRow T> std::span<T> edit(Column<T> column, std::uint32_t first, std::uint32_t count) {
        return as_rows<T>(edit_bytes(column.index, first, count));
    }
    /// One live row.
    template <StateRow T> T& edit_row(Column<T> column, std::uint32_t row) {
        return *reinterpret_cast<T*>(edit_row_bytes(column.index, row).data());
    }
    std::span<std::byte> edit_bytes(std::uint32_t column); ///< All live rows as bytes.
    /// Some live rows as bytes.
    std::span<std::byte> edit_bytes(std::uint32_t column, std::uint32_t first_row, std::uint32_t count);
    /// One live row as bytes.
    std::span<std::byte> edit_row_bytes(std::uint32_t column, std::uint32_t row);

    /// The whole block. Bytes outside live rows are zero: equal states of equal capacity have equal blocks.
    /// Valid as the rows.
    std::span<const std::byte> block_bytes() const { return {block.get(), shared_layout->size_bytes()}; }

    // ---- ring images: the fast path of rollback ----
    /// Makes the image equal to this state; copies only the pages that differ. Allocates if the image is new
    /// or the state has grown since.
    void save(Image& image) const;
    /// Checks that restore() accepts the image: a state with the same columns, fields and origin saved it.
    /// The error names the difference.
    Status can_restore(const Image& image) const;
    /// Replaces all rows by those of the image. An image that can_restore() refuses ends the program. Copies
    /// only the pages that differ if this state saved the image, otherwise all.
    void restore(const Image& image);
    /// Allocates the memory of an image before the first save; empties an image of another layout.
    void reserve(Image& image) const;
    std::size_t image_bytes() const; ///< Bytes of the live rows: upper bound of the bytes that a save copies.

    // ---- portable images: files, packets, other machines. Format: src/state/README.md ----
    std::vector<std::byte> save_portable() const; ///< The rows in little-endian bytes, with a checksum.
    /// Replaces all rows. Errors: damaged bytes, another schema, counts above the limits; the state is then
    /// as before. Capacities may differ.
    Status restore_portable(std::span<const std::byte> image);

    // ---- delta images: the difference to an earlier state. Format: src/state/README.md ----
    /// This state as the difference to `base`, for apply_delta(). Small when little changed; equal bytes on
    /// every machine. Different schemas end the program.
    std::vector<std::byte> save_delta(const State& base) const;
    /// Adds a difference to this state, which must equal the base of save_delta(). Errors: damaged bytes,
    /// another base; the state is then as before.
    Status apply_delta(std::span<const std::byte> delta);

    // ---- hashing ----
    /// Root of the hash tree over all live rows. Hashes only the pages written since the last call. Never
    /// allocates.
    std::uint64_t hash() const;
    HashTree hash_tree() const; ///< The whole tree; allocates.

    // ---- changes: for caches derived from rows ----
    /// Replaces `out` by the live rows of a column that may have changed since the last call with this mark:
    /// whole pages, ascending. Returns the row count at that call; removed rows are not in `out`. All rows
    /// for a new mark or a mark of another state.
    std::uint32_t take_changes(std::uint32_t column, ChangeMark& mark, std::vector<RowRange>& out) const;

    // ---- for tests ----
    /// While `moves` is true, each call that may move the block moves it: resize(), make_room(), reserve()
    /// and copy assignment. A block over 256 kB moves at about one call in 16. The old block is overwritten,
    /// so that code that uses a view for too long reads wrong bytes. Default: false; true in builds with
    /// LOCKSTONE_MOVE_STATE. Copies inherit it. No hash and no image depends on it.
    void move_at_every_chance(bool moves) { moves_at_every_chance = moves; }

    // ---- checks of the dirty tracking; builds without NDEBUG run them at each hash, save and restore ----
    /// Hashes every page again. Error: a cached hash is wrong, with the column and the rows.
    Status verify_versions() const;
    /// Compares an image with this state. Error: a page has equal versions but different rows.
    Status verify_versions(const Image& image) const;

    /// Differences of two states: row counts first, then common rows, in manifest order; at most `limit`
    /// entries. Different schemas end the program.
    static std::vector<Difference> diff(const State& left, const State& right, std::size_t limit);
    /// All rows as text, a line for each: `body.pose[3] position.x=1.5 ...`.
    std::string dump() const;

  private:
    template <class T> static std::span<T> as_rows(std::span<std::byte> bytes) {
        return {reinterpret_cast<T*>(bytes.data()), bytes.size() / sizeof(T)};
    }
    std::span<std::uint32_t> counts() {
        return {reinterpret_cast<std::uint32_t*>(block.get()), shared_layout->tables().size()};
    }
    std::span<const std::uint32_t> counts() const {
        return {reinterpret_cast<const std::uint32_t*>(block.get()), shared_layout->tables().size()};
    }
    void forget_all();
    void grow(std::shared_ptr<const StateLayout> layout);
    void move_block();
    void make_room_for(std::span<const std::uint32_t> rows);
    void grow_to(std::vector<std::uint32_t>& capacities);
    void mark(std::uint32_t column, std::size_t first_page, std::size_t end_page);
    void mark_page(std::uint32_t column, std::size_t page);
    void mark_new_row(TableId table);
    void clear_old_row(TableId table);
    void restore_foreign(const Image& image);
    std::uint64_t column_hash(std::uint32_t column) const;
    std::uint64_t hash_state(HashTree* tree) const;

    std::shared_ptr<const StateLayout> shared_layout;
    detail::Block block;
    detail::Owner owner;
    detail::Versions versions; ///< 0: page without a live row
    std::uint64_t version_last = 0;
    bool moves_at_every_chance = false;
    /// Overwritten old blocks of move_at_every_chance(). Kept, so that the allocator does not reuse them at
    /// once.
    std::vector<detail::Block> left_blocks;
    /// Hash cache of pages and columns, with the versions that the hashes belong to.
    struct Hashes {
        std::vector<std::uint64_t> page; ///< with one spare entry at the end
        std::vector<std::uint64_t> column;
        detail::Versions of;
    };
    mutable Hashes hashes;
};

// ---- the canonical bytes of a row: little-endian fields in order, as hashed, saved and sent ----
/// Appends the canonical bytes of a row to `out`.
void append_canonical(std::span<const std::byte> row, std::span<const LeafInfo> leaves,
                      std::vector<std::byte>& out);
/// Writes canonical bytes into a row in host byte order. `from` must have the size of the row.
void read_canonical(std::span<const std::byte> from, std::span<const LeafInfo> leaves,
                    std::span<std::byte> row);
/// XXH3-64 of the bytes. All hashes of the library use it.
std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed = 0);

} // namespace lockstone
