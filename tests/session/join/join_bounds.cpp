// Bounds of the logs and states that hosts keep for joining machines, and of the packets, memory and time of a join.
#include "session/join/relayed.h"

#include <doctest/doctest.h>

#include <deque>

using namespace lockstone;
using namespace lockstone::test;

namespace {

constexpr std::uint64_t two_minutes = 7200; ///< [ticks], the time for which logs and states are kept

SessionDef two_players() {
    SessionDef def;
    def.content_id = 7;
    def.input_size = input_size_of<Pad>;
    def.players = {0, 1};
    return def;
}
std::uint32_t match_of_two() { return session::packet_context(two_players()).match; }

/// Stores sent packets, and returns the packets that the test puts in.
struct Desk final : Transport {
    std::vector<std::vector<std::byte>> sent;
    std::deque<std::pair<PeerId, std::vector<std::byte>>> in;
    std::vector<std::byte> held;
    void send(PeerId, std::span<const std::byte> bytes) override {
        sent.emplace_back(bytes.begin(), bytes.end());
    }
    std::optional<Datagram> receive() override {
        if (in.empty()) return std::nullopt;
        const PeerId from = in.front().first;
        held = std::move(in.front().second);
        in.pop_front();
        return Datagram{from, held};
    }
    void put(PeerId from, std::span<const std::byte> bytes) {
        in.emplace_back(from, std::vector<std::byte>(bytes.begin(), bytes.end()));
    }
    std::optional<session::Wish> last_wish() const {
        return sent.empty() ? std::nullopt : session::read_wish(sent.back(), match_of_two());
    }
};

/// The log of a player's machine. It sends each tick to one listener.
struct Log {
    session::TimelineHost host{two_players(),
                               {.log_ticks_max = two_minutes,
                                .delay_ticks = 0,
                                .listeners_max = 16,
                                .silence_polls = 600,
                                .keeps_unheard = false}};
    Desk desk;
    std::vector<std::byte> zeros = std::vector<std::byte>(sizeof(Pad));
    void add(std::uint64_t wanted) {
        const std::vector<PlayerInput> inputs(2, {zeros, InputStatus::confirmed});
        host.add(host.log_end(), inputs, 5);
        session::Wish wish{.wants_log = true, .ticket = 256};
        wish.wanted = wanted;
        host.hear(1, wish);
        desk.sent.clear();
        host.serve(desk, nullptr);
    }
    std::uint64_t ticks() const { return host.log_end() - host.log_begin(); }
};

/// A machine that begins at a state, and hosts that the test controls.
struct Newcomer {
    Desk desk;
    std::unique_ptr<Session> session;
    std::vector<std::byte> packet;
    std::uint64_t now = 0;
    std::vector<Notice> notices;
    explicit Newcomer(std::vector<PeerId> hosts)
        : session(make_spectator_session(two_players(), {.hosts = std::move(hosts), .from_state = true}, desk)
                      .value()) {}
    Step poll() {
        session->poll(now += 17);
        while (const auto notice = session->next_notice()) notices.push_back(*notice);
        return session->advance();
    }
    void offer(std::uint64_t tick, std::uint32_t bytes) {
        desk.put(0, session::write_offer(packet, match_of_two(), {tick, 1, 2, bytes}));
    }
    std::size_t refusals() const {
        return static_cast<std::size_t>(std::ranges::count_if(
            notices, [](const Notice& n) { return std::holds_alternative<StateRefused>(n); }));
    }
};

} // namespace

TEST_CASE(
    "a host keeps the newest ticks for listeners and all ticks that a slow listener lacks up to a limit") {
    Log level;
    for (std::uint64_t tick = 0; tick < 3 * two_minutes; ++tick) {
        level.add(tick);
        if (tick >= 512) REQUIRE(level.ticks() >= 256);
        REQUIRE(level.ticks() <= two_minutes);
    }
    Log behind; // the listener lacks tick 600 until the log has eight times its usual length
    for (std::uint64_t tick = 0; tick < 9 * two_minutes; ++tick) {
        behind.add(std::min<std::uint64_t>(tick, 600));
        if (tick < 8 * two_minutes) REQUIRE(behind.host.log_begin() <= 600);
        REQUIRE(behind.ticks() <= 8 * two_minutes);
    }
    REQUIRE(behind.host.log_begin() > 600);
    std::optional<session::Stretch> told; // an answer that says where the log begins
    for (int polls = 0; polls < 20 && !told; ++polls) {
        behind.add(600);
        for (const auto& packet : behind.desk.sent)
            if (const auto one = session::read_stretch(packet, match_of_two(), 6 + 2 * sizeof(Pad)))
                told = one;
    }
    REQUIRE(told);
    CHECK(told->count == 0);
    CHECK(told->first == behind.host.log_begin());
}

TEST_CASE("a host keeps a large state for eight times the time that its chunks take") {
    const auto polls_kept = [](std::size_t bytes) {
        Log log;
        log.add(0);
        const session::Snapshot state(1, 5, std::vector<std::byte>(bytes, std::byte{3}));
        log.host.set_snapshot(state.offer(), std::vector<std::byte>(bytes, std::byte{3}));
        session::Wish wish{.wants_state = true};
        wish.offered = 1;
        std::uint64_t polls = 0;
        for (; polls < 200'000; ++polls) {
            log.host.hear(1, wish);
            if (!log.host.is_snapshot_taken()) break;
            log.desk.sent.clear();
            log.host.serve(log.desk, nullptr);
        }
        return polls;
    };
    CHECK(polls_kept(5000) == two_minutes);
    CHECK(polls_kept(std::size_t{16} << 20) == ((std::size_t{16} << 20) + 959) / 960 * 8 / 2);
}

TEST_CASE("a host keeps the ticks after a large state while a guest downloads it") {
    Log log;
    const std::vector<std::byte> bytes(std::size_t{16} << 20, std::byte{3});
    log.add(0);
    log.host.set_snapshot(session::Snapshot(1, 5, bytes).offer(), bytes);
    session::Wish wish{.wants_state = true};
    wish.offered = 1;
    const std::vector<PlayerInput> inputs(2, {log.zeros, InputStatus::confirmed});
    while (log.host.log_end() < 3 * two_minutes) {
        log.host.add(log.host.log_end(), inputs, 5);
        log.host.hear(1, wish);
        log.desk.sent.clear();
        log.host.serve(log.desk, nullptr);
        REQUIRE(log.host.log_begin() <= 1);
    }
}

TEST_CASE("an offered state takes no memory before its chunks arrive") {
    const session::Snapshot state(77, 5, std::vector<std::byte>(200 * session::chunk_bytes, std::byte{1}));
    session::Assembly assembly(state.offer());
    CHECK(assembly.image().empty());
    session::Chunk chunk;
    state.chunk(65, chunk);
    CHECK_FALSE(assembly.take(chunk)); // beyond the range of a request
    state.chunk(64, chunk);
    CHECK(assembly.take(chunk));
    CHECK(assembly.image().size() == 65 * session::chunk_bytes);
}

TEST_CASE("a guest or relay rejects the states of a host that offers new ones without end or sends one too "
          "slowly") {
    Newcomer guest({0, 1});
    for (std::uint64_t poll = 0; poll < 302; ++poll) {
        guest.offer(1000 + poll, 16u << 20);
        guest.poll();
    }
    CHECK(guest.refusals() == 1);

    Newcomer patient({0, 1}); // a chunk every 200 polls: in time by each chunk, too slow by the whole state
    const session::Snapshot state(500, 9, std::vector<std::byte>(100 * session::chunk_bytes, std::byte{1}));
    session::Chunk chunk;
    for (std::uint32_t poll = 0; poll < 600 + 8 * 5; ++poll) {
        if (poll == 0)
            patient.desk.put(0, session::write_offer(patient.packet, match_of_two(), state.offer()));
        state.chunk(poll / 200, chunk);
        if (poll % 200 == 1) patient.desk.put(0, session::write_chunk(patient.packet, match_of_two(), chunk));
        patient.poll();
    }
    CHECK(patient.refusals() == 1);

    Desk up, down;
    const auto relay =
        make_spectator_relay(two_players(), {.hosts = {0, 1}, .state_polls = 120}, up, down).value();
    const std::vector<std::byte> ticks(6 + 2 * sizeof(Pad));
    std::vector<std::byte> packet;
    for (std::uint64_t poll = 0; poll < 700; ++poll) {
        up.put(0, session::write_stretch(packet, match_of_two(), {poll, 1, poll + 1, ticks}));
        up.put(0, session::write_offer(packet, match_of_two(), {1 + poll, 1, 2, 16u << 20}));
        relay->poll();
    }
    CHECK(relay->counters().states_refused >= 1);
    CHECK(relay->counters().next_tick == 700);
}

TEST_CASE(
    "a guest that lacks dropped ticks fetches a state again or stops with a notice if it has run ticks") {
    for (const bool has_run : {false, true}) {
        CAPTURE(has_run);
        Newcomer guest({0});
        const session::Snapshot state(500, 9, std::vector<std::byte>(100, std::byte{1}));
        session::Chunk chunk;
        state.chunk(0, chunk);
        guest.desk.put(0, session::write_offer(guest.packet, match_of_two(), state.offer()));
        guest.desk.put(0, session::write_chunk(guest.packet, match_of_two(), chunk));
        const Step step = guest.poll();
        REQUIRE(step.requests.size() == 1);
        guest.session->report_adopted({}, 9);
        guest.poll();
        REQUIRE(guest.desk.last_wish());
        REQUIRE(guest.desk.last_wish()->wants_log);
        if (has_run) {
            const std::vector<std::byte> tick(6 + 2 * sizeof(Pad));
            guest.desk.put(0, session::write_stretch(guest.packet, match_of_two(), {500, 1, 501, tick}));
            REQUIRE(guest.poll().requests.size() == 1);
            guest.session->report_hash(500, 0);
            REQUIRE(guest.session->next_confirmed());
        }
        guest.desk.put(0, session::write_stretch(guest.packet, match_of_two(), {600, 0, 700, {}}));
        const Step after = guest.poll();
        const bool is_stopped = after.stall == Stall::stopped;
        CHECK(is_stopped == has_run);
        CHECK(guest.desk.last_wish()->wants_state == !has_run);
        CHECK(std::ranges::any_of(guest.notices, [](const Notice& n) {
                  return std::holds_alternative<MatchStopped>(n);
              }) == has_run);
    }
}

TEST_CASE("a spectator limits the packets of each host per poll and still reads those of the others") {
    Newcomer guest({0, 1});
    for (std::uint32_t i = 0; i < packets_per_peer_max + 36; ++i) guest.offer(1000 + i, 100);
    guest.desk.put(1, session::write_word(guest.packet, match_of_two(), {5, 5}));
    guest.poll();
    const SessionStats& stats = guest.session->stats();
    CHECK(stats.dropped[static_cast<std::size_t>(PacketFault::flood)] == 36);
    CHECK(stats.packets_received == packets_per_peer_max + 37);
    CHECK(stats.packets_dropped == 36);
}
