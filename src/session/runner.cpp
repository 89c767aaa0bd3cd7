// SessionRunner: executes the requests of a session. A ring holds one image for each tick that a rollback
// can reach; all memory is allocated at the start.
#include "lockstone/session.h"

#include "base/assert.h"
#include "base/text.h"
#include "session/event_ledger.h"

#include <algorithm>

namespace lockstone {

namespace {
constexpr std::uint64_t never = ~std::uint64_t{0};
}

struct SessionRunner::Impl final : StateInspector {
    Session& session;
    std::weak_ptr<const void> lifetime; ///< of the session
    Simulation& simulation;
    RunnerDef def;
    std::vector<Image> ring; ///< [images] by tick modulo its size
    std::vector<std::uint64_t> ring_ticks;
    std::vector<std::uint64_t> ring_hashes;
    std::uint64_t hash; ///< of the present state
    session::EventLedger ledger;
    std::vector<SessionEvent> events;
    std::optional<SyncTestFailure> failure;
    /// True: the ring also keeps states for a StateInspector, not only those that a rollback can reach.
    bool is_inspected;
    std::optional<State> shown;      ///< the last state that state_after() returned
    std::uint64_t confirmed_end = 0; ///< the sink has received ticks below
    std::uint64_t first_tick = 0;    ///< the first tick that runs here
    Image played;                    ///< the present state during look_ahead(), if the ring does not hold it
    /// Not null: the simulation runs ahead, and this is the present state.
    const Image* to_come_back = nullptr;

    Impl(Session& driver, Simulation& driven, RunnerDef runner_def)
        : session(driver), lifetime(driver.lifetime()), simulation(driven), def(std::move(runner_def)),
          hash(driven.hash()), ledger(driver.images_max() + 1),
          is_inspected(def.inspected_ticks > 0 && driver.set_inspector(this)) {
        ring.resize(driver.images_max() + (is_inspected ? def.inspected_ticks : 0));
        ring_ticks.assign(ring.size(), never);
        ring_hashes.resize(ring.size());
        events.reserve(256);
        for (Image& image : ring) simulation.state().reserve(image);
    }
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() override {
        come_back();
        if (!lifetime.expired()) session.drop_inspector(*this);
    }

    /// Runs the simulation ahead on predicted inputs for display. Nothing of it reaches the session, the
    /// sink or the ledger.
    void look_ahead() {
        for (std::uint32_t offset = 0; offset < run_ahead_limit; ++offset) {
            const std::span<const PlayerInput> inputs = session.look_ahead(offset);
            if (inputs.empty()) return;
            if (to_come_back == nullptr) {
                const std::uint64_t tick = session.current_tick();
                if (!has(tick)) simulation.save(played);
                to_come_back = has(tick) ? &saved(tick) : &played;
            }
            simulation.advance(inputs);
        }
    }
    void come_back() {
        if (const Image* image = std::exchange(to_come_back, nullptr)) simulation.restore(*image);
    }

    void execute_and_confirm(const Step& step) {
        for (const Request& request : step.requests)
            std::visit([this](const auto& r) { execute(r); }, request);
        std::uint64_t news_end = 0;
        while (const std::optional<ConfirmedTick> tick = session.next_confirmed()) {
            news_end = confirmed_end = tick->tick + 1;
            if (def.sink != nullptr) def.sink->on_confirmed(tick->tick, tick->inputs, tick->hash);
        }
        events.clear();
        ledger.publish(news_end, events);
    }

    void execute(const Save& save) {
        if (is_inspected && save.tick > first_tick) return; // keep() after the previous tick has saved it
        keep(save);
    }
    void keep(const Save& save) {
        const std::size_t slot = save.tick % ring.size();
        simulation.save(ring[slot]);
        ring_ticks[slot] = save.tick;
        ring_hashes[slot] = hash;
    }

    void execute(const Load& load) {
        simulation.restore(saved(load.tick));
        if (!load.verify) return;
        hash = simulation.hash();
        if (hash != ring_hashes[load.tick % ring.size()])
            fail(SyncTestFailure::When::restored, load.tick, load.tick);
    }

    void execute(const Adopt& adopt) {
        const Status taken = simulation.adopt_at(adopt.tick, adopt.image);
        hash = simulation.hash();
        session.report_adopted(taken, hash);
        if (!taken) return;
        std::ranges::fill(ring_ticks, never);
        ledger.begin_at(adopt.tick);
        first_tick = confirmed_end = adopt.tick;
    }

    void execute(const Advance& advance) {
        if (is_inspected && advance.tick == first_tick && !has(first_tick)) keep({first_tick});
        simulation.advance(advance.inputs);
        hash = simulation.hash();
        // The ring still holds the state that the first run led to: that state is replaced only by a later
        // Save.
        if (session.report_hash(advance.tick, hash) == HashCheck::differs)
            fail(SyncTestFailure::When::resimulated, advance.tick, advance.tick + 1);
        ledger.record(advance.tick, simulation.events());
        if (is_inspected) keep({advance.tick + 1});
    }

    bool has(std::uint64_t tick) const { return tick != never && ring_ticks[tick % ring.size()] == tick; }

    const State* state_after(std::uint64_t tick) override {
        if (tick == never || !has(tick + 1)) return nullptr;
        if (!shown) shown.emplace(simulation.state());
        shown->restore(saved(tick + 1));
        return &*shown;
    }
    Rerun run_again(std::uint64_t tick, std::span<const PlayerInput> inputs) override {
        if (!has(tick)) return {};
        if (std::optional<Rerun> aside = simulation.run_aside(saved(tick), inputs)) return *aside;
        Image present;
        simulation.save(present);
        simulation.restore(saved(tick));
        simulation.record_phase_hashes(true);
        simulation.advance(inputs);
        const std::span<const PhaseHash> phases = simulation.phase_hashes();
        Rerun rerun{{phases.begin(), phases.end()}, simulation.hash()};
        simulation.record_phase_hashes(false);
        simulation.restore(present);
        return rerun;
    }

    const Image& saved(std::uint64_t tick) const {
        const std::size_t slot = tick % ring.size();
        LOCKSTONE_ASSERT(ring_ticks[slot] == tick, "tick ", tick, " is not saved, its slot holds ",
                         ring_ticks[slot]);
        return ring[slot];
    }

    /// Records the differences between the state saved before `saved_tick` and the present state. Only the
    /// first failure is recorded.
    void fail(SyncTestFailure::When when, std::uint64_t tick, std::uint64_t saved_tick) {
        if (failure) return;
        State first = simulation.state();
        first.restore(saved(saved_tick));
        failure = {when, tick, first.hash(), hash, State::diff(first, simulation.state(), 8)};
    }
};

SessionRunner::SessionRunner(Session& session, Simulation& simulation, RunnerDef def)
    : impl(std::make_unique<Impl>(session, simulation, std::move(def))) {}
SessionRunner::SessionRunner(SessionRunner&&) noexcept = default;
SessionRunner& SessionRunner::operator=(SessionRunner&&) noexcept = default;
SessionRunner::~SessionRunner() = default;

SessionRunner::Impl& SessionRunner::inside() const {
    LOCKSTONE_ASSERT(impl != nullptr, "this session runner was moved from");
    LOCKSTONE_ASSERT(!impl->lifetime.expired(), "the session was destroyed before its runner");
    return *impl;
}

Frame SessionRunner::frame(std::uint64_t now_ms) {
    Impl& all = inside();
    all.come_back();
    all.session.poll(now_ms);
    const Step step = all.session.advance();
    all.execute_and_confirm(step);
    all.look_ahead();
    return {step.stall, step.wait_ticks};
}

bool SessionRunner::drain(std::uint64_t now_ms) {
    Impl& all = inside();
    all.come_back();
    all.session.poll(now_ms);
    all.execute_and_confirm(all.session.settle());
    return all.confirmed_end == all.session.current_tick();
}

void SessionRunner::wait(std::uint64_t now_ms) {
    inside().session.poll(now_ms);
    inside().events.clear();
}

StateInspector& SessionRunner::inspector() { return inside(); }

std::span<const SessionEvent> SessionRunner::events() const { return inside().events; }

const SyncTestFailure* SessionRunner::sync_failure() const {
    return inside().failure ? &*inside().failure : nullptr;
}

std::string to_string(const SyncTestFailure& failure) {
    const bool restored = failure.when == SyncTestFailure::When::restored;
    std::string out = base::join("tick ", failure.tick, restored ? ", restored: " : ", resimulated: ");
    if (failure.differences.empty())
        return out + base::join("hash ", base::hex(failure.first_hash), " against ",
                                base::hex(failure.second_hash), ", though no field differs");
    return out + to_string(failure.differences.front());
}

} // namespace lockstone
