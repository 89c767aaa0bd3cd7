// A write that bypasses State::edit leaves stale hashes and images: the self-check names the column and the rows.
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

/// Flips a bit of a row without State::edit.
void write_unseen(const State& state, Column<Manifold> column, std::uint32_t row) {
    const std::span<const Manifold> rows = state.rows(column);
    const_cast<Manifold&>(rows[row]).key ^= 1;
}

} // namespace

TEST_CASE("planted fault: a write without State::edit makes the hash stale and fails the self-check") {
    const Sample s = make_sample();
    State state = random_state(s, 8, 400, 10, 1);
    const std::uint64_t before = state.hash();
    CHECK(state.verify_versions().ok());
    write_unseen(state, s.manifold, 171);
    const Status status = state.verify_versions();
    REQUIRE(!status.ok());
    CHECK(status.error().message == "versions: column contact.manifold, rows 170 to 339: written without "
                                    "State::edit since the last hash");
#ifdef NDEBUG // other builds stop at a stale hash
    CHECK(state.hash() == before);
#endif
    state.edit_row(s.manifold, 200);
    CHECK(state.verify_versions().ok());
    CHECK(state.hash() != before);
}

TEST_CASE("planted fault: the self-check finds a write without State::edit against an image that was saved "
          "before") {
    const Sample s = make_sample();
    const State state = random_state(s, 8, 400, 10, 1);
    Image image;
    state.save(image);
    CHECK(state.verify_versions(image).ok());
    write_unseen(state, s.manifold, 399);
    const Status status = state.verify_versions(image);
    REQUIRE(!status.ok());
    CHECK(status.error().message == "versions: column contact.manifold, rows 340 "
                                    "to 399: other rows than in the "
                                    "image, but the same version");
}

} // namespace lockstone::test
