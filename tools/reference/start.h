// Converts a lockstone::World to the bodies of the thesis' engine. Only this file uses both.
#pragma once

#include "reference/reference.h"

#include "lockstone/math/convert.h"

namespace reference {

inline Vec vec(lockstone::Vec3 v) {
    return {lockstone::to_double(v.x), lockstone::to_double(v.y), lockstone::to_double(v.z)};
}
inline Turn turn(lockstone::Quat q) {
    const auto d = lockstone::to_double(q);
    return {d[0], d[1], d[2], d[3]};
}
inline Pose pose(const lockstone::Transform& t) { return {vec(t.position), turn(t.rotation)}; }

Vec operator+(const Vec& a, const Vec& b);
Vec operator-(const Vec& a, const Vec& b);
Vec operator*(const Vec& a, double s);
double dot(const Vec& a, const Vec& b);
Vec cross(const Vec& a, const Vec& b);
Turn operator*(const Turn& a, const Turn& b);
Turn conjugate(const Turn& q);
Vec rotate(const Turn& q, const Vec& v);

struct StartedBody {
    lockstone::BodyId id;
    BodyStart start;
    Vec local_center; ///< centre of mass in the body's axes [m]
    std::vector<lockstone::ShapeDef> shapes;
};

/// The content of a world in the terms of the thesis' engine.
struct Start {
    std::vector<StartedBody> bodies;
    std::vector<Field> fields;
};
lockstone::Result<Start> read_start(const lockstone::World& world);

} // namespace reference
