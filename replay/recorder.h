// Recorders: write a game's confirmed ticks, or a world's commands, to a sink.
//
//   FileSink file = FileSink::create("match.lsr").value();
//   InputRecorder recorder = InputRecorder::begin(file, game, world).value();
//   while (playing) {
//       if (Status s = game.advance(world, inputs); !s) print(s.error().message);
//       if (Status s = recorder.after_tick(world, inputs); !s) print(s.error().message);    // disk full, ...
//   }
//   recorder.close();
//
// Under rollback the world runs ahead of the confirmed ticks: call `on_tick` with the timeline's confirmed ticks, in
// order.
#pragma once

#include "replay/writer.h"

#include <memory>

namespace lockstone::replay {

struct RecorderOptions {
    std::vector<Option> options = {}; ///< for HEAD; the recorder sorts them; keys must be unique
    std::uint64_t keyframe_ticks = keyframe_ticks_default; ///< 0: only the first
    std::uint32_t block_ticks = block_ticks_default;       ///< ticks that a crash may lose, 1..1024
};

class InputRecorder {
  public:
    /// `start` is the world before its next tick. At tick 0 it must equal the result of game.start() (verifiers check
    /// this).
    static Result<InputRecorder> begin(Sink& sink, const Game& game, const World& start,
                                       const RecorderOptions& options = {});
    /// Continues with a writer in inputs mode.
    static InputRecorder resume(Writer writer, std::uint64_t keyframe_ticks);

    // Errors are permanent: after the first one, nothing more is written, and every call returns it.
    /// Records that tick `tick` ran with these inputs and gave a state of this hash. Ticks come in order without gaps.
    Status on_tick(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash);
    /// Returns true if a keyframe of the state after the last tick is due. Without it, seeking is slower.
    bool keyframe_due() const;
    /// Writes a keyframe. `world` must be at the time right after the last recorded tick (checked).
    Status keyframe(const World& world);
    /// For a plain loop: on_tick() for the tick that `world` has just run, and a keyframe if one is due.
    Status after_tick(const World& world, std::span<const PlayerInput> inputs);
    /// Writes pending ticks immediately, for example before a pause.
    Status flush() { return writer.flush(); }
    Status close() { return writer.close(); }

    std::uint64_t next_tick() const { return writer.next_tick(); }
    std::uint64_t bytes_written() const { return writer.bytes_written(); }

  private:
    InputRecorder(Writer w, std::uint64_t every) : writer(std::move(w)), keyframe_ticks(every) {}
    Writer writer;
    std::uint64_t keyframe_ticks;
};

/// Records every command of a world automatically: it attaches as the world's journal.
class CommandRecorder final : public Journal {
  public:
    /// The world must be neither moved nor destroyed before close() or the end of the recorder; otherwise the program
    /// ends with a sentence. A restore in the meantime is a permanent error, as commands alone do not lead to the
    /// restored state.
    static Result<std::unique_ptr<CommandRecorder>> begin(Sink& sink, World& world, const std::string& label,
                                                          const RecorderOptions& options = {});
    /// Continues with a writer in commands mode whose next tick is the world's.
    static std::unique_ptr<CommandRecorder> resume(Writer writer, World& world, std::uint64_t keyframe_ticks);
    ~CommandRecorder() override;
    CommandRecorder(const CommandRecorder&) = delete;
    CommandRecorder& operator=(const CommandRecorder&) = delete;

    void on_command(std::uint64_t tick, const Command& command) override;
    void on_tick(std::uint64_t tick, std::uint64_t hash) override;
    void on_restore(std::uint64_t tick) override;

    /// The first error. A tick cannot return it: read it here, or from close().
    const Status& status() const { return state; }
    /// Detaches from the world and writes the rest. Omits commands after the last tick, which have had no effect yet.
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
    std::vector<Command> pending; ///< for the next tick
    Status state;
};

} // namespace lockstone::replay
