#include "support/allocation_counter.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {

TEST_CASE("an image fits the largest state and the smallest state") {
    const Sample s = make_sample();
    const State full = random_state(s, 8, 400, 100, 1), empty(s.layout);
    CHECK(full.image_bytes() == s.layout->image_bytes_max());
    Image image, fresh;
    full.save(image);
    empty.save(image);
    empty.save(fresh);
    CHECK(image == fresh);
    State state = full;
    state.restore(image);
    CHECK(same_bytes(state.block_bytes(), empty.block_bytes()));
}

TEST_CASE("save and restore and hash allocate nothing after the image has its size") {
    const Sample s = make_sample();
    State small = random_state(s, 1, 3, 1, 5), large = random_state(s, 8, 400, 100, 6);
    Image image;
    small.save(image);
    const AllocationCounter counter;
    std::uint64_t sum = 0;
    for (int i = 0; i < 10; ++i) {
        large.save(image);
        small.restore(image);
        sum += small.hash();
        small.resize(s.contact, 3);
        small.save(image);
    }
    CHECK(counter.count() == 0);
    CHECK(sum != 0);
}

TEST_CASE("the allocation counter counts allocations") {
    const AllocationCounter counter;
    const auto number = std::make_unique<int>(1);
    const State state(make_sample().layout);
    CHECK(*number == 1);
    CHECK(counter.count() > 1);
}

} // namespace lockstone::test
