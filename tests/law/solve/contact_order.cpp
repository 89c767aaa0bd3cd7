// In what order contacts are solved: from the top down.
#include "solve/contacts/contact_order.h"
#include "solve/contacts/contact.h"
#include "support/effort.h"
#include "support/random.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace lockstone;
using namespace lockstone::solve;
using namespace lockstone::test::scene;

namespace {

/// A heap as the order sees it: the first body stands still, of the others each touches some before it.
struct Heap {
    SolverBodies bodies;
    std::vector<Contact> contacts;
    ContactOrder order;
};

/// `deepest`: the largest overlap [m].
Heap heap_of(std::uint32_t count, double deepest, std::uint64_t seed) {
    Random random(seed);
    Heap heap;
    heap.bodies.body.resize(count + 1);
    heap.bodies.step.resize(count + 1);
    for (std::uint32_t b = 0; b <= count; ++b) heap.bodies.step[b].movable = b != 0 && b != count;
    for (std::uint32_t b = 1; b < count; ++b)
        for (int k = 0; k < 3; ++k) {
            Contact contact;
            contact.body_a = static_cast<std::uint32_t>(random(0, b));
            contact.body_b = b;
            contact.count = static_cast<std::uint32_t>(random(1, 4.99));
            contact.points = {};
            contact.restitution = contact.rolling = Unit{};
            for (std::uint32_t i = 0; i < contact.count; ++i)
                contact.points[i].separation = quantize<Separation>(random(-deepest, 0));
            heap.contacts.push_back(contact);
        }
    heap.order.find(heap.contacts, heap.bodies);
    heap.order.find_stages();
    return heap;
}

/// Where two contacts move the same body, and the one that is solved later is higher up. `upwards`: is lower.
std::string out_of_levels(const Heap& heap, bool upwards = false) {
    std::vector<std::uint64_t> last(heap.bodies.body.size(), upwards ? 0 : ~std::uint64_t{0});
    for (std::uint32_t s = 0; s < heap.order.stage_count(); ++s)
        for (const std::uint32_t i : heap.order.stage(s)) {
            const Contact& contact = heap.contacts[i];
            const std::uint64_t height =
                std::uint64_t{heap.order.level(contact.body_a)} + heap.order.level(contact.body_b);
            for (const std::uint32_t b : {contact.body_a, contact.body_b}) {
                if (!heap.bodies.step[b].movable) continue;
                if (upwards ? height < last[b] : height > last[b]) return "body " + std::to_string(b);
                last[b] = height;
            }
        }
    return {};
}

/// Contacts that do not come once, and where a contact is in no later pack than one before it that moves the same body.
std::string out_of_order(const Heap& heap, std::uint32_t lanes, const std::vector<std::uint32_t>& packed) {
    std::vector<std::uint32_t> pack_of(heap.contacts.size(), ContactOrder::no_contact);
    for (std::uint32_t i = 0; i < packed.size(); ++i) {
        if (packed[i] == ContactOrder::no_contact) continue;
        if (pack_of[packed[i]] != ContactOrder::no_contact) return "twice: " + std::to_string(packed[i]);
        pack_of[packed[i]] = i / lanes;
    }
    std::vector<std::uint32_t> last(heap.bodies.body.size(), 0); // one more than the pack
    for (std::uint32_t s = 0; s < heap.order.stage_count(); ++s)
        for (const std::uint32_t i : heap.order.stage(s)) {
            if (pack_of[i] == ContactOrder::no_contact) return "lost: " + std::to_string(i);
            for (const std::uint32_t b : {heap.contacts[i].body_a, heap.contacts[i].body_b}) {
                if (!heap.bodies.step[b].movable) continue;
                if (pack_of[i] + 1 <= last[b]) return "too early: " + std::to_string(i);
                last[b] = pack_of[i] + 1;
            }
        }
    return {};
}

constexpr int per_side = 4, layers = 20;

/// Balls, boxes and capsules of a metre that are dropped into a pit of 5 x 5 m, in layers up to 26 m high.
World dropped(std::uint64_t seed) {
    Random random(seed);
    WorldDef def;
    def.sleeping = 0;
    World w = made(World::create(def));
    add_floor(w);
    for (const double side : {-1.0, 1.0}) {
        add_wall(w, at(side * 3, 20, 0), vec(0.5, 20, 4));
        add_wall(w, at(0, 20, side * 3), vec(3, 20, 0.5));
    }
    const Geometry shapes[] = {sphere(half(Real(1))), box(half(Real(1)), half(Real(1)), half(Real(1))),
                               capsule(real(0.3), real(0.4))};
    for (int i = 0; i < layers * per_side * per_side; ++i) {
        const auto across = [&](int k) { return 1.22 * (k - 1.5) + random(-0.05, 0.05); };
        const int column = i % per_side, row = i / per_side % per_side;
        add(w,
            {.pose = at(across(column), 1 + 1.3 * (i / (per_side * per_side)), across(row),
                        turned(axis_y, random(-17, 17)))},
            {.geometry = shapes[i % 3]});
    }
    return w;
}

double deepest_mm(World& w, int ticks) {
    for (int t = 0; t < ticks; ++t) w.tick();
    double deepest = 0;
    for (const World::ContactPoint& point : w.contacts())
        deepest = std::max(deepest, -1e3 * to_double(point.separation));
    return deepest;
}

} // namespace

TEST_CASE("contacts are solved from the top down, however deep they are") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
        for (const double deepest : {0.0024, 0.15}) {
            const Heap heap = heap_of(200, deepest, seed);
            CHECK(out_of_levels(heap) == "");
            CHECK(out_of_levels(heap, true) != ""); // twin
        }
}

// Every contact of a heap has points; half of them have carried something, and some have one point.
TEST_CASE("packs across stages leave contacts in order, and fewer lanes empty") {
    for (std::uint64_t seed = 1; seed <= 20; ++seed)
        for (const std::uint32_t lanes : {1u, 2u, 4u, 8u}) {
            Heap heap = heap_of(200, 0.01, seed);
            for (std::size_t i = 0; i < heap.contacts.size(); i += 2)
                heap.contacts[i].points[0].impulse = Speed::from_raw(1);
            heap.order.find(heap.contacts, heap.bodies);
            std::vector<std::uint32_t> dense, by_stage, stages;
            heap.order.pack_densely(lanes, dense);
            heap.order.pack_stages(lanes, by_stage, stages);
            CHECK(out_of_order(heap, lanes, dense) == "");
            CHECK(out_of_order(heap, lanes, by_stage) == "");
            CHECK(dense.size() <= by_stage.size());
            if (lanes > 1) CHECK(dense.size() < by_stage.size());
            std::vector<std::uint32_t> lost(dense.begin(), dense.end() - lanes), reversed(dense);
            std::reverse(reversed.begin(), reversed.end());
            CHECK(out_of_order(heap, lanes, lost) != ""); // twins
            CHECK(out_of_order(heap, lanes, reversed) != "");
        }
}

// Four centimetres are half of what Box3D leaves in such a heap of a thousand, and a third more than Bullet. Where loads are
// forgotten as if they were impacts, four of these eight heaps stay deeper.
TEST_CASE("what is rammed into each other when a heap lands comes apart") {
    for (int seed = 1; seed <= test::tries(8); ++seed) {
        World w = dropped(static_cast<std::uint64_t>(seed));
        double while_landing = 0;
        for (int t = 0; t < 100; ++t) while_landing = std::max(while_landing, deepest_mm(w, 1));
        CHECK(while_landing > 40); // twin: it is rammed
        CHECK(deepest_mm(w, 500) < 40);
    }
}
