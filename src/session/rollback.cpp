// The rollback algorithm. A tick runs on the known inputs: true ones that have arrived, predictions for the
// rest. If a true input differs from the prediction that a tick ran on, the session restores the state
// before that tick and runs all ticks up to the present again. With a prediction window of 0 no tick runs
// on a prediction: this is lockstep. A departure may also revoke true inputs that some machines lack
// (departure.cpp), so a tick is fixed only when all machines have acknowledged its inputs.
//
//   the prediction for tick 94 was wrong, present tick 101:
//   Load(94) Advance(94)  Save(95) Advance(95)  ...  Save(100) Advance(100)   then   Save(101) Advance(101)
//
#include "session/peer_session.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone::session {

Step PeerSession::advance() {
    has_run = true;
    run_again();

    const Stall stall = why_stall();
    for (std::uint32_t n = 0; n < catch_up_ticks && why_stall() == Stall::none; ++n) {
        if (n > 0 && (current >= catch_up_end || current >= settled_through()))
            break; // the machine has caught up with the others
        run(current, Run::first);
        ++current;
        make_up_for_waits();
    }

    settled_end = std::min(fixed_through(), current);
    counts.stalls += stall == Stall::none ? 0 : 1;
    return {stall, requests, stall == Stall::none ? wait_recommended() : 0};
}

Step PeerSession::settle() {
    run_again();
    settled_end = std::min(current, fixed_through());
    return {Stall::none, requests, 0};
}

void PeerSession::run_again() {
    LOCKSTONE_ASSERT(confirmed == settled_end, "take confirmed ticks first: ", confirmed, " of ",
                     settled_end);
    requests.clear();
    inputs.clear();
    if (const std::uint64_t wrong = take_first_wrong(); wrong < current) roll_back_to(wrong);
}

void PeerSession::roll_back_to(std::uint64_t wrong) {
    requests.push_back(Load{wrong, false});
    for (std::uint64_t tick = wrong; tick < current; ++tick) run(tick, Run::again);
    ++counts.rollbacks;
    counts.depth_max = std::max(counts.depth_max, current - wrong);
}

void PeerSession::run(std::uint64_t tick, Run how) {
    const std::size_t first = inputs.size();
    for (InputQueue& queue : queues) inputs.push_back(queue.use(tick, *def.predictor));
    const std::span<const PlayerInput> now_known = std::span(inputs).subspan(first);

    // Only a tick that may change needs a saved state. A state that was just loaded is saved already.
    const bool loaded = !requests.empty() && std::holds_alternative<Load>(requests.back());
    if (tick >= fixed_through() && !loaded) requests.push_back(Save{tick});

    requests.push_back(Advance{tick, now_known, how == Run::again});
    ++(how == Run::again ? counts.resimulated : counts.ticks);
}

Stall PeerSession::why_stall() const {
    if (stopped) return Stall::stopped;
    if (is_connecting()) return Stall::connecting;
    if (current >= tick_limit || polls >= tick_limit) return Stall::finished;
    for (const InputQueue& queue : queues) {
        if (!is_local(queue.player())) continue;
        if (queue.room() == 0) return Stall::peer_behind;
        if (queue.next() <= current) return Stall::local_input_missing;
    }
    for (const PeerLink& link : links) {
        if (link.state != PeerLink::State::connected || link.unwanted) continue;
        if (link.hashes.exchanged_through() + history_confirmed_max <= confirmed) return Stall::peer_behind;
    }
    if (current >= settled_through() + def.prediction_max) return Stall::inputs_missing;
    if (current >= fixed_through() + change_max) return Stall::peer_behind;
    return Stall::none;
}

} // namespace lockstone::session
