// The checks of lockstone/prove.h.
#include "lockstone/prove.h"

#include "base/assert.h"
#include "base/text.h"
#include "lockstone/math/random.h"
#include "prove/shuffled_tasks.h"

#include <algorithm>

namespace lockstone {

void Provable::keep(std::size_t slot) {
    if (kept.size() <= slot) kept.resize(slot + 1);
    kept[slot] = save();
}

Status Provable::back(std::size_t slot) {
    LOCKSTONE_ASSERT(slot < kept.size(), "slot ", slot, " of ", kept.size());
    return load(kept[slot]);
}

std::optional<std::vector<std::byte>> Provable::save_delta(std::span<const std::byte>) const { return {}; }
Status Provable::load_delta(std::span<const std::byte>, std::span<const std::byte>) {
    return Error{"this simulation has no differences"};
}

namespace {

/// Changes the contents of freed memory: allocates blocks of many sizes, fills them and frees half of them.
class Stirred {
  public:
    explicit Stirred(std::uint64_t seed) : random(Random::seeded(seed)) {}
    void stir() {
        blocks.clear();
        for (std::size_t size = 16; size <= 1u << 16; size *= 2)
            for (std::size_t i = 0; i < 4; ++i)
                blocks.emplace_back(size + random.next_u32() % size,
                                    static_cast<std::byte>(random.next_u32() & 0xffu));
        for (std::size_t i = 0; i < blocks.size(); i += 2) blocks[i] = {};
    }

  private:
    Random random;
    std::vector<std::vector<std::byte>> blocks;
};

/// The reference of every check: the states and hashes of one run without interruption.
struct Course {
    const Provable& start;
    ProofOptions options;
    std::vector<std::uint64_t> hashes;          ///< before tick t, and at the end
    std::vector<std::vector<std::byte>> states; ///< the saved states at the same times
    std::unique_ptr<Provable> at(std::uint64_t t) const {
        std::unique_ptr<Provable> one = start.make();
        return one->load(states[t]).ok() ? std::move(one) : nullptr;
    }
};

/// Counts equal hashes, and keeps the first difference.
class Check {
  public:
    Check(const Course& course, std::string name) : run(course), result{std::move(name), true, 0, {}} {}
    bool good() const { return result.passed; }
    /// Compares `one`, whose next tick is t, with the reference.
    bool same(const Provable& one, std::uint64_t t, const std::string& how) {
        ++result.compared;
        if (one.hash() == run.hashes[t]) return true;
        const std::unique_ptr<Provable> expected = run.at(t);
        return fail(base::join("before tick ", t, how, ": ",
                               expected ? expected->difference(one) : std::string("the hashes differ")));
    }
    bool done(const Status& status, std::uint64_t t, const std::string& how = {}) {
        return status.ok() || fail(base::join("before tick ", t, how, ": ", status.error().message));
    }
    bool fail(std::string sentence) {
        if (result.passed) result.sentence = std::move(sentence);
        result.passed = false;
        return false;
    }
    void count() { ++result.compared; }
    ProofCheck finish(std::string nothing = "the check compared no states") && {
        if (result.passed && result.compared == 0) result.sentence = std::move(nothing);
        return std::move(result);
    }

  private:
    const Course& run;
    ProofCheck result;
};

/// Runs `one`, whose next tick is `from`, up to tick `end`, and compares each hash.
bool follows(Check& check, Provable& one, std::uint64_t from, std::uint64_t end, const std::string& how) {
    for (std::uint64_t t = from; t < end; ++t) {
        one.step(t);
        if (!check.same(one, t + 1, how)) return false;
    }
    return true;
}

ProofCheck repeats(const Course& run) {
    Check check(run, "repeats");
    Stirred memory(run.options.seed);
    for (int again = 0; again < 2 && check.good(); ++again) {
        memory.stir();
        const std::unique_ptr<Provable> one = run.start.make();
        if (check.same(*one, 0, ", made again")) follows(check, *one, 0, run.options.ticks, ", run again");
    }
    return std::move(check).finish();
}

ProofCheck rolls_back(const Course& run) {
    Check check(run, "rolls back");
    const std::uint64_t depth = run.options.depth, slots = depth + 1;
    const std::unique_ptr<Provable> one = run.start.make();
    for (std::uint64_t t = 0; t < run.options.ticks && check.good(); ++t) {
        one->keep(t % slots);
        if (t >= depth) {
            if (!check.done(one->back((t - depth) % slots), t - depth)) break;
            if (!check.same(*one, t - depth, ", restored")) break;
            if (!follows(check, *one, t - depth, t, base::join(", rolled back to ", t - depth))) break;
        }
        one->step(t);
        check.same(*one, t + 1, ", after rollbacks");
    }
    return std::move(check).finish();
}

ProofCheck saves_everything(const Course& run) {
    Check check(run, "saves everything");
    const std::unique_ptr<Provable> one = run.start.make();
    for (std::uint64_t t = 0; t <= run.options.ticks && check.good(); ++t) {
        if (!check.done(one->load(run.states[t]), t) || !check.same(*one, t, ", loaded")) break;
        if (one->save() != run.states[t])
            check.fail(base::join("before tick ", t, ": what was loaded is saved otherwise"));
    }
    return std::move(check).finish();
}

ProofCheck moves(const Course& run) {
    Check check(run, "moves");
    Stirred memory(run.options.seed + 1);
    std::unique_ptr<Provable> one = run.start.make();
    for (std::uint64_t t = 0; t < run.options.ticks && check.good(); ++t) {
        memory.stir();
        std::unique_ptr<Provable> next = run.start.make();
        if (!check.done(next->load(one->save()), t)) break;
        one = std::move(next);
        one->step(t);
        check.same(*one, t + 1, ", moved before the tick");
    }
    return std::move(check).finish();
}

ProofCheck forgets(const Course& run) {
    Check check(run, "forgets");
    const std::unique_ptr<Provable> one = run.start.make();
    for (std::uint64_t t = 0; t < run.options.ticks; ++t) one->step(t);
    for (std::uint64_t t = run.options.ticks; t-- > 0 && check.good();) {
        if (!check.done(one->load(run.states[t]), t)) break;
        follows(check, *one, t, std::min(t + run.options.depth, run.options.ticks),
                base::join(", back at ", t));
    }
    return std::move(check).finish();
}

ProofCheck reads_no_leftovers(const Course& run) {
    Check check(run, "reads no leftovers");
    const std::unique_ptr<Provable> one = run.start.make();
    for (std::uint64_t t = 0; t < run.options.ticks && check.good(); ++t) {
        if (!one->disturb(run.options.seed + t)) return std::move(check).finish("it shows none");
        if (!check.same(*one, t, ", disturbed")) break;
        one->step(t);
        check.same(*one, t + 1, ", disturbed before the tick");
    }
    return std::move(check).finish();
}

/// Makes state t from an earlier state and a delta. Then checks that the delta is refused for another base.
bool sends(Check& check, const Course& run, Provable& to, std::uint64_t base, std::uint64_t t) {
    const std::unique_ptr<Provable> from = run.at(t);
    const auto delta = from == nullptr ? std::nullopt : from->save_delta(run.states[base]);
    if (!delta) return false;
    if (!check.done(to.load_delta(run.states[base], *delta), t)) return false;
    if (!check.same(to, t, base::join(", out of tick ", base))) return false;
    if (to.save() != run.states[t])
        return check.fail(
            base::join("before tick ", t, ": what came out of tick ", base, " is saved otherwise"));
    const std::uint64_t other = base == 0 ? run.options.ticks : base - 1;
    if (run.states[other] == run.states[base]) return true;
    if (to.load_delta(run.states[other], *delta).ok())
        return check.fail(base::join("before tick ", t, ": the difference to tick ", base,
                                     " is taken for one to tick ", other));
    return check.same(to, t, ", after a difference was refused");
}

ProofCheck sends_differences(const Course& run) {
    Check check(run, "sends differences");
    const std::unique_ptr<Provable> to = run.start.make();
    for (std::uint64_t t = 1; t <= run.options.ticks; ++t)
        if (!sends(check, run, *to, t - std::min<std::uint64_t>(t, run.options.depth), t)) break;
    return std::move(check).finish("it has none");
}

ProofCheck shuffles(const Course& run) {
    Check check(run, "shuffles");
    std::unique_ptr<Provable> one = run.start.make();
    proofs::ShuffledTasks shuffled(run.options.seed);
    if (!one->set_tasks(&shuffled)) return std::move(check).finish("its ticks have no parts");
    follows(check, *one, 0, run.options.ticks, ", tasks in random order");
    one->set_tasks(nullptr);
    if (check.good() && run.options.workers > 0) {
        const std::unique_ptr<Tasks> pool = make_worker_pool(run.options.workers);
        one = run.start.make();
        one->set_tasks(pool.get());
        follows(check, *one, 0, run.options.ticks, base::join(", ", run.options.workers, " workers"));
        one->set_tasks(nullptr);
    }
    ProofCheck result = std::move(check).finish();
    if (result.passed) result.sentence = base::join(shuffled.parts, " parts of ticks in random order");
    return result;
}

/// The way in which a simulation runs its ticks. No hash depends on it.
struct Mode {
    std::optional<Simd> simd; ///< empty: the simulation offers no choice
    Tasks* tasks;             ///< null: ticks are not split
    std::string name;         ///< ", avx2, 3 workers"

    std::unique_ptr<Provable> make(const Provable& start) const {
        std::unique_ptr<Provable> one = start.make();
        if (simd) one->set_simd(*simd);
        one->set_tasks(tasks);
        return one;
    }
};

/// Runs in a mode to the end. Before one random tick, and before each other tick with a chance of one in eight, a new
/// object of the mode loads the state.
void runs_in_mode(Check& check, const Course& run, const Mode& mode, Random& random) {
    const std::uint64_t once = random.next_u64() % run.options.ticks;
    std::unique_ptr<Provable> one = mode.make(run.start);
    for (std::uint64_t t = 0; t < run.options.ticks && check.good(); ++t) {
        if (random.below(8) == 0 || t == once) {
            std::unique_ptr<Provable> next = mode.make(run.start);
            if (!check.done(next->load(one->save()), t, mode.name)) break;
            one = std::move(next);
            if (!check.same(*one, t, mode.name + ", loaded")) break;
        }
        one->step(t);
        check.same(*one, t + 1, mode.name);
    }
    one->set_tasks(nullptr);
}

/// The instruction sets that a simulation supports on this machine; a single empty entry if it offers no choice.
std::vector<std::optional<Simd>> instruction_sets(Provable& one) {
    std::vector<std::optional<Simd>> sets;
    for (const Simd level : every_simd)
        if (has_simd(level) && one.set_simd(level)) sets.emplace_back(level);
    if (sets.empty()) sets.emplace_back();
    return sets;
}

ProofCheck every_mode_agrees(const Course& run) {
    constexpr std::uint32_t pool_max = 4;
    Check check(run, "every mode agrees");
    const std::unique_ptr<Provable> probe = run.start.make();
    const std::vector<std::optional<Simd>> sets = instruction_sets(*probe);
    proofs::ShuffledTasks shuffled(run.options.seed + 1);
    const bool has_parts = probe->set_tasks(&shuffled);
    probe->set_tasks(nullptr);
    if (!sets.front() && !has_parts) return std::move(check).finish("it has one mode");
    Random random = Random::seeded(run.options.seed, 1);
    std::uint32_t modes = 0;
    const auto run_sets = [&](Tasks* tasks, const std::string& how) {
        for (const std::optional<Simd>& set : sets) {
            if (!check.good()) return;
            runs_in_mode(check, run, {set, tasks, (set ? base::join(", ", name_of(*set)) : "") + how},
                         random);
            ++modes;
        }
    };
    run_sets(has_parts ? &shuffled : nullptr, has_parts ? ", tasks in random order" : "");
    for (std::uint32_t workers = 1; has_parts && run.options.workers > 0 && workers <= pool_max; ++workers) {
        const std::unique_ptr<Tasks> pool = make_worker_pool(workers);
        run_sets(pool.get(), base::join(", ", workers, workers == 1 ? " worker" : " workers"));
    }
    ProofCheck result = std::move(check).finish();
    if (result.passed) result.sentence = base::join(modes, " modes");
    return result;
}

ProofCheck every_bit_counts(const Course& run) {
    Check check(run, "every bit counts");
    const std::unique_ptr<Provable> one = run.at(run.options.ticks);
    if (one == nullptr) {
        check.fail("its last state cannot be loaded");
        return std::move(check).finish();
    }
    const std::uint64_t bits = one->bit_count(), hash = one->hash();
    // Every stride-th bit; an odd stride visits all bits of a byte in turn.
    const std::uint64_t stride =
        run.options.bits_max == 0 ? 0 : std::max<std::uint64_t>(bits / run.options.bits_max, 1) | 1u;
    if (bits == 0 || stride == 0) return std::move(check).finish("its bits are not shown");
    for (std::uint64_t bit = 0; bit < bits && check.good(); bit += stride) {
        one->flip(bit);
        if (one->hash() == hash) check.fail(base::join("bit ", bit, " of ", bits, " changes no hash"));
        one->flip(bit);
        check.count();
    }
    if (check.good() && one->hash() != hash) check.fail("bits that were flipped back leave another hash");
    return std::move(check).finish();
}

Course course_of(const Provable& simulation, const ProofOptions& options) {
    Course run{simulation, options, {}, {}};
    run.options.ticks = std::max<std::uint64_t>(options.ticks, 1);
    run.options.depth = std::max<std::uint32_t>(options.depth, 1);
    run.options.workers = std::min(options.workers, workers_max);
    const std::unique_ptr<Provable> one = simulation.make();
    for (std::uint64_t t = 0;; ++t) {
        run.hashes.push_back(one->hash());
        run.states.push_back(one->save());
        if (t == run.options.ticks) return run;
        one->step(t);
    }
}

} // namespace

bool Proof::holds() const { return !checks.empty() && std::ranges::all_of(checks, &ProofCheck::passed); }

std::string to_string(const Proof& proof) {
    std::string out;
    for (const ProofCheck& check : proof.checks) {
        out += base::join(check.passed ? "ok      " : "FAILED  ", check.name, ": ");
        if (check.passed && check.compared > 0)
            out += base::join(check.compared, " compared", check.sentence.empty() ? "" : ", ");
        out += check.sentence + '\n';
    }
    return out;
}

Proof prove(const Provable& simulation, const ProofOptions& options) {
    const Course run = course_of(simulation, options);
    return {{repeats(run), rolls_back(run), saves_everything(run), moves(run), forgets(run),
             reads_no_leftovers(run), sends_differences(run), shuffles(run), every_mode_agrees(run),
             every_bit_counts(run)}};
}

} // namespace lockstone
