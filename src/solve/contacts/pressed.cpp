#include "solve/contacts/pressed.h"

#include "base/poison.h"
#include "lockstone/math/math.h"

#include <algorithm>
#include <utility>

namespace lockstone::solve {

namespace {

/// The search for a support looks at no more than this many bodies: a body deeper in a heap has many supports.
constexpr std::size_t behind_max = 32;
constexpr Separation touching_max = decimal<Separation>("0.001");
/// cosine of 60 degrees: a supporting contact lies within this angle of the push
constexpr Unit cone = half(unit_one);

bool touches(const Contact& c) {
    const auto points = std::span(c.points).first(c.count);
    return std::ranges::any_of(points, [](const ContactPoint& p) { return p.separation <= touching_max; });
}

bool is_heavier(const BodyStep& heavy, const BodyStep& light) {
    return heavy.mass.raw / pressed_ratio > light.mass.raw;
}

/// True if the masses of all bodies are so alike that no body can be pressed.
bool are_alike(std::span<const BodyTraits> traits) {
    std::int64_t least = Real::max().raw, most = 0;
    for (const BodyTraits& t : traits) {
        if (t.mass.mass <= Real{}) continue;
        least = std::min(least, t.mass.mass.raw), most = std::max(most, t.mass.mass.raw);
    }
    return most / pressed_ratio <= least;
}

} // namespace

void PressedBodies::list_contacts(std::span<const Contact> contacts, std::size_t bodies) {
    first.assign(bodies + 2, 0);
    for (const Contact& c : contacts) ++first[c.body_a + 2], ++first[c.body_b + 2];
    for (std::size_t i = 2; i < first.size(); ++i) first[i] += first[i - 1];
    of_body.resize(2 * contacts.size());
    for (std::uint32_t i = 0; i < contacts.size(); ++i)
        of_body[first[contacts[i].body_a + 1]++] = of_body[first[contacts[i].body_b + 1]++] = i;
}

bool PressedBodies::is_supported(std::span<const Contact> contacts, const SolverBodies& bodies,
                                 const Load& load) {
    behind.assign(1, load.light);
    for (std::size_t at = 0; at < behind.size(); ++at) {
        const std::uint32_t body = behind[at];
        for (std::uint32_t k = first[body]; k < first[body + 1]; ++k) {
            const Contact& c = contacts[of_body[k]];
            const bool is_a = c.body_a == body;
            const std::uint32_t other = is_a ? c.body_b : c.body_a;
            if (other == load.heavy || dot<Unit>(is_a ? c.normal : -c.normal, load.push) < cone ||
                !touches(c))
                continue;
            if (!bodies.step[other].movable) return true;
            if (behind.size() < behind_max && std::ranges::find(behind, other) == behind.end())
                behind.push_back(other);
        }
    }
    return false;
}

bool PressedBodies::add(std::span<const Contact> contacts, const Load& load, SolverBodies& bodies) {
    BodyStep& light = bodies.step[load.light];
    if (light.pressed || !light.movable || !is_heavier(bodies.step[load.heavy], light)) return false;
    if (!std::exchange(is_listed, true)) list_contacts(contacts, bodies.step.size());
    if (is_supported(contacts, bodies, load)) light.pressed = true;
    return light.pressed;
}

bool PressedBodies::find(std::span<const Contact> contacts, std::span<const Load> loads,
                         std::span<const BodyTraits> traits, SolverBodies& bodies) {
    if (are_alike(traits)) return false;
    is_listed = false;
    bool any = false;
    for (const Contact& c : contacts) {
        const BodyStep &a = bodies.step[c.body_a], &b = bodies.step[c.body_b];
        if (!a.movable || !b.movable) continue;
        if (is_heavier(a, b)) any |= add(contacts, {c.body_b, c.body_a, c.normal}, bodies);
        if (is_heavier(b, a)) any |= add(contacts, {c.body_a, c.body_b, -c.normal}, bodies);
    }
    for (const Load& load : loads) any |= add(contacts, load, bodies);
    return any;
}

void PressedBodies::reserve(std::size_t bodies, std::size_t contacts) {
    first.reserve(bodies + 3); // two more than bodies, and one for SolverBodies::still()
    of_body.reserve(2 * contacts);
    behind.reserve(behind_max);
}

void PressedBodies::poison(std::byte with) {
    auto& [first_list, contact_list, listed, body_list] = *this;
    base::poison(with, first_list, contact_list, listed, body_list);
}

} // namespace lockstone::solve
