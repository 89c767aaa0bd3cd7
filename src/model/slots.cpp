#include "model/slots.h"

#include "model/sleep.h"

#include <algorithm>
#include <cstring>

namespace lockstone::sim {

std::uint32_t take_slot(Model& w, TableId table, Column<Slot> column, std::uint32_t Header::*first_free,
                        std::uint32_t row) {
    std::uint32_t index = w.header().*first_free;
    if (index == 0) {
        const std::uint32_t count = w.state.count(table);
        w.state.resize(table, count + 1);
        index = count + 1;
        w.state.edit_row(column, index - 1).generation = 1;
    }
    Slot& slot = w.state.edit_row(column, index - 1);
    w.edit_header().*first_free = slot.is_alive() ? 0 : slot.next_free();
    slot.row = row;
    return index;
}

void free_slot(State& state, Column<Slot> column, std::uint32_t index, std::uint32_t& first_free) {
    Slot& slot = state.edit_row(column, index - 1);
    // Generations wrap after 2^32 objects in one slot; 0 stays null.
    slot.generation = slot.generation == 0xffffffffu ? 1 : slot.generation + 1;
    slot.row = Slot::is_free | first_free;
    first_free = index;
}

void remove_row(State& state, TableId table, std::uint32_t row) {
    const std::uint32_t last = state.count(table) - 1;
    if (row != last)
        for (const std::uint32_t column : state.layout().columns_of(table)) {
            const std::span<std::byte> to = state.edit_row_bytes(column, row);
            std::memcpy(to.data(), state.bytes(column).data() + std::size_t{last} * to.size(), to.size());
        }
    state.resize(table, last);
}

namespace {

/// Swaps the bytes of two rows in words: most rows are short.
void swap_bytes(std::byte* x, std::byte* y, std::size_t size) {
    constexpr std::size_t word = sizeof(std::uint64_t);
    for (; size >= word; size -= word, x += word, y += word) {
        std::uint64_t of_x = 0, of_y = 0;
        std::memcpy(&of_x, x, word), std::memcpy(&of_y, y, word);
        std::memcpy(x, &of_y, word), std::memcpy(y, &of_x, word);
    }
    std::swap_ranges(x, x + size, y);
}

} // namespace

void swap_rows(State& state, TableId table, std::uint32_t x, std::uint32_t y) {
    if (x == y) return;
    for (const std::uint32_t column : state.layout().columns_of(table)) {
        const std::span<std::byte> a = state.edit_row_bytes(column, x), b = state.edit_row_bytes(column, y);
        swap_bytes(a.data(), b.data(), a.size());
    }
}

void swap_rows(State& state, TableId table, std::uint32_t except, std::uint32_t end,
               std::span<const RowSwap> swaps) {
    for (const std::uint32_t column : state.layout().columns_of(table)) {
        if (column == except) continue;
        const std::size_t size = state.layout().placements()[column].row_size;
        std::byte* const rows = state.edit_bytes(column, 0, end).data();
        for (const RowSwap& swap : swaps) swap_bytes(rows + swap.x * size, rows + swap.y * size, size);
    }
}

// ---- joints ---

namespace {

/// The link of body `body` in a joint's row.
std::uint32_t& next_of(JointRow& row, BodyId body) {
    return row.def.body_a == body ? row.next_a : row.next_b;
}

void enlist(Model& w, std::uint32_t row, std::uint32_t slot, BodyId body) {
    if (!body) return;
    BodyInfo& info = w.state.edit_row(w.m.body_info, w.row_of(body));
    next_of(w.state.edit_row(w.m.joint, row), body) = info.first_joint;
    info.first_joint = slot;
}

void delist(Model& w, std::uint32_t row, std::uint32_t slot, BodyId body) {
    if (!body) return;
    const std::span<const Slot> slots = w.state.rows(w.m.joint_slot);
    const std::uint32_t next = next_of(w.state.edit_row(w.m.joint, row), body);
    BodyInfo& info = w.state.edit_row(w.m.body_info, w.row_of(body));
    if (info.first_joint == slot) {
        info.first_joint = next;
        return;
    }
    for (std::uint32_t at = info.first_joint; at != 0;) {
        std::uint32_t& link = next_of(w.state.edit_row(w.m.joint, slots[at - 1].row), body);
        if (link == slot) {
            link = next;
            return;
        }
        at = link;
    }
}

} // namespace

void enlist_joint(Model& w, std::uint32_t row) {
    const JointRow& joint = w.state.rows(w.m.joint)[row];
    const BodyId a = joint.def.body_a, b = joint.def.body_b;
    const std::uint32_t slot = joint.id.index;
    enlist(w, row, slot, a);
    enlist(w, row, slot, b);
}

void remove_joint(Model& w, std::uint32_t slot) {
    std::uint32_t row = w.state.rows(w.m.joint_slot)[slot - 1].row;
    const JointDef def = w.state.rows(w.m.joint)[row].def;
    delist(w, row, slot, def.body_a);
    delist(w, row, slot, def.body_b);
    row = put_joint_to_rest(w, row);
    const JointId moved = w.state.rows(w.m.joint).back().id;
    remove_row(w.state, w.m.joints, row);
    w.state.edit_row(w.m.joint_slot, moved.index - 1).row = row;
    free_slot(w.state, w.m.joint_slot, slot, w.edit_header().joint_free);
}

} // namespace lockstone::sim
