// Recordings: they verify, and damage or wrong hashes are detected.
#include "checks.h"
#include "replay/replay.h"

namespace planted {

namespace {

using Bytes = std::vector<std::byte>;

Bytes record(bool commands) {
    const ScriptGame game;
    replay::MemorySink sink;
    World world = game.start().value();
    replay::RecorderOptions options;
    options.keyframe_ticks = 8, options.block_ticks = 8;
    if (commands) {
        const auto recorder = scene::made(replay::CommandRecorder::begin(sink, world, "script", options));
        for (int t = 0; t < 40; ++t) scene::done(game.advance(world, {}));
        scene::done(recorder->close());
        return sink.bytes;
    }
    auto recorder = scene::made(replay::InputRecorder::begin(sink, game, world, options));
    for (int t = 0; t < 40; ++t) {
        scene::done(game.advance(world, {}));
        scene::done(recorder.after_tick(world, {}));
    }
    scene::done(recorder.close());
    return sink.bytes;
}

std::string recordings_verify() {
    const ScriptGame game;
    for (const bool commands : {false, true}) {
        const auto recording = replay::Recording::from_bytes(record(commands), "script");
        if (!recording) return recording.error().message;
        replay::VerifyOptions options;
        options.from_keyframes = true;
        const replay::VerifyReport report = verify(*recording, commands ? nullptr : &game, options);
        if (!report.good() || report.keyframes_compared < 3)
            return report.sentence + ", keyframes " + std::to_string(report.keyframes_compared);
    }
    return {};
}

std::string damaged_recordings() {
    const Bytes bytes = record(true);
    for (std::size_t at = 100; at < bytes.size(); at += bytes.size() / 60) {
        Bytes damaged = bytes;
        damaged[at] ^= std::byte{4};
        const auto recording = replay::Recording::from_bytes(damaged, "script");
        if (recording.ok()) return "byte " + std::to_string(at) + " was taken";
        if (recording.error().message.find("checksum") == std::string::npos &&
            recording.error().message.find("damaged") == std::string::npos)
            return "byte " + std::to_string(at) + ": " + recording.error().message;
    }
    return {};
}

/// Records a run with wrong hashes from tick 20 on.
std::string wrong_hash_found() {
    const ScriptGame game;
    replay::MemorySink sink;
    World world = game.start().value();
    auto recorder = scene::made(replay::InputRecorder::begin(sink, game, world, {}));
    for (std::uint64_t t = 0; t < 40; ++t) {
        const std::uint64_t tick = world.tick_count();
        scene::done(game.advance(world, {}));
        scene::done(recorder.on_tick(tick, {}, world.hash() ^ (t == 20 ? 1u : 0u)));
    }
    scene::done(recorder.close());
    const auto recording = scene::made(replay::Recording::from_bytes(sink.bytes, "script"));
    return verify(recording, &game).verdict == replay::Verdict::diverged ? "" : "it verifies";
}

} // namespace

Checks replay_checks() {
    return {{"recordings verify", recordings_verify},
            {"damaged recordings are refused", damaged_recordings},
            {"a wrong hash in a recording is found", wrong_hash_found}};
}

} // namespace planted
