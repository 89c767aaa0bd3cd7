// Short functions for the worlds that the shrinker printed as tests.
//
//   Story s = kept(12);                                        twelve ticks
//   add<CreateBody>(s, 0, [](auto& c) { set(c.def.pose.position.y, 4294967296); });
//   add<CreateShape>(s, 0, [](auto& c) { name(c.body, 1); });  the body that the first step creates
//   first_apart(s)                                             empty: all instruction sets and workers give equal bits
#pragma once

#include "compare.h"

#include <string>
#include <vector>

namespace worlds {

struct KeptStory {
    const char* about;
    Story story;
};
/// The kept stories.
std::vector<KeptStory> kept_stories();
/// Returns the first instruction set and number of workers for which a story differs from the reference, and the tick.
/// Empty if none differs.
std::string first_apart(const Story& story);

inline Story kept(std::uint64_t ticks) {
    Story s;
    s.ticks = ticks, s.is_symbolic = true;
    return s;
}

/// Sets a number by its bits: for a fixed-point value the raw integer.
template <class T> void set(T& field, std::int64_t raw) {
    if constexpr (FixedPoint<T>)
        field = T::from_raw(static_cast<decltype(T{}.raw)>(raw));
    else
        field = static_cast<T>(raw);
}

/// Sets an id to that of the object that a step creates; steps are counted from 1.
template <class Tag> void name(Id<Tag>& id, std::uint32_t step) { id = {step, 1}; }

template <class C, class Fill> void add(Story& story, std::uint64_t tick, Fill&& fill) {
    C command{};
    fill(command);
    story.steps.push_back({tick, std::move(command)});
}

} // namespace worlds
