// A simulation that breaks one rule of determinism: its result depends on its execution mode. For tests of proofs.
#pragma once

#include "lockstone/prove.h"

#include <cstring>
#include <set>
#include <utility>

namespace lockstone::test {

enum class ReadsMode {
    nothing,
    instruction_set, ///< a tick reads whether the machine's fastest instruction set is in use
    workers,         ///< a tick reads whether there are 4 workers
    load,            ///< load() reads whether that set is in use with 2 workers
};

/// A simulation of one number. If `seen` is set, each mode of a tick is stored in it; `seen` must outlive all objects.
class ModeReader final : public Provable {
  public:
    using Seen = std::set<std::pair<Simd, std::uint32_t>>; ///< instruction set, workers
    explicit ModeReader(ReadsMode what, Seen* modes = nullptr) : reads(what), seen(modes) {}
    std::unique_ptr<Provable> make() const override { return std::make_unique<ModeReader>(reads, seen); }
    void step(std::uint64_t tick) override {
        count = 3 * count + tick;
        if (reads == ReadsMode::instruction_set && simd == best_simd()) ++count;
        if (reads == ReadsMode::workers && workers() == 4) ++count;
        if (seen != nullptr && simd) seen->emplace(*simd, workers());
    }
    std::vector<std::byte> save() const override {
        const auto bytes = std::as_bytes(std::span(&count, 1));
        return {bytes.begin(), bytes.end()};
    }
    Status load(std::span<const std::byte> bytes) override {
        if (bytes.size() != sizeof count) return Error{"other bytes"};
        std::memcpy(&count, bytes.data(), sizeof count);
        if (reads == ReadsMode::load && simd == best_simd() && workers() == 2) ++count;
        return {};
    }
    std::uint64_t hash() const override { return count; }
    bool set_tasks(Tasks* with) override {
        tasks = with;
        return true;
    }
    bool set_simd(Simd level) override {
        simd = level;
        return true;
    }
    std::string difference(const Provable& other) const override {
        return "count: " + std::to_string(count) + " against " +
               std::to_string(static_cast<const ModeReader&>(other).count);
    }

  private:
    std::uint32_t workers() const { return tasks == nullptr ? 0 : tasks->worker_count(); }
    ReadsMode reads;
    Seen* seen;
    std::uint64_t count = 1;
    std::optional<Simd> simd;
    Tasks* tasks = nullptr;
};

} // namespace lockstone::test
