// The rules for a session that gets arbitrary packets. The fuzzer and the tests that replay its inputs use them.
//
// The test checks machine 0; the others are honest. A twin of machine 0 gets only the packets that machine 0 did not
// drop. Dropped packets must change nothing, so both must send, run and confirm equal data.
//
// Byte 0 of an input: bit 0 lockstep, bit 1 three machines instead of two, bits 2-3 input delay - 1, bit 4 the timeout
// is 200 ms instead of 5 s. Then steps, each u8, modulo 8:
//   0-2   1, 2 or 8 frames of all machines
//   3     a packet of arbitrary bytes: u8 from, u8 size, bytes; its head and checksum are made valid when from < 128
//   4, 5  the last honest packet of a peer, changed: u8 from, u8 number of splices modulo 4, the splices; checksum
//         as in 3
//   6     all packets under way to machine 0 are lost
//   7     time advances by u8 times 16 ms
#pragma once

#include "fuzz/edits.h"
#include "session/match.h"
#include "session/seal.h"

#include <deque>

namespace fuzz {

using namespace lockstone;

/// Writes the head of a greeting into a packet whose first bit marks it as one, and a valid checksum.
inline void seal_packet(Buffer& packet, std::uint32_t match) {
    constexpr std::size_t match_at = 4;
    if (packet.size() >= match_at + 8 && (packet[0] & std::byte{128}) == std::byte{0}) {
        base::store_little_endian(session::packet_magic, packet.data());
        packet[2] = std::byte{session::packet_version};
        base::store_little_endian(match, packet.data() + match_at);
    }
    test::seal(packet, match);
}

/// The packets that arrived at one machine and those that it sent. Detects which packets its session did not drop.
class Mailbox final : public Transport {
  public:
    struct Packet {
        PeerId peer; ///< the other machine
        Buffer bytes;
        bool hostile = false;
        friend bool operator==(const Packet&, const Packet&) = default;
    };
    void send(PeerId to, std::span<const std::byte> bytes) override {
        sent.push_back({to, Buffer(bytes.begin(), bytes.end())});
    }
    std::optional<Datagram> receive() override {
        const std::uint64_t dropped = session == nullptr ? 0 : session->stats().packets_dropped;
        if (has_held && dropped == dropped_before) taken.push_back(held);
        has_held = !waiting.empty();
        dropped_before = dropped;
        if (!has_held) return std::nullopt;
        held = std::move(waiting.front());
        waiting.pop_front();
        return Datagram{held.peer, held.bytes};
    }
    const Session* session = nullptr;
    std::deque<Packet> waiting;
    std::vector<Packet> sent, taken; ///< since the last clear()

  private:
    Packet held{};
    bool has_held = false;
    std::uint64_t dropped_before = 0;
};

struct PacketSetup {
    bool lockstep;
    std::uint32_t machines, input_delay;
    std::uint64_t disconnect_ms;

    explicit PacketSetup(std::uint8_t byte)
        : lockstep((byte & 1u) != 0), machines((byte & 2u) != 0 ? 3 : 2), input_delay(1 + (byte >> 2 & 3u)),
          disconnect_ms((byte & 16u) != 0 ? 200 : 5000) {}
    SessionDef def(PeerId self) const {
        SessionDef d;
        d.content_id = 7;
        d.input_size = input_size_of<test::Pad>;
        d.self = self;
        for (PeerId id = 0; id < machines; ++id) d.players.push_back(id);
        d.input_delay = input_delay;
        d.disconnect_ms = disconnect_ms;
        return d;
    }
};

/// Makes machine 0's session. A test may use another maker to plant a fault.
struct SessionMaker {
    std::unique_ptr<Session> operator()(const PacketSetup& setup, const SessionDef& def,
                                        Transport& transport) const {
        return (setup.lockstep ? make_lockstep_session(def, transport)
                               : make_rollback_session(def, transport))
            .value();
    }
};

struct Machine {
    Mailbox mailbox;
    std::unique_ptr<Session> session;
    test::Arena arena;
    test::Timeline timeline;
    test::EventLaw events;
    std::unique_ptr<SessionRunner> runner;
    PeerId self;

    template <class Make>
    Machine(const PacketSetup& setup, PeerId id, Make&& make)
        : session(make(setup, setup.def(id), mailbox)), arena(setup.machines), self(id) {
        mailbox.session = session.get();
        runner = std::make_unique<SessionRunner>(*session, arena, RunnerDef{&timeline});
    }
    Machine(const Machine&) = delete;
    Machine& operator=(const Machine&) = delete;

    void frame(std::uint64_t now_ms) {
        session->add_local_input(self, encode_input(test::scripted_pad(self, session->current_tick())));
        runner->frame(now_ms);
        for (const SessionEvent& e : runner->events()) events.see(e);
        while (session->next_notice()) {}
    }
};

/// The result of an attacked match.
struct PacketOutcome {
    std::uint64_t hostile_taken = 0, dropped = 0, ticks = 0;
};

class SiegedMatch {
  public:
    template <class Make> SiegedMatch(const PacketSetup& made, Make&& make) : setup(made) {
        machines.push_back(std::make_unique<Machine>(setup, 0, make));
        for (PeerId id = 1; id < setup.machines; ++id)
            machines.push_back(std::make_unique<Machine>(setup, id, SessionMaker()));
        twin = std::make_unique<Machine>(setup, 0, SessionMaker());
    }

    /// One frame of all machines. Returns an error sentence or an empty string.
    std::string frame() {
        now_ms += 16;
        Machine& asked = *machines[0];
        const std::uint64_t tick_before = asked.session->current_tick();
        for (const auto& m : machines) m->frame(now_ms);
        for (Mailbox::Packet& packet : asked.mailbox.taken) {
            outcome.hostile_taken += packet.hostile ? 1 : 0;
            twin->mailbox.waiting.push_back(std::move(packet));
        }
        asked.mailbox.taken.clear();
        twin->frame(now_ms);
        std::string complaint = compare(tick_before);
        deliver();
        return complaint;
    }

    void attack(PeerId from, Buffer packet) {
        machines[0]->mailbox.waiting.push_back({from, std::move(packet), true});
    }
    void lose_all() { machines[0]->mailbox.waiting.clear(); }
    void leap(std::uint64_t ms) {
        now_ms += ms;
        has_leapt = has_leapt || ms > 0;
    }
    /// The last packet of a peer to machine 0; empty before the first one.
    const Buffer& last_packet(std::size_t peer) const { return last[peer % last.size()]; }
    std::uint32_t match() const { return session::packet_context(setup.def(0)).match; }

    /// Some more frames without attacks. The match must continue, unless a session accepted a hostile packet.
    std::string finish() {
        const std::uint64_t tick_before = machines[0]->session->current_tick();
        for (int i = 0; i < 40; ++i)
            if (std::string e = frame(); !e.empty()) return e;
        const SessionStats& stats = machines[0]->session->stats();
        outcome.dropped = stats.packets_dropped;
        outcome.ticks = machines[0]->session->current_tick();
        std::uint64_t by_fault = 0;
        for (const std::uint64_t count : stats.dropped) by_fault += count;
        if (by_fault != stats.packets_dropped) return "dropped packets are not counted by their fault";
        const bool deceived = outcome.hostile_taken > 0 || has_leapt;
        // Lockstep among three waits for a round trip: a tick in four frames at a delay of 1.
        const std::uint64_t ticks_least = setup.lockstep && setup.machines > 2 ? 6 : 20;
        if (!deceived && outcome.ticks < tick_before + ticks_least)
            return "nothing was believed, but the match stands still";
        return {};
    }
    PacketOutcome outcome;

  private:
    std::string compare(std::uint64_t tick_before) {
        Machine& asked = *machines[0];
        if (asked.session->current_tick() < tick_before) return "the present went back";
        if (asked.mailbox.sent != twin->mailbox.sent) return "dropped packets changed what is sent";
        if (asked.session->current_tick() != twin->session->current_tick() ||
            asked.arena.hash() != twin->arena.hash())
            return "dropped packets changed the match";
        if (!asked.timeline.in_order || asked.timeline.ticks != twin->timeline.ticks)
            return "dropped packets changed what is confirmed";
        if (!asked.events.holds(asked.timeline.ticks.size())) return "an event has no end, or two";
        for (; checked < asked.timeline.ticks.size(); ++checked) {
            const test::Timeline::Tick& tick = asked.timeline.ticks[checked];
            if (tick.statuses[0] != InputStatus::confirmed) return "the local player was disconnected";
            if (checked < setup.input_delay) continue;
            const auto pressed = encode_input(test::scripted_pad(0, checked - setup.input_delay));
            if (!std::equal(pressed.begin(), pressed.end(), tick.inputs.begin()))
                return "a local input was lost";
        }
        return {};
    }

    void deliver() {
        for (PeerId from = 0; from < setup.machines; ++from) {
            for (Mailbox::Packet& packet : machines[from]->mailbox.sent) {
                if (packet.peer == 0) last[from % last.size()] = packet.bytes;
                machines[packet.peer]->mailbox.waiting.push_back({from, std::move(packet.bytes)});
            }
            machines[from]->mailbox.sent.clear();
            if (from > 0) machines[from]->mailbox.taken.clear();
        }
        twin->mailbox.sent.clear();
        twin->mailbox.taken.clear();
    }

    PacketSetup setup;
    std::vector<std::unique_ptr<Machine>> machines;
    std::unique_ptr<Machine> twin;
    std::array<Buffer, 3> last;
    std::uint64_t now_ms = 0;
    std::size_t checked = 0; ///< confirmed ticks
    bool has_leapt = false;
};

/// One step of an input.
inline std::string step_of(Input& in, SiegedMatch& match, int& frames) {
    const std::uint8_t step = in.take_u8() % 8;
    if (step <= 2) {
        for (int i = step == 0 ? 1 : step == 1 ? 2 : 8; i > 0; --i, ++frames)
            if (std::string e = match.frame(); !e.empty()) return e;
        return {};
    }
    if (step == 6) match.lose_all();
    if (step == 7) match.leap(std::uint64_t{16} * in.take_u8());
    if (step >= 6) return {};
    const std::uint8_t from = in.take_u8();
    Buffer packet;
    if (step == 3) {
        const std::span<const std::byte> bytes = in.take_bytes(in.take_u8());
        packet.assign(bytes.begin(), bytes.end());
    } else {
        packet = match.last_packet(from);
        for (std::uint8_t n = in.take_u8() % 4; n > 0; --n) splice(in, packet);
    }
    if (from < 128) seal_packet(packet, match.match());
    match.attack(from % 4, std::move(packet));
    return {};
}

/// Returns an error sentence about a session that gets these packets, or an empty string.
template <class Make = SessionMaker>
std::string check_packets(std::span<const std::byte> data, PacketOutcome& outcome, Make&& make = {}) {
    Input in(data);
    SiegedMatch match(PacketSetup(in.take_u8()), make);
    int frames = 0;
    for (int steps = 0; steps < 200 && frames < 64 && !in.empty(); ++steps)
        if (std::string e = step_of(in, match, frames); !e.empty()) return e;
    std::string complaint = match.finish();
    outcome = match.outcome;
    return complaint;
}

} // namespace fuzz
