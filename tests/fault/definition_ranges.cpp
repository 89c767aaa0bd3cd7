// Every range that a definition describes is enforced: a value beyond it is refused with a sentence that begins with
// the field, and a value at its end is accepted.
#include "support/sim_scenes.h"

#include "lockstone/play/character.h"

#include <doctest/doctest.h>

#include <functional>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

enum class Spot { below, lowest, highest, above };

/// Sets field `number`, counted among those with a range, to a spot of its range. Stores the field's name in `path`.
class Place {
  public:
    Place(std::size_t number, Spot where) : left(number), spot(where) {}

    std::string path;    ///< empty: no such field
    bool placed = false; ///< false if the type cannot hold that value

    template <class F> void operator()(const char* name, F& value, OwnRanges = {}) {
        if constexpr (!Leaf<F>) {
            const std::string outside = prefix;
            prefix += std::string(name) + ".";
            describe(value, *this);
            prefix = outside;
        }
    }
    template <class T, std::size_t N, class R = OwnRanges>
    void operator()(const char* name, std::array<T, N>& values, const R& range = {}) {
        (*this)(name, values, First<R>{N, range});
    }
    template <class T, std::size_t N, class R>
    void operator()(const char* name, std::array<T, N>& values, const First<R>& range) {
        for (std::size_t i = 0; i < std::min<std::size_t>(N, range.count); ++i)
            (*this)((std::string(name) + "[" + std::to_string(i) + "]").c_str(), values[i], range.range);
    }
    template <class F>
    requires std::is_enum_v<F> || std::is_integral_v<F>
    void operator()(const char* name, F& value, const In<std::int64_t>& range) {
        if (!is_it(name)) return;
        const auto number = pick<std::int64_t>(range.low, range.high, 1);
        placed = static_cast<std::int64_t>(static_cast<F>(number)) == number;
        if (placed) value = static_cast<F>(number);
    }
    void operator()(const char* name, Real& value, const In<Real>& range) {
        if (is_it(name)) put(value, range.low, range.high);
    }
    void operator()(const char* name, Real& value, const Below& range) {
        if (is_it(name)) put(value, Real{}, range.end - Real::step());
    }
    void operator()(const char* name, Real& value, const EitherSign& range) {
        if (is_it(name)) put(value, range.low, range.high);
    }
    void operator()(const char* name, std::uint32_t& value, const BitsOf& bits) {
        if (is_it(name) && spot != Spot::below) value = pick(0u, bits.all, 1u), placed = true;
    }
    void operator()(const char* name, Vec3& value, const EachIn& range) {
        if (is_it(name)) put(value.z, -range.most, range.most);
    }
    void operator()(const char* name, Vec3& value, const LongAtMost& range) {
        if (is_it(name)) value = {}, put(value.y, -range.most, range.most);
    }
    void operator()(const char* name, Transform& value, const PoseIn& range) {
        if (is_it(name)) put(value.position.y, -range.most, range.most);
    }
    void operator()(const char* name, UnitVec3& value, UnitLong) {
        if (is_it(name) && spot != Spot::below)
            value = {Unit{}, spot == Spot::above ? Unit::from_raw((1 << 21) - unit_one.raw) : -unit_one,
                     Unit{}},
            placed = true;
    }

  private:
    bool is_it(const char* name) {
        if (left-- != 0) return false;
        path = prefix + name;
        return true;
    }
    template <class T> T pick(T low, T high, T step) const {
        return spot == Spot::below    ? low - step
               : spot == Spot::lowest ? low
               : spot == Spot::above  ? high + step
                                      : high;
    }
    void put(Real& value, Real low, Real high) {
        value = pick(low, high, Real::step() * (std::int32_t{1} << 12)); // lengths are exact to a few steps
        placed = true;
    }

    std::size_t left;
    Spot spot;
    std::string prefix;
};

struct Tally {
    std::size_t fields = 0;
    std::vector<std::string> faults;
};

/// Returns whether another field limits this one further: about y and z an axis turns within pi, and a body needs a
/// frame near it.
bool depends(const std::string& path) {
    if (path == "frame_a") return true;
    const bool swings = path.starts_with("axis[4].") || path.starts_with("axis[5].");
    return swings && (path.ends_with("lower") || path.ends_with("upper") || path.ends_with("target"));
}

/// A world's definition is no command, but its sentence begins like that of one.
struct CreateWorld {
    WorldDef def;
    friend const char* name_of(const CreateWorld&) { return "world"; }
};

/// Tries a copy of the valid definition for each field with a range and each spot of it. `sentence` returns the error
/// sentence for a command, or an empty string.
template <class Def, class Sentence, class Make>
void try_ranges(const Def& good, const Sentence& sentence, Make&& command_of, Tally& tally) {
    if (const std::string all = sentence(command_of(good)); !all.empty())
        tally.faults.push_back("a good one is refused: " + all);
    for (std::size_t number = 0;; ++number)
        for (const Spot spot : {Spot::below, Spot::lowest, Spot::highest, Spot::above}) {
            Def def = good;
            Place place(number, spot);
            describe(def, place);
            if (place.path.empty()) return;
            if (spot == Spot::below) ++tally.fields;
            if (!place.placed) continue;
            const auto command = command_of(def);
            const std::string said = sentence(command);
            const bool names = said.starts_with(std::string(name_of(command)) + ": " + place.path);
            const bool beyond = spot == Spot::below || spot == Spot::above;
            if (beyond && !names)
                tally.faults.push_back(place.path + " beyond its range: " + (said.empty() ? "taken" : said));
            if (!beyond && names && said.find("must") != std::string::npos && !depends(place.path))
                tally.faults.push_back(place.path + " at its end: " + said);
        }
}

Tally try_all(const std::function<void(Command&)>& change = [](Command&) {}) {
    World world = made(World::create(small_def()));
    const BodyId ground = made(world.create_body({.kind = BodyKind::static_}));
    const BodyId chassis = made(world.create_body({}));
    Image start;
    world.save(start);
    const auto sentence = [&](const Command& command) {
        Command changed = command;
        change(changed);
        world.restore(start);
        const Result<World::Applied> applied = world.apply(changed);
        return applied ? std::string() : applied.error().message;
    };
    Tally tally;
    try_ranges(
        BodyDef{}, sentence, [](const BodyDef& d) -> Command { return CreateBody{d}; }, tally);
    try_ranges(
        ShapeDef{}, sentence,
        [&](const ShapeDef& d) -> Command {
            return CreateShape{chassis, d};
        },
        tally);
    try_ranges(
        water({}), sentence, [](const FieldDef& d) -> Command { return CreateField{d}; }, tally);
    try_ranges(
        ExplosionDef{}, sentence, [](const ExplosionDef& d) -> Command { return Explode{d}; }, tally);
    try_ranges(
        CharacterDef{}, sentence, [](const CharacterDef& d) -> Command { return CreateCharacter{d}; }, tally);
    JointDef joint = six_dof_joint();
    joint.body_b = chassis;
    try_ranges(
        joint, sentence, [](const JointDef& d) -> Command { return CreateJoint{d}; }, tally);
    joint.body_a = ground;
    joint.axis[about_z].frequency = 1_r;
    try_ranges(
        joint, sentence, [](const JointDef& d) -> Command { return CreateJoint{d}; }, tally);
    VehicleDef car = four_wheels(chassis, {1_r, 0_r, 2_r});
    try_ranges(
        car, sentence, [](const VehicleDef& d) -> Command { return CreateVehicle{d}; }, tally);
    const auto of_world = [](const CreateWorld& c) {
        const Result<World> made_of_it = World::create(c.def);
        return made_of_it ? std::string() : made_of_it.error().message;
    };
    try_ranges(
        small_def(), of_world, [](const WorldDef& d) { return CreateWorld{d}; }, tally);
    return tally;
}

} // namespace

TEST_CASE("the library enforces every range of every definition and its error names the field") {
    const Tally tally = try_all();
    for (const std::string& fault : tally.faults) FAIL_CHECK(fault);
    CHECK(tally.fields > 370);
}

TEST_CASE("planted: the check finds a range that is not enforced and an error about another field") {
    const Tally unchecked = try_all([](Command& command) {
        if (auto* vehicle = std::get_if<CreateVehicle>(&command)) vehicle->def->wheel[3].preload = {};
    });
    CHECK(unchecked.faults.size() == 2);
    const Tally misnamed = try_all([](Command& command) {
        if (auto* joint = std::get_if<CreateJoint>(&command))
            std::swap(joint->def->axis[along_x].friction, joint->def->axis[along_x].motor_force);
    });
    CHECK(misnamed.faults.size() == 8);
}
