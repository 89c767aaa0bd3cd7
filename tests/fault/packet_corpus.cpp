// The packet fuzzer's inputs and mutations of them: for all packets the rules of packet_check.h hold, and dropped
// packets change nothing.
#include "fuzz/corpus.h"
#include "fuzz/seeds.h"

#include <doctest/doctest.h>

using namespace lockstone;

namespace {

/// Forwards all calls to a session; a test overrides some.
class Relay : public Session {
  public:
    explicit Relay(std::unique_ptr<Session> to) : real(std::move(to)) {}
    void poll(std::uint64_t now_ms) override { real->poll(now_ms); }
    void add_local_input(std::uint32_t player, std::span<const std::byte> input) override {
        real->add_local_input(player, input);
    }
    Step advance() override { return real->advance(); }
    Step settle() override { return real->settle(); }
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override {
        return real->report_hash(tick, hash);
    }
    std::optional<ConfirmedTick> next_confirmed() override { return real->next_confirmed(); }
    std::optional<Notice> next_notice() override { return real->next_notice(); }
    Status drop_peer(PeerId peer) override { return real->drop_peer(peer); }
    std::uint64_t current_tick() const override { return real->current_tick(); }
    std::uint32_t images_max() const override { return real->images_max(); }
    void set_input_delay(std::uint32_t ticks) override { real->set_input_delay(ticks); }
    PeerQuality quality(PeerId peer) const override { return real->quality(peer); }
    const SessionStats& stats() const override { return real->stats(); }

  protected:
    std::unique_ptr<Session> real;
};

/// A planted fault: the session delays its inputs after a dropped packet.
class Offended final : public Relay {
  public:
    using Relay::Relay;
    void poll(std::uint64_t now_ms) override {
        real->poll(now_ms);
        if (real->stats().packets_dropped > 0) real->set_input_delay(5);
    }
};
/// A planted fault: the session changes one local input.
class Wilful final : public Relay {
  public:
    using Relay::Relay;
    void add_local_input(std::uint32_t player, std::span<const std::byte> input) override {
        std::vector<std::byte> other(input.begin(), input.end());
        if (current_tick() == 9) other[0] ^= std::byte{1};
        real->add_local_input(player, other);
    }
};
/// A planted fault: the session stalls permanently.
class Lame final : public Relay {
  public:
    using Relay::Relay;
    Step advance() override {
        if (real->current_tick() < 9) return real->advance();
        return {Stall::inputs_missing, {}, 0};
    }
};

template <class Planted> std::string judge(const fuzz::Buffer& data) {
    fuzz::PacketOutcome outcome;
    return fuzz::check_packets(data, outcome, [](const auto& setup, const auto& def, Transport& transport) {
        return std::make_unique<Planted>(fuzz::SessionMaker()(setup, def, transport));
    });
}

} // namespace

TEST_CASE("packet corpus: the corpus holds every seed and no packet of it harms a session") {
    const std::vector<fuzz::Seed> seeds = fuzz::packet_seeds();
    const std::vector<fuzz::Buffer> all = fuzz::corpus("packet", seeds);
    for (const fuzz::Seed& seed : seeds)
        CHECK_MESSAGE(std::ranges::find(all, seed.bytes) != all.end(), seed.name);
    std::uint64_t taken = 0, dropped = 0;
    for (const fuzz::Buffer& bytes : all) {
        fuzz::PacketOutcome outcome;
        CHECK(fuzz::check_packets(bytes, outcome) == "");
        taken += outcome.hostile_taken, dropped += outcome.dropped;
    }
    CHECK(taken > 5);
    CHECK(dropped > 50);
}

TEST_CASE("packet corpus: no packet of hundreds of mutations harms a session") {
    const std::vector<fuzz::Buffer> all = fuzz::corpus("packet", {});
    Random random = Random::seeded(2026);
    std::uint64_t dropped = 0;
    const std::size_t count = fuzz::rounds(300);
    for (std::size_t i = 0; i < count; ++i) {
        fuzz::PacketOutcome outcome;
        CAPTURE(i);
        REQUIRE(fuzz::check_packets(fuzz::mutated(all, random), outcome) == "");
        dropped += outcome.dropped;
    }
    CHECK(dropped > count);
}

TEST_CASE("packet corpus: the check finds planted faults of sessions") {
    const fuzz::Buffer peace = fuzz::Script().u8(0).u8(2).u8(2).done(),
                       stranger = fuzz::Script().u8(0).u8(2).u8(3).u8(3).u8(0).u8(2).u8(2).done();
    REQUIRE(judge<Relay>(peace) == "");
    REQUIRE(judge<Relay>(stranger) == "");
    CHECK(judge<Offended>(peace) == "");
    CHECK(judge<Offended>(stranger).starts_with("dropped packets changed"));
    CHECK(judge<Wilful>(peace) != "");
    CHECK(judge<Lame>(peace) != "");
}
