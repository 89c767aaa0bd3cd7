// The whole state of a simulation in one relocatable block: columns of rows, named once in a manifest.
//
// Saving, restoring, hashing, comparing and dumping all walk the manifest; nothing is mirrored by hand, and what
// is not in the block cannot affect the next tick. Row counts are part of the state; capacities and the manifest
// itself are fixed when the block is made.
#pragma once

#include "lockstone/result.h"
#include "lockstone/row.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
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
    std::uint32_t capacity; ///< rows
};

struct ColumnInfo {
    std::string name; ///< "body.pose": unique
    std::uint32_t table;
    Group group;
    std::uint32_t row_size;      ///< bytes
    std::uint32_t rows_per_page; ///< of the hash tree
    std::size_t offset;          ///< of row 0 from the start of the block, a multiple of 64
    std::vector<LeafInfo> leaves;
    std::uint64_t name_hash; ///< seeds the column's node of the hash tree
};

/// The manifest: tables and columns in hash order. Built once, then shared read-only by every copy of the state.
class StateLayout {
  public:
    StateLayout();
    /// Names of tables are unique (asserted). A capacity of zero is allowed: the columns exist and stay empty.
    TableId add_table(std::string name, std::uint32_t capacity);
    /// Columns of a table may be added until a State is made of the layout. Names are unique (asserted).
    template <StateRow T> Column<T> add_column(TableId table, std::string name, Group group) {
        return {add_column(table, std::move(name), group, sizeof(T), leaves_of<T>())};
    }
    std::uint32_t add_column(TableId table, std::string name, Group group, std::size_t row_size,
                             std::vector<LeafInfo> leaves);

    std::span<const TableInfo> tables() const { return table_infos; }
    std::span<const ColumnInfo> columns() const { return column_infos; }
    /// Where each column lies, by column index: what saving walks, without the names in between.
    struct Placement {
        std::size_t offset; ///< of row 0 from the start of the block
        std::uint32_t row_size, table;
    };
    std::span<const Placement> placements() const { return column_placements; }
    /// Bytes of a whole block: counts, then every column at capacity.
    std::size_t size_bytes() const { return block_size; }
    /// Bytes of the largest ring image.
    std::size_t image_bytes_max() const { return image_size_max; }
    /// XXH3 of all names, sizes and formats (not capacities): two states compare or load only where these agree.
    std::uint64_t schema_hash() const { return schema; }
    const ColumnInfo* find_column(std::string_view name) const;

  private:
    void place_columns();

    std::vector<TableInfo> table_infos;
    std::vector<ColumnInfo> column_infos;
    std::vector<Placement> column_placements;
    std::size_t block_size = 0;
    std::size_t image_size_max = 0;
    std::uint64_t schema = 0;
};

namespace detail {
/// Memory that begins at a cache line: packing into it is a fifth faster than 16 bytes off.
template <class T> struct CacheLineAllocator {
    using value_type = T;
    CacheLineAllocator() = default;
    template <class U> CacheLineAllocator(const CacheLineAllocator<U>&) {}
    T* allocate(std::size_t n) {
        return static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64}));
    }
    void deallocate(T* p, std::size_t) { ::operator delete (p, std::align_val_t{64}); }
    friend bool operator==(CacheLineAllocator, CacheLineAllocator) { return true; }
};
} // namespace detail

/// A ring image: the live rows of every column, packed, in host byte order. Only for this process: see save_portable
/// for files and packets. Its memory is allocated once and reused.
struct Image {
    /// Capacity; the first `size` bytes hold the image.
    std::vector<std::byte, detail::CacheLineAllocator<std::byte>> bytes;
    std::size_t size = 0;
};

/// Where two states first differ, ready to print.
struct Difference {
    std::string column; ///< "body.velocity"; for row counts the table's name
    std::uint32_t row;
    std::string field;       ///< "linear.x"; "count" for row counts
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

class State {
  public:
    explicit State(std::shared_ptr<const StateLayout> layout); ///< all counts zero, all bytes zero
    State(const State& other);                                 ///< deep copy at another address
    State&
    operator=(const State& other); ///< the same layout, or one with equal schema and capacities (asserted)
    State(State&&) noexcept = default;
    State& operator=(State&&) noexcept = default;

    const StateLayout& layout() const { return *shared_layout; }
    const std::shared_ptr<const StateLayout>& layout_shared() const { return shared_layout; }

    std::uint32_t count(TableId table) const { return counts()[table.index]; }
    std::uint32_t capacity(TableId table) const { return shared_layout->tables()[table.index].capacity; }
    /// Sets the live row count, at most the capacity (asserted). Rows that appear are zero; rows that go are zeroed.
    void resize(TableId table, std::uint32_t rows);

    /// The live rows of a column. Valid until the state is moved or its table resized.
    template <StateRow T> std::span<T> rows(Column<T> column) {
        const ColumnInfo& info = shared_layout->columns()[column.index];
        return {reinterpret_cast<T*>(block.get() + info.offset), counts()[info.table]};
    }
    template <StateRow T> std::span<const T> rows(Column<T> column) const {
        const ColumnInfo& info = shared_layout->columns()[column.index];
        return {reinterpret_cast<const T*>(block.get() + info.offset), counts()[info.table]};
    }
    std::span<std::byte> bytes(std::uint32_t column); ///< live rows, raw
    std::span<const std::byte> bytes(std::uint32_t column) const;
    /// The whole block. What is not a live row is zero, so equal states are equal blocks.
    std::span<const std::byte> block_bytes() const { return {block.get(), shared_layout->size_bytes()}; }

    // ---- ring images: the fast path of rollback ----
    void save(Image& image) const;    ///< allocates only when the image is smaller than image_bytes_max()
    void restore(const Image& image); ///< of a state with the same schema whose rows fit (asserted)
    std::size_t image_bytes() const;  ///< what save would write now

    // ---- portable images: files, packets, other machines. Format: src/state/README.md ----
    std::vector<std::byte> save_portable() const;
    /// On any error the state is as it was. Capacities may differ; counts must fit.
    Status restore_portable(std::span<const std::byte> image);

    // ---- hashing ----
    std::uint64_t hash() const; ///< the root; always complete, never allocates
    HashTree hash_tree() const;

    /// Row counts first, then the rows that both have, in manifest order; at most `limit` entries. Schemas must agree
    /// (asserted).
    static std::vector<Difference> diff(const State& left, const State& right, std::size_t limit);
    /// One line per live row: `body.pose[3] position.x=1.5 ...`.
    std::string dump() const;

  private:
    std::span<std::uint32_t> counts() {
        return {reinterpret_cast<std::uint32_t*>(block.get()), shared_layout->tables().size()};
    }
    std::span<const std::uint32_t> counts() const {
        return {reinterpret_cast<const std::uint32_t*>(block.get()), shared_layout->tables().size()};
    }
    struct AlignedFree {
        void operator()(std::byte* p) const;
    };
    std::shared_ptr<const StateLayout> shared_layout;
    std::unique_ptr<std::byte[], AlignedFree> block; ///< 64-byte aligned
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
