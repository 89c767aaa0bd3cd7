#include "modes.h"

#include "support/task_runners.h"

#include <cstdio>
#include <stdexcept>

namespace worlds {

std::string to_string(const Mode& m) {
    std::string out = std::string(name_of(m.simd)) + ", ";
    out += m.runner == Runner::caller     ? "no tasks"
           : m.runner == Runner::shuffled ? std::to_string(m.workers) + " workers in random order"
                                          : "a pool of " + std::to_string(m.workers);
    const auto add = [&](bool is_on, const char* text) {
        if (is_on) out += std::string(", ") + text;
    };
    add((m.restores & rolls_back) != 0, "rolled back");
    add((m.restores & into_fresh) != 0, "restored into a new world");
    add((m.restores & from_bytes) != 0, "restored from bytes");
    add((m.restores & from_delta) != 0, "restored from a delta");
    add((m.restores & from_clone) != 0, "cloned");
    add((m.disturbs & scratch) != 0, "scratch poisoned");
    add((m.disturbs & trees) != 0, "other trees");
    add((m.disturbs & pairs) != 0, "pairs forgotten");
    add(m.observes, "observed"), add(m.hashes_phases, "phases hashed"), add(m.reserves, "reserved");
    add(m.queries, "queried"), add(m.other_order, "assembled in another order");
    add(m.moves_state, "moving state");
    return out + ", seed " + std::to_string(m.seed);
}

Mode reference_mode() {
    Mode m;
    m.disturbs = scratch;
    return m;
}

Mode draw_mode(Random& random) {
    Mode m;
    m.seed = random.next_u64();
    std::vector<Simd> sets;
    for (const Simd simd : every_simd)
        if (has_simd(simd)) sets.push_back(simd);
    m.simd = random.below(3) == 0 ? best_simd() : sets[random.below(static_cast<std::uint32_t>(sets.size()))];
    const std::uint32_t who = random.below(8);
    if (who >= 2) {
        // A pool of more threads than the machine has is slow, so most runs with many workers use one thread.
        constexpr std::uint32_t many[] = {2, 2, 3, 4, 8, 16, 64};
        m.runner = who == 2 ? Runner::pool : Runner::shuffled;
        m.workers = who == 2 ? 2 + random.below(2) : many[random.below(7)];
    }
    if (random.below(2) == 0) m.restores = 1u << random.below(5);
    if (random.below(8) == 0) m.restores = all_restores;
    if (random.below(3) == 0) m.disturbs = 1 + random.below(all_disturbs);
    m.observes = random.below(4) == 0;
    m.hashes_phases = random.below(8) == 0;
    m.reserves = random.below(4) == 0;
    m.queries = random.below(4) == 0;
    m.other_order = random.below(2) == 0;
    m.moves_state = random.below(4) == 0;
    return m;
}

std::vector<Mode> simpler(const Mode& mode) {
    std::vector<Mode> out;
    const auto add = [&](auto change) {
        Mode m = mode;
        change(m);
        if (to_string(m) != to_string(mode)) out.push_back(m);
    };
    add([](Mode& m) { m.runner = Runner::caller, m.workers = 1; });
    add([](Mode& m) { m.simd = Simd::scalar; });
    add([](Mode& m) {
        if (m.runner == Runner::pool) m.runner = Runner::shuffled;
    });
    add([](Mode& m) {
        if (m.workers > 2) m.workers = 2;
    });
    add([](Mode& m) { m.restores = 0; });
    for (std::uint32_t bit = 1; bit < all_restores; bit *= 2) add([&](Mode& m) { m.restores &= ~bit; });
    add([](Mode& m) { m.disturbs = 0; });
    for (std::uint32_t bit = 1; bit < all_disturbs; bit *= 2) add([&](Mode& m) { m.disturbs &= ~bit; });
    add([](Mode& m) { m.observes = false; }), add([](Mode& m) { m.hashes_phases = false; });
    add([](Mode& m) { m.reserves = false; }), add([](Mode& m) { m.queries = false; });
    add([](Mode& m) { m.other_order = false; }), add([](Mode& m) { m.moves_state = false; });
    return out;
}

/// An observer and a journal that count their calls.
struct Player::Watcher final : PhaseObserver, Journal {
    void on_phase(const char*) override { ++seen; }
    void on_command(std::uint64_t, const Command&) override { ++seen; }
    void on_tick(std::uint64_t, std::uint64_t) override { ++seen; }
    void on_restore(std::uint64_t) override { ++seen; }
    std::uint64_t seen = 0;
};

Player::Player(const Story& of, const Mode& in)
    : story(of), mode(in), random(Random::seeded(in.seed)), watcher(std::make_unique<Watcher>()), teller(of) {
    if (mode.runner == Runner::pool) tasks = make_worker_pool(mode.workers);
    if (mode.runner == Runner::shuffled)
        tasks = std::make_unique<test::ShuffledTasks>(static_cast<std::uint32_t>(mode.seed), mode.workers);
    own = std::make_unique<World>(teller.start(mode.other_order ? mode.seed | 1 : 0));
    attach();
}

Player::~Player() = default;

void Player::attach() {
    if (!own->set_simd(mode.simd)) throw std::runtime_error("this machine lacks the instruction set");
    own->set_tasks(tasks.get());
    if (mode.moves_state) testing::state_of(*own).move_at_every_chance(true);
    if (mode.observes) own->observe_phases(watcher.get()), own->set_journal(watcher.get());
    if (mode.hashes_phases) own->record_phase_hashes(true);
}

void Player::replace(World other) {
    own = std::make_unique<World>(std::move(other));
    attach();
}

void Player::restore(std::uint64_t t) {
    const auto done = [](const Status& status) {
        if (!status) throw std::runtime_error("restore: " + status.error().message);
    };
    if ((mode.restores & rolls_back) != 0 && random.below(3) == 0) {
        if (is_kept && t - kept_tick <= 6) {
            own->restore(kept);
            for (std::uint64_t again = kept_tick; again < t; ++again) tick(again);
            is_kept = false;
        } else {
            own->save(kept);
            kept_tick = t, is_kept = true;
        }
    }
    if ((mode.restores & into_fresh) != 0 && random.below(4) == 0) {
        Image image;
        own->save(image);
        World other = story_world(story.def);
        other.restore(image);
        replace(std::move(other));
        is_kept = false;
    }
    if ((mode.restores & from_bytes) != 0 && random.below(4) == 0) {
        const std::vector<std::byte> bytes = own->save_portable();
        World other = story_world(story.def);
        done(other.restore_portable(bytes));
        replace(std::move(other));
        is_kept = false;
    }
    if ((mode.restores & from_delta) != 0 && random.below(4) == 0) {
        if (is_kept) {
            const std::vector<std::byte> delta = own->save_delta(kept);
            World other = story_world(story.def);
            done(other.restore_delta(kept, delta));
            replace(std::move(other));
            is_kept = false;
        } else {
            own->save(kept);
            kept_tick = t, is_kept = true;
        }
    }
    if ((mode.restores & from_clone) != 0 && random.below(4) == 0) replace(own->clone()), is_kept = false;
}

void Player::disturb() {
    if ((mode.disturbs & scratch) != 0) testing::disturb(*own, testing::Leftover::scratch, random.next_u64());
    if ((mode.disturbs & trees) != 0 && random.below(2) == 0)
        testing::disturb(*own, testing::Leftover::trees, random.next_u64());
    if ((mode.disturbs & pairs) != 0 && random.below(2) == 0)
        testing::disturb(*own, testing::Leftover::pairs, random.next_u64());
}

void Player::look() {
    if (own->body_count() == 0) return;
    const Vec3 from = own->pose(own->body_at(random.below(own->body_count()))).position;
    const UnitVec3 along = random.unit_vector();
    const Vec3 way = scale<Real>(along, Real(20));
    (void)own->cast_ray({from, way});
    (void)own->cast_shape(sphere(0.3_r), {from, Quat::identity()}, way);
    std::vector<ShapeId> found;
    own->overlap(box(Real(1), Real(1), Real(1)), {from, Quat::identity()}, {}, found);
    (void)own->contacts();
    (void)own->kinetic_energy();
}

void Player::tick(std::uint64_t t) {
    teller.apply(*own, t);
    own->tick();
    taken |= testing::paths_taken(*own);
    if (mode.planted != t + 1 || own->body_count() == 0) return;
    State& state = testing::state_of(*own);
    std::uint32_t column = 0;
    while (state.layout().columns()[column].name != "body.velocity") ++column;
    state.edit_bytes(column, own->body_count() - 1, 1)[0] ^= std::byte{1};
}

void Player::play(std::uint64_t t) {
    if (mode.restores != 0 && t > 0) restore(t);
    if (mode.reserves && random.below(8) == 0) {
        const std::uint32_t some = random.below(2000);
        (void)own->reserve({.bodies = some, .shapes = some, .contacts = 4 * some, .joints = some});
    }
    if (mode.queries) look();
    if (mode.disturbs != 0) disturb();
    tick(t);
}

} // namespace worlds
