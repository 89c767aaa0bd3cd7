// The rules for arbitrary bytes, an image or a delta, from which a world is restored. The fuzzer and the tests that
// replay its inputs use them.
//
// Byte 0 of an input: bits 0-1 the world (modulo 3), bit 2 a delta instead of an image, bits 3-4 the meaning of the
// rest:
//   0     the image or delta itself
//   1     changes of a valid one, each a `splice`
//   2, 3  changes of a valid state's rows and row counts, saved again: see `edit_rows`
// Checksums, sizes and hashes are made valid afterwards, as an attacker would do.
#pragma once

#include "fuzz/checks/state_sessions.h"
#include "lockstone/testing.h"
#include "state/envelope.h"

#include <charconv>
#include <memory>

namespace fuzz {

struct StateInput {
    std::size_t base; ///< index of the base
    bool is_delta;
    Buffer bytes;
};

/// Writes the valid size field and checksum of an image or a delta.
inline void seal_state(Buffer& bytes) {
    constexpr std::size_t size_at = 12;
    if (bytes.size() < size_at + 8 + envelope_checksum_bytes) return;
    base::store_little_endian<std::uint64_t>(bytes.size(), bytes.data() + size_at);
    const std::size_t end = bytes.size() - envelope_checksum_bytes;
    base::store_little_endian(base::xxh3(std::span<const std::byte>(bytes).first(end)), bytes.data() + end);
}

/// Also writes the schema, the base's hash and the result's hash. Only applying the delta computes the last one: the
/// error names it last.
inline void seal_delta(Buffer& bytes, const State& from) {
    constexpr std::size_t schema_at = 20, base_at = 28, result_at = 36;
    if (bytes.size() < result_at + 8 + envelope_checksum_bytes) return;
    base::store_little_endian(from.layout().schema_hash(), bytes.data() + schema_at);
    base::store_little_endian(from.hash(), bytes.data() + base_at);
    seal_state(bytes);
    State to = from;
    const Status status = to.apply_delta(bytes);
    if (status) return;
    const std::string& sentence = status.error().message;
    const std::size_t found = sentence.rfind(" in the delta, 0x");
    if (sentence.find("hash of the result") == std::string::npos || found == std::string::npos) return;
    std::uint64_t hash = 0;
    std::from_chars(sentence.data() + found + 17, sentence.data() + sentence.size(), hash, 16);
    base::store_little_endian(hash, bytes.data() + result_at);
    seal_state(bytes);
}

/// Each change: u8 column; u8 row; u16 field; u8 how: 0 bytes of its size follow, 1 adds an i8, 2 a number of `edges`,
/// 3 the value in another row (u8). A column from 250 on: u8 table, u8 its new number of rows.
inline void edit_rows(Input& in, State& state) {
    static constexpr std::uint64_t edges[] = {0,
                                              1,
                                              0x7f,
                                              0xff,
                                              0x7fff,
                                              0x80000000,
                                              0x7fffffff,
                                              0xffffffff,
                                              0x40000000,
                                              1u << 30,
                                              0x1000000000,
                                              std::uint64_t{1} << 62,
                                              1ull << 63,
                                              ~1ull,
                                              ~std::uint64_t{},
                                              ~0ull >> 1};
    // A table that grows replaces the layout of the state.
    const std::shared_ptr<const StateLayout> kept = state.layout_shared();
    const StateLayout& layout = *kept;
    while (!in.empty()) {
        const std::uint8_t chosen = in.take_u8(), row = in.take_u8();
        if (chosen >= 250) {
            const TableId table{row % static_cast<std::uint32_t>(layout.tables().size())};
            state.resize(table, in.take_u8() % (state.rows_max(table) + 1));
            continue;
        }
        const std::uint32_t index = chosen % static_cast<std::uint32_t>(layout.columns().size());
        const ColumnInfo& column = layout.columns()[index];
        const LeafInfo& leaf = column.leaves[in.take<std::uint16_t>() % column.leaves.size()];
        const std::uint8_t how = in.take_u8() % 4, more = how == 0 ? std::uint8_t{} : in.take_u8();
        const std::span<std::byte> bytes = state.edit_bytes(index);
        const std::size_t rows = bytes.size() / column.row_size;
        if (rows == 0) continue;
        std::byte* const at = bytes.data() + row % rows * column.row_size + leaf.offset;
        std::uint64_t value = 0; // in the low bytes: the fuzzer's hosts are little-endian
        std::memcpy(&value, at, leaf.size);
        if (how == 0) std::ranges::copy(in.take_bytes(leaf.size), reinterpret_cast<std::byte*>(&value));
        if (how == 1) value += static_cast<std::uint64_t>(std::int64_t{static_cast<std::int8_t>(more)});
        if (how == 2) value = edges[more % std::size(edges)];
        if (how == 3)
            std::memcpy(&value, bytes.data() + more % rows * column.row_size + leaf.offset, leaf.size);
        std::memcpy(at, &value, leaf.size);
    }
}

inline StateInput read_state_input(std::span<const std::byte> data) {
    Input in(data);
    const std::uint8_t first = in.take_u8();
    StateInput out{(first & 3u) % base_count, (first & 4u) != 0, {}};
    const Base& from = base_of(out.base);
    switch (first >> 3 & 3u) {
    case 0: {
        const std::span<const std::byte> rest = in.take_rest();
        out.bytes.assign(rest.begin(), rest.end());
        break;
    }
    case 1:
        out.bytes = out.is_delta ? from.delta : from.portable;
        while (!in.empty()) splice(in, out.bytes);
        break;
    default: {
        State state = out.is_delta ? from.after.state() : from.now.state();
        edit_rows(in, state);
        out.bytes = out.is_delta ? state.save_delta(from.now.state()) : state.save_portable();
    }
    }
    if (out.is_delta)
        seal_delta(out.bytes, from.now.state());
    else
        seal_state(out.bytes);
    return out;
}

/// The loader. A test may use another one to plant a fault.
struct WorldLoader {
    Status operator()(World& world, const StateInput& input) const {
        return input.is_delta ? world.restore_delta(base_of(input.base).image, input.bytes)
                              : world.restore_portable(input.bytes);
    }
};

/// Calls the queries of a world that a game may call.
inline void ask_everything(const World& w) {
    (void)w.kinetic_energy();
    for (std::uint32_t i = 0; i < w.joint_count(); ++i) (void)w.joint_state(w.joint_at(i));
    for (std::uint32_t i = 0; i < w.vehicle_count(); ++i) (void)w.vehicle_state(w.vehicle_at(i));
    for (std::uint32_t i = 0; i < w.character_count(); ++i) (void)w.character_state(w.character_at(i));
    for (const BodyId body : w.bodies()) {
        (void)w.pose(body), (void)w.linear_velocity(body), (void)w.mass(body), (void)w.joints(body);
        for (const ShapeId shape : w.shapes(body)) (void)w.shape(shape);
    }
    (void)w.cast_ray({{Real{}, Real(20), Real{}}, {Real(4), Real(-40), Real(1)}});
    (void)State::diff(w.state(), base_of(0).now.state(), 4);
}

/// Worlds of a base, made once because that takes longer than all checks. Data that an input leaves in their scratch
/// memory must not affect a later input.
struct Subjects {
    World w, twin, again;
    explicit Subjects(const Base& from)
        : w(from.before.clone()), twin(from.before.clone()), again(from.before.clone()) {}
};
inline Subjects& subjects_of(std::size_t base) {
    static std::array<Subjects, base_count> all{Subjects(base_of(0)), Subjects(base_of(1)),
                                                Subjects(base_of(2))};
    return all[base];
}

/// Checks two copies of a world that was accepted: they tick to equal states with different data in their scratch
/// memory, and the result is accepted when it is loaded again.
inline std::string check_ticks(Subjects& subjects) {
    auto& [w, twin, again] = subjects;
    using Leftover = testing::Leftover;
    for (const Leftover what : {Leftover::scratch, Leftover::trees, Leftover::pairs})
        testing::disturb(twin, what, 17);
    for (int tick = 0; tick < 3; ++tick) {
        w.tick(), twin.tick();
        if (w.hash() != twin.hash()) return "two copies part: " + lockstone::test::scene::difference(w, twin);
        ask_everything(w);
        if (tick > 0) continue;
        for (const BodyId body : w.bodies()) (void)w.wake_body(body), (void)twin.wake_body(body);
    }
    if (const Status status = again.restore_portable(w.save_portable()); !status)
        return "what it ticks to is refused: " + status.error().message;
    for (const BodyId body : w.bodies())
        if (w.is_alive(body) && !w.destroy(body)) return "a body cannot be destroyed";
    w.tick();
    return w.body_count() == 0 ? "" : "bodies are left when all are destroyed";
}

/// Returns an error sentence about loading, or an empty string. Sets `loaded` if the world accepted the bytes.
template <class Loader = WorldLoader>
std::string check_state_load(const StateInput& input, bool& loaded, Loader&& load = {}) {
    const Base& from = base_of(input.base);
    Subjects& subjects = subjects_of(input.base);
    auto& [w, twin, again] = subjects;
    for (World* world : {&w, &twin, &again}) world->restore(from.image_before);
    const Status status = load(w, input);
    loaded = status.ok();
    if (!loaded) {
        if (status.error().message.size() < 20) return "an error does not say what is wrong";
        return w.hash() == from.before.hash() && w.save_portable() == from.before.save_portable()
                   ? ""
                   : "refused, but changed";
    }
    const Buffer image = w.save_portable();
    if (!input.is_delta && image != input.bytes) return "taken, but the world holds something else";
    if (const Status versions = w.state().verify_versions(); !versions) return versions.error().message;
    if (const Status taken = twin.restore_portable(image); !taken)
        return "what was taken is refused when it was saved: " + taken.error().message;
    if (twin.hash() != w.hash()) return "saved and loaded it has another hash";
    if (std::string fault = play_in_sessions(w, again, input.base, base::xxh3(image)); !fault.empty())
        return fault;
    return check_ticks(subjects);
}

inline std::string check_state_load(std::span<const std::byte> data, bool& loaded) {
    return check_state_load(read_state_input(data), loaded);
}

} // namespace fuzz
