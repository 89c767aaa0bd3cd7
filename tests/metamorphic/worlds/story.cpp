#include "story.h"

#include "lockstone/math/random.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <type_traits>

namespace worlds {

namespace {

/// A row of the game: numbers that commands write and no rule reads.
struct Mark {
    std::uint64_t value;
    std::array<std::uint32_t, 2> more;
};
template <class V> constexpr void describe(Mark& m, V&& v) { v("value", m.value), v("more", m.more); }

/// Ends the program. It throws no exception, because WebAssembly builds have none.
[[noreturn]] void stop(const std::string& sentence) {
    std::fprintf(stderr, "a story cannot be played: %s\n", sentence.c_str());
    std::exit(3);
}

template <class T> T taken(Result<T> result) {
    if (!result) stop(result.error().message);
    return std::move(*result);
}

} // namespace

const char* name_of(Feature feature) {
    static constexpr const char* names[] = {
        "bounces",    "rolls",          "slides",         "locks",       "bullets",      "no gyroscope",
        "one way",    "sensors",        "starts asleep",  "sleeps",      "kinematic",    "hulls",
        "compounds",  "meshes",         "height fields",  "joints",      "springs",      "limits",
        "motors",     "joint friction", "joints break",   "loops",       "fields",       "fluids",
        "explosions", "vehicles",       "characters",     "ragdolls",    "pair filters", "groups",
        "masses",     "damping",        "gravity scales", "integrators", "far away",     "comes and goes",
        "drops",      "game columns",   "assembled",      "wild"};
    static_assert(std::size(names) == feature_count);
    return names[static_cast<std::uint32_t>(feature)];
}

World story_world(const WorldDef& def) { return taken(World::create(def, story_schema(), story_assets())); }

const GameSchema& story_schema() {
    static const GameSchema schema = [] {
        GameSchema s;
        s.add_body_column<Mark>("game.mark");
        s.add_record<Mark>("game.sum");
        return s;
    }();
    return schema;
}

World Teller::start(std::uint64_t order) const {
    World world = story_world(told.def);
    if (!told.start) return world;
    if (order == 0) {
        taken(assemble(world, *told.start));
        return world;
    }
    Level level = *told.start;
    Random random = Random::seeded(order, 7);
    const auto shuffle = [&](auto& list) {
        for (std::size_t i = list.size(); i > 1; --i)
            std::swap(list[i - 1], list[random.below(static_cast<std::uint32_t>(i))]);
    };
    shuffle(level.bodies), shuffle(level.characters), shuffle(level.joints), shuffle(level.vehicles);
    shuffle(level.fields);
    taken(assemble(world, level));
    return world;
}

void Teller::apply(World& world, std::uint64_t tick) {
    auto step = std::ranges::lower_bound(told.steps, tick, {}, &Step::tick);
    for (; step != told.steps.end() && step->tick == tick; ++step) {
        const auto number = static_cast<std::size_t>(step - told.steps.begin());
        if (!told.is_symbolic) {
            const Result<World::Applied> result = world.apply(step->command);
            if (!made.empty()) made[number] = result ? *result : World::Applied{};
            continue;
        }
        Command command = step->command;
        bool is_whole = true;
        for_each_id(command, [&]<class Tag>(Id<Tag>& id) {
            if (!id) return;
            const World::Applied& from = made[id.index - 1];
            if constexpr (std::is_same_v<Id<Tag>, BodyId>)
                id = from.character && world.is_alive(from.character) ? world.body_of(from.character)
                                                                      : from.body;
            else if constexpr (std::is_same_v<Id<Tag>, ShapeId>)
                id = from.shape;
            else if constexpr (std::is_same_v<Id<Tag>, FieldId>)
                id = from.field;
            else if constexpr (std::is_same_v<Id<Tag>, JointId>)
                id = from.joint;
            else if constexpr (std::is_same_v<Id<Tag>, CharacterId>)
                id = from.character;
            else
                id = from.vehicle;
            is_whole = is_whole && id;
        });
        made[number] = {};
        if (!is_whole) continue; // its object was never created
        if (const Result<World::Applied> result = world.apply(command)) made[number] = *result;
    }
}

Story symbolic(const Story& story) {
    if (story.is_symbolic) return story;
    // The journal of a run also has the commands that assemble() applies at the start.
    struct Recorder final : Journal {
        void on_command(std::uint64_t tick, const Command& command) override {
            steps.push_back({tick, command});
        }
        void on_tick(std::uint64_t, std::uint64_t) override {}
        void on_restore(std::uint64_t) override {}
        std::vector<Step> steps;
    };
    Story out = story;
    out.start.reset();
    World world = story_world(story.def);
    if (story.start) {
        Recorder recorder;
        world.set_journal(&recorder);
        taken(assemble(world, *story.start));
        world.set_journal(nullptr);
        out.steps.insert(out.steps.begin(), recorder.steps.begin(), recorder.steps.end());
        world = story_world(story.def);
    }
    Teller teller(out);
    teller.keep_applied();
    std::map<std::pair<std::size_t, std::pair<std::uint32_t, std::uint32_t>>, std::uint32_t> step_of;
    for (std::uint64_t tick = 0; tick < out.ticks; ++tick) {
        teller.apply(world, tick);
        auto step = std::ranges::lower_bound(out.steps, tick, {}, &Step::tick);
        for (; step != out.steps.end() && step->tick == tick; ++step) {
            const auto number = static_cast<std::uint32_t>(step - out.steps.begin());
            const World::Applied& made = teller.applied()[number];
            const auto note = [&](std::size_t kind, auto id) {
                if (id) step_of[{kind, {id.index, id.generation}}] = number + 1;
            };
            note(0, made.body), note(1, made.shape), note(2, made.field), note(3, made.joint);
            note(4, made.character), note(5, made.vehicle);
            if (made.character && world.is_alive(made.character)) note(0, world.body_of(made.character));
        }
        world.tick();
    }
    for (Step& step : out.steps)
        for_each_id(step.command, [&]<class Tag>(Id<Tag>& id) {
            if (!id) return;
            constexpr std::size_t kind = std::is_same_v<Id<Tag>, BodyId>        ? 0
                                         : std::is_same_v<Id<Tag>, ShapeId>     ? 1
                                         : std::is_same_v<Id<Tag>, FieldId>     ? 2
                                         : std::is_same_v<Id<Tag>, JointId>     ? 3
                                         : std::is_same_v<Id<Tag>, CharacterId> ? 4
                                                                                : 5;
            const auto found = step_of.find({kind, {id.index, id.generation}});
            id = found == step_of.end() ? Id<Tag>{} : Id<Tag>{found->second, 1};
        });
    out.is_symbolic = true;
    return out;
}

} // namespace worlds
