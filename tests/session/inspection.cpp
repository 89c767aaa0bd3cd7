// Reports of desyncs name tick, phase, column, row, field and both values, at both machines. A hostile machine cannot
// break the inquiry.
#include "session/desync/inspection.h"
#include "session/match.h"
#include "session/seal.h"

#include "lockstone/world.h"
#include "scenes/scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// A fault: one bit of one byte of one row flips after a tick. Without a column: a push before the tick, as other rules
/// would give.
struct Flip {
    std::uint64_t tick;
    std::string column;
    std::uint32_t row, byte;
    /// True: the bit flips whenever the tick runs, a fault of the program. False: only the first time, a fault of the
    /// machine.
    bool each_time;
};

/// A world whose state changes outside of its ticks.
class FaultySimulation final : public Simulation {
  public:
    FaultySimulation(std::unique_ptr<Game> rules, std::optional<Flip> planted)
        : game(std::move(rules)), world(game->start().value()), real(world, *game), flip(std::move(planted)) {
    }
    void save(Image& image) const override { real.save(image); }
    void restore(const Image& image) override { real.restore(image); }
    std::uint64_t hash() const override { return real.hash(); }
    std::span<const Event> events() const override { return real.events(); }
    State& state() override { return real.state(); }
    void record_phase_hashes(bool on) override {
        real.record_phase_hashes(on);
        run_again_here += on ? 1u : 0u;
    }
    /// A fault of the program is in every copy of the simulation. A fault of the machine is not.
    std::optional<Rerun> run_aside(const Image& before, std::span<const PlayerInput> inputs) override {
        const bool is_in_program = flip && (flip->column.empty() || flip->each_time);
        return is_in_program ? std::nullopt : real.run_aside(before, inputs);
    }
    std::span<const PhaseHash> phase_hashes() const override { return real.phase_hashes(); }
    void advance(std::span<const PlayerInput> inputs) override {
        const std::uint64_t tick = world.tick_count();
        if (flip && flip->column.empty() && tick == flip->tick)
            for (const BodyId body : world.bodies())
                if (world.kind(body) == BodyKind::dynamic) world.add_impulse(body, {1_r, 0_r, 0_r}).value();
        real.advance(inputs);
        if (!flip || flip->column.empty() || tick != flip->tick || (!flip->each_time && done++ > 0)) return;
        const StateLayout& layout = state().layout();
        const auto column =
            static_cast<std::uint32_t>(layout.find_column(flip->column) - layout.columns().data());
        state().edit_bytes(column, flip->row, 1)[flip->byte] ^= std::byte{1};
    }

    std::uint32_t run_again_here = 0; ///< ticks of an inquiry that ran here, not aside

  private:
    std::unique_ptr<Game> game;
    World world;
    WorldSimulation real;
    std::optional<Flip> flip;
    int done = 0;
};

/// Two machines that play a scene; machine 1 is faulty.
struct SceneMatch {
    SimulatedNetwork network;
    struct Side {
        std::unique_ptr<Session> session;
        std::unique_ptr<FaultySimulation> simulation;
        std::unique_ptr<SessionRunner> runner;
        std::vector<DesyncReport> reports;
        std::vector<Desync> desyncs;
    };
    std::array<Side, 2> sides;
    std::uint64_t frames = 0;

    explicit SceneMatch(const Flip& flip,
                        const LinkDef& link = {.latency_ms = 50, .jitter_ms = 10, .loss_permille = 50})
        : network(2, link, 3) {
        for (PeerId id = 0; id < 2; ++id) {
            std::unique_ptr<Game> rules =
                make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value();
            SessionDef def = session_def(*rules, id, {0, 1});
            Side& s = sides[id];
            s.session = make_rollback_session(def, network.endpoint(id)).value();
            s.simulation = std::make_unique<FaultySimulation>(std::move(rules),
                                                              id == 1 ? std::optional(flip) : std::nullopt);
            s.runner = std::make_unique<SessionRunner>(*s.session, *s.simulation);
        }
    }
    void run(int count) {
        for (int i = 0; i < count; ++i) {
            const std::uint64_t now_ms = ++frames * 1000 / 60;
            network.advance_to(now_ms);
            for (PeerId id = 0; id < 2; ++id) {
                Side& s = sides[id];
                std::vector<std::byte> input(game->input_size());
                scripted_input(*game, 1, s.session->current_tick(), id, input);
                s.session->add_local_input(id, input);
                s.runner->frame(now_ms);
                while (const auto notice = s.session->next_notice()) {
                    if (const auto* named = std::get_if<DesyncNamed>(&*notice))
                        s.reports.push_back(*named->report);
                    if (const auto* desync = std::get_if<Desync>(&*notice)) s.desyncs.push_back(*desync);
                }
            }
        }
    }
    std::unique_ptr<Game> game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value();
};

} // namespace

/// Returns a sentence about the first error in both machines' reports of a bit flipped in a column. Returns an empty
/// string where both name the bit exactly.
static std::string named_wrongly(const SceneMatch& match, const Flip& flip) {
    for (PeerId id = 0; id < 2; ++id) {
        const SceneMatch::Side& s = match.sides[id];
        const std::string who = "machine " + std::to_string(id) + ": ";
        if (s.desyncs.size() != 1 || s.desyncs[0].tick != flip.tick)
            return who + "no desync, or of another tick";
        if (s.reports.size() != 1) return who + std::to_string(s.reports.size()) + " reports";
        const DesyncReport& r = s.reports[0];
        if (!r.complete) return who + "the other side has not told all";
        if (r.tick != flip.tick) return who + "another tick";
        if (r.columns != std::vector{flip.column}) return who + "other columns";
        if (r.differences.size() != 1) return who + std::to_string(r.differences.size()) + " differences";
        const Difference& d = r.differences[0];
        const Difference& mirrored = match.sides[1 - id].reports.at(0).differences.at(0);
        if (d.column != flip.column || d.row != flip.row) return who + "another row: " + to_string(d);
        if (d.left == d.right || d.left != mirrored.right || d.right != mirrored.left ||
            d.field != mirrored.field)
            return who + "other values: " + to_string(d);
        if (static_cast<std::uint32_t>(r.local) != s.desyncs[0].local ||
            static_cast<std::uint32_t>(r.remote) != s.desyncs[0].remote)
            return who + "other hashes";
        if (r.bytes_exchanged > 2 * session::inspection_bytes_max) return who + "too many bytes";
        if (r.log.size() != std::min(desync_log_ticks, flip.tick + 1) || r.log.back().tick != flip.tick)
            return who + "another log";
        for (const DesyncReport::Tick& tick : r.log)
            if ((tick.local != tick.remote) != (tick.tick == flip.tick)) return who + "a log of other hashes";
    }
    return {};
}

TEST_CASE("both machines name the tick, column, row, field and both values of a flipped bit") {
    for (const Flip& flip : {Flip{150, "body.velocity", 7, 1, true}, Flip{30, "body.pose", 3, 2, true},
                             Flip{0, "body_traits.row", 1, 0, true}, Flip{200, "body.sleep", 4, 0, true},
                             Flip{101, "body.velocity", 9, 4, false}}) {
        CAPTURE(flip.column);
        SceneMatch match(flip);
        match.run(static_cast<int>(flip.tick) + 240);
        CHECK(named_wrongly(match, flip) == "");
        if (match.sides[0].reports.empty()) continue;
        const DesyncReport& report = match.sides[0].reports[0];
        CHECK(report.local_repeats);
        CHECK(report.remote_repeats == flip.each_time); // a fault that does not repeat is the other machine's
        CHECK(match.sides[1].reports[0].local_repeats == flip.each_time);
        CHECK(match.sides[0].simulation->run_again_here == 0); // the played world is not changed
        CHECK(match.sides[1].simulation->run_again_here == (flip.each_time ? 1 : 0));
        MESSAGE(to_string(report), "; ", report.bytes_exchanged, " bytes, log of ", log_text(report).size());
    }
}

TEST_CASE("a session inspects a runner that replaces another one even after the old runner is destroyed") {
    const Flip flip{150, "body.velocity", 7, 1, true};
    SceneMatch match(flip);
    for (SceneMatch::Side& side : match.sides) // makes the new runner before it destroys the old one
        side.runner = std::make_unique<SessionRunner>(*side.session, *side.simulation);
    match.run(static_cast<int>(flip.tick) + 240);
    CHECK(named_wrongly(match, flip) == "");
}

TEST_CASE("planted: a session that drops the inspector of its runner leaves a desync without a report") {
    const Flip flip{150, "body.velocity", 7, 1, true};
    SceneMatch match(flip);
    for (SceneMatch::Side& side : match.sides) side.session->drop_inspector(side.runner->inspector());
    match.run(static_cast<int>(flip.tick) + 240);
    CHECK(named_wrongly(match, flip) != "");
}

TEST_CASE("a report names the first phase that differs when two machines push by different rules") {
    SceneMatch match({100, "", 0, 0, true});
    match.run(340);
    for (PeerId id = 0; id < 2; ++id) {
        REQUIRE(match.sides[id].reports.size() == 1);
        const DesyncReport& report = match.sides[id].reports[0];
        MESSAGE(to_string(report), "; ", report.bytes_exchanged, " bytes");
        CHECK(report.complete);
        CHECK(report.phase == "commands");
        CHECK(report.differences.size() > 0);
    }
}

namespace {

/// Returns states in which a column is all zeros, so a comparison misses differences in that column.
class BlindInspector final : public StateInspector {
  public:
    StateInspector* real = nullptr;
    std::string column;
    const State* state_after(std::uint64_t tick) override {
        const State* after = real->state_after(tick);
        if (after == nullptr) return nullptr;
        shown.emplace(*after);
        const ColumnInfo* info = shown->layout().find_column(column);
        std::ranges::fill(
            shown->edit_bytes(static_cast<std::uint32_t>(info - shown->layout().columns().data())),
            std::byte{0});
        return &*shown;
    }
    Rerun run_again(std::uint64_t tick, std::span<const PlayerInput> inputs) override {
        return real->run_again(tick, inputs);
    }

  private:
    std::optional<State> shown;
};

} // namespace

TEST_CASE("planted: a comparison that skips the column does not name it and the check above reports that") {
    const Flip flip{60, "body.velocity", 7, 1, true};
    SceneMatch match(flip);
    std::array<BlindInspector, 2> blind;
    for (PeerId id = 0; id < 2; ++id) {
        blind[id].real = &match.sides[id].runner->inspector();
        blind[id].column = flip.column;
        match.sides[id].session->set_inspector(&blind[id]);
    }
    match.run(300);
    CHECK(named_wrongly(match, flip) == "machine 0: other columns");
}

TEST_CASE("a session whose stored states are unavailable reports a desync by its tick only") {
    const Flip flip{60, "body.velocity", 7, 1, true};
    SceneMatch match(flip);
    for (SceneMatch::Side& side : match.sides) side.session->set_inspector(nullptr);
    match.run(300);
    for (const SceneMatch::Side& side : match.sides) {
        CHECK(side.desyncs.size() == 1);
        CHECK(side.reports.empty());
    }
}

// ---- hostile -----------------------------------------------------------------------------------------------------

namespace {

using session::Answer;
using session::Question;
using session::Topic;

State sample_state(std::int32_t speed) {
    Arena arena(2);
    State state = arena.state();
    state.edit_row(arena_columns().agent, 3).speed = speed;
    return state;
}
session::Inspection inspection_of(const State& state) {
    DesyncReport known;
    known.tick = 7;
    return session::Inspection(known, state, {});
}
constexpr session::PacketContext context{0x1234, 2, 4};

} // namespace

TEST_CASE("an inspection answers endless questions with 64 kB in total and one packet per poll") {
    session::Inspection inspection = inspection_of(sample_state(1));
    std::size_t sent = 0;
    for (std::uint32_t i = 0; i < 100'000; ++i) {
        for (int more = 0; more < 3; ++more) inspection.take(Question{7, Topic::rows, 0, 0, 0});
        const std::span<const std::byte> packet = inspection.next_packet(context);
        CHECK(packet.size() <= packet_bytes_max);
        sent += packet.size();
    }
    CHECK(sent >= session::inspection_bytes_max);
    CHECK(sent <= session::inspection_bytes_max + packet_bytes_max);
}

TEST_CASE("an inspection without answers sends 40 questions and returns a report that is not complete") {
    session::Inspection inspection = inspection_of(sample_state(1));
    int asked = 0, polls = 0;
    std::optional<DesyncReport> report;
    for (; !report && polls < 10'000; ++polls) {
        asked += inspection.next_packet(context).empty() ? 0 : 1;
        report = inspection.take_report();
    }
    REQUIRE(report);
    CHECK_FALSE(report->complete);
    CHECK(asked == 40);
    CHECK(polls < 700);
    CHECK_FALSE(inspection.take_report());
}

TEST_CASE(
    "an inspection survives answers of any bytes and its report stays within its limit of differences") {
    test::SplitMix random(5);
    std::size_t complete = 0;
    for (int i = 0; i < 2000; ++i) {
        session::Inspection inspection = inspection_of(sample_state(1));
        session::Inspection honest = inspection_of(sample_state(2));
        for (int poll = 0; poll < 60; ++poll) {
            std::optional<Question> question;
            std::optional<Answer> answer;
            const std::span<const std::byte> asked = inspection.next_packet(context);
            if (asked.empty() || session::read_inspection(asked, context, question, answer) || !question)
                continue;
            honest.take(*question);
            const std::span<const std::byte> told = honest.next_packet(context);
            std::vector<std::byte> packet(told.begin(), told.end());
            for (std::uint32_t changes = random.below(3); changes > 0 && !packet.empty(); --changes) {
                if (random.below(4) == 0)
                    packet.resize(random.below(static_cast<std::uint32_t>(packet.size())) + 1);
                packet[random.below(static_cast<std::uint32_t>(packet.size()))] =
                    static_cast<std::byte>(random.next());
            }
            test::seal(packet, 0);
            if (!session::read_inspection(packet, context, question, answer) && answer)
                inspection.take(*answer);
        }
        inspection.give_up();
        const auto report = inspection.take_report();
        REQUIRE(report);
        CHECK(report->differences.size() <= 2 + desync_differences_max);
        complete += report->complete ? 1u : 0u;
    }
    CHECK(complete > 50);
    CHECK(complete < 1950);
}

TEST_CASE("read_inspection() rejects malformed questions and answers with the matching fault") {
    std::vector<std::byte> buffer;
    const Question asked{7, Topic::rows, 1, 2, 3};
    const std::vector<std::byte> content(20);
    const std::span<const std::byte> wrote = session::write_answer(buffer, context, {asked, 23, content});
    const std::vector<std::byte> packet(wrote.begin(), wrote.end());
    std::optional<Question> question;
    std::optional<Answer> answer;
    REQUIRE_FALSE(session::read_inspection(packet, context, question, answer));
    REQUIRE(answer);
    CHECK(answer->to == asked);
    CHECK(answer->bytes.size() == 20);
    const auto refused = [&](std::size_t at, unsigned value) {
        std::vector<std::byte> changed = packet;
        changed[at] = static_cast<std::byte>(value);
        test::seal(changed, 0);
        return session::read_inspection(changed, context, question, answer);
    };
    CHECK(refused(1, 4) == PacketFault::malformed); // no such topic
    CHECK(refused(2, 9) == PacketFault::match);
    CHECK(refused(20, 2) == PacketFault::malformed);   // an offset beyond 64 kB
    CHECK(refused(22, 22) == PacketFault::malformed);  // less content than the length says
    CHECK(refused(24, 2) == PacketFault::malformed);   // more than 64 kB
    CHECK(refused(0, 0x51) == PacketFault::malformed); // a question must not have content
    for (std::size_t bit = 8; bit < packet.size() * 8; ++bit) {
        std::vector<std::byte> damaged = packet;
        damaged[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
        CHECK(session::read_inspection(damaged, context, question, answer) == PacketFault::damaged);
    }
}
