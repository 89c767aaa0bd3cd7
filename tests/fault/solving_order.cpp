// The check of the order of solving: it accepts the plans that the solvers make, and refuses plans with one fault each.
#include "lockstone/testing.h"
#include "solve/contacts/contact.h"
#include "solve/contacts/contact_order.h"
#include "solve/contacts/contact_packs.h"
#include "support/random.h"
#include "support/rigs/feature_pit.h"
#include "support/stops.h"
#include "support/task_worlds.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace lockstone;
using namespace lockstone::solve;
using namespace lockstone::test;
using namespace lockstone::test::scene;

namespace {

/// Impulses do not move body 0. Each other body touches three bodies of lower numbers.
struct Heap {
    SolverBodies bodies;
    std::vector<ContactHead> heads;
    std::vector<Transform> poses;
    ContactOrder order;
};

Heap heap_of(std::uint32_t count, std::uint64_t seed) {
    RandomPoint random(seed);
    Heap heap;
    heap.bodies.body.resize(count + 1), heap.bodies.step.resize(count + 1);
    for (std::uint32_t b = 0; b <= count; ++b) heap.bodies.step[b].movable = b != 0 && b != count;
    for (std::uint32_t b = 1; b < count; ++b)
        for (int k = 0; k < 3; ++k)
            heap.heads.push_back({static_cast<std::uint32_t>(random(0, b)), b,
                                  ContactOrder::several | ContactOrder::touches | ContactOrder::carried});
    heap.poses.resize(count);
    for (Transform& pose : heap.poses) pose.position = vec(random(-9, 9), random(-1, 1), random(-3, 3));
    heap.order.find(heap.heads, heap.bodies);
    return heap;
}

/// A column of bodies: each touches the next one, and the first touches body 0.
Heap column_of(std::uint32_t count) {
    Heap heap;
    heap.bodies.body.resize(count + 1), heap.bodies.step.resize(count + 1);
    for (std::uint32_t b = 1; b < count; ++b) {
        heap.bodies.step[b].movable = true;
        heap.heads.push_back({b - 1, b, ContactOrder::several | ContactOrder::touches});
    }
    heap.poses.resize(count);
    heap.order.find(heap.heads, heap.bodies);
    return heap;
}

std::vector<BetweenPasses> followed_in(const ContactPacks& packs) {
    std::vector<BetweenPasses> followed;
    for (std::uint32_t k = 0; k < packs.plan().strands; ++k)
        for (std::uint32_t i = 0; i < packs.plan().count(k); ++i)
            for (const std::uint32_t body : packs.bodies_after({k, i, 0})) followed.push_back({body, k, i});
    return followed;
}

/// A plan whose strands have these numbers of pieces. Each piece is one item, and items are numbered strand by strand.
base::StrandPlan plan_of(std::initializer_list<std::uint32_t> pieces) {
    base::StrandPlan plan;
    std::uint32_t item = 0;
    for (const std::uint32_t count : pieces) {
        for (std::uint32_t i = 0; i < count; ++i, ++item)
            plan.pieces[plan.strands].push_back({item, item + 1, 0, 0, item});
        ++plan.strands;
    }
    return plan;
}
void add_wait(base::StrandPlan& plan, std::uint32_t strand, std::uint32_t piece, base::PieceWait wait) {
    base::Piece& at = plan.pieces[strand][piece];
    at.first_wait = static_cast<std::uint32_t>(plan.waits.size());
    plan.waits.push_back(wait);
    at.last_wait = at.first_wait + 1;
}

} // namespace

TEST_CASE("items of one strand and items with waits between them move a body in order") {
    const std::vector<Solved> solved = {{1, 0, {7, no_body}}, {2, 1, {7, 3}}};
    CHECK(order_fault({}, solved) == "");
    base::StrandPlan plan = plan_of({2, 1});
    CHECK(order_fault(plan, solved) == "body 7: rank 1 in item 2 does not come after rank 0 in item 1");
    add_wait(plan, 1, 0, {0, 1, false});
    CHECK(order_fault(plan, solved) != ""); // it waits for the piece before that one
    plan.waits[0] = {0, 2, true};
    CHECK(order_fault(plan, solved) != ""); // it waits for the previous pass
    plan.waits[0] = {0, 2, false};
    CHECK(order_fault(plan, solved) == "");
}

TEST_CASE("waits order pieces across strands and the check rejects pieces that wait in a cycle") {
    const std::vector<Solved> solved = {{0, 0, {7, no_body}}, {2, 1, {7, no_body}}};
    base::StrandPlan plan = plan_of({1, 1, 1});
    add_wait(plan, 1, 0, {0, 1, false});
    CHECK(order_fault(plan, solved) != "");
    add_wait(plan, 2, 0, {1, 1, false});
    CHECK(order_fault(plan, solved) == "");
    add_wait(plan, 0, 0, {2, 1, false});
    CHECK(order_fault(plan, solved) == "piece 0 of strand 0 waits for ever");
}

TEST_CASE(
    "planted fault: the check finds items that share a body or are reversed or repeated or in no piece") {
    const base::StrandPlan plan = plan_of({3});
    CHECK(order_fault(plan, std::vector<Solved>{{0, 0, {4, 5}}, {0, 1, {5, 6}}}) != "");
    CHECK(order_fault(plan, std::vector<Solved>{{1, 0, {4, 5}}, {0, 1, {5, 6}}}) != "");
    CHECK(order_fault(plan, std::vector<Solved>{{0, 0, {4, 5}}, {1, 0, {4, 5}}}) ==
          "body 4: rank 0 is solved twice");
    CHECK(order_fault(plan, std::vector<Solved>{{3, 0, {4, 5}}}) == "item 3 is in no piece");
    CHECK(order_fault(plan, std::vector<Solved>{{0, 0, {4, 5}}, {0, 1, {6, no_body}}}) == "");
}

TEST_CASE("the check requires that each body is followed between passes after its last and before its first "
          "constraint") {
    const std::vector<Solved> solved = {{0, 0, {7, no_body}}, {1, 1, {7, no_body}}};
    base::StrandPlan plan = plan_of({1, 1});
    add_wait(plan, 1, 0, {0, 1, false});
    const std::vector<BetweenPasses> followed = {{7, 1, 0}};
    CHECK(order_fault(plan, solved, followed) == "body 7 is followed after rank 0 of the next pass");
    add_wait(plan, 0, 0, {1, 1, true});
    CHECK(order_fault(plan, solved, followed) == "");
    CHECK(order_fault(plan, solved, std::vector<BetweenPasses>{{7, 0, 0}}) ==
          "body 7 is followed before its rank 1");
    CHECK(order_fault(plan, solved, std::vector<BetweenPasses>{{7, 1, 0}, {7, 1, 0}}) ==
          "body 7 is followed twice");
    CHECK(order_fault(plan, solved, std::vector<BetweenPasses>{}) == "body 7 is not followed");
}

TEST_CASE("plans of contacts keep the order and the check finds two swapped packs and missing waits") {
    int swapped = 0, left_out = 0, waits = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
        for (const std::uint32_t lanes : {1u, 2u, 4u, 8u})
            for (const std::uint32_t workers : {1u, 2u, 5u}) {
                const Heap heap = heap_of(700, seed);
                ContactPacks made;
                made.make(heap.order, {lanes, workers, false, 2000}, heap.poses);
                REQUIRE(made.order_fault(heap.order) == "");
                std::vector<std::uint32_t> packed(made.contact_of_lane().begin(),
                                                  made.contact_of_lane().end());
                const auto solved = solved_in_packs(heap.order, packed, lanes);
                REQUIRE(order_fault(made.plan(), solved) == "");
                for (std::size_t w = 0; w < made.plan().waits.size(); w += 7, ++waits) {
                    base::StrandPlan hurried = made.plan();
                    hurried.waits[w].pieces = 0;
                    left_out += order_fault(hurried, solved) != "" ? 1 : 0;
                }
                std::swap_ranges(packed.begin(), packed.begin() + lanes, packed.end() - lanes);
                swapped += order_fault(made.plan(), solved_in_packs(heap.order, packed, lanes)) != "" ? 1 : 0;
            }
    CHECK(swapped == 72);
    CHECK(waits > 100);
    CHECK(left_out > waits * 9 / 10); // other waits may order these pieces too
}

TEST_CASE(
    "passes in one run keep the order from pass to pass and the check finds a missing wait between passes") {
    const Heap column = column_of(2000);
    for (const std::uint32_t workers : {2u, 4u}) {
        ContactPacks made;
        made.make(column.order, {4, workers, true, 0}, column.poses);
        REQUIRE(made.runs_all_passes());
        CHECK(made.order_fault(column.order) == "");
        const auto solved = solved_in_packs(column.order, made.contact_of_lane(), 4);
        const std::vector<BetweenPasses> followed = followed_in(made);
        CHECK(order_fault(made.plan(), solved, followed) == "");
        int refused = 0, between = 0;
        for (std::size_t w = 0; w < made.plan().waits.size(); ++w) {
            if (!made.plan().waits[w].of_last_round) continue;
            base::StrandPlan hurried = made.plan();
            hurried.waits[w].pieces = 0;
            refused += order_fault(hurried, solved, followed) != "" ? 1 : 0, ++between;
        }
        CHECK(between > 0);
        CHECK(refused == between);
        std::vector<BetweenPasses> early = followed;
        for (BetweenPasses& f : early) f.piece = 0;
        CHECK(order_fault(made.plan(), solved, early) != "");
    }
}

TEST_CASE("the plans of whole worlds keep the order on one thread and on workers") {
    ShuffledTasks two(1, 2), five(2, 5);
    for (Tasks* tasks :
         {static_cast<Tasks*>(nullptr), static_cast<Tasks*>(&two), static_cast<Tasks*>(&five)}) {
        World worlds[] = {net(30), towers(300).world, features::pit(200, features::rolls, 1),
                          features::pit(200, features::bounces, 1)};
        for (World& world : worlds) {
            world.set_tasks(tasks);
            CHECK(testing::order_fault(world) == "");
            for (int t = 0; t < 25; ++t) {
                world.tick();
                REQUIRE(testing::order_fault(world) == "");
            }
        }
    }
}

TEST_CASE("a pass counter accepts ascending ranks and ends the program if a body moves out of order") {
    PassCounter counter;
    counter.begin(3);
    const std::uint32_t first = counter.next_pass();
    counter.move(first, 0, 1), counter.move(first, 5, 1), counter.move(first, 2, 2);
    counter.move(first, 0, no_body);
    const std::uint32_t second = counter.next_pass();
    CHECK(second == first + 1);
    counter.move(second, 4, 1);
    if (!checks_order) return;
    CHECK(last_words([&] {
              counter.move(second, 3, 1);
          }).find("body 1 is moved by rank 3 of pass 2 after rank 4") != std::string::npos);
    CHECK(last_words([&] { counter.move(first, 9, 2), counter.move(first, 9, 2); }) != "");
    CHECK(last_words([&] { counter.move(second, 5, 1); }) == "");
}
