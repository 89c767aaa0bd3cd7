// FORMAT.md and the code must agree: the writer's bytes equal the vectors on the page.
#include "replay/format/codec.h"
#include "replay/replay.h"
#include "support/small_game.h"

#include <doctest/doctest.h>

#include <fstream>
#include <sstream>

using namespace lockstone;
using namespace lockstone::replay;
using test::must;

namespace {

std::string text_of(const std::string& path) {
    std::ifstream in(std::string(LOCKSTONE_SOURCE_DIR) + "/" + path);
    std::ostringstream out;
    out << in.rdbuf();
    return out.str();
}

/// The bytes of the fenced block "```lsr NAME" on the page. A '#' begins a comment.
std::vector<std::byte> vector_on_page(const std::string& name) {
    std::istringstream page(text_of("replay/FORMAT.md"));
    std::vector<std::byte> bytes;
    bool inside = false;
    for (std::string line; std::getline(page, line);) {
        if (line == "```lsr " + name)
            inside = true;
        else if (line == "```")
            inside = false;
        else if (inside) {
            std::istringstream words(line.substr(0, line.find('#')));
            for (std::string word; words >> word;)
                bytes.push_back(static_cast<std::byte>(std::stoul(word, nullptr, 16)));
        }
    }
    return bytes;
}

std::span<const std::byte> bytes_of(std::string_view text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

Header tiny_header(Mode mode) {
    Header header;
    header.mode = mode;
    header.engine = "0.1.0";
    header.game = "tiny";
    header.content_id = mode == Mode::inputs ? 0x1122334455667788u : 0;
    header.schema_hash = 0x0123456789abcdefu;
    header.player_count = mode == Mode::inputs ? 2 : 0;
    header.input_size = mode == Mode::inputs ? 1 : 0;
    header.start_tick = mode == Mode::inputs ? 0 : 100;
    header.options = {{"seed", "7"}};
    return header;
}

GameSchema tiny_schema() {
    GameSchema schema;
    schema.add({"game.score", false, 4, {{"points", 0, 4, LeafKind::unsigned_integer, 0}}});
    return schema;
}

/// Sets every field by name, so that the page does not depend on a default.
WorldDef tiny_def() {
    WorldDef def;
    def.tick_rate = 60;
    def.substeps = 4;
    def.gravity = {Real{}, Real(-10), Real{}};
    def.integrator = Integrator::verlet;
    def.bounds_shift = 2;
    def.bodies_max = 8;
    def.shapes_max = 9;
    def.contacts_max = 10;
    def.fields_max = 3;
    def.pair_filters_max = 5;
    def.joints_max = 6;
    def.characters_max = 1;
    def.vehicles_max = 2;
    def.continuous = 1;
    def.sleeping = 1;
    def.restitution_speed_min = Real(1);
    def.contact_hertz = Real(60);
    def.contact_damping = Real(10);
    def.push_speed_max = Real(3);
    def.sleep_speed = 0.25_r;
    def.sleep_time = 0.5_r;
    def.seed = 7;
    return def;
}

/// Three ticks of two players; the second player leaves. A keyframe follows the second tick. The images are invented,
/// because the file format does not interpret them.
std::vector<std::byte> tiny_inputs() {
    MemorySink sink;
    const std::string_view first = "portable image", second = "portable imago";
    Writer writer = must(
        Writer::begin(sink, tiny_header(Mode::inputs), tiny_schema(), tiny_def(), 0xa0, bytes_of(first)));
    const std::byte up{1}, down{2};
    const auto tick = [&](std::byte a, std::optional<std::byte> b, std::uint64_t hash) {
        const PlayerInput gone{{}, InputStatus::disconnected};
        const PlayerInput inputs[] = {{{&a, 1}}, b ? PlayerInput{{&*b, 1}} : gone};
        must(writer.add_inputs(inputs, hash));
    };
    tick(up, down, 0xa1);
    tick(up, up, 0xa2);
    must(writer.add_keyframe(bytes_of(second)));
    tick(up, std::nullopt, 0xa3);
    must(writer.close());
    return sink.bytes;
}

/// Two ticks from time 100: two commands before the first, none before the second.
std::vector<std::byte> tiny_commands() {
    MemorySink sink;
    Writer writer =
        must(Writer::begin(sink, tiny_header(Mode::commands), {}, tiny_def(), 0xb0, bytes_of("image")));
    const Command commands[] = {SetGravity{{Real{}, Real(-10), Real{}}}, DestroyBody{{3, 1}}};
    must(writer.add_commands(commands, 0xb1));
    must(writer.add_commands({}, 0xb2));
    must(writer.close());
    return sink.bytes;
}

/// The first difference of two byte strings, for a helpful message.
std::string first_difference(std::span<const std::byte> a, std::span<const std::byte> b) {
    std::size_t i = 0;
    while (i < a.size() && i < b.size() && a[i] == b[i]) ++i;
    return i == a.size() && i == b.size() ? ""
                                          : "byte " + std::to_string(i) + " of " + std::to_string(a.size()) +
                                                " and " + std::to_string(b.size());
}

} // namespace

TEST_CASE("the writer produces the test vector for inputs in FORMAT.md") {
    CHECK(first_difference(tiny_inputs(), vector_on_page("inputs")) == "");
}

TEST_CASE("the writer produces the test vector for commands in FORMAT.md") {
    CHECK(first_difference(tiny_commands(), vector_on_page("commands")) == "");
}

TEST_CASE("the test vector for inputs reads back with the content that FORMAT.md describes") {
    const Recording recording = must(Recording::from_bytes(vector_on_page("inputs"), "page"));
    CHECK(recording.header() == tiny_header(Mode::inputs));
    CHECK(recording.complete());
    REQUIRE(recording.tick_count() == 3);
    const TickBlock block = recording.block_with(0), last = recording.block_with(2);
    CHECK(block.inputs(0)[1].bytes[0] == std::byte{2});
    CHECK(block.inputs(1)[1].bytes[0] == std::byte{1});
    CHECK(last.inputs(2)[0].status == InputStatus::confirmed);
    CHECK(last.inputs(2)[1].status == InputStatus::disconnected);
    for (std::uint64_t t = 0; t <= 3; ++t) CHECK(recording.hash_at(t) == 0xa0 + t);
    REQUIRE(recording.keyframes().size() == 2);
    CHECK(std::ranges::equal(recording.keyframe_image(1), bytes_of("portable imago")));
}

TEST_CASE("the test vector for commands reads back with the content that FORMAT.md describes") {
    const Recording recording = must(Recording::from_bytes(vector_on_page("commands"), "page"));
    REQUIRE(recording.tick_count() == 2);
    CHECK(recording.start_tick() == 100);
    const auto commands = recording.block_with(100).commands(100);
    REQUIRE(commands.size() == 2);
    CHECK(std::get<SetGravity>(commands[0]).gravity.y == Real(-10));
    CHECK(std::get<DestroyBody>(commands[1]).body == BodyId{3, 1});
    CHECK(recording.block_with(100).commands(101).empty());
}

TEST_CASE("the table of commands in FORMAT.md matches the engine") {
    const std::string page = text_of("replay/FORMAT.md");
    for (std::size_t kind = 0; kind < command_kinds; ++kind) {
        std::vector<std::byte> zeros(command_bytes(kind));
        const Command command = read_command(kind, zeros);
        const std::string row = "| " + std::to_string(kind) + " | " + name_of(command) + " | " +
                                std::to_string(command_bytes(kind)) + " |";
        CAPTURE(row);
        CHECK(page.find(row) != std::string::npos);
    }
}

TEST_CASE("recordings name the engine version of the build") {
    CHECK(text_of("CMakeLists.txt").find("VERSION " + std::string(engine_version) + " ") !=
          std::string::npos);
}
