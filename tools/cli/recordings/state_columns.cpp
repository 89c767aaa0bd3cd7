#include "cli/recordings/state_columns.h"

#include <algorithm>
#include <concepts>
#include <span>

namespace lockstone::cli {
namespace {

void append(std::string& text, std::string_view part) { text += part; }
void append(std::string& text, std::integral auto part) { text += std::to_string(part); }
template <class... Parts> std::string join(const Parts&... parts) {
    std::string text;
    (append(text, parts), ...);
    return text;
}

using Leaves = std::span<const LeafInfo>;

/// Leaves (fields of a basic type) of a struct, and the length of the name prefix that is already printed.
struct Part {
    Leaves leaves;
    std::size_t told; ///< characters

    /// The next part of the name: "x" of "position.x", "[1]" of "axis[1].x"; empty if the value is a single leaf.
    std::string first_name() const {
        const std::string_view rest = std::string_view(leaves[0].name).substr(told);
        if (rest.empty()) return "";
        const std::size_t from = rest[0] == '.' ? 1 : 0, end = rest.find_first_of(".[", from + 1);
        return std::string(rest.substr(from, end - from));
    }
    /// The leading leaves that share the next part of their names.
    Part first() const {
        const std::string name = first_name();
        const std::size_t skip = leaves[0].name[told] == '.' ? 1 : 0;
        std::size_t count = 1;
        while (count < leaves.size() && Part{leaves.subspan(count), told}.first_name() == name) ++count;
        return {leaves.first(count), told + skip + name.size()};
    }
    bool is_leaf() const { return leaves[0].name.size() == told; }
    bool is_array() const { return leaves[0].name[told] == '['; }
    std::uint32_t offset() const { return leaves[0].offset; }
    std::uint32_t bytes() const { return leaves.back().offset + leaves.back().size - offset(); }
};

template <class Each> void for_each_field(Part part, Each&& each) {
    while (!part.leaves.empty()) {
        const Part field = part.first();
        each(part.first_name(), field);
        part.leaves = part.leaves.subspan(field.leaves.size());
    }
}

bool are_alike(const LeafInfo& a, std::string_view name_a, const LeafInfo& b, std::string_view name_b) {
    if (!name_a.empty() && name_a[0] == '.') name_a.remove_prefix(1);
    return name_a == name_b && a.size == b.size && a.kind == b.kind && a.fraction_bits == b.fraction_bits;
}
bool is(const Part& part, const NamedLeaves& known) {
    return std::ranges::equal(part.leaves, known.leaves, [&](const LeafInfo& a, const LeafInfo& b) {
        return are_alike(a, std::string_view(a.name).substr(part.told), b, b.name);
    });
}

std::string type_of_leaf(const LeafInfo& leaf) {
    const int bits = 8 * leaf.size;
    if (leaf.kind != LeafKind::fixed_point)
        return join(leaf.kind == LeafKind::signed_integer ? "i" : "u", bits);
    if (bits == 64 && leaf.fraction_bits == 32) return "Real";
    return join("I", bits - leaf.fraction_bits, "F", int{leaf.fraction_bits});
}

std::string type_of(const Part& part, const std::vector<NamedLeaves>& known) {
    if (part.is_leaf()) return type_of_leaf(part.leaves[0]);
    for (const NamedLeaves& one : known)
        if (is(part, one)) return one.name;
    if (part.is_array()) {
        std::size_t count = 0;
        for_each_field(part, [&](const std::string&, const Part&) { ++count; });
        return join(count, " x ", type_of(part.first(), known));
    }
    std::string names, types, before;
    bool all_same = true;
    for_each_field(part, [&](const std::string& name, const Part& field) {
        const std::string type = type_of(field, known);
        all_same = all_same && (before.empty() || type == before);
        names += join(names.empty() ? "" : ", ", name);
        types += join(types.empty() ? "" : "; ", name, ": ", type);
        before = type;
    });
    if (all_same && names == "x, y, z") return join("3 x ", before);
    return all_same ? join("(", names, ": ", before, ")") : join("(", types, ")");
}

std::string row_table(const Part& row, const std::vector<NamedLeaves>& known) {
    std::string text = "| offset | field | type | bytes |\n|---|---|---|---|\n";
    for_each_field(row, [&](const std::string& name, const Part& field) {
        text += join("| ", field.offset(), " | ", name, " | ", type_of(field, known), " | ", field.bytes(),
                     " |\n");
    });
    return text;
}

bool has_fields(const ColumnInfo& column) { return column.leaves[0].name != "value"; }

bool have_equal_rows(const ColumnInfo& a, const ColumnInfo& b) {
    return std::ranges::equal(a.leaves, b.leaves, [](const LeafInfo& x, const LeafInfo& y) {
        return x.offset == y.offset && are_alike(x, x.name, y, y.name);
    });
}

} // namespace

std::string state_tables(const StateLayout& layout, const std::vector<NamedLeaves>& known) {
    std::string list = "| column | table | group | bytes of a row |\n|---|---|---|---|\n", rows;
    const std::span<const ColumnInfo> columns = layout.columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
        const ColumnInfo& column = columns[i];
        list += join("| ", column.name, " | ", layout.tables()[column.table].name, " | ",
                     name_of(column.group), " | ", column.row_size, " |\n");
        const auto is_alike = [&](const ColumnInfo& other) { return have_equal_rows(other, column); };
        if (std::ranges::any_of(columns.first(i), is_alike)) continue;
        std::string names;
        for (const ColumnInfo& other : columns.subspan(i))
            if (is_alike(other)) names += join(names.empty() ? "" : ", ", other.name);
        rows += join("\n**", names, "**, ", column.row_size, " bytes");
        rows += has_fields(column) ? join("\n\n", row_table({column.leaves, 0}, known))
                                   : join(": one ", type_of_leaf(column.leaves[0]), "\n");
    }
    return join(list, rows);
}

} // namespace lockstone::cli
