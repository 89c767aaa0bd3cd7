// Compounds: convex parts with poses, selected by extent.
#include "lockstone/math/math.h"
#include "shapes/asset/asset_file.h"
#include "shapes/bounds_hierarchy.h"

#include <algorithm>
#include <numeric>

namespace lockstone {
namespace shapes {
namespace {

using base::join;

constexpr Real place_max = Real(100);

Extent united(const Extent& a, const Extent& b) { return {min(a.lower, b.lower), max(a.upper, b.upper)}; }

/// The bounds of a rotated and moved box, grown by more than the rounding errors.
Extent placed(const Extent& e, const Transform& local) {
    const Rotation r = to_rotation(local.rotation);
    const CoordinateVec3 middle = e.lower + e.upper, half = e.upper - e.lower; // both are twice the value
    const Rotation turned = transpose(r);
    const CoordinateVec3 at = mul<Coordinate>(r, middle);
    const CoordinateVec3 reach{dot<Coordinate>(abs(turned.x), half), dot<Coordinate>(abs(turned.y), half),
                               dot<Coordinate>(abs(turned.z), half)};
    const CoordinateVec3 position = to<Coordinate>(local.position);
    const auto halved = [](Coordinate c, std::int64_t slack) {
        return Coordinate::from_raw((c.raw >> 1) + slack);
    };
    const auto bound = [&](CoordinateVec3 c, std::int64_t slack) {
        return CoordinateVec3{halved(c.x, slack), halved(c.y, slack), halved(c.z, slack)} + position;
    };
    return {bound(at - reach, -4), bound(at + reach, 4)};
}

/// Orders the parts so that neighbours in space are together, in groups that fill whole boxes of the hierarchy.
class Ordering {
  public:
    explicit Ordering(Compound& of) : compound(of) {
        compound.order.resize(compound.parts.size());
        std::iota(compound.order.begin(), compound.order.end(), 0u);
        split(0, static_cast<std::uint32_t>(compound.order.size()));
    }

  private:
    static std::int64_t twice_middle(const Extent& e, int axis) {
        return e.lower[axis].raw + e.upper[axis].raw;
    }

    void split(std::uint32_t first, std::uint32_t last) {
        if (last - first <= BoundsHierarchy::width) return;
        Extent all = part(first).extent;
        for (std::uint32_t i = first; i < last; ++i) all = united(all, part(i).extent);
        const CoordinateVec3 size = all.upper - all.lower;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
        const auto before = [&](std::uint32_t a, std::uint32_t b) {
            const std::int64_t ma = twice_middle(compound.parts[a].extent, axis);
            const std::int64_t mb = twice_middle(compound.parts[b].extent, axis);
            return ma != mb ? ma < mb : a < b;
        };
        std::sort(compound.order.begin() + first, compound.order.begin() + last, before);
        std::uint32_t box =
            BoundsHierarchy::width; // number of parts in each box of the level that these parts fill
        while (box * BoundsHierarchy::width < last - first) box *= BoundsHierarchy::width;
        const std::uint32_t boxes = (last - first + box - 1) / box, middle = first + boxes / 2 * box;
        split(first, middle);
        split(middle, last);
    }
    const Compound::Part& part(std::uint32_t i) const { return compound.parts[compound.order[i]]; }

    Compound& compound;
};

void complete(Compound& compound) {
    for (Compound::Part& part : compound.parts) {
        part.extent = placed(extent_of(part.solid), part.local);
        compound.extent = &part == compound.parts.data() ? part.extent : united(compound.extent, part.extent);
        const Length inner = inner_radius(part.solid);
        if (inner > compound.inner_radius) {
            compound.inner_radius = inner;
            compound.core_center = part.local * shapes::core_center(part.solid);
        }
    }
    // Few parts are tested one by one. A compound of one part, 112 bytes, then takes 592 bytes of memory. With
    // a hierarchy it would take 960, more than the factor of eight that a reader of recordings allows for an
    // asset.
    if (compound.parts.size() <= BoundsHierarchy::width) return;
    Ordering{compound};
    compound.hierarchy = std::make_unique<const BoundsHierarchy>(
        static_cast<std::uint32_t>(compound.parts.size()), compound.extent,
        [&](std::uint32_t i) { return compound.parts[compound.order[i]].extent; });
}

bool is_unit(Quat q) {
    const std::int64_t square =
        SumOfProducts<Unit, Unit>{}.add(q.x, q.x).add(q.y, q.y).add(q.z, q.z).add(q.w, q.w).exact();
    return magnitude(square - (std::int64_t{1} << 60)) <= std::uint64_t{1} << 33; // 2^-27
}

/// Returns the error in a part, or an empty string.
std::string complaint(const CompoundPart& part) {
    if (part.geometry.kind > ShapeKind::plane)
        return join("its kind is ", static_cast<std::uint32_t>(part.geometry.kind),
                    ", there is none of that number");
    if (part.geometry.kind > ShapeKind::hull)
        return join("it is a ", name_of(part.geometry.kind), ", it must be convex");
    if (std::string why = validate(part.geometry); !why.empty()) return why;
    if (part.geometry.kind == ShapeKind::hull && part.geometry.scale != scale_one)
        return "a hull's scale must be 1";
    const Vec3 away = abs(part.local.position);
    if (max(away.x, max(away.y, away.z)) > place_max) return "it is further than 100 m from the origin";
    if (!is_unit(part.local.rotation)) return "its rotation is not a unit quaternion";
    return {};
}

void write_part(base::ByteWriter& out, const CompoundPart& part) {
    const Geometry& g = part.geometry;
    out.u32(static_cast<std::uint32_t>(g.kind));
    for (Length l :
         {g.radius, g.half_extent.x, g.half_extent.y, g.half_extent.z, g.scale.x, g.scale.y, g.scale.z})
        out.i32(l.raw);
    out.u64(g.asset.value);
    const Transform& t = part.local;
    for (Real r : {t.position.x, t.position.y, t.position.z}) out.i64(r.raw);
    for (Unit u : {t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w}) out.i32(u.raw);
}

CompoundPart read_part(base::ByteReader& in) {
    CompoundPart part{};
    part.geometry.kind = static_cast<ShapeKind>(in.u32("part kind"));
    const auto length = [&](const char* what) { return Length::from_raw(in.i32(what)); };
    part.geometry.radius = length("part radius");
    for (int i = 0; i < 3; ++i) part.geometry.half_extent[i] = length("part half extent");
    for (int i = 0; i < 3; ++i) part.geometry.scale[i] = length("part scale");
    part.geometry.asset.value = in.u64("part asset");
    for (int i = 0; i < 3; ++i) part.local.position[i] = Real::from_raw(in.i64("part position"));
    Quat& q = part.local.rotation;
    for (Unit* u : {&q.x, &q.y, &q.z, &q.w}) *u = Unit::from_raw(in.i32("part rotation"));
    return part;
}
constexpr std::size_t part_size = 4 + 7 * 4 + 8 + 3 * 8 + 4 * 4;

} // namespace

Compound::Compound() = default;
Compound::~Compound() = default;

void Compound::find(const Extent& where, std::vector<std::uint32_t>& out) const {
    const std::size_t start = out.size();
    if (hierarchy == nullptr) {
        for (std::uint32_t i = 0; i < parts.size(); ++i)
            if (overlap(parts[i].extent, where)) out.push_back(i);
        return;
    }
    hierarchy->visit(where, [&](std::uint32_t i) {
        if (hierarchy->is_exact() || overlap(parts[order[i]].extent, where)) out.push_back(order[i]);
    });
    std::sort(out.begin() + static_cast<std::ptrdiff_t>(start), out.end());
}

void write_compound(base::ByteWriter& out, std::span<const CompoundPart> parts) {
    out.u32(static_cast<std::uint32_t>(parts.size()));
    for (const CompoundPart& part : parts) write_part(out, part);
}

std::unique_ptr<const Compound> read_compound(base::ByteReader& in, const AssetLibrary& library) {
    const std::size_t start = in.offset();
    const std::uint32_t count = in.u32("part count");
    if (in.ok() && (count < 1 || count > compound_parts_max))
        in.fail_at(start, join("a compound of ", count, " parts, it must have 1 .. ", compound_parts_max));
    if (in.ok() && in.remaining() != count * part_size)
        in.fail_at(start,
                   join(count, " parts need ", count * part_size, " bytes, ", in.remaining(), " remain"));
    auto compound = std::make_unique<Compound>();
    for (std::uint32_t i = 0; in.ok() && i < count; ++i) {
        const std::size_t at = in.offset();
        const CompoundPart part = read_part(in);
        std::string why = complaint(part);
        Solid solid{.geometry = part.geometry};
        if (why.empty() && part.geometry.kind == ShapeKind::hull) {
            const Asset* asset = library.find(part.geometry.asset);
            if (asset == nullptr || asset->hull == nullptr)
                why = join("there is no hull ", base::hex(part.geometry.asset.value), " in the library");
            else
                solid.hull = asset->hull.get();
        }
        if (!why.empty()) in.fail_at(at, join("part ", i, ": ", why));
        compound->parts.push_back({solid, part.local, Extent{}});
    }
    if (!in.ok()) return nullptr;
    complete(*compound);
    return compound;
}

} // namespace shapes

Result<AssetBytes> bake_compound(std::span<const CompoundPart> parts) {
    if (parts.empty() || parts.size() > compound_parts_max)
        return Error{
            base::join("a compound of ", parts.size(), " parts, it must have 1 .. ", compound_parts_max)};
    for (std::size_t i = 0; i < parts.size(); ++i)
        if (std::string why = shapes::complaint(parts[i]); !why.empty())
            return Error{base::join("part ", i, ": ", why)};
    shapes::AssetWriter writer(ShapeKind::compound, 0);
    shapes::write_compound(writer.out(), parts);
    return std::move(writer).finish();
}

} // namespace lockstone
