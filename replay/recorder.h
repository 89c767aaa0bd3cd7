// Recorders: from a game's confirmed ticks, or from a world's commands, to a sink.
//
//   FileSink file = FileSink::create("match.lsr").value();
//   InputRecorder recorder = InputRecorder::begin(file, game, world).value();
//   while (playing) {
//       if (Status s = game.advance(world, inputs); !s) print(s.error().message);
//       if (Status s = recorder.after_tick(world, inputs); !s) print(s.error().message);    // disk full, ...
//   }
//   recorder.close();
//
// Under rollback the world runs ahead of what is confirmed: feed `on_tick` from the timeline's confirmed ticks, in order.
#pragma once

#include "replay/writer.h"

#include <memory>

namespace lockstone::replay {

struct RecorderOptions {
    std::vector<Option> options = {};                      ///< for HEAD; sorted here, keys unique
    std::uint64_t keyframe_ticks = keyframe_ticks_default; ///< 0: only the first
    std::uint32_t block_ticks = block_ticks_default;       ///< ticks that a crash may lose, 1..1024
};

class InputRecorder {
  public:
    /// `start` is the world before its next tick; when it stands at tick 0, it is as game.start() made it (verifiers check).
    static Result<InputRecorder> begin(Sink& sink, const Game& game, const World& start,
                                       const RecorderOptions& options = {});
    /// Goes on with a writer in inputs mode.
    static InputRecorder resume(Writer writer, std::uint64_t keyframe_ticks);

    // Errors stay: after the first, nothing more is written and every call returns it.
    /// Tick `tick` was run with these inputs and left a state of this hash. Ticks come in order without gaps.
    Status on_tick(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash);
    /// Whether a keyframe of the state after the last tick should be given now. Leaving one out only makes seeking slower.
    bool keyframe_due() const;
    /// `world` stands right after the last tick that was recorded (checked).
    Status keyframe(const World& world);
    /// The plain loop: on_tick for the tick that `world` has just run, and a keyframe when one is due.
    Status after_tick(const World& world, std::span<const PlayerInput> inputs);
    /// Writes pending ticks at once, as before a pause.
    Status flush() { return writer.flush(); }
    Status close() { return writer.close(); }

    std::uint64_t next_tick() const { return writer.next_tick(); }
    std::uint64_t bytes_written() const { return writer.bytes_written(); }

  private:
    InputRecorder(Writer w, std::uint64_t every) : writer(std::move(w)), keyframe_ticks(every) {}
    Writer writer;
    std::uint64_t keyframe_ticks;
};

/// Records every command of a world, by itself: it attaches as the world's journal.
class CommandRecorder final : public Journal {
  public:
    /// The world is neither moved nor destroyed until close() or the recorder's end: that ends the program with a sentence.
    /// A restore meanwhile is an error that stays: commands alone do not lead there.
    static Result<std::unique_ptr<CommandRecorder>> begin(Sink& sink, World& world, const std::string& label,
                                                          const RecorderOptions& options = {});
    /// Goes on with a writer in commands mode whose next tick is the world's.
    static std::unique_ptr<CommandRecorder> resume(Writer writer, World& world, std::uint64_t keyframe_ticks);
    ~CommandRecorder() override;
    CommandRecorder(const CommandRecorder&) = delete;
    CommandRecorder& operator=(const CommandRecorder&) = delete;

    void on_command(std::uint64_t tick, const Command& command) override;
    void on_tick(std::uint64_t tick, std::uint64_t hash) override;
    void on_restore(std::uint64_t tick) override;

    /// Ticking cannot return an error: ask here, or wait for close().
    const Status& status() const { return state; }
    /// Detaches, writes the rest. Commands after the last tick have had no effect yet and are left out.
    Status close();
    std::uint64_t bytes_written() const { return writer.bytes_written(); }

  private:
    CommandRecorder(Writer w, World& of, std::uint64_t every)
        : writer(std::move(w)), world(&of), lifetime(of.lifetime()), keyframe_ticks(every) {}
    void detach();
    Writer writer;
    World* world; ///< null after close
    std::weak_ptr<const void> lifetime;
    std::uint64_t keyframe_ticks;
    std::vector<Command> pending; ///< before the next tick
    Status state;
};

} // namespace lockstone::replay
