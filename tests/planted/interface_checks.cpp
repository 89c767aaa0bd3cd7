// Wrong arguments, files and games at the interface: images of other columns, starts that differ, headers that the
// format forbids.
#include "checks.h"
#include "lockstone/math/random.h"
#include "lockstone/prove.h"
#include "lockstone/testing.h"
#include "model/contact_rows.h"
#include "model/manifest.h"
#include "support/mode_reader.h"
#include "support/rigs/moving_state.h"
#include "support/small_recording.h"

#include <map>
#include <stdexcept>

namespace planted {

namespace {

struct Points {
    std::int32_t points;
};
template <class V> constexpr void describe(Points& p, V&& v) { v("points", p.points); }
/// A row with the size of Points.
struct Goals {
    std::int32_t goals;
};
template <class V> constexpr void describe(Goals& g, V&& v) { v("goals", g.goals); }

std::string other_fields_refused() {
    GameSchema points, goals;
    points.add_record<Points>("game.score"), goals.add_record<Goals>("game.score");
    const World here = scene::made(World::create({}, points));
    Image image;
    scene::made(World::create({}, goals)).save(image);
    return here.can_restore(image).ok() ? "an image with other fields is accepted" : "";
}

/// A game whose starts have different gravity.
struct RestlessGame : SmallGame {
    mutable int starts = 0;
    Result<World> start() const override {
        Result<World> world = SmallGame::start();
        if (world) scene::done(world->set_gravity({Real(starts++), Real{}, Real{}}));
        return world;
    }
};

std::string starts_compared() {
    const Proof proof = scene::made(prove(RestlessGame(), {.ticks = 4, .bits_max = 10}));
    return proof.holds() ? "a game whose starts differ passes" : "";
}

std::string modes_told_apart() {
    for (const ReadsMode reads : {ReadsMode::instruction_set, ReadsMode::workers, ReadsMode::load})
        if (prove(ModeReader(reads), {.ticks = 5}).holds())
            return "a result that depends on the mode passes, kind " +
                   std::to_string(static_cast<int>(reads));
    return {};
}

std::string wrong_hash_found() {
    if (const Status same = self_test(); !same) return same.error().message;
    const std::vector<std::uint64_t> right = scene::made(testing::self_test_hashes());
    for (const std::size_t place : {std::size_t{0}, right.size() / 2, right.size() - 1}) {
        std::vector<std::uint64_t> hashes = right;
        hashes[place] ^= 1;
        if (testing::self_test_against(hashes).ok())
            return "wrong hash " + std::to_string(place) + " is accepted";
    }
    return {};
}

std::string zero_streams() {
    return lockstone::Random{}.split(3) == lockstone::Random::seeded(0).split(3)
               ? ""
               : "streams of a zero generator are not those of seed 0";
}

replay::Header header(replay::Mode mode) {
    replay::Header h =
        must(read(mode == replay::Mode::commands ? record_commands(4) : record_inputs(4))).header();
    return h;
}

/// A sleeping heap's own state is accepted; each of its damaged copies is refused.
std::string broken_states_refused() {
    using M = sim::Manifest;
    const World world = lockstone::test::MovingState::make().w.clone();
    const M m = sim::make_manifest(world.def(), {});
    const auto takes = [&](const auto& damage) {
        World w = world.clone();
        State state = w.state();
        damage(state);
        return w.restore_portable(state.save_portable()).ok();
    };
    const auto add_row = [&](State& s, std::uint32_t flags) {
        sim::ContactList list;
        sim::read_contacts(s, m.sleeping_contacts, list);
        list.keys.insert(list.keys.begin(), list.keys.at(0));
        list.memories.insert(list.memories.begin(), list.memories[0]);
        list.memories[1].flags = (list.memories[1].flags & ~std::uint32_t{solve::contact_touching}) ^ flags;
        sim::write_contacts(s, m.sleeping_contacts, list);
    };
    if (!takes([](State&) {}) || !takes([&](State& s) { add_row(s, 0); })) return "a good state is refused";
    if (takes([&](State& s) { add_row(s, solve::contact_touching); })) return "a second row touches";
    if (takes([&](State& s) { add_row(s, solve::contact_passing); })) return "rows of a pair differ";
    if (takes([&](State& s) {
            s.edit_row(m.body_traits.row, s.rows(m.body_info)[1].traits).mass.gyration.x = Real::from_raw(2);
        }))
        return "a body may turn about a point";
    if (takes([&](State& s) {
            std::map<std::uint32_t, std::vector<std::uint32_t>> rings; // slots by island
            for (std::uint32_t i = 0; i < s.count(m.bodies); ++i)
                if (const sim::BodySleep& b = s.rows(m.body_sleep)[i]; b.next != 0)
                    rings[b.island].push_back(s.rows(m.body_info)[i].id.index);
            for (auto& [island, slots] : rings) {
                if (slots.size() < 3) continue;
                std::ranges::sort(slots);
                s.edit_row(m.body_sleep, s.rows(m.body_slot)[slots[0] - 1].row).next = slots[2];
                return;
            }
            throw std::runtime_error("no ring of three");
        }))
        return "two members of a ring lead to one";
    return {};
}

std::string forbidden_headers() {
    replay::Header commands = header(replay::Mode::commands);
    if (!find_fault(commands).empty()) return "a right header is refused: " + find_fault(commands);
    commands.content_id = 1;
    if (find_fault(commands).empty()) return "a recording of commands has a content id";
    replay::Header inputs = header(replay::Mode::inputs);
    inputs.game = "a\xc2\x9b[2J";
    return find_fault(inputs).empty() ? "the name of a game holds U+009B" : "";
}

std::string forbidden_assets() {
    const LengthVec3 corners[] = {{}, {Length(1), {}, {}}, {{}, Length(1), {}}, {{}, {}, Length(1)}};
    const AssetBytes hull = scene::made(bake_hull(corners));
    for (const bool commands : {true, false}) {
        std::vector<Chunk> chunks = chunks_of(commands ? record_commands(4) : record_inputs(4));
        const auto place =
            chunks.begin() + static_cast<std::ptrdiff_t>(find_chunk(chunks, replay::chunk_world_def)) + 1;
        chunks.insert(place, {replay::chunk_asset, 0, Bytes(hull.begin(), hull.end())});
        if (read(file_of(chunks, true)).ok() != commands)
            return commands ? "an asset in a recording of commands is refused"
                            : "a recording of inputs has an asset";
    }
    return {};
}

/// A set of two hulls with a damaged second hull, and a recording that has a set as an asset.
std::string sets_added_whole() {
    const LengthVec3 corners[] = {{}, {Length(1), {}, {}}, {{}, Length(1), {}}, {{}, {}, Length(1)}};
    const LengthVec3 larger[] = {{}, {Length(2), {}, {}}, {{}, Length(1), {}}, {{}, {}, Length(1)}};
    const AssetBytes both[] = {scene::made(bake_hull(corners)), scene::made(bake_hull(larger))};
    AssetBytes set = encode_assets(both);
    AssetLibrary library;
    set.back() ^= std::byte{1};
    if (library.add(set).ok() || !library.ids().empty()) return "a damaged set leaves an asset behind";
    set.back() ^= std::byte{1};
    if (!library.add(set).ok() || library.ids().size() != 2) return "a set is refused";
    std::vector<Chunk> chunks = chunks_of(record_commands(4));
    const auto place =
        chunks.begin() + static_cast<std::ptrdiff_t>(find_chunk(chunks, replay::chunk_world_def)) + 1;
    chunks.insert(place, {replay::chunk_asset, 0, Bytes(set.begin(), set.end())});
    return read(file_of(chunks, true)).ok() ? "a recording has a set of assets as one asset" : "";
}

} // namespace

Checks interface_checks() {
    return {{"images of other fields are refused", other_fields_refused},
            {"broken states are refused", broken_states_refused},
            {"starts are compared", starts_compared},
            {"modes are told apart", modes_told_apart},
            {"the self test finds a wrong hash", wrong_hash_found},
            {"a zero generator has the streams of seed 0", zero_streams},
            {"headers that the format forbids are refused", forbidden_headers},
            {"sets of assets are added whole", sets_added_whole},
            {"assets in recordings of inputs are refused", forbidden_assets}};
}

} // namespace planted
