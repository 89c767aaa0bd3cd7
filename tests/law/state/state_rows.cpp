#include "lockstone/math/random.h"
#include "lockstone/state.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

struct Padded {
    std::uint8_t a;
    std::uint32_t b;
};
template <class V> constexpr void describe(Padded& p, V&& visit) { visit("a", p.a), visit("b", p.b); }

struct WithFloat {
    float a;
};
template <class V> constexpr void describe(WithFloat& p, V&& visit) { visit("a", p.a); }

struct WithPointer {
    const char* a;
};
template <class V> constexpr void describe(WithPointer& p, V&& visit) { visit("a", p.a); }

struct WithBool {
    bool a;
};
template <class V> constexpr void describe(WithBool& p, V&& visit) { visit("a", p.a); }

enum LooseEnum { loose };
struct WithLooseEnum {
    LooseEnum a;
};
template <class V> constexpr void describe(WithLooseEnum& p, V&& visit) { visit("a", p.a); }

struct Forgetful {
    std::uint32_t a, b;
};
template <class V> constexpr void describe(Forgetful& p, V&& visit) { visit("a", p.a); }

struct Repeated {
    std::uint32_t a, b;
};
template <class V> constexpr void describe(Repeated& p, V&& visit) { visit("a", p.a), visit("a", p.a); }

struct Swapped {
    std::uint32_t a, b;
};
template <class V> constexpr void describe(Swapped& p, V&& visit) { visit("b", p.b), visit("a", p.a); }

struct Nameless {
    std::uint32_t a;
};

struct NestedFloat {
    std::array<WithFloat, 2> a;
};
template <class V> constexpr void describe(NestedFloat& p, V&& visit) { visit("a", p.a); }

struct Virtual {
    virtual ~Virtual() = default;
    std::uint64_t a;
};
template <class V> constexpr void describe(Virtual& p, V&& visit) { visit("a", p.a); }

// Each rejected type has a similar accepted one, so that the rejection has the intended reason.
static_assert(StateRow<Health> && StateRow<Manifold> && StateRow<Inventory> && StateRow<Transform> &&
              StateRow<Rotation>);
static_assert(StateRow<std::uint8_t> && StateRow<std::int64_t> && StateRow<Real> && StateRow<Mood>);
static_assert(StateRow<lockstone::Random>, "a game's record keeps its generator");
static_assert(StateRow<std::array<Health, 3>>);
static_assert(!StateRow<Padded>, "padding");
static_assert(!StateRow<WithFloat> && !StateRow<float> && !StateRow<double> && !StateRow<NestedFloat>,
              "floats");
static_assert(!StateRow<WithPointer> && !StateRow<int*>, "pointers");
static_assert(!StateRow<WithBool> && !StateRow<bool>, "bool has two legal values of 256");
static_assert(!StateRow<char> && !StateRow<wchar_t>, "sign or size depends on the platform");
static_assert(!StateRow<WithLooseEnum>, "the compiler chooses the enum's size");
static_assert(!StateRow<Forgetful>, "a field that the list forgets");
static_assert(!StateRow<Repeated>, "a field named twice hides another");
static_assert(!StateRow<Swapped>, "fields out of order");
static_assert(!StateRow<Nameless>, "no field list");
static_assert(!StateRow<Virtual>, "a virtual table pointer");
static_assert(!StateRow<std::string> && !StateRow<std::vector<int>>, "memory elsewhere");

} // namespace

TEST_CASE("leaves_of() names leaves by their path and gives offset and size and kind and fraction bits") {
    const auto leaves = leaves_of<Manifold>();
    REQUIRE(leaves.size() == 5);
    CHECK(leaves[0].name == "key");
    CHECK(leaves[0].kind == LeafKind::unsigned_integer);
    CHECK(leaves[3].name == "points[1].normal");
    CHECK(leaves[3].offset == 16);
    CHECK(leaves[3].size == 4);
    CHECK(leaves[3].kind == LeafKind::fixed_point);
    CHECK(leaves[3].fraction_bits == 19);
    CHECK(leaves_of<Health>()[1].kind == LeafKind::signed_integer);
    CHECK(leaves_of<Transform>()[6].name == "rotation.w");
    CHECK(leaves_of<std::uint32_t>()[0].name == "value");
}

TEST_CASE("columns start at multiples of 64 bytes in order and without overlap after the row counts") {
    const Sample s = make_sample();
    std::size_t end = s.layout->tables().size() * sizeof(std::uint32_t);
    for (const ColumnInfo& column : s.layout->columns()) {
        CHECK(column.offset % 64 == 0);
        CHECK(column.offset >= end);
        end = column.offset + std::size_t{s.layout->tables()[column.table].capacity} * column.row_size;
    }
    CHECK(s.layout->size_bytes() >= end);
    const State state(s.layout);
    CHECK(reinterpret_cast<std::uintptr_t>(state.block_bytes().data()) % 64 == 0);
    CHECK(std::ranges::all_of(state.block_bytes(), [](std::byte b) { return b == std::byte{}; }));
}

TEST_CASE("the schema hash depends on every name and format but on no capacity") {
    const auto hash_of = [](std::string table, std::string column, Group group, std::vector<LeafInfo> leaves,
                            std::uint32_t capacity) {
        StateLayout layout;
        layout.add_column(layout.add_table(std::move(table), capacity), std::move(column), group, 4,
                          std::move(leaves));
        return std::move(layout).finished()->schema_hash();
    };
    const LeafInfo x{"x", 0, 4, LeafKind::fixed_point, 19};
    const auto reference = hash_of("t", "c", Group::game, {x}, 1);
    CHECK(hash_of("t", "c", Group::game, {x}, 7) == reference);
    CHECK(hash_of("u", "c", Group::game, {x}, 1) != reference);
    CHECK(hash_of("t", "d", Group::game, {x}, 1) != reference);
    CHECK(hash_of("t", "c", Group::motion, {x}, 1) != reference);
    CHECK(hash_of("t", "c", Group::game, {{"y", 0, 4, LeafKind::fixed_point, 19}}, 1) != reference);
    CHECK(hash_of("t", "c", Group::game, {{"x", 0, 4, LeafKind::fixed_point, 20}}, 1) != reference);
    CHECK(hash_of("t", "c", Group::game, {{"x", 0, 4, LeafKind::signed_integer, 0}}, 1) != reference);
    CHECK(hash_of("t", "c", Group::game,
                  {{"x", 0, 2, LeafKind::fixed_point, 9}, {"y", 2, 2, LeafKind::fixed_point, 9}},
                  1) != reference);
}

TEST_CASE("State zeroes the rows that it removes and rows that it adds again are zero") {
    const Sample s = make_sample();
    State state = random_state(s, 8, 400, 3, 1), smaller = state;
    smaller.resize(s.contact, 170);
    CHECK(same_bytes(smaller.bytes(s.manifold.index),
                     state.bytes(s.manifold.index).first(170 * sizeof(Manifold))));
    smaller.resize(s.contact, 400);
    for (const Manifold& m : smaller.rows(s.manifold).subspan(170)) CHECK(m.key == 0);
    state.resize(s.body, 0), state.resize(s.contact, 0), state.resize(s.tag, 0);
    CHECK(same_bytes(state.block_bytes(), State(s.layout).block_bytes()));
}

} // namespace lockstone::test
