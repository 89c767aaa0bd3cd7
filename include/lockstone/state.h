// The whole state of a simulation in one relocatable block: columns of rows, named once in a manifest.
//
// Saving, restoring, hashing, comparing and dumping all walk the manifest; nothing is mirrored by hand, and what
// is not in the block cannot affect the next tick. Row counts are part of the state. How many rows there is memory for
// is not: tables grow when they need to, up to a limit of each, and states with other capacities are equal all the same.
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

/// Columns written by the same part of the tick share a group; the hash tree has one node for each, in this order.
enum class Group : std::uint32_t { world, definition, motion, contact, game };
inline constexpr std::uint32_t group_count = 5;
std::string_view name_of(Group group);

/// A set of columns with one row count. Handed out by StateLayout::add_table.
struct TableId {
    std::uint32_t index;
};

/// A typed column. Handed out by StateLayout::add_column.
template <StateRow T> struct Column { std::uint32_t index; };

struct TableInfo {
    std::string name;
    std::uint32_t capacity; ///< rows that there is memory for
    std::uint32_t rows_max; ///< that it may grow to

    /// The capacity that a table grows to when it is to hold `rows`, at most rows_max: half as much again as it has, so
    /// that growing row by row copies each row a few times in all.
    std::uint32_t grown(std::uint32_t rows) const;
};

struct ColumnInfo {
    std::string name; ///< "body.pose": unique
    std::uint32_t table;
    Group group;
    std::uint32_t row_size;           ///< bytes
    std::uint32_t rows_per_page;      ///< of the hash tree
    std::size_t offset;               ///< of row 0 from the start of the block, a multiple of 64
    std::span<const LeafInfo> leaves; ///< valid while a layout lives that has the column
    std::uint64_t name_hash;          ///< seeds the column's node of the hash tree
};

/// The manifest: tables and columns in hash order. Tables and columns are added, then finished() gives what every copy of a
/// state shares, read-only; what is asked of places, sizes and the schema's hash holds of a finished layout only.
class StateLayout {
  public:
    /// Names of tables are unique (asserted). A limit of zero is allowed: the columns exist and stay empty.
    /// `capacity`: rows that a state has memory for when it is made, at most `rows_max` (asserted).
    TableId add_table(std::string name, std::uint32_t capacity, std::uint32_t rows_max);
    /// A table that has all its memory from the start.
    TableId add_table(std::string name, std::uint32_t capacity) {
        return add_table(std::move(name), capacity, capacity);
    }
    /// Names of columns are unique (asserted).
    template <StateRow T> Column<T> add_column(TableId table, std::string name, Group group) {
        return {add_column(table, std::move(name), group, sizeof(T), leaves_of<T>())};
    }
    std::uint32_t add_column(TableId table, std::string name, Group group, std::size_t row_size,
                             std::vector<LeafInfo> leaves);
    /// Places the columns and hashes the schema: a State is made of this.
    std::shared_ptr<const StateLayout> finished() &&;
    bool is_finished() const { return has_places; }

    std::span<const TableInfo> tables() const { return table_infos; }
    std::span<const ColumnInfo> columns() const { return column_infos; }
    /// Where each column lies, by column index: what saving walks, without the names in between.
    struct Placement {
        std::size_t offset; ///< of row 0 from the start of the block
        std::uint32_t row_size, table;
        std::uint32_t rows_per_page;
        std::size_t first_page; ///< among the pages of all columns at capacity; a multiple of pages_per_chunk
    };
    std::span<const Placement> placements() const { return column_placements; }
    static constexpr std::size_t pages_per_chunk = 16;
    /// Pages of all columns at capacity, each column's filled up to whole chunks.
    std::size_t page_count() const { return pages_total; }
    /// Bytes of a whole block: counts, then every column at capacity.
    std::size_t size_bytes() const { return block_size; }
    /// What image_bytes() of a state is whose tables are full, at capacity.
    std::size_t image_bytes_max() const { return image_size_max; }
    /// The same manifest with other capacities, by table: for the same columns, at other places. Each at most the table's
    /// rows_max (asserted).
    std::shared_ptr<const StateLayout> with_capacities(std::span<const std::uint32_t> capacities) const;
    /// XXH3 of all names, sizes and formats (not capacities): two states compare or load only where these agree.
    std::uint64_t schema_hash() const { return schema; }
    const ColumnInfo* find_column(std::string_view name) const;
    /// What the rows were made for, as the maker of the layout says: images of another origin are not for this state. Not
    /// part of the schema; 0 where nobody says.
    std::uint64_t origin() const { return made_for; }
    void set_origin(std::uint64_t origin) { made_for = origin; }

  private:
    void place_columns();

    std::vector<TableInfo> table_infos;
    std::vector<ColumnInfo> column_infos;
    std::vector<std::shared_ptr<const std::vector<LeafInfo>>> leaf_lists; ///< what ColumnInfo::leaves is of
    std::vector<Placement> column_placements;
    std::size_t block_size = 0;
    std::size_t image_size_max = 0;
    std::size_t pages_total = 0;
    std::uint64_t schema = 0;
    std::uint64_t made_for = 0;
    bool has_places = false;
};

namespace detail {
/// Bytes that begin at a cache line and are not touched before they are written.
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

/// Which contents stand where. A version names what a page, a chunk of pages or a column holds: two places with the
/// same version, given out by the same state, hold the same live rows, and as many. Bookkeeping, never hashed or sent.
/// 0: of no contents.
struct Versions {
    std::vector<std::uint64_t> pages;   ///< as in StateLayout::Placement::first_page
    std::vector<std::uint64_t> chunks;  ///< by page / StateLayout::pages_per_chunk
    std::vector<std::uint64_t> columns; ///< by column index
};
/// The state that gave the versions out. It lives while anything refers to it, so no other state's is the same.
using Owner = std::shared_ptr<const std::byte>;
} // namespace detail

/// A ring image: the rows of a state at one time, only for this process (save_portable is for files and packets). It
/// has as much memory as the state had when it was saved, of which only what was ever live is touched. Saving into an
/// image that already holds most of the state, and restoring from one, copies the pages that differ.
class Image {
  public:
    /// What image_bytes() was of the state when it was saved; 0: nothing was.
    std::size_t size() const { return packed_size; }
    /// StateLayout::origin of the state; 0 of an empty image.
    std::uint64_t origin() const { return layout == nullptr ? 0 : layout->origin(); }
    /// The same schema, counts and rows.
    friend bool operator==(const Image& left, const Image& right);

  private:
    friend class State;
    std::span<const std::uint32_t> counts() const {
        return {reinterpret_cast<const std::uint32_t*>(block.get()), layout->tables().size()};
    }
    std::shared_ptr<const StateLayout> layout;
    detail::Block block; ///< laid out as the state's; zero from the last live row up to a whole cache line
    detail::Owner owner;
    detail::Versions versions;
    std::size_t packed_size = 0;
};

/// Rows [first, end) of a table.
struct RowRange {
    std::uint32_t first, end;
};

/// Up to where a reader has seen the changes of a state, column by column: see State::take_changes. A fresh one has seen nothing.
class ChangeMark {
    friend class State;
    std::shared_ptr<const StateLayout> layout;
    detail::Owner owner;
    detail::Versions versions;       ///< of what the reader saw; 0: of pages that were not live then
    std::vector<std::uint32_t> rows; ///< by column: how many there were
};

inline constexpr const char* row_count_field =
    "row count"; ///< of Difference: no field has a name with a space in it
/// Where two states first differ, ready to print.
struct Difference {
    std::string column; ///< "body.velocity"; for row counts the table's name
    std::uint32_t row;
    std::string field;       ///< "linear.x"; row_count_field for row counts
    std::string left, right; ///< decimal and raw: "-1.25 (raw 0xfff60000)"
};
/// "column body.velocity, row 7, linear.x: 1 (raw 0x80000) against 2 (raw 0x100000)"
std::string to_string(const Difference& difference);

/// The hash tree of one state, from the root downwards. Two peers descend it to a column and a page.
struct HashTree {
    std::uint64_t root;
    std::array<std::uint64_t, group_count> groups;
    std::vector<std::uint64_t> columns;            ///< by column index
    std::vector<std::vector<std::uint64_t>> pages; ///< by column index, then page
    std::vector<std::uint32_t> row_counts;         ///< by column index
    std::vector<std::uint32_t> rows_per_page;      ///< by column index
};

/// A page of a column and the rows it holds, last_row included.
struct PageRef {
    std::uint32_t column, page, first_row, last_row;

    friend bool operator==(const PageRef&, const PageRef&) = default;
};
/// The pages whose hashes differ, or that only one tree has; by column, then page. Trees of the same schema.
std::vector<PageRef> differing_pages(const HashTree& left, const HashTree& right);

/// One thread at a time, reading included: hash() keeps what it found for the next time.
class State {
  public:
    explicit State(std::shared_ptr<const StateLayout> layout); ///< all counts zero, all bytes zero
    State(const State& other);                                 ///< deep copy at another address
    State& operator=(const State& other); ///< of an equal schema, within the limits (asserted); grows
    State(State&&) noexcept = default;
    State& operator=(State&&) noexcept = default;

    /// The present one: growing replaces it. Handles of columns and tables stay what they are, and so does the schema.
    const StateLayout& layout() const { return *shared_layout; }
    const std::shared_ptr<const StateLayout>& layout_shared() const { return shared_layout; }

    std::uint32_t count(TableId table) const { return counts()[table.index]; }
    /// Rows that there is memory for. Enters no hash and no image, and no comparison looks at it.
    std::uint32_t capacity(TableId table) const { return shared_layout->tables()[table.index].capacity; }
    std::uint32_t rows_max(TableId table) const { return shared_layout->tables()[table.index].rows_max; }
    /// Sets the live row count, at most rows_max (asserted). Rows that appear are zero; rows that go are zeroed. Grows
    /// where there is no room.
    void resize(TableId table, std::uint32_t rows);
    /// Room for `more` rows in each of the tables, so that no resize to it grows: once for all of them. At most rows_max
    /// is taken, whatever is asked for.
    void make_room(std::initializer_list<TableId> tables, std::uint32_t more);
    /// Capacities of at least these, by table, each at most the table's rows_max (asserted). Growing moves the block, takes
    /// time and memory like a copy of it, and changes nothing that a hash, an image or a reader of changes could tell.
    void reserve(std::span<const std::uint32_t> capacities);

    /// The live rows of a column. Valid until the state is moved or grows, or the table is resized.
    template <StateRow T> std::span<const T> rows(Column<T> column) const {
        const std::span<const std::byte> all = bytes(column.index);
        return {reinterpret_cast<const T*>(all.data()), all.size() / sizeof(T)};
    }
    /// Live rows, raw. Asked for a hundred thousand times in a tick.
    std::span<const std::byte> bytes(std::uint32_t column) const {
        const StateLayout::Placement& place = shared_layout->placements()[column];
        return {block.get() + place.offset, std::size_t{counts()[place.table]} * place.row_size};
    }

    // ---- writing: whatever these name counts as written ----
    // Use what they return at once: it is valid until the state is moved or grows, or the table is resized, and a write
    // through it after a save, a restore or a hash goes unnoticed.
    /// All live rows.
    template <StateRow T> std::span<T> edit(Column<T> column) { return as_rows<T>(edit_bytes(column.index)); }
    /// `count` live rows from `first` (asserted).
    template <StateRow T> std::span<T> edit(Column<T> column, std::uint32_t first, std::uint32_t count) {
        return as_rows<T>(edit_bytes(column.index, first, count));
    }
    template <StateRow T> T& edit_row(Column<T> column, std::uint32_t row) { return edit(column, row, 1)[0]; }
    std::span<std::byte> edit_bytes(std::uint32_t column);
    std::span<std::byte> edit_bytes(std::uint32_t column, std::uint32_t first_row, std::uint32_t count);

    /// The whole block. Bytes outside of live rows are zero, so equal states of equal capacities are equal blocks.
    std::span<const std::byte> block_bytes() const { return {block.get(), shared_layout->size_bytes()}; }

    // ---- ring images: the fast path of rollback ----
    /// Copies what the image does not hold yet. Allocates only for an image of none or of another layout: once for each
    /// image after the state has grown.
    void save(Image& image) const;
    /// Checks that `restore` accepts the image: a state with the same columns, fields and origin saved it. The error says which of
    /// these differs.
    Status can_restore(const Image& image) const;
    /// Replaces all rows by those of the image, which can_restore accepts (asserted). Copies only the pages that differ where this
    /// state saved the image itself, also after it has grown.
    void restore(const Image& image);
    /// Gives an image its memory ahead of the first save.
    void reserve(Image& image) const;
    std::size_t image_bytes() const; ///< of the live rows, packed: what a save copies at most

    // ---- portable images: files, packets, other machines. Format: src/state/README.md ----
    std::vector<std::byte> save_portable() const;
    /// On any error the state is as it was. Capacities may differ; counts must be within the limits.
    Status restore_portable(std::span<const std::byte> image);

    // ---- delta images: a portable image as the difference to an earlier state. Format: src/state/README.md ----
    /// What apply_delta of a state like `base` turns into this one: small where little changed, the same bytes on every
    /// machine. Schemas must agree (asserted).
    std::vector<std::byte> save_delta(const State& base) const;
    /// Turns this state, the base that the delta was saved against, into the other. On any error, another base
    /// included, the state is as it was.
    Status apply_delta(std::span<const std::byte> delta);

    // ---- hashing ----
    /// The root, over all live rows; hashes the pages that were written since it was last asked. Never allocates.
    std::uint64_t hash() const;
    HashTree hash_tree() const;

    // ---- following changes: for what is derived from rows and kept beside the state ----
    /// The live rows of a column that may be others than when this was last called with the mark, in whole pages, in
    /// order; `out` is written anew. Returns how many rows there were then: those from there on that are gone are not
    /// in `out`. Of a state that was replaced by another, all rows.
    std::uint32_t take_changes(std::uint32_t column, ChangeMark& mark, std::vector<RowRange>& out) const;

    // ---- for tests ----
    /// While `moves` is true, each call that may move the block does move it: resize() to another count, make_room(), reserve(), and
    /// replacing all rows. The old block is overwritten before it is freed: code that uses a view for too long reads other bytes, and a
    /// sanitizer names it. Default: false; true in builds with LOCKSTONE_MOVE_STATE. A copy of the state moves like the original.
    /// No hash and no image depends on it.
    void move_at_every_chance(bool moves) { moves_at_every_chance = moves; }

    // ---- checks of the bookkeeping; builds without NDEBUG make them at each hash, save and restore ----
    /// Hashes every page anew: refuses, with the column and the rows, where hash() would use another value.
    Status verify_versions() const;
    /// Refuses where a page of the image has the version of this state's page, but other rows.
    Status verify_versions(const Image& image) const;

    /// Row counts first, then the rows that both have, in manifest order; at most `limit` entries. Schemas must agree
    /// (asserted).
    static std::vector<Difference> diff(const State& left, const State& right, std::size_t limit);
    /// One line per live row: `body.pose[3] position.x=1.5 ...`.
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
    void mark(std::uint32_t column, std::size_t first_page, std::size_t end_page);
    void restore_foreign(const Image& image);
    std::uint64_t column_hash(std::uint32_t column) const;
    std::uint64_t hash_state(HashTree* tree) const;

    std::shared_ptr<const StateLayout> shared_layout;
    detail::Block block;
    detail::Owner owner;
    detail::Versions versions; ///< of a page without a live row: 0
    std::uint64_t version_last = 0;
    bool moves_at_every_chance = false;
    /// Blocks that the state has left, overwritten. They are kept for a while, or the allocator gives the same memory again.
    std::vector<detail::Block> left_blocks;
    /// Of pages and columns, and the versions they are of.
    struct Hashes {
        std::vector<std::uint64_t> page; ///< and room for one value after the last
        std::vector<std::uint64_t> column;
        detail::Versions of;
    };
    mutable Hashes hashes;
};

// ---- the canonical bytes of a row: little-endian fields in order, as hashed, saved and sent ----
/// Appends the row's canonical bytes.
void append_canonical(std::span<const std::byte> row, std::span<const LeafInfo> leaves,
                      std::vector<std::byte>& out);
/// Reads canonical bytes into a row of the host; `from` has exactly the row's size.
void read_canonical(std::span<const std::byte> from, std::span<const LeafInfo> leaves,
                    std::span<std::byte> row);
/// XXH3-64 of bytes, the one hash of the library.
std::uint64_t hash_bytes(std::span<const std::byte> bytes, std::uint64_t seed = 0);

} // namespace lockstone
