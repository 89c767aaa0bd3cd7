#include "shrink.h"

#include "compare.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <type_traits>

namespace worlds {

namespace {

template <class T> inline constexpr bool is_id = false;
template <class Tag> inline constexpr bool is_id<Id<Tag>> = true;
template <class T> inline constexpr bool is_command_of_indirect = false;
template <> inline constexpr bool is_command_of_indirect<CreateJoint> = true;
template <> inline constexpr bool is_command_of_indirect<CreateVehicle> = true;

template <class T> bool are_equal(const T& a, const T& b) {
    if constexpr (Leaf<T>) {
        return a == b;
    } else if constexpr (is_std_array<T>) {
        for (std::size_t i = 0; i < a.size(); ++i)
            if (!are_equal(a[i], b[i])) return false;
        return true;
    } else {
        bool same = true;
        T left = a;
        describe(left, [&](const char*, auto& field) {
            using F = std::remove_reference_t<decltype(field)>;
            const auto offset =
                reinterpret_cast<const std::byte*>(&field) - reinterpret_cast<const std::byte*>(&left);
            same = same && are_equal<F>(field, *reinterpret_cast<const F*>(
                                                   reinterpret_cast<const std::byte*>(&b) + offset));
        });
        return same;
    }
}

/// Calls visit(path, node, usual node) for a value, then for its parts. If visit returns false, the parts of that node
/// are skipped.
template <class T, class Visit> void walk(const std::string& path, T& value, const T& usual, Visit& visit) {
    if (!visit(path, value, usual)) return;
    if constexpr (Leaf<T> || is_id<T>) {
        return;
    } else if constexpr (is_std_array<T>) {
        for (std::size_t i = 0; i < value.size(); ++i)
            walk(path + "[" + std::to_string(i) + "]", value[i], usual[i], visit);
    } else {
        std::byte* const base = reinterpret_cast<std::byte*>(&value);
        describe(value, [&](const char* name, auto& field) {
            using F = std::remove_reference_t<decltype(field)>;
            const auto offset = reinterpret_cast<std::byte*>(&field) - base;
            walk(path + "." + name, field,
                 *reinterpret_cast<const F*>(reinterpret_cast<const std::byte*>(&usual) + offset), visit);
        });
    }
}

/// Walks through a command and a default command of its kind.
template <class Visit> void walk_command(Command& command, Visit&& visit) {
    std::visit(
        [&]<class C>(C& c) {
            if constexpr (is_command_of_indirect<C>) {
                const std::remove_reference_t<decltype(*c.def)> usual{};
                walk("c.def->", *c.def, usual, visit);
            } else {
                const C usual{};
                walk("c", c, usual, visit);
            }
        },
        command);
}

/// Resets node `number` of a command to its default. Returns false if there is no such node. Sets `changed` if the
/// value differed.
bool reset_node(Command& command, std::size_t number, bool& changed) {
    std::size_t at = 0;
    bool found = false;
    walk_command(command, [&]<class T>(const std::string&, T& node, const T& usual) {
        if (found) return false;
        if constexpr (is_id<T>) {
            return false;
        } else {
            if (at++ != number) return true;
            found = true;
            changed = !are_equal(node, usual);
            if (changed) node = usual;
            return false;
        }
    });
    return found;
}

class Shrinker {
  public:
    Shrinker(const Story& story, const Mode& mode) : best{story, mode, 0} {}
    Shrunk run() {
        if (!still_fails(best.story, best.mode)) return best; // only a longer run shows it
        simplify_mode();
        if (const Story named = symbolic(best.story); still_fails(named, best.mode)) best.story = named;
        if (best.story.is_symbolic) {
            remove_steps();
            simplify_values();
            remove_steps();
        }
        simplify_mode();
        return best;
    }

  private:
    /// Returns whether the story still fails. Cuts it to the ticks that show the failure, and keeps it.
    bool still_fails(const Story& story, const Mode& mode) {
        if (is_late()) return false;
        try {
            const std::optional<std::uint64_t> tick = first_tick_apart(story, mode);
            if (!tick) return false;
            best = {story, mode, *tick};
            best.story.ticks = *tick + 1;
            return true;
        } catch (const std::exception&) { return false; }
    }

    /// A minute is enough for most worlds. The bits of a shrunk story do not depend on the time.
    bool is_late() const { return std::chrono::steady_clock::now() - began > std::chrono::seconds(60); }

    void simplify_mode() {
        bool again = true;
        while (again) {
            again = false;
            for (const Mode& mode : simpler(best.mode)) {
                if (!still_fails(best.story, mode)) continue;
                again = true;
                break;
            }
        }
    }

    /// The story without some steps. Ids of the removed steps' objects become empty.
    static Story without(const Story& story, std::size_t first, std::size_t last) {
        Story out = story;
        out.steps.clear();
        const auto removed = static_cast<std::uint32_t>(last - first);
        for (std::size_t i = 0; i < story.steps.size(); ++i) {
            if (i >= first && i < last) continue;
            Step step = story.steps[i];
            bool is_whole = true;
            for_each_id(step.command, [&](auto& id) {
                if (!id) return;
                if (id.index > first && id.index <= last) is_whole = false;
                if (id.index > last) id.index -= removed;
            });
            // A step that lost its object stays in the list with empty ids, so that the numbers of the other steps
            // remain right.
            if (!is_whole) for_each_id(step.command, [&](auto& id) { id = {}; });
            out.steps.push_back(std::move(step));
        }
        return out;
    }

    void remove_steps() {
        for (std::size_t piece = std::max<std::size_t>(best.story.steps.size() / 2, 1);; piece /= 2) {
            for (std::size_t first = 0; first < best.story.steps.size();) {
                const std::size_t last = std::min(first + piece, best.story.steps.size());
                if (!still_fails(without(best.story, first, last), best.mode)) first = last;
            }
            if (piece <= 1 || is_late()) return;
        }
    }

    void simplify_values() {
        // First resets a value in all commands of a kind at once, then in each command alone.
        for (std::size_t kind = 0; kind < std::variant_size_v<Command>; ++kind)
            try_nodes([&](std::size_t i) { return best.story.steps[i].command.index() == kind; });
        if (best.story.steps.size() <= 40)
            for (std::size_t i = 0; i < best.story.steps.size(); ++i)
                try_nodes([&](std::size_t k) { return k == i; });
        for (const auto& change :
             {+[](WorldDef& d) { d = WorldDef{}; }, +[](WorldDef& d) { d.substeps = 1; },
              +[](WorldDef& d) { d.sleeping = 0; }, +[](WorldDef& d) { d.gravity = WorldDef{}.gravity; },
              +[](WorldDef& d) { d.tick_rate = 60; }}) {
            Story story = best.story;
            change(story.def);
            still_fails(story, best.mode);
        }
    }

    template <class Chosen> void try_nodes(Chosen&& chosen) {
        for (std::size_t node = 0; !is_late(); ++node) {
            Story story = best.story;
            bool any = false, is_there = false;
            for (std::size_t i = 0; i < story.steps.size(); ++i) {
                if (!chosen(i)) continue;
                bool changed = false;
                is_there |= reset_node(story.steps[i].command, node, changed);
                any |= changed;
            }
            if (!is_there) return;
            if (any) still_fails(story, best.mode);
        }
    }

    Shrunk best;
    std::chrono::steady_clock::time_point began = std::chrono::steady_clock::now();
};

template <class T> std::string number_of(const T& leaf) {
    if constexpr (FixedPoint<T>)
        return std::to_string(leaf.raw);
    else
        return std::to_string(static_cast<std::int64_t>(leaf));
}

const char* type_of(const Command& command) {
    static constexpr const char* names[] = {
        "CreateBody",     "DestroyBody",     "CreateShape",       "DestroyShape",     "CreateField",
        "DestroyField",   "SetPose",         "SetVelocity",       "AddForce",         "AddForceAt",
        "AddImpulse",     "AddImpulseAt",    "SetBodyParameters", "SetMaterial",      "SetGravity",
        "WriteGame",      "SetFilter",       "SetPairFilter",     "SetMass",          "CreateJoint",
        "DestroyJoint",   "SetJointAxis",    "SetJointFrames",    "WakeBody",         "CreateVehicle",
        "DestroyVehicle", "SetVehicleInput", "CreateCharacter",   "DestroyCharacter", "SetCharacterInput",
        "SetField",       "Explode"};
    static_assert(std::size(names) == std::variant_size_v<Command>);
    return names[command.index()];
}

/// Collects an assignment for each leaf that differs from its default.
class Assignments {
  public:
    template <class T> bool operator()(const std::string& path, T& node, const T& usual) {
        if constexpr (is_id<T>) {
            if (node) text += " name(" + plain(path) + ", " + std::to_string(node.index) + ");";
            return false;
        } else if constexpr (Leaf<T>) {
            if (node != usual) text += " set(" + plain(path) + ", " + number_of(node) + ");";
            return false;
        } else {
            return true;
        }
    }
    std::string text;

  private:
    static std::string plain(std::string path) {
        if (const std::size_t at = path.find("->."); at != std::string::npos) path.erase(at + 2, 1);
        return path;
    }
};

} // namespace

Shrunk shrink(const Story& story, const Mode& mode) { return Shrinker(story, mode).run(); }

std::string program_of(const Shrunk& shrunk) {
    std::string out = "TEST_CASE(\"kept world: " + to_string(shrunk.mode) + "\") {\n";
    out += "    Story s = kept(" + std::to_string(shrunk.story.ticks) + ");\n";
    WorldDef def = shrunk.story.def;
    const WorldDef usual{};
    Assignments of_def;
    walk("s.def", def, usual, of_def);
    if (!of_def.text.empty()) out += "   " + of_def.text + "\n";
    for (const Step& step : shrunk.story.steps) {
        Command command = step.command;
        Assignments a;
        walk_command(command, a);
        out += "    add<" + std::string(type_of(command)) + ">(s, " + std::to_string(step.tick) +
               ", [](auto& c) {" + (a.text.empty() ? " (void)c;" : a.text) + " });\n";
    }
    const Mode& m = shrunk.mode;
    out += "    Mode m;\n    m.simd = Simd::" + std::string(name_of(m.simd)) + ";";
    const auto add = [&](const char* name, std::uint64_t value) {
        if (value != 0)
            out += std::string(" set(m.") + name + ", " + std::to_string(static_cast<std::int64_t>(value)) +
                   ");";
    };
    add("runner", static_cast<std::uint64_t>(m.runner)), add("workers", m.workers),
        add("restores", m.restores);
    add("disturbs", m.disturbs), add("seed", m.seed);
    for (const auto& [name, is_on] : {std::pair{"observes", m.observes},
                                      {"hashes_phases", m.hashes_phases},
                                      {"reserves", m.reserves},
                                      {"queries", m.queries}})
        if (is_on) out += std::string(" m.") + name + " = true;";
    return out + "\n    CHECK(!first_tick_apart(s, m));\n}\n";
}

} // namespace worlds
