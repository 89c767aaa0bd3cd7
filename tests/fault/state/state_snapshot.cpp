// A saver that forgets a column must be found out, by the check that the real one passes.
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

/// Sends one state through `transfer(from, to)` into another with other content; the differences that remain.
template <class Transfer> std::vector<Difference> lost_in(Transfer&& transfer) {
    const Sample s = make_sample();
    const State saved = random_state(s, 6, 30, 4, 1);
    State restored = random_state(s, 6, 30, 4, 2);
    transfer(saved, restored);
    return State::diff(saved, restored, 1);
}

/// Copies the rows of all columns but one.
struct ForgetfulSaver {
    std::string forgotten;
    void operator()(const State& from, State& to) const {
        for (std::uint32_t column = 0; column < from.layout().columns().size(); ++column)
            if (from.layout().columns()[column].name != forgotten)
                std::ranges::copy(from.bytes(column), to.edit_bytes(column).begin());
    }
};

} // namespace

TEST_CASE("ring images and portable images lose nothing") {
    CHECK(lost_in([](const State& from, State& to) {
              Image image;
              from.save(image);
              to.restore(image);
          }).empty());
    CHECK(lost_in([](const State& from, State& to) {
              REQUIRE(to.restore_portable(from.save_portable()).ok());
          }).empty());
}

TEST_CASE("a saver that forgets a column is caught, and the column named") {
    CHECK(lost_in(ForgetfulSaver{""}).empty());
    const Sample s = make_sample();
    for (const ColumnInfo& column : s.layout->columns()) {
        const auto lost = lost_in(ForgetfulSaver{column.name});
        REQUIRE(lost.size() == 1);
        CHECK(lost[0].column == column.name);
        CHECK(lost[0].row == 0);
    }
}

} // namespace lockstone::test
