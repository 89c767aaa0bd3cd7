// Adapts a game and its world to prove().
#include "lockstone/prove.h"
#include "lockstone/testing.h"

#include "base/text.h"
#include "lockstone/math/random.h"

#include <algorithm>
#include <utility>

namespace lockstone {

namespace {

void random_input(std::uint64_t seed, std::uint64_t tick, std::uint32_t player, std::span<std::byte> input) {
    Random random = Random::seeded(seed, tick << 8 | player);
    for (std::byte& byte : input) byte = static_cast<std::byte>(random.next_u32() & 0xffu);
}

class ProvableWorld final : public Provable {
  public:
    /// `first` is the world before tick 0. The game, the input and `first` must outlive this object.
    ProvableWorld(const Game& rules, const ProofInput& player_input, const World& first)
        : game(rules), input(player_input), start(first), world(first.clone()),
          bytes(rules.player_count(), std::vector<std::byte>(rules.input_size())),
          inputs(rules.player_count()) {}

    std::unique_ptr<Provable> make() const override {
        return std::make_unique<ProvableWorld>(game, input, start);
    }
    void step(std::uint64_t tick) override {
        for (std::uint32_t p = 0; p < inputs.size(); ++p) {
            std::fill(bytes[p].begin(), bytes[p].end(), std::byte{0});
            input(tick, p, bytes[p]);
            inputs[p] = {bytes[p]};
        }
        status = game.advance(world, inputs);
    }
    /// The status of the last step.
    const Status& last_step() const { return status; }
    std::vector<std::byte> save() const override { return world.save_portable(); }
    Status load(std::span<const std::byte> from) override {
        if (Status s = world.restore_portable(from); !s) return s;
        return game.check(world);
    }
    std::uint64_t hash() const override { return world.hash(); }

    void keep(std::size_t slot) override {
        if (images.size() <= slot) images.resize(slot + 1);
        world.save(images[slot]);
    }
    Status back(std::size_t slot) override {
        world.restore(images.at(slot));
        return {};
    }
    bool disturb(std::uint64_t seed) override {
        for (const testing::Leftover what :
             {testing::Leftover::scratch, testing::Leftover::trees, testing::Leftover::pairs})
            testing::disturb(world, what, seed);
        return true;
    }
    std::optional<std::vector<std::byte>> save_delta(std::span<const std::byte> base) const override {
        State before(world.state().layout_shared());
        if (!before.restore_portable(base)) return {};
        return world.state().save_delta(before);
    }
    Status load_delta(std::span<const std::byte> base, std::span<const std::byte> delta) override {
        State before(world.state().layout_shared());
        if (Status s = before.restore_portable(base); !s) return s;
        Image image;
        before.save(image);
        return world.restore_delta(image, delta);
    }
    bool set_tasks(Tasks* tasks) override {
        world.set_tasks(tasks);
        return true;
    }
    bool set_simd(Simd level) override { return world.set_simd(level); }
    std::uint64_t bit_count() const override {
        std::uint64_t sum = 0;
        for (std::uint32_t c = 0; c < columns(); ++c) sum += world.state().bytes(c).size() * 8;
        return sum;
    }
    void flip(std::uint64_t bit) override {
        for (std::uint32_t c = 0; c < columns(); ++c) {
            const std::uint64_t here = world.state().bytes(c).size() * 8;
            if (bit < here) {
                const std::uint32_t row_size = world.state().layout().columns()[c].row_size;
                const std::uint64_t byte = bit / 8;
                testing::state_of(world).edit_bytes(c, static_cast<std::uint32_t>(byte / row_size),
                                                    1)[byte % row_size] ^= std::byte{1} << (bit % 8);
                return;
            }
            bit -= here;
        }
    }
    std::string difference(const Provable& other) const override {
        const std::vector<Difference> found =
            State::diff(world.state(), static_cast<const ProvableWorld&>(other).world.state(), 1);
        return found.empty() ? "the hashes differ, but no row does" : to_string(found.front());
    }

  private:
    std::uint32_t columns() const {
        return static_cast<std::uint32_t>(world.state().layout().columns().size());
    }

    const Game& game;
    const ProofInput& input;
    const World& start;
    World world;
    std::vector<Image> images;
    std::vector<std::vector<std::byte>> bytes; ///< by player
    std::vector<PlayerInput> inputs;
    Status status;
};

/// A sentence about the first difference of two worlds that a game started; empty if they are equal.
std::string difference_of_starts(const World& first, const World& second) {
    if (first.hash() == second.hash()) return {};
    if (first.state().layout().schema_hash() != second.state().layout().schema_hash())
        return "the game starts worlds with different columns";
    const std::vector<Difference> found = State::diff(first.state(), second.state(), 1);
    return "the game starts different worlds" + (found.empty() ? "" : ": " + to_string(found.front()));
}

} // namespace

Result<Proof> prove(const Game& game, const ProofOptions& options, ProofInput input) {
    const Result<World> start = game.start(), again = game.start();
    for (const Result<World>* each : {&start, &again})
        if (!*each) return each->error();
    if (!input)
        input = [seed = options.seed](std::uint64_t tick, std::uint32_t player, std::span<std::byte> bytes) {
            random_input(seed, tick, player, bytes);
        };
    const ProvableWorld provable(game, input, *start);
    ProvableWorld plain(game, input, *start);
    for (std::uint64_t tick = 0; tick < options.ticks; ++tick) {
        plain.step(tick);
        if (!plain.last_step())
            return Error{
                base::join("tick ", tick, ": the game's rules fail: ", plain.last_step().error().message)};
    }
    Proof proof = prove(provable, options);
    if (std::string other = difference_of_starts(*start, *again); !other.empty()) {
        ProofCheck& repeats = proof.checks.front();
        repeats.passed = false, repeats.sentence = std::move(other);
    }
    return proof;
}

} // namespace lockstone
