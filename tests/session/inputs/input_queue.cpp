// The input queue: predictions, true inputs, and the first tick where the two differ.
#include "session/inputs/input_queue.h"

#include "session/arena.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;
using session::InputQueue;
using session::never;

namespace {

std::array<std::byte, 1> input(unsigned value) { return {static_cast<std::byte>(value)}; }
unsigned value_of(const PlayerInput& i) { return std::to_integer<unsigned>(i.bytes[0]); }

class CountUp final : public InputPredictor {
  public:
    void predict(std::uint32_t, std::span<const std::byte> last, std::uint64_t ahead,
                 std::span<std::byte> out) const override {
        out[0] = static_cast<std::byte>(std::to_integer<std::uint64_t>(last[0]) + ahead);
    }
};

} // namespace

TEST_CASE("an input queue passes the number of ticks to look ahead to its predictor") {
    InputQueue queue(0, 1);
    queue.confirm(input(10));
    CHECK(value_of(queue.use(1, CountUp{})) == 11);
    CHECK(value_of(queue.use(4, CountUp{})) == 14);
}

TEST_CASE(
    "an input queue returns settled zeros from a disconnection on and accepts no more confirmed inputs") {
    InputQueue queue(0, 1);
    queue.confirm(input(9));
    for (std::uint64_t tick = 0; tick < 5; ++tick) queue.use(tick, repeat_last_input());
    CHECK(queue.settled_through() == 1);
    queue.disconnect_at(1);
    CHECK(queue.settled_through() == never);
    CHECK(queue.take_first_wrong() == 1);
    CHECK(queue.use(3, repeat_last_input()).status == InputStatus::disconnected);
    CHECK(value_of(queue.use(3, repeat_last_input())) == 0);
    queue.confirm(input(4));
    CHECK(queue.next() == 1);
}

TEST_CASE("an input queue agrees with a complete list of inputs under random use") {
    test::SplitMix random(3);
    InputQueue queue(0, 1);
    std::vector<unsigned> truth;                // by tick
    std::vector<std::pair<unsigned, bool>> ran; // by tick: value, and whether it was predicted
    for (int step = 0; step < 50'000; ++step) {
        if (random.below(2) == 0 && queue.room() > 0) {
            const unsigned value = random.below(3);
            truth.push_back(value);
            queue.confirm(input(value));
        }
        std::uint64_t wrong = never;
        for (std::uint64_t t = ran.size(); t-- > 0;) {
            if (t < truth.size() && ran[t].second && ran[t].first != truth[t]) wrong = t;
            if (t + 80 < ran.size()) break;
        }
        REQUIRE(queue.take_first_wrong() == wrong);
        const std::size_t end = std::max(ran.size(), truth.size() + random.below(10));
        if (wrong != never) ran.resize(wrong); // as a rollback does: ticks from `wrong` on run again
        while (ran.size() < end) {
            const PlayerInput used = queue.use(ran.size(), repeat_last_input());
            const bool guess = used.status == InputStatus::predicted;
            REQUIRE(guess == (ran.size() >= truth.size()));
            REQUIRE(value_of(used) == (guess ? (truth.empty() ? 0 : truth.back()) : truth[ran.size()]));
            ran.emplace_back(value_of(used), guess);
        }
        for (std::uint64_t t = std::min(ran.size(), truth.size()); t-- > 0 && ran[t].second;)
            ran[t].second = false;
        queue.forget_before(std::min(ran.size(), truth.size()));
    }
}
