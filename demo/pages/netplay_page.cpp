#include "netplay_page.h"

#include "view/hud.h"

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float flash_frames = 15;

constexpr const char* link_keys = "- = less or more latency   9 0 less or more loss";

/// Mixes the colour with `hot` right after an event, and fades back.
glm::vec4 flash(const glm::vec4& colour, const glm::vec4& hot, std::uint64_t frames_since) {
    return glm::mix(hot, colour, std::min(static_cast<float>(frames_since) / flash_frames, 1.0f));
}

std::string padded(std::uint64_t number, std::size_t width) {
    std::string text = std::to_string(number);
    return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

} // namespace

NetplayPage::NetplayPage(const Options& options, Stage& stage, std::unique_ptr<NetplayMatch> match)
    : stage_(stage), match_(std::move(match)),
      people_play_(stage.interactive && is_playable(match_->game()) && options.input_file.empty()),
      record_file_(options.record_file) {
    for (std::uint32_t i = 0; i < NetplayMatch::peer_count; ++i) {
        halves_[i].view.reset(match_->peer(i).world);
        halves_[i].rig.frame_scene(halves_[i].view.bounds());
        halves_[i].rig.follow(i);
    }
}

Result<std::unique_ptr<Page>> NetplayPage::open(const Options& options, Stage& stage) {
    const std::uint64_t ticks =
        options.ticks.value_or(stage.interactive ? ticks_default_window : ticks_default);
    Result<std::unique_ptr<NetplayMatch>> match = NetplayMatch::create(options, ticks);
    if (!match) return match.error();
    return std::unique_ptr<Page>(new NetplayPage(options, stage, std::move(*match)));
}

Status NetplayPage::tick() {
    if (finished()) return {};
    match_->frame(people_play_ ? &input_map_ : nullptr);
    for (std::uint32_t i = 0; i < NetplayMatch::peer_count; ++i)
        halves_[i].view.capture(match_->peer(i).world);
    return finished() ? finish() : Status{};
}

Status NetplayPage::finish() {
    closed_ = true;
    replays_identical_ = match_->replays_identical();
    if (record_file_.empty()) return {};
    Result<replay::FileSink> file = replay::FileSink::create(record_file_);
    if (!file) return file.error();
    if (const Status status = file->append(match_->peer(0).log.replay()); !status) return status;
    return file->close();
}

void NetplayPage::control(const Input& input, const Moment& moment) {
    const std::uint32_t latency = match_->latency_ms(), loss = match_->loss_percent();
    if (input.pressed(Key::minus)) match_->set_link(latency - std::min(latency, 20u), loss);
    if (input.pressed(Key::equal)) match_->set_link(std::min(latency + 20, 400u), loss);
    if (input.pressed(Key::num_9)) match_->set_link(latency, loss - std::min(loss, 5u));
    if (input.pressed(Key::num_0)) match_->set_link(latency, std::min(loss + 5, 60u));
    if (people_play_) input_map_.poll(input, halves_[0].rig.camera());
    for (Half& half : halves_)
        half.rig.control(input, half.view, moment.size.y * moment.pixel_scale, moment.seconds, people_play_);
}

// ---- drawing ----------------------------------------------------------------------------------------------

std::vector<Frame> NetplayPage::draw(const Moment& moment) {
    std::vector<Frame> frames;
    for (std::uint32_t i = 0; i < NetplayMatch::peer_count; ++i) frames.push_back(draw_half(i, moment));
    frames.push_back(draw_middle(moment));
    return frames;
}

Frame NetplayPage::draw_half(std::uint32_t index, const Moment& moment) {
    Half& half = halves_[index];
    half.rig.update(half.view, moment.alpha, moment.seconds);
    Frame frame;
    frame.viewport = {0.5f * static_cast<float>(index), 0, 0.5f, 1};
    frame.camera = half.rig.camera();
    frame.wireframe = stage_.view.wireframe;
    half.view.draw(frame, moment.alpha, stage_, half.rig.followed());
    if (!stage_.view.overlay) return frame;
    draw_peer(frame, index, moment);
    draw_rollbacks(frame, match_->peer(index), moment);
    draw_match(frame, moment, half.view, match_->game().player_count());
    return frame;
}

void NetplayPage::draw_peer(Frame& frame, std::uint32_t index, const Moment& moment) const {
    const Peer& peer = match_->peer(index);
    const SessionStats& stats = peer.session->stats();
    const std::uint64_t confirmed = peer.log.hashes().size();
    TextPanel panel(moment, {12, 12});
    panel.title("peer " + std::to_string(index + 1));
    panel.line("tick       " + padded(peer.session->current_tick(), 6) + "  predicted", ink::white);
    panel.line("confirmed  " + padded(confirmed, 6) + "  of " + std::to_string(match_->ticks()));
    panel.line("ping       " + padded(peer.session->quality(1 - index).ping_ms, 6) + "  ms");
    panel.line("rollbacks  " + padded(stats.rollbacks, 6) + "  depth " + std::to_string(peer.last_depth) +
                   ", at most " + std::to_string(stats.depth_max),
               flash(ink::grey, ink::amber, peer.frames_since_rollback));
    panel.line("run again  " + padded(stats.resimulated, 6) + "  ticks");
    panel.line("stalls     " + padded(stats.stalls, 6) +
               (peer.stall == Stall::none ? "" : std::string("  ") + name_of(peer.stall)));
    panel.line("events:");
    panel.line("  predicted" + padded(peer.events[0], 6),
               flash(ink::grey, ink::blue, peer.frames_since_event[0]));
    panel.line("  confirmed" + padded(peer.events[1], 6),
               flash(ink::grey, ink::green, peer.frames_since_event[1]));
    panel.line("  cancelled" + padded(peer.events[2], 6),
               flash(ink::grey, ink::red, peer.frames_since_event[2]));
    if (!peer.notices.empty()) panel.line(peer.notices.back(), ink::red);
    panel.draw(frame);
}

/// A bar per frame: its height is the number of re-simulated ticks.
void NetplayPage::draw_rollbacks(Frame& frame, const Peer& peer, const Moment& moment) const {
    constexpr float bar = 3, unit = 3, bottom = 116;
    const glm::vec2 size = viewport_size(frame, moment);
    const float left = 12, base = size.y - bottom;
    for (std::size_t i = 0; i < peer.depths.size(); ++i) {
        if (peer.depths[i] == 0) continue;
        const float height = unit * static_cast<float>(peer.depths[i]);
        frame.rects.push_back({.position = {left + bar * static_cast<float>(i), base - height},
                               .size = {bar - 1, height},
                               .colour = {1.0f, 0.80f, 0.35f, 0.9f}});
    }
    frame.rects.push_back({.position = {left, base},
                           .size = {bar * static_cast<float>(NetplayMatch::history), 1},
                           .colour = {1, 1, 1, 0.5f}});
    frame.text.push_back(
        {.text = "ticks run again, by frame", .position = {left, base + 2}, .colour = ink::white});
}

Frame NetplayPage::draw_middle(const Moment& moment) const {
    Frame frame;
    frame.scene = false;
    const auto divide = [&](float height) {
        frame.rects.push_back(
            {.position = {0.5f * moment.size.x - 1, 0}, .size = {2, height}, .colour = {0, 0, 0, 1}});
    };
    if (!stage_.view.overlay) {
        divide(moment.size.y);
        return frame;
    }
    const NetplayMatch::Agreement& agreement = match_->agreement();
    const bool good = agreement.hashes == agreement.compared;
    TextPanel panel(moment, {0, 0});
    panel.line("latency " + std::to_string(match_->latency_ms()) + " ms   loss " +
               std::to_string(match_->loss_percent()) + " %   " + format_speed(stage_.clock) + "   F1 keys");
    panel.line(std::to_string(agreement.hashes) + " of " + std::to_string(agreement.compared) +
                   " confirmed hashes agree" + (good ? "  \u2713" : ""),
               good ? ink::green : ink::red);
    if (agreement.compared != 0)
        panel.line("tick " + std::to_string(agreement.compared - 1) + "   " +
                   format_hash(match_->peer(0).log.hashes()[agreement.compared - 1]));
    panel.move_to({0.5f * (moment.size.x - panel.size().x), moment.size.y - panel.size().y - 10});
    divide(moment.size.y - panel.size().y - 10);
    panel.draw(frame);
    draw_help(frame, moment, stage_.view,
              (people_play_ ? keys_of_players(match_->game(), true) : "") + link_keys);
    return frame;
}

Verdict NetplayPage::verdict() const {
    const NetplayMatch::Agreement& agreement = match_->agreement();
    const SessionStats &a = match_->peer(0).session->stats(), &b = match_->peer(1).session->stats();
    std::string sentence =
        match_->game().name() + ", two peers over " + std::to_string(match_->latency_ms()) + " ms and " +
        std::to_string(match_->loss_percent()) + " % loss: " + std::to_string(agreement.hashes) + " of " +
        std::to_string(closed_ ? match_->ticks() : agreement.compared) + " confirmed hashes agree, ";
    const bool inputs = agreement.inputs == agreement.compared;
    sentence += inputs ? "confirmed inputs identical" : "confirmed inputs differ";
    if (closed_)
        sentence += replays_identical_ ? ", replays byte-identical (" +
                                             format_bytes(match_->peer(0).log.replay().size()) + ")"
                                       : ", replays differ";
    sentence += "; " + std::to_string(a.rollbacks) + " and " + std::to_string(b.rollbacks) +
                " rollbacks, depth at most " + std::to_string(std::max(a.depth_max, b.depth_max));
    if (match_->stuck()) sentence += "; the peers stopped confirming ticks";
    const bool good = inputs && agreement.hashes == agreement.compared && !match_->stuck() &&
                      (!closed_ || replays_identical_);
    return {sentence, good};
}

} // namespace lockstone::demo
