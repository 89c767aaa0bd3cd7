// A relay for spectators: a spectator of one host, and a host of many spectators, without a world.
#include "lockstone/session/spectator_relay.h"

#include "session/join/told_ticks.h"

#include "base/text.h"

namespace lockstone::session {
namespace {

/// Maximum silence of a host during the transfer of a state.
constexpr std::uint32_t state_patience_polls = 300;
constexpr std::uint32_t hosts_max = players_max, log_ticks_least = 1024, state_polls_least = 120;

class Relay final : public SpectatorRelay {
  public:
    Relay(const SessionDef& session_def, const SpectatorRelayDef& how, Transport& up, Transport& down)
        : def(how), to_hosts(up), to_watchers(down), match(packet_context(session_def).match),
          tick_bytes(tick_bytes_of(session_def)), ticks(tick_bytes),
          timeline(session_def, {.log_ticks_max = how.log_ticks_max,
                                 .delay_ticks = how.delay_ticks,
                                 .listeners_max = how.watchers_max,
                                 .silence_polls = how.silence_polls,
                                 .keeps_unheard = true}) {}

    void poll() override {
        for (std::uint32_t i = 0, read = 0; i < packets_per_poll_max; ++i) {
            const std::optional<Datagram> datagram = to_hosts.receive();
            if (!datagram) break;
            const bool is_asked = datagram->from == def.hosts[serving];
            if (!is_asked || ++read > packets_per_peer_max || !take(*datagram)) ++dropped;
        }
        judge_host();
        ask();
        for (std::uint32_t i = 0; i < packets_per_poll_max; ++i) {
            const std::optional<Datagram> datagram = to_watchers.receive();
            if (!datagram) break;
            if (const auto wish = read_wish(datagram->bytes, match)) timeline.hear(datagram->from, *wish);
        }
        timeline.serve(to_watchers, nullptr);
    }

    Counters counters() const override {
        return {.first_tick = timeline.log_begin(),
                .next_tick = timeline.log_end(),
                .state_tick = state_tick,
                .watchers = timeline.listeners(),
                .host = def.hosts[serving],
                .host_changes = host_changes,
                .states_refused = states_refused,
                .bytes_to_watchers = timeline.bytes_sent(),
                .bytes_to_hosts = bytes_up,
                .log_bytes = timeline.log_bytes(),
                .packets_dropped = dropped};
    }

  private:
    /// Handles a packet of the serving host. Returns false if the packet is dropped.
    bool take(const Datagram& datagram) {
        if (const auto stretch = read_stretch(datagram.bytes, match, tick_bytes)) {
            ticks.take(*stretch, timeline.log_end());
            for (std::uint64_t tick = timeline.log_end(); tick < ticks.next(); ++tick)
                timeline.add_told(tick, ticks.at(tick));
            return true;
        }
        if (const auto offer = read_offer(datagram.bytes, match)) return take_offer(*offer);
        const auto chunk = read_chunk(datagram.bytes, match);
        if (!chunk || !assembly || !assembly->take(*chunk)) return false;
        polls_without_chunk = 0;
        if (assembly->is_complete()) take_state();
        return true;
    }

    bool take_offer(const Offer& offer) {
        if (!fetches || (assembly && assembly->offer().tick >= offer.tick)) return false;
        if (offer.bytes > def.state_bytes_max) {
            give_up_state();
            return false;
        }
        if (!assembly) polls_without_chunk = 0; // a changed offer does not count as progress
        assembly.emplace(offer);
        return true;
    }

    /// Stores the complete state if its hash agrees with the hash in the log.
    void take_state() {
        const Offer offer = assembly->offer();
        const std::optional<std::uint32_t> told = timeline.told_hash(offer.tick - 1);
        // The tick has not arrived yet, or the log has dropped it; ask() retries and has a timeout.
        if (!told) return;
        if (*told != static_cast<std::uint32_t>(offer.hash)) return give_up_state();
        timeline.set_snapshot(offer, assembly->image());
        state_tick = offer.tick;
        assembly.reset();
        fetches = false;
    }
    void give_up_state() {
        ++states_refused;
        assembly.reset();
        fetches = false;
    }

    /// Changes to the next host after too many polls without new ticks.
    void judge_host() {
        if (std::exchange(ticks_seen, ticks.next()) != ticks.next())
            polls_without_ticks = 0;
        else if (++polls_without_ticks > host_silence_polls && def.hosts.size() > 1) {
            serving = (serving + 1) % def.hosts.size();
            polls_without_ticks = 0;
            assembly.reset(); // a state of another host may be for another tick
            ++host_changes;
        }
    }

    /// Sends the request of this poll. States are requested at fixed intervals of polls, so that no
    /// spectator increases the traffic of a player.
    void ask() {
        const bool is_due = def.state_polls != 0 && polls % def.state_polls == 0;
        ++polls;
        wants_state = wants_state || is_due;
        if (wants_state && !fetches && ticks.next() > 0 && !timeline.is_snapshot_taken())
            fetches = true, wants_state = false, polls_without_chunk = polls_fetching = 0;
        Wish wish;
        wish.wants_log = true;
        wish.wanted = ticks.next();
        const std::uint32_t most_polls = polls_for_state(assembly ? assembly->missing() : 0);
        const bool is_too_slow = ++polls_fetching > most_polls;
        if (fetches && (++polls_without_chunk > state_patience_polls || is_too_slow)) give_up_state();
        if (assembly && assembly->is_complete()) take_state();
        if (fetches) {
            wish.wants_state = true;
            if (assembly) {
                wish.offered = assembly->offer().tick;
                wish.missing = assembly->missing();
                wish.have = assembly->have_after_missing();
            }
        }
        const std::span<const std::byte> out = write_wish(packet, match, wish);
        to_hosts.send(def.hosts[serving], out);
        bytes_up += out.size();
    }

    SpectatorRelayDef def;
    Transport& to_hosts;
    Transport& to_watchers;
    std::uint32_t match;
    std::size_t tick_bytes;
    ToldTicks ticks;
    TimelineHost timeline;
    std::size_t serving = 0; ///< index of the host that receives the requests
    std::uint64_t ticks_seen = 0, polls = 0;
    std::uint32_t polls_without_ticks = 0, polls_without_chunk = 0, polls_fetching = 0;
    bool wants_state = false, fetches = false;
    std::optional<Assembly> assembly;
    std::uint64_t state_tick = 0, host_changes = 0, states_refused = 0, bytes_up = 0, dropped = 0;
    std::vector<std::byte> packet;
};

} // namespace
} // namespace lockstone::session

namespace lockstone {

Result<std::unique_ptr<SpectatorRelay>> make_spectator_relay(const SessionDef& def,
                                                             const SpectatorRelayDef& relay,
                                                             Transport& to_hosts, Transport& to_watchers) {
    using base::join;
    if (def.players.empty() || def.players.size() > players_max || def.input_size > input_bytes_max)
        return Error{join("spectator relay: ", def.players.size(), " players with inputs of ", def.input_size,
                          " bytes")};
    if (relay.hosts.empty() || relay.hosts.size() > session::hosts_max)
        return Error{
            join("spectator relay: ", relay.hosts.size(), " hosts, expected 1 to ", session::hosts_max)};
    if (relay.log_ticks_max < session::log_ticks_least)
        return Error{join("spectator relay: log_ticks_max is ", relay.log_ticks_max, ", at least ",
                          session::log_ticks_least)};
    if (relay.state_polls != 0 && relay.state_polls < session::state_polls_least)
        return Error{join("spectator relay: state_polls is ", relay.state_polls, ", 0 or at least ",
                          session::state_polls_least)};
    if (relay.state_bytes_max == 0 || relay.state_bytes_max > session::state_bytes_limit)
        return Error{join("spectator relay: state_bytes_max is ", relay.state_bytes_max, ", expected 1 to ",
                          session::state_bytes_limit)};
    return std::unique_ptr<SpectatorRelay>(
        std::make_unique<session::Relay>(def, relay, to_hosts, to_watchers));
}

} // namespace lockstone
