// One cell of the matrix: runs games and prints their hashes in the format of tests/golden/hashes.tsv, in the
// environment that the options select. Builds with any C++20 compiler for any machine, without libraries except
// xxHash's header.
//
//   matrix_hash [OPTION...] GAME...      GAME: a Game::name(), as in the golden table
//   matrix_hash --worlds FIRST COUNT     small random worlds of these seeds; prints a row for each, with its number of
//                                        ticks and a hash of all ticks
//
//   --ticks N        0: prints only the hash of the start
//   --powers         prints ticks 0, 1, 2, 4, 8 ... and the last; else every tick
//   --workers N      runs ticks on a pool of N workers (builds without threads refuse)
//   --shuffle SEED   runs the tasks of ticks in random order
//   --fpu            before each tick the next of all rounding modes, with and without flushing of denormals
//   --poison BYTE    fills memory with the byte when it is allocated and when it is freed
//   --move SEED      allocates and frees at random before and between ticks, so that addresses differ
//   --write FOLDER   writes a snapshot at half of the ticks, its difference to the start, and a recording of all ticks
//   --read FOLDER    continues from those snapshots, which the differences must give too, and plays those recordings
//                    against their own hashes
//
// Exit status: 0 success, 1 a check failed, 2 wrong usage.
#include "host.h"
#include "metamorphic/worlds/draw.h"
#include "replay/player.h"
#include "replay/recorder.h"
#include "tests/support/scripted_inputs.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

using namespace lockstone;

namespace {

struct Options {
    std::uint64_t ticks = 8;
    bool powers = false;
    std::uint32_t workers = 0;
    std::uint64_t shuffle = 0, move = 0;
    bool fpu = false;
    std::string write, read;
    std::uint64_t first_world = 0, worlds = 0;
    std::vector<std::string> games;
};

[[noreturn]] void refuse(const std::string& sentence) {
    std::fprintf(stderr, "matrix_hash: %s\n", sentence.c_str());
    std::exit(2);
}
[[noreturn]] void fail(const std::string& sentence) {
    std::fflush(stdout);
    std::fprintf(stderr, "matrix_hash: %s\n", sentence.c_str());
    std::exit(1);
}
template <class T> T got(Result<T> result, const std::string& what) {
    if (!result) fail(what + ": " + result.error().message);
    return std::move(*result);
}
void good(const Status& status, const std::string& what) {
    if (!status) fail(what + ": " + status.error().message);
}

Options parse(int argc, char** argv) {
    Options o;
    for (int i = 1; i < argc; ++i) {
        const std::string a = argv[i];
        const auto value = [&] {
            if (++i == argc) refuse(a + " wants a value");
            return std::string(argv[i]);
        };
        const auto number = [&] { return std::strtoull(value().c_str(), nullptr, 0); };
        if (a == "--ticks")
            o.ticks = number();
        else if (a == "--powers")
            o.powers = true;
        else if (a == "--workers")
            o.workers = static_cast<std::uint32_t>(number());
        else if (a == "--shuffle")
            o.shuffle = number();
        else if (a == "--fpu")
            o.fpu = true;
        else if (a == "--poison")
            host::poison(static_cast<unsigned char>(number()));
        else if (a == "--move")
            o.move = number();
        else if (a == "--write")
            o.write = value();
        else if (a == "--read")
            o.read = value();
        else if (a == "--worlds")
            o.first_world = number(), o.worlds = number();
        else if (a.starts_with("--"))
            refuse("there is no option " + a);
        else
            o.games.push_back(a);
    }
    if (o.games.empty() && o.worlds == 0) refuse("name a game");
    return o;
}

/// "rollback-arena-size-0-seed-1-players-2"
std::string file_name(const std::string& folder, const std::string& game, const char* ending) {
    std::string name = game;
    for (char& c : name)
        if (c == ' ' || c == '=') c = '-';
    return folder + "/" + name + ending;
}

void write_bytes(const std::string& path, std::span<const std::byte> bytes) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    if (file == nullptr || std::fwrite(bytes.data(), 1, bytes.size(), file) != bytes.size() ||
        std::fclose(file) != 0)
        fail(path + ": cannot be written");
}
std::vector<std::byte> read_bytes(const std::string& path) {
    std::FILE* file = std::fopen(path.c_str(), "rb");
    if (file == nullptr) fail(path + ": cannot be read");
    std::vector<std::byte> bytes;
    std::byte piece[4096];
    for (std::size_t n; (n = std::fread(piece, 1, sizeof piece, file)) != 0;)
        bytes.insert(bytes.end(), piece, piece + n);
    std::fclose(file);
    return bytes;
}

void print(const Options& o, const std::string& game, const World& world) {
    const std::uint64_t tick = world.tick_count();
    if (o.powers && (tick & (tick - 1)) != 0 && tick != o.ticks) return;
    std::printf("%s\t%llu\t%016llx\n", game.c_str(), static_cast<unsigned long long>(tick),
                static_cast<unsigned long long>(world.hash()));
}

void advance(const Options& o, const Game& game, World& world, test::ScriptedInputs& inputs) {
    if (o.move != 0) host::move_heap(o.move + world.tick_count());
    const std::span<const PlayerInput> now = inputs.at(world.tick_count());
    const host::FloatingPoint odd(o.fpu, world.tick_count());
    good(game.advance(world, now), game.name());
}

/// Continues from a snapshot of another cell. Its difference to the start must give an equal state.
void read_state(const Options& o, const std::string& name, World& world) {
    Image start;
    world.save(start);
    const std::string path = file_name(o.read, name, ".state"), other = file_name(o.read, name, ".delta");
    good(world.restore_portable(read_bytes(path)), path);
    const std::uint64_t hash = world.hash();
    good(world.restore_delta(start, read_bytes(other)), other);
    if (world.hash() != hash) fail(other + ": leads to another state than " + path);
}

void write_state(const Options& o, const std::string& name, const World& world, const Image& start) {
    write_bytes(file_name(o.write, name, ".state"), world.save_portable());
    write_bytes(file_name(o.write, name, ".delta"), world.save_delta(start));
}

/// The target of a recording: a file, as a game would write it, if one is requested; else memory.
std::unique_ptr<replay::Sink> sink_of(const Options& o, const std::string& name) {
    if (o.write.empty()) return std::make_unique<replay::MemorySink>();
    const std::string path = file_name(o.write, name, ".lsr");
    return std::make_unique<replay::FileSink>(got(replay::FileSink::create(path), path));
}

void run(const Options& o, const std::string& name) {
    const std::unique_ptr<Game> game = got(make_scene_named(name), name);
    if (o.move != 0) host::move_heap(o.move);
    const std::unique_ptr<Tasks> tasks = host::make_tasks(o.workers, o.shuffle);
    World world = got(game->start(), name);
    test::ScriptedInputs inputs(*game);
    const std::unique_ptr<replay::Sink> file = sink_of(o, name);
    auto recorder = got(replay::InputRecorder::begin(*file, *game, world), name);
    Image start;
    world.save(start);
    if (!o.read.empty()) read_state(o, name, world);
    world.set_tasks(tasks.get());
    print(o, name, world);
    while (world.tick_count() < o.ticks) {
        advance(o, *game, world, inputs);
        print(o, name, world);
        if (o.write.empty()) continue;
        good(recorder.after_tick(world, inputs.at(world.tick_count() - 1)), name);
        if (world.tick_count() == o.ticks / 2) write_state(o, name, world, start);
    }
    if (o.write.empty()) return;
    good(recorder.close(), name);
    good(file->close(), name);
}

/// Plays a recording of another cell: every tick must give the recorded hash.
void play(const Options& o, const std::string& name) {
    const std::string path = file_name(o.read, name, ".lsr");
    const auto recording = got(replay::Recording::open(path), path);
    const std::unique_ptr<Game> game = got(make_scene_named(recording.header().game), path);
    auto player = got(replay::Player::open(recording, *game), path);
    std::uint64_t compared = 0;
    for (;; ++compared) {
        if (!player.agrees()) fail(path + ": differs at time " + std::to_string(player.time()));
        if (player.at_end()) break;
        good(player.step(), path);
    }
    if (compared != o.ticks) fail(path + ": holds " + std::to_string(compared) + " ticks");
    std::printf("# %s: played, %llu ticks agree\n", name.c_str(), static_cast<unsigned long long>(compared));
}

/// A row for each random world: its number of ticks, and a hash of all ticks' hashes.
void print_worlds(const Options& o) {
    for (std::uint64_t seed = o.first_world; seed < o.first_world + o.worlds; ++seed) {
        const host::FloatingPoint odd(o.fpu, seed);
        const std::vector<std::uint64_t> hashes =
            worlds::draw(seed, {.bodies_most = 60, .work = 400, .has_large = false}).hashes;
        std::vector<std::byte> bytes;
        for (const std::uint64_t hash : hashes)
            for (int i = 0; i < 8; ++i) bytes.push_back(static_cast<std::byte>(hash >> (8 * i) & 0xffu));
        std::printf("world %llu\t%zu\t%016llx\n", static_cast<unsigned long long>(seed), hashes.size(),
                    static_cast<unsigned long long>(hash_bytes(bytes)));
    }
}

} // namespace

int main(int argc, char** argv) {
    const Options o = parse(argc, argv);
    for (const std::string& game : o.games) {
        run(o, game);
        if (!o.read.empty()) play(o, game);
    }
    print_worlds(o);
    return 0;
}
