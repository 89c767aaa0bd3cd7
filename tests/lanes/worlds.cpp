// No kernel reads unspecified bits of a lane, so no instruction set's value there matters.
#include "golden/table.h"
#include "lanes/checked_lanes.h"
#include "solve/kernels/kernels.h"

#include <doctest/doctest.h>

namespace lockstone::test {

TEST_CASE("every scene has its golden hashes in lanes that check their bits") {
    LaneFaults::forget();
    const golden::Table expected = golden::from_file();
    REQUIRE_FALSE(expected.empty());
    REQUIRE(solve::kernels_of(Simd::scalar)->contacts->lanes == CheckedLanes::lanes);
    CHECK(golden::differences(expected, golden::computed(expected, Simd::scalar)) == "");
    INFO("the first: ", std::string(LaneFaults::first != nullptr ? LaneFaults::first.load() : "none"));
    CHECK(LaneFaults::count == 0);
}

TEST_CASE("checked lanes count each use of a bit that has no meaning") {
    using L = CheckedLanes;
    const std::int32_t numbers[4] = {-7, 1, 2, 3}, masks[4] = {-1, 0, 0, -1};
    const auto faults = [](auto&& operation) {
        const std::uint64_t before = LaneFaults::count;
        operation();
        return LaneFaults::count - before;
    };
    const L::V low = L::load32(numbers), whole = L::extended(L::load_low(numbers)), mask = L::load32(masks);
    std::int64_t out[4];
    CHECK(faults([&] { L::store64(out, low); }) == 1);
    CHECK(faults([&] { L::store64(out, L::add(low, whole)); }) == 1);
    CHECK(faults([&] { L::greater64(low, whole); }) == 1);
    CHECK(faults([&] { L::packed(L::shift_right<1>(low)); }) == 4); // one for each lane
    CHECK(faults([&] { L::shift_right_signed<1>(low); }) == 1);
    CHECK(faults([&] { L::shift_right_by(whole, low); }) == 1);
    CHECK(faults([&] { L::select(whole, low, low); }) == 1);
    CHECK(faults([&] { L::lanes_of(whole); }) == 2); // plus one for its low halves
    CHECK(faults([&] { L::store64(out, whole), L::greater64(whole, whole), L::packed(low); }) == 0);
    CHECK(faults([&] { L::store64(out, L::shift_left<32>(low)), L::packed(L::shift_right<32>(whole)); }) ==
          0);
    CHECK(faults([&] { L::select(mask, low, low), L::lanes_of(mask); }) == 0);
    CHECK(L::packed(low).at == L::packed(whole).at);
}

} // namespace lockstone::test
