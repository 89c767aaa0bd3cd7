// Factory functions of sessions. They check the definitions once; the session classes rely on the ranges.
#include "session/join/join_session.h"
#include "session/peer_session.h"
#include "session/sync_test.h"

#include "base/text.h"

#include <algorithm>

namespace lockstone {

namespace {

using base::join;

Status check(const SessionDef& def) {
    if (def.players.empty() || def.players.size() > players_max)
        return Error{join("session: ", def.players.size(), " players, expected 1 to ", players_max)};
    if (def.input_size > input_bytes_max)
        return Error{
            join("session: input_size is ", def.input_size, ", at most ", input_bytes_max, " bytes")};
    if (std::ranges::find(def.players, def.self) == def.players.end())
        return Error{join("session: no player plays at machine ", def.self, " (self)")};
    for (std::uint32_t p = 0; p < def.players.size(); ++p) {
        const std::uint32_t there = session::players_at(def, def.players[p]);
        if ((def.absent & there) != 0 && (def.absent & there) != there)
            return Error{
                join("session: of machine ", def.players[p], " some players are absent and some are not")};
    }
    if (def.absent >> def.players.size() != 0)
        return Error{"session: absent names players that there are not"};
    if (def.input_delay > input_delay_limit)
        return Error{
            join("session: input_delay is ", def.input_delay, ", at most ", input_delay_limit, " ticks")};
    if (def.run_ahead > run_ahead_limit)
        return Error{join("session: run_ahead is ", def.run_ahead, ", at most ", run_ahead_limit, " ticks")};
    if (def.disconnect_ms == 0 || def.connect_ms == 0)
        return Error{join("session: ", def.disconnect_ms == 0 ? "disconnect_ms" : "connect_ms",
                          " is 0, at least 1 ms: every peer would be gone at once")};
    if (def.disconnect_ms > disconnect_ms_limit)
        return Error{
            join("session: disconnect_ms is ", def.disconnect_ms, ", at most ", disconnect_ms_limit)};
    if (def.predictor == nullptr)
        return Error{"session: predictor is null; repeat_last_input() is the default"};
    return {};
}

} // namespace

SessionDef session_def(const Game& game, PeerId self, std::vector<PeerId> players) {
    SessionDef def;
    def.content_id = game.content_id();
    def.input_size = game.input_size();
    def.self = self;
    def.players = std::move(players);
    return def;
}

namespace {
Status check_present(const SessionDef& def) {
    if (const Status status = check(def); !status) return status;
    if ((def.absent & session::players_at(def, def.self)) != 0)
        return Error{"session: this machine (self) is absent; make_join_session comes late"};
    return {};
}
} // namespace

Result<std::unique_ptr<Session>> make_join_session(const SessionDef& def, const JoinDef& join,
                                                   Transport& transport) {
    if (const Status status = check(def); !status) return status.error();
    if (join.life == 0 || join.life >> 24 != 0)
        return Error{base::join("join: life is ", join.life, ", expected 1 to 16777215")};
    if (std::ranges::all_of(def.players, [&](PeerId peer) { return peer == def.self; }))
        return Error{"join: all players are local, so no other machine has the match"};
    WatchDef watch;
    watch.hosts = {def.self};
    watch.ticks_per_frame = join.ticks_per_frame;
    watch.state_bytes_max = join.state_bytes_max;
    if (const Status status = session::check_watch(def, watch); !status) return status.error();
    if (join.lockstep && def.input_delay == 0)
        return Error{"session: input_delay is 0; lockstep needs at least 1 tick"};
    if (!join.lockstep && (def.prediction_max == 0 || def.prediction_max > prediction_limit))
        return Error{base::join("session: prediction_max is ", def.prediction_max, ", expected 1 to ",
                                prediction_limit, " ticks")};
    return std::unique_ptr<Session>(std::make_unique<session::JoinSession>(def, join, transport));
}

Result<std::unique_ptr<Session>> make_rollback_session(const SessionDef& def, Transport& transport) {
    if (const Status status = check_present(def); !status) return status.error();
    if (def.prediction_max == 0 || def.prediction_max > prediction_limit)
        return Error{join("session: prediction_max is ", def.prediction_max, ", expected 1 to ",
                          prediction_limit, " ticks; make_lockstep_session never predicts")};
    return std::unique_ptr<Session>(std::make_unique<session::PeerSession>(def, transport));
}

Result<std::unique_ptr<Session>> make_lockstep_session(const SessionDef& def, Transport& transport) {
    if (const Status status = check_present(def); !status) return status.error();
    if (def.input_delay == 0) return Error{"session: input_delay is 0; lockstep needs at least 1 tick"};
    SessionDef lockstep = def;
    lockstep.prediction_max = 0;
    return std::unique_ptr<Session>(std::make_unique<session::PeerSession>(lockstep, transport));
}

Result<std::unique_ptr<Session>> make_sync_test_session(const SessionDef& def, std::uint32_t depth) {
    if (const Status status = check(def); !status) return status.error();
    if (std::ranges::any_of(def.players, [&](PeerId peer) { return peer != def.self; }))
        return Error{"session: a sync test has no remote players; let all play at self"};
    if (def.run_ahead != 0)
        return Error{join("session: run_ahead is ", def.run_ahead, "; a sync test shows nothing ahead")};
    if (depth == 0 || depth > prediction_limit)
        return Error{join("session: depth is ", depth, ", expected 1 to ", prediction_limit, " ticks")};
    return std::unique_ptr<Session>(std::make_unique<session::SyncTestSession>(def, depth));
}

const char* name_of(Stall stall) {
    switch (stall) {
    case Stall::none:
        return "none";
    case Stall::connecting:
        return "connecting";
    case Stall::inputs_missing:
        return "inputs missing";
    case Stall::local_input_missing:
        return "local input missing";
    case Stall::peer_behind:
        return "peer behind";
    case Stall::finished:
        return "finished";
    case Stall::stopped:
        return "stopped";
    }
    return "unknown";
}

const char* name_of(PacketFault fault) {
    switch (fault) {
    case PacketFault::stranger:
        return "from a stranger";
    case PacketFault::damaged:
        return "damaged";
    case PacketFault::version:
        return "another version of the packet format";
    case PacketFault::match:
        return "another match, game or line-up of players";
    case PacketFault::malformed:
        return "malformed";
    case PacketFault::implausible:
        return "implausible";
    case PacketFault::flood:
        return "more than one poll reads";
    }
    return "unknown";
}

std::uint64_t SessionStats::bytes_per_player_second() const {
    const std::uint64_t elapsed_ms = last_poll_ms - first_poll_ms;
    if (elapsed_ms == 0 || local_players == 0) return 0;
    return bytes_sent * 1000 / elapsed_ms / local_players;
}

} // namespace lockstone
