// A match with one hostile machine: an honest session whose packets are changed on their way out. The header also
// checks the result at the honest machines.
#pragma once

#include "session/link/message.h"
#include "session/match.h"

#include <algorithm>

namespace lockstone::test {

/// Decodes every packet, lets `lie` change the message, and encodes it again with a valid checksum. The transport
/// decodes inputs as differences to zeros, because it does not keep the earlier inputs.
class LyingTransport final : public Transport {
  public:
    /// Changes the message for machine `to`, its input blocks included. Returns whether the packet is sent.
    using Lie = std::function<bool(PeerId to, session::Message& message)>;
    Transport* real = nullptr;
    Lie lie;
    session::PacketContext context{};
    std::uint32_t players = 0; ///< of the liar's machine, as bits

    void send(PeerId to, std::span<const std::byte> bytes) override {
        session::Message message{};
        session::Sender& known = sent.try_emplace(to, session::Sender{players}).first->second;
        if (session::decode(bytes, context, known, message)) return real->send(to, bytes);
        known.sequence = message.sequence, known.tick = message.tick;
        if (!lie) return real->send(to, bytes);
        if (lie(to, message)) real->send(to, written(message));
    }
    std::optional<Datagram> receive() override { return real->receive(); }

    std::span<const std::byte> written(const session::Message& message) {
        writer.begin(context, session::Sender{players}, message);
        const std::vector<std::byte> zeros(context.input_size);
        for (std::uint32_t p = 0; p < context.player_count; ++p) {
            if ((players >> p & 1u) == 0) continue;
            const auto block = std::ranges::find(message.input_blocks(), p, &session::InputBlock::player);
            if (block == message.input_blocks().end()) {
                writer.add_no_inputs();
                continue;
            }
            std::vector<std::vector<std::byte>> inputs;
            session::for_each_input(*block, zeros, [&](std::uint64_t, std::span<const std::byte> input) {
                inputs.emplace_back(input.begin(), input.end());
            });
            writer.add_inputs(block->first, inputs.size(), 0, zeros, [&](std::uint64_t tick) {
                return std::span<const std::byte>(inputs[tick - block->first]);
            });
        }
        return writer.finish();
    }

  private:
    session::PacketWriter writer;
    std::map<PeerId, session::Sender> sent; ///< by receiver: its decoder's state if it gets every packet
};

/// Machines with one player each. The last machine lies once `liar.lie` is set. A machine is dropped after one second
/// of silence.
class HostileMatch {
  public:
    explicit HostileMatch(std::uint32_t machines, MatchDef def = {})
        : hostile(machines - 1), match(complete(machines, std::move(def))) {}

    LyingTransport liar;
    PeerId hostile;
    Match match;

    /// Returns an error sentence about these honest machines, or an empty string. Each must have confirmed
    /// `ticks_least` ticks.
    std::string trouble(const std::vector<PeerId>& honest, std::uint64_t ticks_least) {
        for (const PeerId a : honest) {
            const std::string name = "machine " + std::to_string(a) + ": ";
            for (const PeerId b : honest) {
                if (!match.agree(a, b)) return name + "another timeline than machine " + std::to_string(b);
                for (const Desync& desync : match.notices<Desync>(a))
                    if (desync.peer == b) return name + "a desync with an honest machine";
                for (const PlayerDisconnected& left : match.notices<PlayerDisconnected>(a))
                    if (left.peer == b) return name + "an honest machine was thrown out";
            }
            for (const MatchStopped& stop : match.notices<MatchStopped>(a))
                return name + "stopped: " + stop.reason;
            const std::uint64_t ticks = match.machine(a).timeline.ticks.size();
            if (ticks < ticks_least)
                return name + std::to_string(ticks) + " ticks of " + std::to_string(ticks_least);
        }
        return {};
    }
    bool has_left(PeerId at, PeerId who) {
        return std::ranges::any_of(match.notices<PlayerDisconnected>(at),
                                   [&](const PlayerDisconnected& left) { return left.peer == who; });
    }

  private:
    MatchDef complete(std::uint32_t machines, MatchDef def) {
        def.machines = machines;
        def = completed(std::move(def));
        if (def.disconnect_ms == 5000) def.disconnect_ms = 1000;
        if (def.link.latency_ms == 0) def.link = {.latency_ms = 40, .jitter_ms = 15, .loss_permille = 50};
        SessionDef as_match;
        as_match.content_id = 7;
        as_match.input_size = input_size_of<Pad>;
        as_match.players = def.players;
        liar.context = session::packet_context(as_match);
        liar.players = session::players_at(as_match, hostile);
        def.through = [this](PeerId id, Transport& wire) -> Transport& {
            if (id != hostile) return wire;
            liar.real = &wire;
            return liar;
        };
        return def;
    }
};

} // namespace lockstone::test
