// The self test: runs small worlds from seeds, and compares their hashes after every tick with stored hashes.
#include "base/text.h"
#include "lockstone/prove.h"
#include "lockstone/testing.h"
#include "prove/random_world.h"
#include "prove/shuffled_tasks.h"
#include "prove/stored_hashes.h"

namespace lockstone {

namespace {

using proofs::RandomWorld;
using testing::self_test_ticks;
using testing::self_test_worlds;

struct SelfTestMode {
    Simd simd;
    Tasks* tasks; ///< null: no tasks
    std::string name() const {
        return base::join(name_of(simd), tasks != nullptr ? " with tasks in random order" : "");
    }
};

std::vector<SelfTestMode> modes_of_machine(Tasks& shuffled) {
    std::vector<SelfTestMode> modes;
    for (const Simd level : every_simd)
        if (has_simd(level)) modes.push_back({level, nullptr});
    modes.push_back({best_simd(), &shuffled});
    return modes;
}

/// All 16 digits, as in tables of hashes.
std::string digits(std::uint64_t hash) {
    const std::string text = base::hex(hash).substr(2);
    return std::string(16 - text.size(), '0') + text;
}

Status run_against(RandomWorld& one, const SelfTestMode& mode, std::span<const std::uint64_t> stored) {
    one.rewind();
    if (!one.world.set_simd(mode.simd)) return Error{"this build has no kernels of the instruction set"};
    one.world.set_tasks(mode.tasks);
    for (std::size_t tick = 0; tick < stored.size(); ++tick) {
        if (Status done = one.step(); !done)
            return Error{base::join("in tick ", tick, ": ", done.error().message)};
        const std::uint64_t hash = one.world.hash();
        if (hash != stored[tick])
            return Error{base::join("after tick ", tick, ": hash ", digits(hash), " against the stored ",
                                    digits(stored[tick]))};
    }
    return {};
}

Result<RandomWorld> world_of(std::uint32_t number) {
    Result<RandomWorld> made = RandomWorld::make(number);
    if (!made) return Error{base::join("world ", number, ": ", made.error().message)};
    return made;
}

} // namespace

Result<std::vector<std::uint64_t>> testing::self_test_hashes() {
    std::vector<std::uint64_t> hashes;
    for (std::uint32_t number = 0; number < self_test_worlds; ++number) {
        Result<RandomWorld> one = world_of(number);
        if (!one) return one.error();
        for (std::uint32_t tick = 0; tick < self_test_ticks; ++tick) {
            if (Status done = one->step(); !done)
                return Error{base::join("world ", number, ", in tick ", tick, ": ", done.error().message)};
            hashes.push_back(one->world.hash());
        }
    }
    return hashes;
}

Status testing::self_test_against(std::span<const std::uint64_t> stored) {
    constexpr std::size_t count = std::size_t{self_test_worlds} * self_test_ticks;
    if (stored.size() != count)
        return Error{base::join("there are ", stored.size(), " stored hashes for ", count,
                                " ticks; tools/refresh writes them")};
    proofs::ShuffledTasks shuffled(1);
    const std::vector<SelfTestMode> modes = modes_of_machine(shuffled);
    for (std::uint32_t number = 0; number < self_test_worlds; ++number) {
        Result<RandomWorld> one = world_of(number);
        if (!one) return one.error();
        for (const SelfTestMode& mode : modes) {
            if (mode.tasks != nullptr && number % 2 != 0) continue;
            if (Status same =
                    run_against(*one, mode, stored.subspan(number * self_test_ticks, self_test_ticks));
                !same)
                return Error{base::join("world ", number, ", ", mode.name(), ", ", same.error().message)};
        }
    }
    return {};
}

Status self_test() { return testing::self_test_against(proofs::stored_hashes); }

} // namespace lockstone
