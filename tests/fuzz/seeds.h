// The first inputs of the fuzzers of states, recordings and packets.
#pragma once

#include "fuzz/checks/packet_check.h"
#include "fuzz/checks/recording_check.h"

namespace fuzz {

namespace detail {

constexpr std::string_view world_names[] = {"blocks", "joints", "drivers"};

enum class As : std::uint8_t { itself = 0, splices = 8, rows = 16 };
inline Script state_seed(std::size_t world, bool is_delta, As how) {
    return Script().u8(static_cast<std::uint8_t>(world | (is_delta ? 4u : 0u) | static_cast<unsigned>(how)));
}

inline std::uint8_t column_named(std::string_view name) {
    const StateLayout& layout = base_of(0).now.state().layout();
    return static_cast<std::uint8_t>(layout.find_column(name) - layout.columns().data());
}

/// Changes numbers that commands do not bound, in every row, a little or to an edge value.
inline Script& change_numbers(Script& to, std::uint8_t how, std::uint8_t by) {
    for (const std::string_view column :
         {"body.velocity", "body.force", "body.pose", "contact.memory", "contact.point", "joint.memory",
          "vehicle.memory", "game.bruise", "game.purse"})
        for (std::uint8_t row = 0; row < 2; ++row) {
            const std::uint16_t first =
                column == "contact.memory" ? 2 : 0; // after the flags and the number of points
            to.u8(column_named(column)).u8(row).u16(static_cast<std::uint16_t>(first + row)).u8(how).u8(by);
        }
    return to;
}

/// A world of one ball and three ticks: a complete recording in few bytes.
inline Buffer least_recording() {
    WorldDef def;
    def.bodies_max = def.shapes_max = def.contacts_max = 4;
    def.fields_max = def.pair_filters_max = def.joints_max = def.characters_max = def.vehicles_max = 1;
    World w = made(World::create(def));
    replay::MemorySink sink;
    add_ball(w, at(0, 1, 0));
    const auto recorder = made(replay::CommandRecorder::begin(sink, w, "ball"));
    for (int tick = 0; tick < 3; ++tick) {
        done(w.add_impulse(w.body_at(0), vec(tick, 1, 0)));
        w.tick();
    }
    done(recorder->close());
    return sink.bytes;
}

} // namespace detail

inline std::vector<Seed> state_seeds() {
    using detail::As, detail::state_seed;
    std::vector<Seed> all;
    for (std::size_t world = 0; world < base_count; ++world)
        for (const bool is_delta : {false, true}) {
            const std::string name =
                std::string(detail::world_names[world]) + (is_delta ? "_delta" : "_image");
            const auto add = [&](const char* what, const Script& script) {
                all.push_back({name + what, script.done()});
            };
            add("_good", state_seed(world, is_delta, As::rows));
            Script little = state_seed(world, is_delta, As::rows), edge = little, cut = little;
            add("_little", detail::change_numbers(little, 1, 3));
            add("_edge", detail::change_numbers(edge, 2, 13));
            add("_rows", cut.u8(255).u8(4).u8(2)); // of the bodies
            Script spliced = state_seed(world, is_delta, As::splices);
            const std::byte patch[] = {std::byte{7}, std::byte{0}, std::byte{255}};
            add("_splice", spliced.splice(900, 3, patch).splice(50, 1, {}));
        }
    const auto raw = [&](const char* name, std::size_t world, bool is_delta, const Buffer& bytes) {
        all.push_back({name, state_seed(world, is_delta, As::itself).bytes(bytes).done()});
    };
    raw("blocks_image_itself", 0, false, base_of(0).portable);
    raw("joints_delta_itself", 1, true, base_of(1).delta);
    raw("no_image", 0, false, {});
    return all;
}

inline std::vector<Seed> recording_seeds() {
    std::vector<Seed> all;
    const auto seed = [](std::size_t which, unsigned how, bool index = true) {
        return Script().u8(static_cast<std::uint8_t>(which | how << 2 | (index ? 16u : 0u)));
    };
    constexpr std::string_view names[] = {"inputs", "joints", "drivers"};
    for (std::size_t which = 0; which < recording_count; ++which) {
        const std::string name(names[which]);
        const std::byte patch[] = {std::byte{1}, std::byte{200}};
        all.push_back({name + "_good", seed(which, 2).done()});
        Script ticks = seed(which, 2), file = seed(which, 1), start = seed(which, 3);
        for (std::uint8_t chunk = 0; chunk < 12; ++chunk)
            ticks.u8(chunk).u8(1).splice(static_cast<std::uint16_t>(40 + 31 * chunk), 2, patch);
        all.push_back({name + "_chunks", ticks.done()});
        all.push_back({name + "_cut", file.splice(1200, 255, {}).done()});
        all.push_back({name + "_start", detail::change_numbers(start, 1, 1).done()});
        all.push_back({name + "_one_tick", seed(which, 2).u8(5).u8(1).splice(70, 1, patch).done()});
    }
    all.push_back({"ball_itself", seed(1, 0).bytes(detail::least_recording()).done()});
    all.push_back({"nothing", seed(1, 0).done()});
    return all;
}

inline std::vector<Seed> packet_seeds() {
    constexpr std::uint8_t frame = 0, frames = 2, any = 3, changed = 4, lost = 6, leap = 7;
    std::vector<Seed> all;
    for (const std::uint8_t setup : std::initializer_list<std::uint8_t>{0, 1, 2, 7, 14, 16, 19}) {
        const std::string name = "setup_" + std::to_string(setup);
        const std::byte byte[] = {std::byte{9}};
        all.push_back({name + "_peace", Script().u8(setup).u8(frames).u8(lost).u8(frames).u8(frames).done()});
        Script fire;
        fire.u8(setup).u8(frames);
        for (std::uint16_t place = 0; place < 34; place = static_cast<std::uint16_t>(place + 2))
            fire.u8(changed).u8(1).u8(1).splice(place, 1, byte).u8(frame); // each field of a packet in turn
        all.push_back({name + "_fire", fire.done()});
        Script rest;
        rest.u8(setup).u8(frames).u8(any).u8(3).u8(1).bytes(byte).u8(changed).u8(130).u8(0).u8(frame);
        rest.u8(any).u8(1).u8(1).bytes(byte).u8(leap).u8(20).u8(frames).u8(changed).u8(2).u8(0);
        all.push_back({name + "_rest", rest.u8(frames).done()});
    }
    return all;
}

} // namespace fuzz
