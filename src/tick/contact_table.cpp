// Builds the contact table of this tick from the table of the last tick. Kept rows move to their new places, and new
// rows are written between them. Rows that keep their place are not written.
#include "base/parallel.h"
#include "tick/contacts.h"

#include <algorithm>
#include <cstring>

namespace lockstone::sim {

namespace {

/// Removes from a chunk the pairs whose rows do not fit into `room` rows; such pairs stop touching. Returns the
/// number of rows removed.
std::uint32_t drop_pairs(NearChunk& chunk, std::size_t room) {
    std::uint32_t dropped = 0, rows = 0, made = 0, made_kept = 0, contacts = 0;
    std::size_t contact = 0;
    for (ContactResult& result : chunk.results) {
        const std::uint32_t end = result.first_row + result.row_count;
        const bool fits = result.row_count <= room - rows;
        for (; contact < chunk.contacts.size() && chunk.contacts[contact].memory < end; ++contact) {
            if (!fits) continue;
            chunk.heads[contacts] = chunk.heads[contact];
            solve::Contact& moved = chunk.contacts[contacts++] = chunk.contacts[contact];
            moved.memory = moved.memory - result.first_row + rows;
        }
        const std::uint32_t new_rows = result.is_kept ? 0 : result.row_count;
        for (std::uint32_t i = 0; fits && i < new_rows; ++i)
            chunk.memories[made_kept++] = chunk.memories[made + i];
        made += new_rows;
        result.first_row = rows;
        if (!fits) dropped += result.row_count, result.row_count = 0, result.is_touching = false;
        rows += result.row_count;
    }
    chunk.memories.resize(made_kept), chunk.contacts.resize(contacts), chunk.heads.resize(contacts);
    return dropped;
}

/// Computes where the rows, contacts and results of each chunk go, in pair order. Drops rows for which the table has
/// no room. Returns the number of rows.
std::uint32_t place_chunks(Model& w, bool is_cut, std::span<NearChunk> chunks, ContactScratch& s,
                           FoundContacts& out) {
    const std::uint32_t room =
        w.state.rows_max(w.m.contacts.contacts) - w.state.count(w.m.sleeping_contacts.contacts);
    std::uint32_t rows = 0, contacts = 0, results = 0, dropped = is_cut ? 1 : 0;
    for (NearChunk& chunk : chunks) {
        if (chunk.row_count > room - rows) {
            const std::uint32_t too_many = drop_pairs(chunk, room - rows);
            dropped += too_many, chunk.row_count -= too_many;
        }
        chunk.first_row = rows, chunk.first_contact = contacts, chunk.first_result = results;
        rows += chunk.row_count;
        results += static_cast<std::uint32_t>(chunk.results.size());
        contacts += static_cast<std::uint32_t>(chunk.contacts.size());
        if (chunks.size() == 1) {
            std::swap(out.results, chunk.results);
            break;
        }
    }
    if (chunks.size() != 1) out.results.resize(results);
    out.dropped = dropped;
    s.paths.take(dropped != 0, base::Path::contacts_all_fit, base::Path::contacts_dropped);
    if (dropped != 0) w.state.edit_row(w.m.faults, 0).contacts_dropped += dropped;
    return rows;
}

/// Lists the kept rows that change places. Returns true if every row of the table keeps its key.
bool find_moves(const ContactList& table, std::span<const ContactResult> results, std::uint32_t rows,
                ContactScratch& s) {
    bool same_keys = rows == table.keys.size();
    s.row_moves.clear();
    for (const ContactResult& result : results) {
        if (result.row_count == 0) continue;
        if (result.old_first == result.first_row && result.old_count == result.row_count) continue;
        same_keys = false;
        if (!result.is_kept || result.old_first == result.first_row) continue;
        if (!s.row_moves.empty()) {
            ContactScratch::RowMove& last = s.row_moves.back();
            if (last.from + last.count == result.old_first && last.to + last.count == result.first_row) {
                last.count += result.row_count;
                continue;
            }
        }
        s.row_moves.push_back({result.old_first, result.first_row, result.row_count});
    }
    return same_keys;
}

/// Moves rows in place. The order of rows does not change. Moves towards lower indices run first, from the first one
/// on; then moves towards higher indices run, from the last one back. So no move overwrites a row that has not moved
/// yet.
template <class Row> void move_rows(std::span<Row> rows, std::span<const ContactScratch::RowMove> moves) {
    const auto move = [&](const ContactScratch::RowMove& m) {
        std::memmove(rows.data() + m.to, rows.data() + m.from, m.count * sizeof(Row));
    };
    for (const ContactScratch::RowMove& m : moves)
        if (m.to < m.from) move(m);
    for (std::size_t i = moves.size(); i-- > 0;)
        if (moves[i].to > moves[i].from) move(moves[i]);
}

void write_rows(std::span<const NearChunk> chunks, std::span<const ContactResult> results, std::uint32_t rows,
                ContactList& table, ContactScratch& s) {
    const bool same_keys = find_moves(table, results, rows, s);
    s.paths.take(same_keys, base::Path::contact_rows_moved, base::Path::contact_rows_in_place);
    std::vector<ContactMemory>& memories = table.memories;
    if (memories.capacity() < rows) memories.reserve(rows + rows / 8);
    memories.resize(std::max<std::size_t>(rows, memories.size()));
    move_rows(std::span(memories), s.row_moves);
    auto chunk = chunks.begin();
    std::size_t made = 0; // rows of this chunk that are already written
    for (const ContactResult& result : results) {
        if (result.is_kept || result.row_count == 0) continue;
        while (made == chunk->memories.size()) ++chunk, made = 0;
        std::copy_n(chunk->memories.begin() + static_cast<std::ptrdiff_t>(made), result.row_count,
                    memories.begin() + result.first_row);
        made += result.row_count;
    }
    memories.resize(rows);
    if (same_keys) return;
    std::vector<ContactKey>& keys = table.keys;
    if (keys.capacity() < rows) keys.reserve(rows + rows / 8);
    keys.resize(rows);
    for (const ContactResult& result : results)
        for (std::uint32_t i = 0; i < result.row_count; ++i) keys[result.first_row + i] = result.key;
}

/// Copies the results and contacts of a chunk to their places in `out`.
void copy_chunk(const NearChunk& chunk, FoundContacts& out) {
    ContactResult* result_at = out.results.data() + chunk.first_result;
    for (const ContactResult& result : chunk.results) {
        *result_at = result;
        result_at++->first_row += chunk.first_row;
    }
    solve::Contact* contact_at = out.contacts.data() + chunk.first_contact;
    for (const solve::Contact& contact : chunk.contacts) {
        *contact_at = contact;
        contact_at++->memory += chunk.first_row;
    }
    std::copy(chunk.heads.begin(), chunk.heads.end(), out.heads.begin() + chunk.first_contact);
}

} // namespace

void place_contacts(Model& w, bool is_cut, std::span<NearChunk> chunks, ContactList& table, ContactScratch& s,
                    FoundContacts& out, Tasks* tasks) {
    const std::uint32_t rows = place_chunks(w, is_cut, chunks, s, out);
    if (chunks.size() == 1) {
        std::swap(out.contacts, chunks[0].contacts), std::swap(out.heads, chunks[0].heads);
    } else {
        out.contacts.resize(chunks.empty() ? 0 : chunks.back().first_contact + chunks.back().contacts.size());
        out.heads.resize(out.contacts.size());
        constexpr std::uint32_t copied_at_once = 8;
        const auto count = static_cast<std::uint32_t>(chunks.size());
        s.paths.take(base::is_shared(tasks, count, copied_at_once), base::Path::chunks_copied_by_one,
                     base::Path::chunks_copied_by_workers);
        base::for_all_chunks(tasks, count, copied_at_once,
                             [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                                 for (const NearChunk& chunk : chunks.subspan(first, last - first))
                                     copy_chunk(chunk, out);
                             });
    }
    write_rows(chunks, out.results, rows, table, s);
}

} // namespace lockstone::sim
