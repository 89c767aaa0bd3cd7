// The impulses that a manifold takes over from the previous tick's manifolds, for points at all distances.
#include "solve/contacts/contact_memory.h"
#include "lockstone/math/convert.h"

#include <doctest/doctest.h>

#include <array>

using namespace lockstone;
using namespace lockstone::solve;

namespace {

ContactMemory one_point(double x, double y, double z, std::uint32_t feature, std::int32_t impulse) {
    ContactMemory m{};
    m.count = 1;
    m.normal = {Unit{}, unit_one, Unit{}};
    m.points[0].position = {quantize<Length>(x), quantize<Length>(y), quantize<Length>(z)};
    m.points[0].feature = feature;
    m.points[0].normal = Speed(impulse);
    return m;
}

/// Returns the impulse that a fresh point takes from an old one of another feature.
Speed taken_from(const ContactMemory& old, ContactMemory fresh) {
    Taken taken;
    carry_impulses(std::span(&old, 1), taken, fresh);
    return fresh.points[0].normal;
}

} // namespace

namespace {

/// Counts the pairs of points this far apart, along one axis, two and three, where `judge` takes over an impulse.
template <class Judge> int taken_from_afar(double apart, Judge&& judge) {
    const double half = apart / 2;
    int taken = 0;
    for (const auto& [y, z] : {std::pair(0.0, 0.0), {half, 0.0}, {half, half}})
        taken += judge(one_point(half, -y, z, 1, 5), one_point(-half, y, -z, 2, 0)) != Speed(0);
    return taken;
}
constexpr double far_apart[] = {0.03, 1.0, 64.0, 100.0, 180.0, 182.0, 200.0, 255.9};

} // namespace

TEST_CASE("a contact point takes the impulse of another feature only within 2 cm even at distances of up to "
          "443 m") {
    CHECK(taken_from(one_point(1, 2, 3, 1, 5), one_point(1.01, 2, 3, 2, 0)) == Speed(5));
    for (const double apart : far_apart) {
        INFO(apart, " m apart");
        CHECK(taken_from_afar(apart, taken_from) == 0);
    }
}

TEST_CASE("planted fault: 64-bit squares of distances take impulses from far points") {
    const auto wrapped = [](const ContactMemory& old, const ContactMemory& fresh) {
        std::uint64_t square = 0;
        for (int i = 0; i < 3; ++i) {
            const auto d = static_cast<std::uint64_t>(std::int64_t{old.points[0].position[i].raw} -
                                                      fresh.points[0].position[i].raw);
            square += d * d;
        }
        const auto most = static_cast<std::int64_t>(quantize<Length>(0.02).raw);
        return static_cast<std::int64_t>(square) <= most * most ? old.points[0].normal : Speed(0);
    };
    int taken = 0;
    for (const double apart : far_apart) taken += taken_from_afar(apart, wrapped);
    CHECK(taken > 0);
}
