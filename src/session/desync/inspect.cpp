// The session's part of a desync inspection: from the first different tick to the report. For the protocol
// see inspection.h.
#include "session/peer_session.h"

#include <algorithm>

namespace lockstone::session {

bool PeerSession::set_inspector(StateInspector* whom) {
    inspector = whom;
    return true;
}

/// Called on both machines for the same tick, so each of them can answer the other after this call.
void PeerSession::begin_inspection(PeerLink& link, const Desync& desync) {
    const State* after = inspector == nullptr ? nullptr : inspector->state_after(desync.tick);
    if (after == nullptr) return;
    std::vector<PlayerInput> run_on;
    for (const InputQueue& queue : queues) {
        const auto input = queue.before(desync.tick + 1);
        const bool has_left = queue.is_absent(desync.tick);
        if (!input && !has_left) return; // the input is older than the stored ones
        run_on.push_back(has_left ? queue.settled(desync.tick) : PlayerInput{*input, InputStatus::confirmed});
    }
    Rerun rerun = inspector->run_again(desync.tick, run_on);
    DesyncReport report;
    report.peer = link.peer;
    report.tick = desync.tick;
    report.local = local_hash(desync.tick);
    report.log = last_ticks(link, desync.tick);
    link.inspection = std::make_unique<Inspection>(std::move(report), *after, std::move(rerun));
}

std::vector<DesyncReport::Tick> PeerSession::last_ticks(const PeerLink& link, std::uint64_t tick) const {
    std::vector<DesyncReport::Tick> log;
    for (std::uint64_t t = tick - std::min(tick, desync_log_ticks - 1); t <= tick; ++t) {
        log.push_back({t, static_cast<std::uint32_t>(local_hash(t)), link.hashes.remote_hash(t), {}});
        for (const InputQueue& queue : queues) {
            std::vector<std::byte>& told = log.back().inputs.emplace_back();
            if (queue.is_absent(t)) continue;
            if (const auto input = queue.before(t + 1)) told.assign(input->begin(), input->end());
        }
    }
    return log;
}

std::optional<PacketFault> PeerSession::receive_inspection(PeerLink& link,
                                                           std::span<const std::byte> packet) {
    std::optional<Question> question;
    std::optional<Answer> answer;
    if (const auto fault = read_inspection(packet, link.context, question, answer)) return fault;
    // Not begun here yet, or an unrequested packet; a question is repeated.
    if (link.inspection == nullptr) return PacketFault::implausible;
    if (question) link.inspection->take(*question);
    if (answer) link.inspection->take(*answer);
    return std::nullopt;
}

void PeerSession::go_on_inspecting(PeerLink& link) {
    if (link.inspection == nullptr) return;
    if (link.state == PeerLink::State::gone) link.inspection->give_up();
    const std::span<const std::byte> packet = link.inspection->next_packet(link.context);
    if (!packet.empty() && link.state != PeerLink::State::gone) {
        transport.send(link.peer, packet);
        ++counts.packets_sent;
        counts.bytes_sent += packet.size();
    }
    if (auto report = link.inspection->take_report())
        notices.emplace_back(std::in_place_type<DesyncNamed>,
                             DesyncNamed{std::make_shared<const DesyncReport>(std::move(*report))});
}

} // namespace lockstone::session
