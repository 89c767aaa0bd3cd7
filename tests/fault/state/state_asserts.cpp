// Programming errors end the program and print the values. Each test runs in a child process.
#include "support/state_sample.h"
#include "support/stops.h"

#include <doctest/doctest.h>

#if defined(__unix__)

namespace lockstone::test {
namespace {

bool begins_with(const std::string& text, std::string_view start) {
    INFO(text);
    const bool good = std::string_view(text).starts_with(start);
    CHECK(good);
    return good;
}

} // namespace

TEST_CASE("a programming error aborts with the broken rule and the values") {
    const Sample s = make_sample();
    State state(s.layout);
    CHECK(begins_with(last_words([&] { state.resize(s.body, 9); }),
                      "lockstone: broken rule: rows <= rows_max(table): table "
                      "body: 9 rows, capacity 8"));
    CHECK(begins_with(last_words([] {
                          StateLayout layout;
                          layout.add_table("t", 1);
                          layout.add_table("t", 2);
                      }),
                      "lockstone: broken rule: table.name != name: two tables named t"));
    CHECK(begins_with(last_words([] {
                          StateLayout layout;
                          const TableId t = layout.add_table("t", 1);
                          layout.add_column<Real>(t, "c", Group::game);
                          layout.add_column<Speed>(t, "c", Group::game);
                      }),
                      "lockstone: broken rule: find_column(name) == nullptr: two "
                      "columns named c"));
    CHECK(begins_with(last_words([] {
                          StateLayout layout;
                          layout.add_column(layout.add_table("t", 1), "c", Group::game, 8,
                                            {{"x", 0, 4, LeafKind::signed_integer, 0}});
                      }),
                      "lockstone: broken rule: row_size"));
    CHECK(begins_with(last_words([] {
                          StateLayout layout;
                          layout.add_table("t", 1);
                          const State never(std::make_shared<const StateLayout>(std::move(layout)));
                      }),
                      "lockstone: broken rule: shared_layout != nullptr && shared_layout->is_finished(): "
                      "a State needs a finished layout"));
    CHECK(begins_with(last_words([&] {
                          const State other(StateLayout().finished());
                          Image image;
                          other.save(image);
                          state.restore(image);
                      }),
                      "lockstone: broken rule: good.ok(): the image is of a state whose columns have other "
                      "names or fields"));
    CHECK(begins_with(last_words([&] { state.restore(Image{}); }),
                      "lockstone: broken rule: good.ok(): the image is empty"));
    CHECK(
        begins_with(last_words([&] {
                        const Sample larger = make_sample(9);
                        Image image;
                        random_state(larger, 9, 0, 0, 1).save(image);
                        state.restore(image);
                    }),
                    "lockstone: broken rule: rows[table] <= info.rows_max: table body: 9 rows, capacity 8"));
    CHECK(last_words([&] { state = State(make_sample(9).layout); }) == "");
    CHECK(begins_with(last_words([&] {
                          const State other = random_state(make_sample(9), 9, 0, 0, 1);
                          state = other;
                      }),
                      "lockstone: broken rule: rows[table] <= info.rows_max"));
}

} // namespace lockstone::test

#endif
