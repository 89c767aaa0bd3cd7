#include "model/contact_rows.h"

#include "base/parallel.h"
#include "base/poison.h"
#include "base/room.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace lockstone::sim {

namespace {

constexpr int beyond_bits = 32; // Length and Coordinate have the same step

/// The part of a coordinate that its lower 32 bits, sign extended, do not hold.
std::int32_t beyond(Coordinate at) {
    const std::uint64_t raw = static_cast<std::uint64_t>(at.raw);
    return static_cast<std::int32_t>(
        static_cast<std::uint32_t>((raw + (std::uint64_t{1} << 31)) >> beyond_bits));
}

ContactMore more_of(const ContactMemory& m) {
    return {{beyond(m.made_position.x), beyond(m.made_position.y), beyond(m.made_position.z)},
            m.rolling,
            m.piece_a,
            m.piece_b};
}

/// Returns true if any field of more_of() is not zero.
bool has_more(const ContactMemory& m) {
    const auto far = [](Coordinate at) { return at.raw ^ static_cast<std::int32_t>(at.raw); };
    const std::int64_t any = far(m.made_position.x) | far(m.made_position.y) | far(m.made_position.z) |
                             m.rolling.x.raw | m.rolling.y.raw | m.rolling.z.raw | std::int64_t{m.piece_a} |
                             std::int64_t{m.piece_b};
    return any != 0;
}

constexpr std::size_t same_first = offsetof(ContactMemory, made_rotation),
                      same_first_of_row = offsetof(ContactRow, made_rotation),
                      same_size = sizeof(ContactRow) - same_first_of_row;
static_assert(offsetof(ContactMemory, normal) - same_first ==
              offsetof(ContactRow, normal) - same_first_of_row);
static_assert(offsetof(ContactMemory, margin) - same_first ==
              offsetof(ContactRow, margin) - same_first_of_row);
static_assert(offsetof(ContactMemory, tangent_1) - same_first ==
              offsetof(ContactRow, tangent_1) - same_first_of_row);
static_assert(offsetof(ContactMemory, tangent_2) - same_first ==
              offsetof(ContactRow, tangent_2) - same_first_of_row);
static_assert(offsetof(ContactMemory, twist) - same_first == offsetof(ContactRow, twist) - same_first_of_row);
static_assert(offsetof(ContactMemory, twist) + sizeof(Length) - same_first == same_size);

void put_row(const ContactMemory& m, bool has_more, ContactRow& row) {
    const auto low = [](Coordinate at) { return Length::from_raw(static_cast<std::int32_t>(at.raw)); };
    row.flags = static_cast<std::uint16_t>(m.flags | (has_more ? solve::contact_has_more : 0u));
    row.count = static_cast<std::uint16_t>(m.count);
    row.made_position = {low(m.made_position.x), low(m.made_position.y), low(m.made_position.z)};
    std::memcpy(reinterpret_cast<std::byte*>(&row) + same_first_of_row,
                reinterpret_cast<const std::byte*>(&m) + same_first, same_size);
}

void take_row(const ContactRow& row, ContactMemory& m) {
    m.flags = row.flags & ~std::uint32_t{solve::contact_has_more};
    m.made_position = to<Coordinate>(row.made_position);
    std::memcpy(reinterpret_cast<std::byte*>(&m) + same_first,
                reinterpret_cast<const std::byte*>(&row) + same_first_of_row, same_size);
    m.rolling = {};
    m.piece_a = m.piece_b = 0;
}

void take_more(const ContactMore& more, ContactMemory& m) {
    for (int i = 0; i < 3; ++i)
        m.made_position[i].raw = static_cast<std::int64_t>(
            static_cast<std::uint64_t>(m.made_position[i].raw) +
            (std::uint64_t{static_cast<std::uint32_t>(more.beyond[static_cast<std::size_t>(i)])}
             << beyond_bits));
    m.rolling = more.rolling;
    m.piece_a = more.piece_a, m.piece_b = more.piece_b;
}

/// Copies in halves, which compilers do without a call.
void copy_four(const ContactPointMemory* from, ContactPointMemory* to) {
    std::memcpy(to, from, 2 * sizeof *from);
    std::memcpy(to + 2, from + 2, 2 * sizeof *from);
}

/// Adds the row counts of a contact.
void add_rows(const ContactMemory& m, ContactsBegin& rows) {
    rows.points += m.count, rows.more += has_more(m) ? 1u : 0u;
}

/// Compares words: the memcmp of WebAssembly's C library goes byte by byte, which costs a measurable part of a tick.
bool are_same(std::span<const ContactKey> a, std::span<const ContactKey> b) {
    using Words = std::array<std::uint64_t, sizeof(ContactKey) / sizeof(std::uint64_t)>;
    std::uint64_t differs = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const auto x = std::bit_cast<Words>(a[i]), y = std::bit_cast<Words>(b[i]);
        for (std::size_t k = 0; k < x.size(); ++k) differs |= x[k] ^ y[k];
    }
    return differs == 0;
}

/// Leaves equal keys unwritten, so that their pages need not be saved and hashed again.
void write_keys(State& state, const ContactTables& to, const ContactList& list) {
    const std::span<const ContactKey> now = state.rows(to.key);
    if (now.empty() || are_same(now, list.keys)) return;
    std::memcpy(state.edit(to.key).data(), list.keys.data(), now.size_bytes());
}

/// The tables, resized and open for writing.
struct Written {
    ContactRow* rows;
    ContactPointMemory* points;
    ContactMore* mores;

    Written(State& state, const ContactTables& to, const ContactList& list, ContactsBegin all) {
        const auto count = static_cast<std::uint32_t>(list.keys.size());
        state.make_room_for({{to.contacts, count}, {to.points, all.points}, {to.more, all.more}});
        state.resize(to.contacts, count);
        state.resize(to.points, all.points), state.resize(to.more, all.more);
        write_keys(state, to, list);
        rows = state.edit(to.memory).data(), points = state.edit(to.point).data();
        mores = state.edit(to.beyond).data();
    }
    /// Writes contacts [first, last). Their rows of `points` and `more` are those from `begin` to `end`.
    void put(const ContactList& list, std::uint32_t first, std::uint32_t last, ContactsBegin begin,
             ContactsBegin end) const {
        ContactPointMemory* point = points + begin.points;
        const ContactPointMemory* const end_point = points + end.points;
        ContactMore* next = mores + begin.more;
        const bool any_has_more = begin.more != end.more;
        for (std::uint32_t i = first; i < last; ++i) {
            const ContactMemory& m = list.memories[i];
            const bool has = any_has_more && has_more(m);
            put_row(m, has, rows[i]);
            if (end_point - point >= static_cast<std::ptrdiff_t>(m.points.size()))
                copy_four(m.points.data(), point); // fast; the next contact's points overwrite the excess
            else
                std::copy_n(m.points.begin(), m.count, point);
            point += m.count;
            if (has) *next++ = more_of(m);
        }
    }
};

constexpr std::uint32_t contacts_per_chunk = 256;

} // namespace

void read_contacts(const State& state, const ContactTables& from, ContactList& out) {
    const std::span<const ContactKey> keys = state.rows(from.key);
    const std::span<const ContactRow> rows = state.rows(from.memory);
    const std::span<const ContactPointMemory> points = state.rows(from.point);
    const std::span<const ContactMore> mores = state.rows(from.beyond);
    if (out.memories.capacity() < rows.size()) out.reserve(rows.size() + rows.size() / 8);
    out.keys.assign(keys.begin(), keys.end());
    out.memories.resize(rows.size());
    std::size_t point = 0, more = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        ContactMemory& m = out.memories[i];
        take_row(rows[i], m);
        m.count = static_cast<std::uint32_t>(
            std::min<std::size_t>({rows[i].count, m.points.size(), points.size() - point}));
        std::copy_n(points.data() + point, m.count, m.points.begin());
        std::fill(m.points.begin() + m.count, m.points.end(), ContactPointMemory{});
        point += m.count;
        if ((rows[i].flags & solve::contact_has_more) != 0 && more < mores.size())
            take_more(mores[more++], m);
    }
}

void write_contacts(State& state, const ContactTables& to, const ContactList& list) {
    ContactsBegin all;
    for (const ContactMemory& m : list.memories) add_rows(m, all);
    const std::uint32_t count = static_cast<std::uint32_t>(list.memories.size());
    Written(state, to, list, all).put(list, 0, count, {}, all);
}

bool ContactCopy::has_changed(const State& state, const ContactTables& tables) {
    bool any = false;
    const auto look = [&](TableId table, std::uint32_t column) {
        const std::uint32_t before = state.take_changes(column, seen, changed);
        any |= !changed.empty() || before != state.count(table);
    };
    look(tables.contacts, tables.key.index), look(tables.contacts, tables.memory.index);
    look(tables.points, tables.point.index), look(tables.more, tables.beyond.index);
    return any;
}

void ContactCopy::read(const State& state, const ContactTables& from) {
    if (has_changed(state, from)) read_contacts(state, from, list);
}

void ContactCopy::write(State& state, const ContactTables& to, Tasks* tasks) {
    const std::uint32_t count = static_cast<std::uint32_t>(list.memories.size());
    begins.clear();
    base::make_room(begins, count / contacts_per_chunk + 1);
    ContactsBegin all;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (i % contacts_per_chunk == 0) begins.push_back(all);
        add_rows(list.memories[i], all);
    }
    const Written written(state, to, list, all);
    paths.take(base::is_shared(tasks, count, contacts_per_chunk), base::Path::table_by_one,
               base::Path::table_by_workers);
    base::for_all_chunks(tasks, count, contacts_per_chunk,
                         [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                             written.put(list, first, last, begins[first / contacts_per_chunk],
                                         last == count ? all : begins[last / contacts_per_chunk]);
                         });
    has_changed(state, to);
}

void ContactCopy::reserve(std::size_t rows) {
    list.reserve(rows), begins.reserve(rows / contacts_per_chunk + 2);
}

void ContactCopy::poison(std::byte with) {
    base::poison(with, list.keys, list.memories, changed, begins);
    list.clear();
    seen = {};
}

} // namespace lockstone::sim
