// The requests of a session, one by one.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

std::string text_of(const Step& step) {
    std::string out;
    for (const Request& request : step.requests) {
        if (const Load* load = std::get_if<Load>(&request)) out += " L" + std::to_string(load->tick);
        if (const Save* save = std::get_if<Save>(&request)) out += " S" + std::to_string(save->tick);
        const Advance* advance = std::get_if<Advance>(&request);
        if (advance == nullptr) continue;
        out += (advance->resimulated ? " a" : " A") + std::to_string(advance->tick);
        for (const PlayerInput& input : advance->inputs)
            out += input.status == InputStatus::confirmed ? "c" : "p";
    }
    return out.empty() ? out : out.substr(1);
}

/// Two machines with one player and one byte of input each. The hashes are invented, and equal on both machines.
struct Pair {
    SimulatedNetwork network;
    std::array<std::unique_ptr<Session>, 2> sessions;
    std::uint64_t now = 0;
    bool connected = true;

    explicit Pair(std::uint32_t window, std::uint32_t delay = 0) : network(2, {}, 1) {
        SessionDef def;
        def.input_size = 1;
        def.players = {0, 1};
        def.input_delay = delay;
        def.prediction_max = window;
        for (PeerId id = 0; id < 2; ++id) {
            def.self = id;
            sessions[id] = (window == 0 ? make_lockstep_session(def, network.endpoint(id))
                                        : make_rollback_session(def, network.endpoint(id)))
                               .value();
        }
        poll(0);
        poll(1);
        poll(0);
    }
    void poll(PeerId id) {
        network.advance_to(++now);
        sessions[id]->poll(now);
    }
    void input(PeerId id, unsigned value) {
        const std::array bytes{static_cast<std::byte>(value)};
        sessions[id]->add_local_input(id, bytes);
    }
    Step advance(PeerId id) {
        const Step step = sessions[id]->advance();
        for (const Request& request : step.requests) {
            if (const Advance* a = std::get_if<Advance>(&request))
                sessions[id]->report_hash(a->tick, a->tick);
        }
        return step;
    }
    std::vector<std::uint64_t> confirmed(PeerId id) {
        std::vector<std::uint64_t> ticks;
        while (const auto tick = sessions[id]->next_confirmed()) ticks.push_back(tick->tick);
        return ticks;
    }
    std::string step(PeerId id, unsigned value) {
        input(id, value);
        const std::string text = text_of(advance(id));
        confirmed(id);
        return text;
    }
};

} // namespace

TEST_CASE("a session saves a tick with predicted inputs before the tick runs") {
    Pair pair(8);
    CHECK(pair.step(0, 1) == "S0 A0cp");
    CHECK(pair.step(0, 1) == "S1 A1cp");
}

TEST_CASE("a wrong prediction loads the state before it, resimulates to the present and saves ticks still "
          "predicted") {
    Pair pair(8);
    for (unsigned i = 0; i < 5; ++i) pair.step(0, 1);
    pair.step(1, 0); // tick 0 as predicted
    pair.step(1, 9); // tick 1 not as predicted
    pair.poll(1);
    pair.poll(0);
    CHECK(pair.step(0, 1) == "L1 a1cc S2 a2cp S3 a3cp S4 a4cp S5 A5cp");
    CHECK(pair.sessions[0]->stats().rollbacks == 1);
    CHECK(pair.sessions[0]->stats().resimulated == 4);
    CHECK(pair.sessions[0]->stats().depth_max == 4);
}

TEST_CASE("correct predictions confirm ticks without resimulation") {
    Pair pair(8);
    for (unsigned i = 0; i < 3; ++i) pair.step(0, 1);
    for (unsigned i = 0; i < 3; ++i) pair.step(1, 0);
    pair.poll(1);
    pair.poll(0);
    pair.input(0, 1);
    CHECK(text_of(pair.advance(0)) == "S3 A3cp");
    CHECK(pair.confirmed(0) == std::vector<std::uint64_t>{0, 1, 2});
}

TEST_CASE("a session does not save a tick whose inputs are all confirmed") {
    Pair pair(8);
    pair.input(1, 3);
    pair.poll(1);
    pair.poll(0);
    CHECK(pair.step(0, 1) == "A0cc");
}

TEST_CASE("a session stalls at the limit of predicted ticks and corrects the past while it stalls") {
    Pair pair(3);
    for (unsigned i = 0; i < 3; ++i) CHECK(pair.step(0, 1) != "");
    pair.input(0, 1);
    const Step stalled = pair.advance(0);
    CHECK(stalled.stall == Stall::inputs_missing);
    CHECK(stalled.requests.empty());
    CHECK(pair.sessions[0]->stats().stalls == 1);
    pair.step(1, 5);
    pair.poll(1);
    pair.poll(0);
    CHECK(pair.step(0, 1) == "L0 a0cc S1 a1cp S2 a2cp S3 A3cp");
    CHECK(pair.step(0, 1) == "");
}

TEST_CASE("a session runs no tick without the local input") {
    Pair pair(8);
    CHECK(pair.sessions[0]->advance().stall == Stall::local_input_missing);
}

TEST_CASE("lockstep runs a tick only after all its inputs arrive and never saves") {
    Pair pair(0, 2);
    CHECK(pair.step(0, 1) == ""); // machine 1 has sent nothing for tick 0
    pair.input(1, 1);
    pair.poll(1);
    pair.poll(0);
    CHECK(pair.step(0, 1) == "A0cc"); // ticks before the input delay are zeros
    CHECK(pair.step(0, 1) == "A1cc");
    CHECK(pair.step(0, 1) == "A2cc");
    CHECK(pair.step(0, 1) == "");
}

TEST_CASE("a local input acts after the input delay") {
    Pair pair(8, 3);
    std::vector<unsigned> seen;
    for (unsigned i = 1; i <= 6; ++i) {
        pair.input(0, i);
        const Step step = pair.advance(0);
        seen.push_back(std::to_integer<unsigned>(std::get<Advance>(step.requests.back()).inputs[0].bytes[0]));
        pair.confirmed(0);
    }
    CHECK(seen == std::vector<unsigned>{0, 0, 0, 1, 2, 3});
}

TEST_CASE("a session ignores a second input for a tick because the first may be on its way") {
    Pair pair(8);
    pair.input(0, 1);
    pair.input(0, 2);
    const Step step = pair.advance(0);
    CHECK(std::get<Advance>(step.requests.back()).inputs[0].bytes[0] == std::byte{1});
}

TEST_CASE("a session with only local players sends no packets and confirms every tick at once") {
    SimulatedNetwork network(1, {}, 1);
    SessionDef def;
    def.input_size = 4;
    def.players = {0, 0};
    def.input_delay = 0;
    const auto session = make_rollback_session(def, network.endpoint(0)).value();
    Arena arena(2);
    Timeline timeline;
    SessionRunner runner(*session, arena, {&timeline});
    for (std::uint64_t tick = 0; tick < 100; ++tick) {
        for (std::uint32_t p = 0; p < 2; ++p)
            session->add_local_input(p, encode_input(scripted_pad(p, tick)));
        CHECK(runner.frame(tick).stall == Stall::none);
        CHECK(timeline.ticks.size() == tick + 1);
    }
    CHECK(session->stats().packets_sent == 0);
}

TEST_CASE("a session rejects a definition out of range and names the field") {
    SimulatedNetwork network(1, {}, 1);
    const auto refused = [&](auto change, const char* field) {
        SessionDef def;
        def.input_size = 4;
        def.players = {0, 1};
        change(def);
        const auto result = make_rollback_session(def, network.endpoint(0));
        return !result.ok() && result.error().message.find(field) != std::string::npos;
    };
    CHECK(refused([](SessionDef& d) { d.players.clear(); }, "0 players"));
    CHECK(refused([](SessionDef& d) { d.players.assign(17, 0); }, "17 players"));
    CHECK(refused([](SessionDef& d) { d.input_size = 65; }, "input_size"));
    CHECK(refused([](SessionDef& d) { d.self = 9; }, "self"));
    CHECK(refused([](SessionDef& d) { d.input_delay = 33; }, "input_delay"));
    CHECK(refused([](SessionDef& d) { d.prediction_max = 0; }, "prediction_max"));
    CHECK(refused([](SessionDef& d) { d.prediction_max = 65; }, "prediction_max"));
    CHECK(refused([](SessionDef& d) { d.predictor = nullptr; }, "predictor"));
    SessionDef def;
    def.players = {0, 1};
    def.input_delay = 0;
    CHECK_FALSE(make_lockstep_session(def, network.endpoint(0)).ok());
    CHECK_FALSE(make_sync_test_session(def, 4).ok());
    def.players = {0, 0};
    CHECK_FALSE(make_sync_test_session(def, 0).ok());
    CHECK(make_sync_test_session(def, 4).ok());
}
