// What a manifold takes over from those of the tick before, over the whole range of places.
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

/// The impulse that a fresh point takes from an old one of another feature.
Speed taken_from(const ContactMemory& old, ContactMemory fresh) {
    Taken taken;
    carry_impulses(std::span(&old, 1), taken, fresh);
    return fresh.points[0].normal;
}

} // namespace

TEST_CASE("a point takes the impulse of another feature within 2 cm, and of none farther, up to 443 m away") {
    CHECK(taken_from(one_point(1, 2, 3, 1, 5), one_point(1.01, 2, 3, 2, 0)) == Speed(5));
    for (const double apart : {0.03, 1.0, 64.0, 100.0, 180.0, 182.0, 200.0, 255.9}) {
        const double half = apart / 2;
        INFO(apart, " m apart");
        CHECK(taken_from(one_point(half, 0, 0, 1, 5), one_point(-half, 0, 0, 2, 0)) == Speed(0));
        CHECK(taken_from(one_point(0, -half, half, 1, 5), one_point(0, half, -half, 2, 0)) == Speed(0));
        CHECK(taken_from(one_point(half, -half, half, 1, 5), one_point(-half, half, -half, 2, 0)) ==
              Speed(0));
    }
}

TEST_CASE("planted fault: a square of 200 m in 64 bits would count as near") {
    const std::uint64_t d = std::uint64_t{200} << Length::fraction_bits;
    CHECK((static_cast<std::int64_t>(d * d) >> 4) < (std::int64_t{1} << 30)); // as contact_memory.cpp had it
}
