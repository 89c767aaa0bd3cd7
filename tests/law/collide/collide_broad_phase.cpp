// The broad phase finds exactly the pairs that a comparison of all boxes finds, after any history.
#include "collide/broad/broad_phase.h"
#include "collide/swept_box.h"
#include "oracle/double_shapes.h"
#include "support/allocation_counter.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>

using namespace lockstone;
using namespace lockstone::collide;

namespace {

/// A crowd of boxes that move, appear, vanish and change kind.
struct Crowd {
    struct Member {
        bool present = false, is_static = false;
        oracle::D3 at{}, velocity{};
        double size = 0;
        Bounds bounds{};
    };
    std::vector<Member> members;
    oracle::RandomReal random;
    double room;

    Crowd(std::size_t count, double room_size, std::uint64_t seed)
        : members(count), random(seed), room(room_size) {
        for (Member& m : members) appear(m);
    }
    void appear(Member& m) {
        const auto coordinate = [&] { return random.uniform(-room, room); };
        const double x = coordinate(), y = coordinate(), z = coordinate();
        m = {true, random.below(4) == 0, {x, y, z}, random.vector(0, 0.2), random.log_uniform(0.1, 1.5), {}};
        measure(m);
    }
    static void measure(Member& m) {
        const auto bound = [](double v) { return oracle::as_fixed<Bound>(v); };
        const oracle::D3 at = m.at;
        const double s = m.size;
        m.bounds = {{bound(at.x - s), bound(at.y - s), bound(at.z - s)},
                    {bound(at.x + s), bound(at.y + s), bound(at.z + s)}};
    }
    void step() {
        for (Member& m : members) {
            const std::uint32_t event = random.below(200);
            if (event == 0) m.present = !m.present;
            if (event == 1) appear(m);
            if (event == 2) m.is_static = !m.is_static;
            if (m.is_static && event > 4) continue;
            if (random.below(3) == 0) continue; // asleep for a frame
            m.at = m.at + m.velocity;
            for (int i = 0; i < 3; ++i)
                if (std::abs(m.at[i]) > room) m.velocity[i] = -m.velocity[i];
            measure(m);
        }
    }
    void set(BroadPhase& phase, std::uint32_t i) const {
        const Member& m = members[i];
        const auto way = [](double v) { return oracle::as_fixed<Bound>(v); };
        const bool is_known = i % 2 == 0; // this member's motion is passed to set()
        if (!m.present)
            phase.remove(i);
        else if (is_known)
            phase.set(i, m.bounds, m.is_static, {way(m.velocity.x), way(m.velocity.y), way(m.velocity.z)});
        else if (m.is_static || !phase.move_within(i, m.bounds))
            phase.set(i, m.bounds, m.is_static);
    }
    std::vector<ProxyPair> brute_force() const {
        std::vector<ProxyPair> out;
        for (std::uint32_t a = 0; a < members.size(); ++a)
            for (std::uint32_t b = a + 1; b < members.size(); ++b) {
                const Member &x = members[a], &y = members[b];
                if (x.present && y.present && !(x.is_static && y.is_static) && overlap(x.bounds, y.bounds))
                    out.push_back({a, b});
            }
        return out;
    }
};

/// Returns an empty string if the pairs are the brute-force ones in order, else the first difference.
std::string check_pairs(const std::vector<ProxyPair>& found, const std::vector<ProxyPair>& expected) {
    for (std::size_t i = 0; i < std::max(found.size(), expected.size()); ++i) {
        const auto name = [](const ProxyPair& p) { return std::to_string(p.a) + "-" + std::to_string(p.b); };
        if (i >= found.size()) return "missing " + name(expected[i]);
        if (i >= expected.size()) return "extra " + name(found[i]);
        if (found[i] != expected[i]) return "found " + name(found[i]) + ", expected " + name(expected[i]);
    }
    return {};
}

} // namespace

TEST_CASE("three broad phases with different histories find the brute-force pairs of a moving crowd in every "
          "frame") {
    constexpr std::uint32_t count = 300;
    Crowd crowd(count, 7, 1);
    oracle::RandomReal random(2);
    BroadPhase kept(count), rebuilt(count), restless(count, decimal<Bound>("0.5"));
    std::vector<ProxyPair> pairs;
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    std::size_t total = 0;
    for (int frame = 0; frame < 200; ++frame) {
        crowd.step();
        const std::vector<ProxyPair> expected = crowd.brute_force();
        total += expected.size();
        for (std::uint32_t i = 0; i < count; ++i) crowd.set(kept, i);
        kept.find_pairs(pairs);
        REQUIRE(check_pairs(pairs, expected) == "");
        for (std::uint32_t i = 0; i < count; ++i) {
            REQUIRE(kept.contains(i) == crowd.members[i].present);
            if (kept.contains(i)) REQUIRE(kept.bounds(i) == crowd.members[i].bounds);
        }

        rebuilt.clear();
        CHECK(!rebuilt.contains(random.below(count)));
        for (std::uint32_t i = count; i-- > 0;) crowd.set(rebuilt, i);
        rebuilt.find_pairs(pairs);
        REQUIRE(check_pairs(pairs, expected) == "");

        for (std::uint32_t i = count - 1; i > 0; --i) std::swap(order[i], order[random.below(i + 1)]);
        for (std::uint32_t i : order) {
            if (random.below(10) == 0) restless.remove(i);
            if (random.below(10) == 0) {
                const std::uint32_t other = random.below(count);
                restless.set(i, crowd.members[other].bounds, random.below(2) == 0);
            }
            crowd.set(restless, i);
        }
        if (frame % 3 != 1) restless.find_pairs(pairs); // find_pairs() runs twice in some frames
        restless.find_pairs(pairs);
        REQUIRE(check_pairs(pairs, expected) == "");
    }
    CHECK(total > 20000);
}

TEST_CASE("the check reports a broad phase that drops a pair or adds one or breaks the order") {
    Crowd crowd(100, 4, 3);
    const std::vector<ProxyPair> expected = crowd.brute_force();
    REQUIRE(expected.size() > 50);
    CHECK(check_pairs(expected, expected) == "");
    std::vector<ProxyPair> wrong = expected;
    wrong.erase(wrong.begin() + 20);
    CHECK(check_pairs(wrong, expected) != "");
    wrong = expected;
    wrong.pop_back();
    CHECK(check_pairs(wrong, expected) != "");
    wrong = expected;
    wrong.push_back({98, 99});
    CHECK(check_pairs(wrong, expected) != "");
    wrong = expected;
    std::swap(wrong[3], wrong[4]);
    CHECK(check_pairs(wrong, expected) != "");
    // A broad phase that missed one move returns wrong pairs, and the check detects that.
    BroadPhase stale(100);
    for (std::uint32_t i = 0; i < 100; ++i) crowd.set(stale, i);
    for (int frame = 0; frame < 20; ++frame) crowd.step();
    for (std::uint32_t i = 1; i < 100; ++i) crowd.set(stale, i);
    crowd.members[0] = {true, false, {0, 0, 0}, {}, 4, {}};
    Crowd::measure(crowd.members[0]);
    std::vector<ProxyPair> pairs;
    stale.find_pairs(pairs);
    CHECK(check_pairs(pairs, crowd.brute_force()) != "");
}

TEST_CASE("the broad phase finds the first pairs of a crowd after searches that succeeded and searches that "
          "gave up") {
    constexpr std::uint32_t count = 300;
    Crowd crowd(count, 3, 7);
    oracle::RandomReal random(8);
    BroadPhase kept(count);
    std::vector<ProxyPair> pairs;
    const auto is_wanted = [](ProxyPair p) { return (p.a + p.b) % 3 != 0; };
    int given_up = 0, listed = 0;
    for (int frame = 0; frame < 60; ++frame) {
        crowd.step();
        for (std::uint32_t i = 0; i < count; ++i) crowd.set(kept, i);
        std::vector<ProxyPair> expected = crowd.brute_force();
        // All pairs, or fewer than there are, so that the broad phase must give up.
        const bool all = random.below(3) == 0;
        const std::size_t most = all ? SIZE_MAX : random.below(static_cast<std::uint32_t>(expected.size()));
        const bool found = kept.find_pairs(pairs, most);
        REQUIRE(found == all);
        ++(found ? listed : given_up);
        if (found) REQUIRE(check_pairs(pairs, expected) == "");
        std::erase_if(expected, [&](ProxyPair p) { return !is_wanted(p); });
        expected.resize(std::min(expected.size(), most));
        kept.find_first_pairs(pairs, most, is_wanted);
        REQUIRE(check_pairs(pairs, expected) == "");
    }
    CHECK(given_up > 20);
    CHECK(listed > 10);
}

TEST_CASE("the broad phase caches the answers of a filter and calls a new filter for all pairs") {
    constexpr std::uint32_t count = 200;
    Crowd crowd(count, 5, 9);
    oracle::RandomReal random(10);
    BroadPhase kept(count);
    std::vector<ProxyPair> pairs;
    std::uint32_t apart = 2;
    std::size_t asked = 0, total = 0;
    PairFilter filter{[&](ProxyPair p) { return ++asked, (p.a + p.b) % apart != 0; }};
    for (int frame = 0; frame < 200; ++frame) {
        crowd.step();
        for (std::uint32_t i = 0; i < count; ++i) crowd.set(kept, i);
        filter.is_new = random.below(5) == 0;
        if (filter.is_new) apart = 2 + random.below(3);
        const bool is_asked = random.below(8) != 0, gives_up = random.below(8) == 0;
        if (gives_up) CHECK(!kept.find_pairs(pairs, 3, filter));
        filter.is_new = filter.is_new && !gives_up;
        kept.find_pairs(pairs, SIZE_MAX, is_asked ? filter : PairFilter{});
        std::vector<ProxyPair> expected = crowd.brute_force();
        std::erase_if(expected, [&](ProxyPair p) { return is_asked && (p.a + p.b) % apart == 0; });
        total += expected.size();
        REQUIRE(check_pairs(pairs, expected) == "");
    }
    CHECK(total > 10000);
    asked = 0, filter.is_new = false;
    kept.find_pairs(pairs, SIZE_MAX, filter), asked = 0;
    kept.find_pairs(pairs, SIZE_MAX, filter);
    CHECK(asked == 0);
}

TEST_CASE(
    "the broad phase excludes pairs of two proxies that never move, and finds all others, whichever side "
    "searches") {
    constexpr std::uint32_t count = 300;
    Crowd crowd(count, 6, 11);
    oracle::RandomReal random(12);
    BroadPhase kept(count);
    std::vector<bool> is_still(count, false);
    std::vector<ProxyPair> pairs;
    std::size_t total = 0, all = 0;
    for (int frame = 0; frame < 300; ++frame) {
        crowd.step();
        // In some frames many proxies begin or cease to move, or appear at another place; in the others few do.
        const bool are_many = random.below(4) == 0;
        const std::uint32_t one_in = are_many ? 2 : 100;
        const bool are_mostly_still = random.below(2) == 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            if (random.below(one_in) == 0) {
                is_still[i] = are_mostly_still ? random.below(10) != 0 : random.below(2) == 0;
                if (random.below(2) == 0) crowd.appear(crowd.members[i]);
            }
            kept.set_never_moves(i, is_still[i]);
            crowd.set(kept, i);
        }
        std::vector<ProxyPair> expected = crowd.brute_force();
        all += expected.size();
        std::erase_if(expected, [&](ProxyPair p) { return is_still[p.a] && is_still[p.b]; });
        total += expected.size();
        if (random.below(10) == 0) kept.find_pairs(pairs, 3); // gives up
        kept.find_pairs(pairs);
        REQUIRE(check_pairs(pairs, expected) == "");
        kept.find_first_pairs(pairs, SIZE_MAX, [](ProxyPair) { return true; });
        REQUIRE(check_pairs(pairs, expected) == "");
    }
    CHECK(total > 10000);
    CHECK(all > total + 5000);
}

TEST_CASE("a query returns the sorted proxies that a box overlaps or that a swept box may meet on short and "
          "long paths") {
    constexpr std::uint32_t count = 400;
    Crowd crowd(count, 8, 6);
    BroadPhase phase(count);
    BroadPhase::Asker asker;
    std::vector<std::uint32_t> begun, overlapping, expected, standing;
    int more_than_begun = 0;
    for (int frame = 0; frame < 30; ++frame) {
        crowd.step();
        for (std::uint32_t i = 0; i < count; ++i) crowd.set(phase, i);
        phase.update_trees();
        for (int k = 0; k < 20; ++k) {
            const Crowd::Member& from = crowd.members[crowd.random.below(count)];
            Crowd::Member to = from;
            to.at = to.at + crowd.random.vector(0, k % 2 == 0 ? from.size : 8);
            Crowd::measure(to);
            const SweptBox box(from.bounds, to.bounds);
            expected.clear(), standing.clear();
            for (std::uint32_t i = 0; i < count; ++i) {
                if (!crowd.members[i].present || !box.may_meet(crowd.members[i].bounds)) continue;
                expected.push_back(i);
                if (crowd.members[i].is_static) standing.push_back(i);
            }
            phase.query(box, asker);
            REQUIRE(asker.proxies == expected);
            phase.query_static(box, asker);
            REQUIRE(asker.proxies == standing);
            overlapping.clear();
            for (std::uint32_t i = 0; i < count; ++i)
                if (crowd.members[i].present && overlap(crowd.members[i].bounds, from.bounds))
                    overlapping.push_back(i);
            phase.query(from.bounds, begun);
            REQUIRE(begun == overlapping);
            more_than_begun += begun != expected ? 1 : 0;
        }
    }
    CHECK(more_than_begun > 100); // planted: the box at the start of the way misses some
}

TEST_CASE("the broad phase allocates no memory for a crowd in steady motion") {
    constexpr std::uint32_t count = 500;
    Crowd crowd(count, 10, 9);
    BroadPhase phase(count);
    std::vector<ProxyPair> pairs;
    const auto frame = [&] {
        crowd.step();
        for (std::uint32_t i = 0; i < count; ++i) crowd.set(phase, i);
        phase.find_pairs(pairs);
    };
    for (int i = 0; i < 50; ++i) frame();
    pairs.reserve(2 * pairs.size());
    const lockstone::test::AllocationCounter counter;
    for (int i = 0; i < 100; ++i) frame();
    CHECK(counter.count() == 0);
}
