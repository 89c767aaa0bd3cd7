#include "figure_ticks.h"

#include <vector>

namespace lockstone::demo {

Result<FigureFinder> FigureFinder::create(const World& start) {
    if (start.tick_count() != 0)
        return Error{"it begins at tick " + std::to_string(start.tick_count()) +
                     ", where blocks may touch already; the figures need the start"};
    std::vector<BodyId> dynamic;
    for (const BodyId body : start.bodies())
        if (start.kind(body) == BodyKind::dynamic) dynamic.push_back(body);
    if (dynamic.size() != 2)
        return Error{"the figures need two dynamic bodies; it has " + std::to_string(dynamic.size())};
    return FigureFinder({dynamic[0], dynamic[1]});
}

FigureFinder::Begun FigureFinder::read_events(const World& world) {
    Begun begun;
    for (const Event& event : world.events()) {
        const bool begins = event.kind == EventKind::contact_begin;
        if (!begins && event.kind != EventKind::contact_end) continue;
        const auto is = [&](std::size_t block) {
            return event.body_a == blocks_[block] || event.body_b == blocks_[block];
        };
        const int change = begins ? 1 : -1;
        if (is(0) && is(1)) {
            between_ += change;
            begun.between |= begins;
        } else if (is(0) || is(1)) {
            const std::size_t block = is(0) ? 0 : 1;
            ground_[block] += change;
            begun.ground[block] |= begins;
        }
    }
    return begun;
}

void FigureFinder::after_tick(const World& world) {
    if (done()) return;
    time_ = world.tick_count();
    const Begun begun = read_events(world);
    if (stage_ == Stage::falling && begun.any()) {
        first_ = begun.ground[1] && !begun.ground[0] ? 1 : 0;
        first_contact_ = time_;
        stage_ = Stage::bounced;
    }
    if (stage_ == Stage::bounced) {
        second_landed_ |= begun.ground[1 - first_];
        if (begun.between) meeting_ = time_, stage_ = Stage::met;
    }
    if (stage_ == Stage::apart) after_parting(begun);
    if (stage_ == Stage::met && nothing_touches()) {
        parted_ = time_, flight_end_ = 0, landed_ = {};
        stage_ = Stage::apart;
    }
}

void FigureFinder::after_parting(const Begun& begun) {
    if (flight_end_ == 0 && begun.any()) flight_end_ = time_;
    for (std::size_t block = 0; block < 2; ++block) landed_[block] |= begun.ground[block];
    if (landed_[0] && landed_[1])
        landing_ = time_, stage_ = Stage::landed;
    else if (begun.between)
        stage_ = Stage::met; // the blocks touched again, so they had not parted yet
}

std::string FigureFinder::complaint() const {
    const std::string within = " within " + std::to_string(time_) + " ticks";
    if (stage_ == Stage::falling) return "no bodies touch" + within;
    if (stage_ == Stage::bounced) return "the blocks never meet" + within;
    if (second_landed_ || meeting_ == first_contact_)
        return "the blocks meet at tick " + std::to_string(meeting_) +
               ", but not while one has bounced off the ground and the other is in the air";
    if (stage_ == Stage::met) return "the blocks never fly apart" + within;
    if (stage_ == Stage::apart) return "the blocks do not both meet the ground again" + within;
    return "";
}

Result<FigureTicks> FigureFinder::ticks() const {
    if (const std::string why = complaint(); !why.empty()) return Error{why};
    return FigureTicks{.in_the_air = first_contact_ / 2,
                       .meeting = meeting_,
                       .apart = (parted_ + flight_end_ - 1) / 2,
                       .landing = landing_,
                       .blocks = {blocks_[first_], blocks_[1 - first_]}};
}

} // namespace lockstone::demo
