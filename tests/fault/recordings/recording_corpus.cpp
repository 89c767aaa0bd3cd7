// The recording fuzzer's inputs and mutations of them: bytes are refused with an error sentence, or play equally each
// time.
#include "fuzz/corpus.h"
#include "fuzz/seeds.h"

#include <doctest/doctest.h>

using namespace lockstone;

namespace {

struct Tally {
    std::size_t read = 0, opened = 0, ticks = 0;
    void add(const fuzz::RecordingOutcome& o) {
        read += o.was_read ? 1 : 0, opened += o.was_opened ? 1 : 0;
        ticks += static_cast<std::size_t>(o.ticks);
    }
};

} // namespace

TEST_CASE(
    "recording corpus: the corpus holds every seed and the reader rejects each file or the file plays") {
    const std::vector<fuzz::Seed> seeds = fuzz::recording_seeds();
    const std::vector<fuzz::Buffer> all = fuzz::corpus("recording", seeds);
    for (const fuzz::Seed& seed : seeds)
        CHECK_MESSAGE(std::ranges::find(all, seed.bytes) != all.end(), seed.name);
    Tally tally;
    for (const fuzz::Buffer& bytes : all) {
        fuzz::RecordingOutcome outcome;
        CHECK(fuzz::check_recording(bytes, outcome) == "");
        tally.add(outcome);
    }
    CHECK(tally.read >= 2 * fuzz::recording_count);
    CHECK(tally.read < all.size());
    CHECK(tally.ticks >= 8 * fuzz::recording_count);
}

TEST_CASE("recording corpus: the reader rejects each of hundreds of mutations or the mutation plays") {
    const std::vector<fuzz::Buffer> all = fuzz::corpus("recording", {});
    Random random = Random::seeded(2026);
    Tally tally;
    const std::size_t count = fuzz::rounds(100);
    for (std::size_t i = 0; i < count; ++i) {
        fuzz::RecordingOutcome outcome;
        CAPTURE(i);
        REQUIRE(fuzz::check_recording(fuzz::mutated(all, random), outcome) == "");
        tally.add(outcome);
    }
    CHECK(tally.read > count / 20);
    CHECK(tally.opened < count);
    CHECK(tally.ticks > count / 10);
}

TEST_CASE("recording corpus: the check finds planted faults of readers and players") {
    const fuzz::RecordingReader right;
    const auto judge = [](const fuzz::Buffer& data, auto&& read, auto&& step) {
        fuzz::RecordingOutcome outcome;
        return fuzz::check_recording(fuzz::read_recording_input(data), outcome, read, step);
    };
    const fuzz::Buffer good = fuzz::Script().u8(1 | 2 << 2 | 16).done(), none = fuzz::Script().u8(1).done();
    REQUIRE(judge(good, right, fuzz::RecordingStepper()) == "");
    REQUIRE(judge(none, right, fuzz::RecordingStepper()) == "");
    const auto silent = [](const fuzz::Buffer&, fuzz::OnDamage) -> Result<replay::Recording> {
        return Error{"fuzz.lsr: "};
    };
    CHECK(judge(none, silent, fuzz::RecordingStepper()) == "a refusal does not say why");
    const auto strict_only = [&](const fuzz::Buffer& file, fuzz::OnDamage on_damage) {
        return on_damage == fuzz::OnDamage::refuse ? right(file, on_damage) : right({}, on_damage);
    };
    CHECK(judge(good, strict_only, fuzz::RecordingStepper()) == "a whole file is recovered otherwise");
    int steps = 0;
    const auto drifting = [&](replay::Player& player) {
        if (++steps == 11) lockstone::test::scene::done(player.world().set_gravity({}));
        return player.step();
    };
    CHECK(judge(good, right, drifting) == "played from the start again it is another run");
    const auto always_other = [&](replay::Player& player) {
        lockstone::test::scene::done(player.world().set_gravity({}));
        return player.step();
    };
    CHECK(judge(good, right, always_other) == "verified as good, but it plays otherwise");
}
