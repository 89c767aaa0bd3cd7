// lockstone::prove on a small simulation that breaks one rule at a time: the check of that rule must detect it.
#include "lockstone/prove.h"
#include "support/mode_reader.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

using namespace lockstone;

namespace {

enum class Fault {
    none,
    static_counter,    ///< a tick reads data that an earlier run left in the process
    address,           ///< a tick adds an address
    column_left_out,   ///< save() leaves out a value
    hash_left_out,     ///< hash() leaves out a value
    scratch_read,      ///< a tick reads data that the last tick left outside of the state
    stale_cache,       ///< a cache is made once, and load() does not drop it
    knows_the_future,  ///< a tick reads the latest tick that the object ever reached
    leftover_read,     ///< a tick reads memory that it should have written first
    delta_left_out,    ///< a difference leaves out a value
    delta_unnamed,     ///< a difference does not name its base
    keep_is_shallow,   ///< keep() stores only the last state
    order_of_tasks,    ///< a sum that depends on the order of the parts
    worker_number,     ///< a part writes the number of its worker
    load_refuses_late, ///< load() refuses states after tick 5
};

std::uint64_t runs_made = 0;

/// Eight numbers that each tick mixes.
class Toy final : public Provable {
  public:
    explicit Toy(Fault what) : fault(what) {}
    std::unique_ptr<Provable> make() const override {
        ++runs_made;
        return std::make_unique<Toy>(fault);
    }
    void step(std::uint64_t tick) override {
        if (fault == Fault::static_counter) state[0] += runs_made;
        if (fault == Fault::address) state[1] += reinterpret_cast<std::uintptr_t>(this);
        if (fault == Fault::scratch_read) state[2] += scratch;
        farthest = std::max(farthest, tick);
        if (fault == Fault::knows_the_future && farthest > tick + 6) ++state[0];
        if (cache == 0) cache = state[3] + 1;
        if (fault == Fault::stale_cache) state[3] += cache;
        scratch = state[4] ^ tick;
        if (fault != Fault::leftover_read) leftover = state[1];
        state[5] += leftover & 1u;
        leftover = 0;
        run_parts();
        for (std::size_t i = 0; i < 8; ++i)
            state[i] = state[i] * 6364136223846793005u + state[(i + 1) % 8] + tick;
    }
    std::vector<std::byte> save() const override {
        std::array<std::uint64_t, 8> out = state;
        if (fault == Fault::column_left_out) out[5] = 0;
        const auto bytes = std::as_bytes(std::span(out));
        return {bytes.begin(), bytes.end()};
    }
    Status load(std::span<const std::byte> bytes) override {
        std::array<std::uint64_t, 8> from;
        std::memcpy(from.data(), bytes.data(), sizeof from);
        if (fault == Fault::load_refuses_late && from[0] > (std::uint64_t{1} << 63))
            return Error{"it is late"};
        state = from;
        if (fault != Fault::stale_cache) cache = 0;
        return {};
    }
    std::uint64_t hash() const override {
        std::array<std::uint64_t, 8> in = state;
        if (fault == Fault::hash_left_out) in[6] = 0;
        return hash_bytes(std::as_bytes(std::span(in)));
    }
    void keep(std::size_t slot) override { Provable::keep(fault == Fault::keep_is_shallow ? 0 : slot); }
    Status back(std::size_t slot) override {
        return Provable::back(fault == Fault::keep_is_shallow ? 0 : slot);
    }
    bool disturb(std::uint64_t seed) override {
        leftover = seed;
        return true;
    }
    std::optional<std::vector<std::byte>> save_delta(std::span<const std::byte> base) const override {
        const std::uint64_t name = hash_bytes(base);
        const std::vector<std::byte> now = save();
        std::vector<std::byte> delta(sizeof name);
        std::memcpy(delta.data(), &name, sizeof name);
        for (std::size_t i = 0; i < now.size(); ++i) delta.push_back(now[i] ^ base[i]);
        if (fault == Fault::delta_left_out) std::fill_n(delta.begin() + 32, 8, std::byte{});
        return delta;
    }
    Status load_delta(std::span<const std::byte> base, std::span<const std::byte> delta) override {
        std::uint64_t name;
        std::memcpy(&name, delta.data(), sizeof name);
        if (name != hash_bytes(base) && fault != Fault::delta_unnamed) return Error{"another base"};
        std::vector<std::byte> now(base.begin(), base.end());
        for (std::size_t i = 0; i < now.size(); ++i) now[i] ^= delta[sizeof name + i];
        return load(now);
    }
    bool set_tasks(Tasks* with) override {
        tasks = with;
        return true;
    }
    std::uint64_t bit_count() const override { return sizeof state * 8; }
    void flip(std::uint64_t bit) override { state[bit / 64] ^= std::uint64_t{1} << (bit % 64); }

  private:
    void run_parts() {
        const Tasks::Item item = [](void* context, std::uint32_t index, std::uint32_t worker) {
            Toy& toy = *static_cast<Toy*>(context);
            if (toy.fault == Fault::order_of_tasks) toy.state[7] = toy.state[7] * 31 + index;
            if (toy.fault == Fault::worker_number) toy.state[index] += worker;
        };
        if (tasks != nullptr && fault == Fault::worker_number) return tasks->run(8, item, this);
        // A shared sum in a pool would be a data race, which is a different fault. Random order reveals it as well.
        if (tasks != nullptr && tasks->worker_count() == 5) return tasks->run(8, item, this);
        for (std::uint32_t i = 0; i < 8; ++i) item(this, i, 0);
    }

    Fault fault;
    std::array<std::uint64_t, 8> state{1, 2, 3, 4, 5, 6, 7, 8};
    std::uint64_t scratch = 0, cache = 0, farthest = 0, leftover = 0;
    Tasks* tasks = nullptr;
};

Proof proof_of(Fault fault) {
    ProofOptions options;
    options.ticks = 12;
    return prove(Toy(fault), options);
}

const ProofCheck& check_named(const Proof& proof, const std::string& name) {
    for (const ProofCheck& check : proof.checks)
        if (check.name == name) return check;
    FAIL("no check ", name);
    return proof.checks.front();
}

} // namespace

TEST_CASE("a simulation without a fault passes all ten checks of a proof") {
    const Proof proof = proof_of(Fault::none);
    INFO(to_string(proof));
    CHECK(proof.holds());
    CHECK(proof.checks.size() == 10);
    for (const ProofCheck& check : proof.checks) CHECK(check.compared >= 12);
    CHECK(to_string(proof).starts_with("ok      repeats: "));
}

TEST_CASE("planted fault: the proof reports each broken rule of a simulation in the check of this rule") {
    const std::pair<Fault, const char*> meant[] = {
        {Fault::static_counter, "repeats"},
        {Fault::address, "repeats"},
        {Fault::column_left_out, "rolls back"},
        {Fault::hash_left_out, "every bit counts"},
        {Fault::scratch_read, "moves"},
        {Fault::stale_cache, "moves"},
        {Fault::knows_the_future, "forgets"},
        {Fault::leftover_read, "reads no leftovers"},
        {Fault::delta_left_out, "sends differences"},
        {Fault::delta_unnamed, "sends differences"},
        {Fault::keep_is_shallow, "rolls back"},
        {Fault::order_of_tasks, "shuffles"},
        {Fault::worker_number, "shuffles"},
        {Fault::load_refuses_late, "saves everything"},
    };
    for (const auto& entry : meant) {
        const Fault fault = entry.first;
        const char* const name = entry.second;
        const Proof proof = proof_of(fault);
        INFO(static_cast<int>(fault), "\n", to_string(proof));
        CHECK_FALSE(proof.holds());
        const ProofCheck& check = check_named(proof, name);
        CHECK_FALSE(check.passed);
        CHECK(check.sentence != "");
        CHECK(to_string(proof).find(std::string("FAILED  ") + name) != std::string::npos);
    }
}

TEST_CASE("a proof runs every instruction set of the machine on one to four workers each and with tasks in "
          "random order") {
    test::ModeReader::Seen seen;
    const Proof proof = prove(test::ModeReader(test::ReadsMode::nothing, &seen), {.ticks = 5});
    CHECK(proof.holds());
    std::uint32_t modes = 0;
    for (const Simd level : every_simd)
        for (std::uint32_t workers = 1; has_simd(level) && workers <= 5;
             ++workers, ++modes) // 5: in random order
            CHECK(seen.contains({level, workers}));
    CHECK(seen.size() == modes);
    CHECK(check_named(proof, "every mode agrees").sentence == std::to_string(modes) + " modes");
}

TEST_CASE("planted fault: the proof names the mode of a simulation whose result depends on the mode") {
    const std::string best(name_of(best_simd()));
    const std::pair<test::ReadsMode, std::string> sentences[] = {
        {test::ReadsMode::instruction_set,
         "before tick 1, " + best + ", tasks in random order: count: 3 against 4"},
        {test::ReadsMode::workers, "before tick 1, scalar, 4 workers: count: 3 against 4"},
        {test::ReadsMode::load, ", " + best + ", 2 workers, loaded: count: "},
    };
    for (const auto& entry : sentences) {
        const test::ReadsMode reads = entry.first;
        const std::string sentence = entry.second;
        const Proof proof = prove(test::ModeReader(reads), {.ticks = 5});
        INFO(to_string(proof));
        CHECK_FALSE(proof.holds());
        for (const ProofCheck& check : proof.checks)
            CHECK(check.passed == (check.name != "every mode agrees"));
        CHECK(check_named(proof, "every mode agrees").sentence.find(sentence) != std::string::npos);
    }
}

TEST_CASE("a proof without pools runs tasks only in random order and a simulation with one mode has no "
          "comparison") {
    test::ModeReader::Seen seen;
    CHECK(prove(test::ModeReader(test::ReadsMode::workers, &seen), {.ticks = 5, .workers = 0}).holds());
    for (const auto& mode : seen) CHECK(mode.second == 5);
    struct OneMode final : Provable {
        std::unique_ptr<Provable> make() const override { return std::make_unique<OneMode>(); }
        void step(std::uint64_t tick) override { last = tick + 1; }
        std::vector<std::byte> save() const override { return {static_cast<std::byte>(last)}; }
        Status load(std::span<const std::byte> bytes) override {
            last = static_cast<std::uint64_t>(bytes[0]);
            return {};
        }
        std::uint64_t hash() const override { return last; }
        std::uint64_t last = 0;
    };
    const Proof proof = prove(OneMode(), {.ticks = 5});
    CHECK(proof.holds());
    CHECK(check_named(proof, "every mode agrees").compared == 0);
    CHECK(check_named(proof, "every mode agrees").sentence == "it has one mode");
}

TEST_CASE("a proof without a check does not hold") { CHECK_FALSE(Proof{}.holds()); }
