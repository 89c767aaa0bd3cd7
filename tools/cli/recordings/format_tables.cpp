#include "cli/recordings/format_tables.h"

#include "cli/recordings/state_columns.h"
#include "lockstone/command.h"
#include "lockstone/math/decimal.h"
#include "lockstone/world_def.h"

#include <algorithm>

namespace lockstone::cli {
namespace {

// ---- types ---------------------------------------------------------------------------------------------------

/// The names of the structs that have a table of their own. A new struct does not compile until it has a name here.
template <class T> constexpr const char* struct_name = nullptr;
template <> constexpr const char* struct_name<BodyDef> = "BodyDef";
template <> constexpr const char* struct_name<ShapeDef> = "ShapeDef";
template <> constexpr const char* struct_name<Geometry> = "Geometry";
template <> constexpr const char* struct_name<FieldDef> = "FieldDef";
template <> constexpr const char* struct_name<Region> = "Region";
template <> constexpr const char* struct_name<ExplosionDef> = "ExplosionDef";
template <> constexpr const char* struct_name<JointDef> = "JointDef";
template <> constexpr const char* struct_name<JointAxis> = "JointAxis";
template <> constexpr const char* struct_name<VehicleDef> = "VehicleDef";
template <> constexpr const char* struct_name<WheelDef> = "WheelDef";
template <> constexpr const char* struct_name<Tyre> = "Tyre";
template <> constexpr const char* struct_name<CurvePoint> = "CurvePoint";
template <> constexpr const char* struct_name<AntiRollBar> = "AntiRollBar";
template <> constexpr const char* struct_name<EngineDef> = "EngineDef";
template <> constexpr const char* struct_name<GearboxDef> = "GearboxDef";
template <> constexpr const char* struct_name<Differential> = "Differential";
template <> constexpr const char* struct_name<TrackDef> = "TrackDef";
template <> constexpr const char* struct_name<VehicleInput> = "VehicleInput";
template <> constexpr const char* struct_name<CharacterDef> = "CharacterDef";
template <> constexpr const char* struct_name<CharacterInput> = "CharacterInput";

template <class T> struct TypeName {
    static std::string text() {
        static_assert(struct_name<T> != nullptr, "a struct of commands needs a name");
        return struct_name<T>;
    }
};
template <class T> std::string type_name() {
    if constexpr (FixedPoint<T>)
        return "I" + std::to_string(8 * sizeof(T) - T::fraction_bits) + "F" +
               std::to_string(T::fraction_bits);
    else if constexpr (Leaf<T>)
        return (detail::is_signed_leaf<T>() ? "i" : "u") + std::to_string(8 * sizeof(T));
    else
        return TypeName<T>::text();
}
template <> std::string type_name<Real>() { return "Real"; }
template <> struct TypeName<Vec3> {
    static std::string text() { return "Vec3"; }
};
template <class T> struct TypeName<Vector3<T>> {
    static std::string text() { return "3 x " + type_name<T>(); }
};
template <> struct TypeName<Quat> {
    static std::string text() { return "Quat"; }
};
template <> struct TypeName<Transform> {
    static std::string text() { return "Transform"; }
};
template <> struct TypeName<AssetId> {
    static std::string text() { return "u64"; }
};
template <class Tag> struct TypeName<Id<Tag>> {
    static std::string text() { return "Id"; }
};
template <class T> struct TypeName<Change<T>> {
    static std::string text() { return "Change of " + type_name<T>(); }
};
template <class T, std::size_t N> struct TypeName<std::array<T, N>> {
    static std::string text() { return std::to_string(N) + " x " + type_name<T>(); }
};

template <class T> std::size_t bytes_of() {
    T value{};
    std::size_t bytes = 0;
    for_each_leaf(value, [&](auto& leaf) { bytes += sizeof leaf; });
    return bytes;
}

// ---- ranges, as RangeCheck says them ---------------------------------------------------------------------------

std::string text_of(OwnRanges) { return ""; }
std::string text_of(const In<std::int64_t>& r) {
    if (r.low == r.high) return std::to_string(r.low);
    return std::to_string(r.low) + (r.low == 0 && r.high == 1 ? " or " : " to ") + std::to_string(r.high);
}
std::string text_of(const In<Real>& r) { return to_string(r.low) + " to " + to_string(r.high) + r.unit; }
std::string text_of(const Below& r) { return std::string("0 to less than ") + r.text; }
std::string text_of(const EitherSign& r) {
    return to_string(r.low) + " to " + to_string(r.high) + " or the negative of that";
}
std::string text_of(const BitsOf& r) {
    return std::string("a sum of ") + r.name + " bits, at most " + std::to_string(r.all);
}
std::string text_of(const EachIn& r) { return "each within " + to_string(r.most) + " " + r.unit; }
std::string text_of(const LongAtMost& r) { return std::string("at most ") + r.text + " long"; }
std::string text_of(const PoseIn& r) {
    return "position within " + to_string(r.most) + " m on each axis, rotation of length 1";
}
std::string text_of(UnitLong) { return "length 1"; }
template <class R> std::string text_of(const First<R>& r) {
    const std::string each = text_of(r.range);
    return each.empty() ? "entries in use only" : "entries in use: " + each;
}

// ---- tables --------------------------------------------------------------------------------------------------

/// One line of a table: consecutive fields with equal type and range.
struct Row {
    std::string names, type, range;
};

struct Rows {
    std::vector<Row> rows;

    template <class F, class R = OwnRanges> void operator()(const char* name, F&, const R& range = {}) {
        const Row row{name, type_name<F>(), text_of(range)};
        if (!rows.empty() && rows.back().type == row.type && rows.back().range == row.range)
            rows.back().names += ", " + row.names;
        else
            rows.push_back(row);
    }
};

template <class T> std::vector<Row> rows_of() {
    T value{};
    Rows rows;
    describe(value, rows);
    return rows.rows;
}

template <class T> std::string table_of() {
    std::string text = "| field | type | range |\n|---|---|---|\n";
    for (const Row& row : rows_of<T>())
        text +=
            "| " + row.names + " | " + row.type + " |" + (row.range.empty() ? "" : " " + row.range) + " |\n";
    return text;
}

/// The tables of all named structs. Each table follows the first table that uses its struct.
struct Definitions {
    std::string text;
    std::vector<std::string> seen;
    std::vector<NamedLeaves> leaves; ///< of the structs that the state may contain

    template <class F, class R = OwnRanges> void operator()(const char*, F& value, const R& = {}) {
        if constexpr (is_std_array<F>) {
            if constexpr (!Leaf<typename F::value_type>) (*this)("", value[0]);
        } else if constexpr (struct_name<F> != nullptr) {
            const std::string name = struct_name<F>;
            if (std::ranges::find(seen, name) != seen.end()) return;
            seen.push_back(name);
            if constexpr (StateRow<F>) leaves.push_back({name, leaves_of<F>()});
            text += "\n**" + name + "**, " + std::to_string(bytes_of<F>()) + " bytes\n\n" + table_of<F>();
            describe(value, *this);
        }
    }
};

template <class C> std::string command_row(std::size_t kind) {
    std::string fields;
    for (const Row& row : rows_of<C>()) fields += (fields.empty() ? "" : "; ") + row.names + ": " + row.type;
    return "| " + std::to_string(kind) + " | " + name_of(Command(C{})) + " | " +
           std::to_string(bytes_of<C>()) + " | " + fields + " |\n";
}

template <std::size_t... I> std::string commands(std::index_sequence<I...>) {
    std::string text = "| kind | name | bytes | fields |\n|---|---|---|---|\n";
    ((text += command_row<std::variant_alternative_t<I, Command>>(I)), ...);
    return text;
}

template <std::size_t... I> Definitions definitions(std::index_sequence<I...>) {
    Definitions all;
    const auto look_into = [&](auto command) { describe(command, all); };
    (look_into(std::variant_alternative_t<I, Command>{}), ...);
    all.text.erase(0, 1);
    return all;
}

/// The tables of the state of a world without game columns.
std::string state_of(std::vector<NamedLeaves> known) {
    known.push_back({"Transform", leaves_of<Transform>()});
    known.push_back({"Vec3", leaves_of<Vec3>()});
    known.push_back({"Quat", leaves_of<Quat>()});
    known.push_back({"Id", leaves_of<BodyId>()});
    return state_tables(*state_layout_of({}, {}), known);
}

} // namespace

std::string format_tables() {
    constexpr auto kinds = std::make_index_sequence<std::variant_size_v<Command>>{};
    Definitions all = definitions(kinds);
    const std::string state = state_of(std::move(all.leaves));
    const std::pair<std::string, std::string> parts[] = {{"world", table_of<WorldDef>()},
                                                         {"commands", commands(kinds)},
                                                         {"definitions", std::move(all.text)},
                                                         {"state", state}};
    std::string text;
    for (const auto& [name, table] : parts)
        text += "<!-- " + name + " -->\n" + table + "<!-- end of " + name + " -->\n";
    return text;
}

} // namespace lockstone::cli
