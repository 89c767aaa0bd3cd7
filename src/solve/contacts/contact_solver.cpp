#include "solve/contacts/contact_solver.h"

#include "base/parallel.h"
#include "base/poison.h"
#include "base/prefetch.h"
#include "base/room.h"
#include "base/strands.h"
#include "lockstone/math/wide.h"
#include "solve/bodies/integrate.h"
#include "solve/contacts/bounce.h"
#include "solve/contacts/contact_order.h"
#include "solve/contacts/contact_packs.h"
#include "solve/joints/followed_turn.h"
#include "solve/kernels/kernels.h"

#include <algorithm>

namespace lockstone::solve {

using solve::Contact;
using solve::ContactMemory;
using solve::SolverBodies;
using solve::SolverBody;
using solve::StepConstants;

namespace {

/// Packs per piece of work that a worker takes while packs are prepared.
constexpr std::uint32_t pack_chunk = 16;
/// Packs of more bytes than this do not stay in a processor's cache from pass to pass, so each pass prefetches the next
/// packs. For smaller worlds the prefetch costs more than it saves.
constexpr std::size_t cache_bytes = std::size_t{4} << 20;

} // namespace

struct ContactSolver::Inside {
    Simd simd = Simd::scalar;
    const ContactKernel* kernel = nullptr;
    const solve::BodyKernel* body_kernel = nullptr;
    std::uint32_t pack_count = 0;
    bool asks_ahead = false;            ///< the packs do not fit into the cache, so passes prefetch
    bool started = false;               ///< the warm start from the last tick is done
    std::vector<std::uint32_t> storage; ///< the packs; with islands, the packs of one strand for each worker
    std::vector<WarmStart> warm;        ///< by body
    std::vector<WarmStart> arrival;     ///< by body: PassData::arrival
    /// Contacts that bounce, and contacts that roll, in the order of contacts. One thread walks both lists, and their
    /// contacts share bodies, so their order decides bits; the order of packs depends on lanes and workers.
    std::vector<Bounce> bounces;
    std::vector<Rolling> rolling;
    std::vector<Struck> struck; ///< by body in a substep with impacts, otherwise empty
    /// By contact: pack * lanes + lane. Filled for contacts that bounce or roll.
    std::vector<std::uint32_t> lane_of;
    solve::ContactOrder order;
    solve::ContactPacks in_packs;
    std::span<const std::uint32_t> lane_contact; ///< contact of each lane of each pack, or none
    base::Paths paths;
    // Used in builds that check the order:
    PassCounter counter;
    CheckVector<std::uint32_t> rank_of; ///< by contact

    /// A list of bodies, or the first `count` bodies where `list` is null.
    struct Rows {
        const std::uint32_t* list;
        std::uint32_t count;
        std::size_t operator[](std::uint32_t k) const { return list != nullptr ? list[k] : k; }
    };
    static Rows all_rows(const SolverBodies& bodies) { return {nullptr, bodies.still() + 1}; }

    void place_packs(std::uint32_t workers, bool may_run_all, std::span<const Transform> poses);
    /// Fills the head of a pack, and the source of the rest.
    template <unsigned N>
    void fill(std::uint32_t pack, ContactPack<N>& to, PackSource& source, const PrepareInput& in) const;
    template <unsigned N>
    void prepare_packs(std::uint32_t first, std::uint32_t last, ContactPack<N>* to,
                       const PrepareInput& in) const;
    template <unsigned N>
    void store_packs(std::uint32_t first, std::uint32_t last, const ContactPack<N>* from,
                     std::span<const Contact> contacts, std::span<ContactMemory> memory,
                     ClampCounts& clamps) const;
    /// Counts the contact of a lane, or the contacts of packs [first, last), as solved in a pass.
    void count_lane(std::uint32_t lane, std::uint32_t pass);
    void count_packs(std::uint32_t first, std::uint32_t last, std::uint32_t pass);
    /// Counts the contacts that roll, which one thread solves in the order of their list.
    void count_rolling();
    template <unsigned N> void make_room(std::size_t packs);
    void note_paths(const Tasks* tasks) const;
    template <class Visit> void for_each_piece(Tasks* tasks, Visit&& visit);
    static std::int64_t* numbers(std::vector<WarmStart>& of) {
        static_assert(sizeof(WarmStart) == 6 * sizeof(std::int64_t));
        return reinterpret_cast<std::int64_t*>(of.data());
    }
    void begin_pass(const SolverBodies& bodies, Rows rows);
    void find_arrival(const SolverBodies& bodies, Rows rows);
    void end_pass(const SolverBodies& bodies, Rows rows);
    void first_warm_start(SolverBodies& bodies, Tasks* tasks);
    void next_warm_start(SolverBodies& bodies, Rows rows) const;
    void follow_pass(const StepConstants& step, SolverBodies& bodies, Rows rows, std::uint32_t pass);
    template <unsigned N> std::span<ContactPack<N>> packs() {
        return {reinterpret_cast<ContactPack<N>*>(storage.data()), pack_count};
    }
    /// visit(std::integral_constant<unsigned, N>) for the lane width in use.
    template <class Visit> void with_lanes(Visit&& visit) const;
    PassData data(SolverBodies& bodies) {
        return {bodies.body.data(), warm.data(), arrival.data(), pack_count, asks_ahead};
    }
};

ContactSolver::ContactSolver() : inside(std::make_unique<Inside>()) { use(best_simd()); }
ContactSolver::~ContactSolver() = default;
Simd ContactSolver::level() const { return inside->simd; }

bool ContactSolver::use(Simd level) {
    const Kernels* kernels = kernels_of(level);
    if (kernels == nullptr) return false;
    inside->kernel = kernels->contacts;
    inside->body_kernel = kernels->bodies;
    inside->simd = level;
    return true;
}

template <class Visit> void ContactSolver::Inside::with_lanes(Visit&& visit) const {
    switch (kernel->lanes) {
    case 8:
        return visit(std::integral_constant<unsigned, 8>{});
    case 4:
        return visit(std::integral_constant<unsigned, 4>{});
    case 2:
        return visit(std::integral_constant<unsigned, 2>{});
    default:
        return visit(std::integral_constant<unsigned, 1>{});
    }
}

void ContactSolver::reserve(std::size_t contacts, std::size_t bodies) {
    inside->bounces.reserve(contacts), inside->rolling.reserve(contacts);
    inside->lane_of.reserve(contacts);
    inside->warm.reserve(bodies + 1), inside->arrival.reserve(bodies + 1), inside->struck.reserve(bodies + 1);
    inside->order.reserve(contacts, bodies), inside->in_packs.reserve(contacts, bodies);
    inside->with_lanes([&](auto width) {
        // Enough for packs with half of their lanes in use; few scenes have emptier packs.
        constexpr std::size_t words = sizeof(ContactPack<width()>) / sizeof(std::uint32_t);
        inside->storage.reserve((2 * contacts / width() + 1) * words);
    });
}

/// Chooses the contacts of each pack, and lists those that bounce or roll. Contacts of one point have packs of their
/// own, and so have contacts that carried nothing: those packs take little time.
void ContactSolver::Inside::place_packs(std::uint32_t workers, bool may_run_all,
                                        std::span<const Transform> poses) {
    static_assert(none == ContactPacks::no_contact);
    const std::uint32_t lanes = kernel->lanes;
    std::size_t bytes = 0;
    with_lanes([&](auto width) { bytes = sizeof(ContactPack<width()>); });
    in_packs.make(order, {lanes, workers, may_run_all, bytes}, poses);
    lane_contact = in_packs.contact_of_lane();
    pack_count = static_cast<std::uint32_t>(lane_contact.size()) / lanes;
    if constexpr (checks_order) rank_of = order.ranks(), counter.begin(order.body_count());
    bounces.clear(), rolling.clear();
    if ((order.any_kind() & (ContactOrder::bounces | ContactOrder::rolls)) == 0) return;
    const auto add = [&](auto& table, std::uint32_t lane) {
        auto& entry = table.emplace_back();
        entry.pack = lane / lanes, entry.lane = lane % lanes;
    };
    lane_of.resize(order.down_from_the_top().size());
    for (std::uint32_t i = 0; i < lane_contact.size(); ++i)
        if (lane_contact[i] != none) lane_of[lane_contact[i]] = i;
    for (const std::uint32_t contact : order.down_from_the_top()) {
        const unsigned kind = order.kind(contact);
        if (kind & ContactOrder::bounces) add(bounces, lane_of[contact]);
        if (kind & ContactOrder::rolls) add(rolling, lane_of[contact]);
    }
}

void ContactSolver::Inside::count_lane(std::uint32_t lane, std::uint32_t pass) {
    const std::uint32_t contact = lane_contact[lane];
    if (contact == none) return;
    const solve::ContactOrder::Link link = order.link(contact);
    for (const std::uint32_t body : {link.a, link.b})
        if (order.moves(body)) counter.move(pass, rank_of[contact], body);
}
void ContactSolver::Inside::count_packs(std::uint32_t first, std::uint32_t last, std::uint32_t pass) {
    if constexpr (checks_order)
        for (std::uint32_t lane = first * kernel->lanes; lane < last * kernel->lanes; ++lane)
            count_lane(lane, pass);
}
void ContactSolver::Inside::count_rolling() {
    const std::uint32_t pass = counter.next_pass();
    if constexpr (checks_order)
        for (const Rolling& rows : rolling) count_lane(rows.pack * kernel->lanes + rows.lane, pass);
}

template <unsigned N>
void ContactSolver::Inside::fill(std::uint32_t pack, ContactPack<N>& to, PackSource& source,
                                 const PrepareInput& in) const {
    const auto for_contacts_of = [&](std::size_t other, auto&& visit) {
        for (std::size_t i = other * N; i < (other + 1) * N && i < lane_contact.size(); ++i)
            if (lane_contact[i] != none) visit(in.contacts[lane_contact[i]]);
    };
    // Prefetch data of later packs, which arrives while the packs before them are prepared.
    for_contacts_of(pack + 2 * prepared_at_once, [](const Contact& c) { base::prefetch(c); });
    for_contacts_of(pack + prepared_at_once, [&](const Contact& c) {
        const auto& step = in.bodies.step;
        base::prefetch(step[c.body_a].movable), base::prefetch(step[c.body_b].movable);
        if (!in_packs.has_islands()) return; // only large worlds have islands
        base::prefetch(in.bodies.body[c.body_a].v), base::prefetch(in.bodies.body[c.body_b].v);
    });
    if (asks_ahead) base::prefetch((&to)[prepared_at_once]);
    const Contact* of[N];
    std::uint32_t points = 0;
    for (unsigned lane = 0; lane < N; ++lane) {
        const std::uint32_t contact = lane_contact[pack * N + lane];
        of[lane] = contact != none ? &in.contacts[contact] : nullptr;
        if (contact != none) points = std::max(points, of[lane]->count);
    }
    clear_pack(to, in.bodies.still(), points);
    fill_pack(to, source, of, in);
}

/// Prepares packs [first, last), and writes them from `to` on.
template <unsigned N>
void ContactSolver::Inside::prepare_packs(std::uint32_t first, std::uint32_t last, ContactPack<N>* to,
                                          const PrepareInput& in) const {
    PackSource sources[prepared_at_once];
    for (std::uint32_t end; first < last; to += end - first, first = end) {
        end = std::min(first + prepared_at_once, last);
        for (std::uint32_t at = first; at < end; ++at) fill<N>(at, to[at - first], sources[at - first], in);
        kernel->prepare(to, sources, end - first, in.bodies.body.data());
    }
}

void ContactSolver::Inside::note_paths(const Tasks* tasks) const {
    using base::Path;
    paths.take(!bounces.empty(), Path::contacts_do_not_bounce, Path::contacts_bounce);
    paths.take(!rolling.empty(), Path::contacts_do_not_roll, Path::contacts_roll);
    paths.take(in_packs.has_islands()       ? Path::passes_by_island
               : in_packs.runs_all_passes() ? Path::passes_in_one_run
                                            : Path::passes_one_by_one);
    if (in_packs.has_islands()) return;
    paths.take(base::is_shared(tasks, pack_count, pack_chunk), Path::packs_by_one, Path::packs_by_workers);
}

template <unsigned N> void ContactSolver::Inside::make_room(std::size_t packs) {
    const std::size_t words = packs * (sizeof(ContactPack<N>) / sizeof(std::uint32_t));
    base::make_room(storage, words); // resize() alone would allocate twice as much
    if (storage.size() < words) storage.resize(words);
    asks_ahead = packs * sizeof(ContactPack<N>) > cache_bytes;
    paths.take(asks_ahead, base::Path::packs_in_cache, base::Path::packs_beyond_cache);
}

void ContactSolver::prepare(std::span<const ContactHead> heads, std::span<const Contact> contacts,
                            std::span<const ContactMemory> memory, const solve::MassView& mass,
                            const StepConstants& step, const SolverBodies& bodies,
                            std::span<const Transform> poses, bool alone, Tasks* tasks) {
    Inside& s = *inside;
    s.order.find(heads, bodies);
    constexpr unsigned others = ContactOrder::bounces | ContactOrder::rolls | ContactOrder::driven;
    const bool may_run_all = alone && bodies.turns.empty() && (s.order.any_kind() & others) == 0;
    s.place_packs(base::worker_count(tasks), may_run_all, poses);
    s.started = false;
    if (s.pack_count == 0) return;
    s.note_paths(tasks);
    if (s.in_packs.has_islands())
        s.warm.resize(bodies.body.size()); // each strand sets the entries of its bodies
    else
        s.warm.assign(bodies.body.size(), {});
    s.arrival.resize(bodies.body.size());
    const PrepareInput in{contacts, memory, mass, step, bodies};
    s.with_lanes([&](auto width) {
        constexpr unsigned N = width();
        if (s.in_packs.has_islands()) return; // each strand prepares its packs when it runs
        s.make_room<N>(s.pack_count);
        const std::span<ContactPack<N>> packs = s.packs<N>();
        const auto contact_of = [&](std::uint32_t pack, unsigned lane) {
            return s.lane_contact[pack * N + lane];
        };
        base::for_all_chunks(tasks, s.pack_count, pack_chunk,
                             [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                                 s.prepare_packs<N>(first, last, &packs[first], in);
                             });
        for (Bounce& bounce : s.bounces) {
            packs[bounce.pack].bounces[bounce.lane] = -1;
            ++packs[bounce.pack].bounce_count;
            bounce.restitution = contacts[contact_of(bounce.pack, bounce.lane)].restitution.raw;
            std::ranges::fill(bounce.impulse, 0);
        }
        for (Rolling& rows : s.rolling) fill_rolling(rows, contacts[contact_of(rows.pack, rows.lane)], in);
    });
}

/// Calls visit(first, last) for pieces of packs: in order within a strand, and for different strands at the same time.
template <class Visit> void ContactSolver::Inside::for_each_piece(Tasks* tasks, Visit&& visit) {
    if (tasks == nullptr || in_packs.plan().strands == 0) return visit(0, pack_count);
    base::for_strands(tasks, in_packs.plan(), 1,
                      [&](const base::Piece& piece, base::PieceAt) { visit(piece.first, piece.last); });
}

/// The velocity that the passes give to a body is the difference between its velocities before and after them. So it is
/// subtracted before a pass and added after it. Modulo 2^64 this is right even where a velocity left its range in
/// between.
void ContactSolver::Inside::begin_pass(const SolverBodies& bodies, Rows rows) {
    body_kernel->take_velocities(bodies.body.data(), numbers(warm), rows.list, rows.count);
}
void ContactSolver::Inside::end_pass(const SolverBodies& bodies, Rows rows) {
    body_kernel->add_velocities(bodies.body.data(), numbers(warm), rows.list, rows.count);
}

void ContactSolver::Inside::find_arrival(const SolverBodies& bodies, Rows rows) {
    for (std::uint32_t k = 0; k < rows.count; ++k) {
        const SolverBody& from = bodies.body[rows[k]];
        WarmStart& to = arrival[rows[k]];
        for (int axis = 0; axis < 3; ++axis) to.v[axis] = from.v[axis], to.u[axis] = from.u[axis];
    }
}

void ContactSolver::begin_substep(const SolverBodies& bodies) {
    if (inside->pack_count != 0) inside->find_arrival(bodies, Inside::all_rows(bodies));
}
void ContactSolver::leave_forces_out(const SolverBodies& bodies) {
    Inside& s = *inside;
    if (s.pack_count == 0) return;
    s.body_kernel->take_velocities(bodies.body.data(), s.numbers(s.arrival), nullptr,
                                   s.all_rows(bodies).count);
}

void ContactSolver::Inside::first_warm_start(SolverBodies& bodies, Tasks* tasks) {
    begin_pass(bodies, all_rows(bodies));
    const std::uint32_t pass = counter.next_pass();
    for_each_piece(tasks, [&](std::uint32_t first, std::uint32_t last) {
        count_packs(first, last, pass);
        kernel->warm_start(storage.data(), first, last, data(bodies));
    });
    end_pass(bodies, all_rows(bodies));
}
void ContactSolver::Inside::next_warm_start(SolverBodies& bodies, Rows rows) const {
    for (std::uint32_t k = 0; k < rows.count; ++k) {
        SolverBody& b = bodies.body[rows[k]];
        const WarmStart& from = warm[rows[k]];
        for (int axis = 0; axis < 3; ++axis) {
            b.v[axis] = add_saturated(b.v[axis], from.v[axis] & b.keep[axis]);
            b.u[axis] = add_saturated(b.u[axis], from.u[axis]);
        }
    }
}

void ContactSolver::warm_start(SolverBodies& bodies, Tasks* tasks) {
    Inside& s = *inside;
    if (s.pack_count == 0) return;
    s.body_kernel->add_velocities(bodies.body.data(), s.numbers(s.arrival), nullptr,
                                  s.all_rows(bodies).count);
    begin_contacts(bodies);
    if (s.started)
        s.next_warm_start(bodies, s.all_rows(bodies));
    else
        s.first_warm_start(bodies, tasks);
    s.started = true;
    s.with_lanes([&](auto width) {
        constexpr unsigned N = width();
        if (!s.rolling.empty()) solve_rolling<N>(s.rolling, s.packs<N>(), bodies, true);
    });
    s.count_rolling();
    end_contacts(bodies);
}

static PassSettings settings_of(const StepConstants& step, bool bias) {
    const std::int64_t gap_max =
        (std::int64_t{impulse_limit} << (gap_bits - speed_bits)) / step.substeps_per_second;
    return {static_cast<std::int32_t>(step.substeps_per_second),
            static_cast<std::int32_t>(std::min<std::int64_t>(gap_max, 0x7fffffff)),
            step.restitution_speed_min.raw, bias};
}

void ContactSolver::rebound(const StepConstants& step, SolverBodies& bodies) {
    Inside& s = *inside;
    s.struck.clear();
    if (s.bounces.empty()) return;
    const PassSettings settings = settings_of(step, true);
    if (!s.kernel->find_hits(s.storage.data(), s.pack_count, s.data(bodies), settings)) return;
    note_energies(bodies);
    s.struck.assign(bodies.body.size(), Struck{});
    s.with_lanes([&](auto width) {
        solve::rebound<width()>(s.bounces, s.packs<width()>(), settings, bodies, s.arrival.data(), s.struck);
    });
    keep_energies(bodies);
    note_u(bodies);
    begin_ways(s.struck, bodies);
    keep_velocity(bodies);
}

void ContactSolver::end_ways(SolverBodies& bodies) {
    if (inside->struck.empty()) return;
    note_u(bodies);
    solve::end_ways(inside->struck, bodies);
    keep_velocity(bodies);
}

void ContactSolver::solve(const StepConstants& step, SolverBodies& bodies, bool bias, Tasks* tasks) {
    Inside& s = *inside;
    if (s.pack_count == 0) return;
    begin_contacts(bodies);
    if (!s.rolling.empty())
        s.with_lanes(
            [&](auto width) { solve_rolling<width()>(s.rolling, s.packs<width()>(), bodies, false); });
    s.count_rolling();
    const PassSettings settings = settings_of(step, bias);
    const std::uint32_t pass = s.counter.next_pass();
    s.begin_pass(bodies, s.all_rows(bodies));
    s.for_each_piece(tasks, [&](std::uint32_t first, std::uint32_t last) {
        s.count_packs(first, last, pass);
        s.kernel->solve(s.storage.data(), first, last, s.data(bodies), settings);
    });
    s.end_pass(bodies, s.all_rows(bodies));
    end_contacts(bodies);
}

// ---- all passes of a tick as one run ---

bool ContactSolver::has_all_passes() const { return inside->in_packs.runs_all_passes(); }

/// The kind of a pass: 0 for the warm start, which is pass 0; then in turn 1, with bias, and 2, without bias.
static constexpr std::uint32_t pass_kind(std::uint32_t pass) { return pass == 0 ? 0 : 2 - pass % 2; }

/// The steps between a pass and the next one, for bodies that no later contact of this pass moves.
void ContactSolver::Inside::follow_pass(const StepConstants& step, SolverBodies& bodies, Rows rows,
                                        std::uint32_t pass) {
    const std::span<const std::uint32_t> list(rows.list, rows.count);
    if (pass_kind(pass) == 1) {
        end_pass(bodies, rows);
        integrate_poses(step, bodies, list);
        begin_pass(bodies, rows);
        return;
    }
    if (pass_kind(pass) == 2) {
        end_pass(bodies, rows);
        find_arrival(bodies, rows);
        integrate_velocities(step, bodies, list);
        next_warm_start(bodies, rows);
        begin_pass(bodies, rows);
    }
}

void ContactSolver::solve_substeps(const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    Inside& s = *inside;
    move_driven(step, bodies, true);
    s.begin_pass(bodies, s.all_rows(bodies));
    const PassSettings settings[2] = {settings_of(step, true), settings_of(step, false)};
    const std::uint32_t last_pass = static_cast<std::uint32_t>(2 * step.substeps);
    base::for_strands(
        tasks, s.in_packs.plan(), last_pass + 1, [&](const base::Piece& piece, base::PieceAt at) {
            s.count_packs(piece.first, piece.last, at.round + 1);
            if (at.round == 0)
                s.kernel->warm_start(s.storage.data(), piece.first, piece.last, s.data(bodies));
            else
                s.kernel->solve(s.storage.data(), piece.first, piece.last, s.data(bodies),
                                settings[pass_kind(at.round) - 1]);
            const std::span<const std::uint32_t> rows = s.in_packs.bodies_after(at);
            if (at.round != last_pass && !rows.empty())
                s.follow_pass(step, bodies, {rows.data(), static_cast<std::uint32_t>(rows.size())}, at.round);
        });
}

bool ContactSolver::has_islands() const { return inside->in_packs.has_islands(); }

void ContactSolver::solve_islands(std::span<const Contact> contacts, std::span<ContactMemory> memory,
                                  const MassView& mass, const StepConstants& step, SolverBodies& bodies,
                                  Tasks* tasks) {
    Inside& s = *inside;
    const PrepareInput in{contacts, memory, mass, step, bodies};
    const PassSettings settings[2] = {settings_of(step, true), settings_of(step, false)};
    const std::uint32_t passes = static_cast<std::uint32_t>(2 * step.substeps);
    move_driven(step, bodies, false);
    for (std::uint32_t row = 0; row <= bodies.still(); ++row)
        if (!s.order.moves(row)) s.warm[row] = {}, s.find_arrival(bodies, {&row, 1}); // all strands read it
    s.with_lanes([&](auto width) {
        constexpr unsigned N = width();
        std::size_t most = 0;
        for (std::uint32_t k = 0; k < s.in_packs.plan().strands; ++k)
            for (const base::Piece& piece : s.in_packs.plan().pieces[k])
                most = std::max<std::size_t>(most, piece.last - piece.first);
        s.make_room<N>(most * base::worker_count(tasks));
        s.asks_ahead = false;
        base::for_strands(tasks, s.in_packs.plan(), 1, [&](const base::Piece& piece, base::PieceAt at) {
            ContactPack<N>* const packs =
                reinterpret_cast<ContactPack<N>*>(s.storage.data()) + at.worker * most;
            const std::span<const std::uint32_t> list = s.in_packs.bodies_after(at);
            const Inside::Rows rows{list.data(), static_cast<std::uint32_t>(list.size())};
            const std::uint32_t count = piece.last - piece.first;
            s.prepare_packs<N>(piece.first, piece.last, packs, in);
            s.find_arrival(bodies, rows);
            integrate_velocities(step, bodies, list);
            for (const std::uint32_t row : list) s.warm[row] = {};
            s.begin_pass(bodies, rows);
            s.count_packs(piece.first, piece.last, 1);
            s.kernel->warm_start(packs, 0, count, s.data(bodies));
            for (std::uint32_t pass = 0; pass < passes; ++pass) {
                s.follow_pass(step, bodies, rows, pass);
                s.count_packs(piece.first, piece.last, pass + 2);
                s.kernel->solve(packs, 0, count, s.data(bodies), settings[pass_kind(pass + 1) - 1]);
            }
            ClampCounts counts;
            s.store_packs<N>(piece.first, piece.last, packs, contacts, memory, counts);
            base::add_count(bodies.clamps.impulse, counts.impulse);
        });
    });
}

namespace {

template <unsigned N>
void store_lane(const ContactPack<N>& pack, unsigned lane, const Contact& contact, ContactMemory& m,
                solve::ClampCounts& clamps) {
    bool clamped = false;
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        const std::int32_t p = pack.points[k].impulse[lane];
        m.points[k].normal = Speed::from_raw(p);
        clamped = clamped || p >= impulse_limit;
    }
    m.tangent_1 = Speed::from_raw(pack.slide[0][lane]);
    m.tangent_2 = Speed::from_raw(pack.slide[1][lane]);
    m.twist = Length::from_raw(saturate_to_int32(
        shift_right_rounded(std::int64_t{pack.slide[2][lane]} * pack.size[lane], speed_bits)));
    const std::uint32_t hit = (pack.hit >> lane) & 1u ? solve::contact_hit : 0u;
    m.flags = (m.flags & ~std::uint32_t{solve::contact_hit}) | hit;
    if (clamped) ++clamps.impulse;
}

} // namespace

template <unsigned N>
void ContactSolver::Inside::store_packs(std::uint32_t first, std::uint32_t last, const ContactPack<N>* from,
                                        std::span<const Contact> contacts, std::span<ContactMemory> memory,
                                        ClampCounts& clamps) const {
    // entries to prefetch ahead: the order of packs visits the tables at scattered places
    constexpr std::size_t ahead = 8;
    const auto soon = [&](std::size_t lane) { return lane_contact[std::min(lane, lane_contact.size() - 1)]; };
    for (std::uint32_t i = first * N; i < last * N; ++i) {
        const std::uint32_t pack = i / N - first;
        if (const std::uint32_t c = soon(i + 2 * ahead); c != none) base::prefetch(contacts[c].memory);
        if (const std::uint32_t c = soon(i + ahead); c != none) base::prefetch(memory[contacts[c].memory]);
        if (asks_ahead && i % N == 0 && i / N + 1 < last) {
            const ContactPack<N>& next = from[pack + 1];
            for (const PointLanes<N>& point : next.points) base::prefetch(point.impulse);
            base::prefetch(next.slide), base::prefetch(next.size), base::prefetch(next.hit);
        }
        if (const std::uint32_t c = lane_contact[i]; c != none)
            store_lane(from[pack], i % N, contacts[c], memory[contacts[c].memory], clamps);
    }
}

void ContactSolver::store(std::span<const Contact> contacts, std::span<ContactMemory> memory,
                          solve::ClampCounts& clamps, Tasks* tasks) const {
    Inside& s = *inside;
    if (s.in_packs.has_islands()) return;
    s.with_lanes([&](auto width) {
        constexpr unsigned N = width();
        const std::span<const ContactPack<N>> packs = s.packs<N>();
        base::for_chunks(tasks, s.pack_count, 4 * pack_chunk,
                         [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                             ClampCounts counts;
                             s.store_packs<N>(first, last, &packs[first], contacts, memory, counts);
                             base::add_count(clamps.impulse, counts.impulse);
                         });
        for (const Rolling& rows : s.rolling) {
            ContactMemory& m = memory[contacts[s.lane_contact[rows.pack * N + rows.lane]].memory];
            for (int r = 0; r < 3; ++r) m.rolling[r] = Speed::from_raw(rows.impulse[r]);
        }
    });
}

void ContactSolver::list_impacts(std::vector<ContactImpact>& out) const {
    solve::list_impacts(inside->bounces, inside->lane_contact, inside->kernel->lanes, out);
}

std::string ContactSolver::order_fault() const {
    const Inside& s = *inside;
    if (s.pack_count == 0) return {};
    if (std::string fault = s.in_packs.order_fault(s.order); !fault.empty()) return "contacts: " + fault;
    const CheckVector<std::uint32_t> rank_of = s.order.ranks();
    const auto is_ordered = [&](const auto& list, const auto& lane_of_entry) {
        return std::ranges::is_sorted(
            list, {}, [&](const auto& entry) { return rank_of[s.lane_contact[lane_of_entry(entry)]]; });
    };
    if (!is_ordered(s.bounces, [&](const Bounce& at) { return at.pack * s.kernel->lanes + at.lane; }))
        return "contacts that bounce are out of order";
    if (!is_ordered(s.rolling, [&](const Rolling& rows) { return rows.pack * s.kernel->lanes + rows.lane; }))
        return "contacts that roll are out of order";
    return {};
}

void ContactSolver::take_paths(base::Paths& to) {
    for (base::Paths* own : {&inside->paths, &inside->order.paths, &inside->in_packs.paths})
        to.add(*own), own->clear();
}

void ContactSolver::poison(std::byte with) {
    Inside& s = *inside;
    base::poison(with, s.storage, s.warm, s.arrival, s.bounces, s.rolling, s.struck, s.lane_of);
    s.order.poison(with), s.in_packs.poison(with);
}

} // namespace lockstone::solve
