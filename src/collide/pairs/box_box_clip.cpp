// Face against face: clips the incident face, a parallelogram, by the four sides of the reference face, then
// reduces the result to four points.
//
// source: Sutherland, Hodgman, Reentrant Polygon Clipping, CACM 1974; the reduction follows Visvalingam,
// Whyatt, Line Generalisation by Repeated Elimination of Points, 1993.
#include "collide/pairs/box_box.h"

namespace lockstone::collide {
namespace {

constexpr int face_points_max = 12; // a parallelogram cut by four lines has 8; the rest is room for roundings

/// Corners outside of a side by at most this are kept: for nearly equal faces the position of cuts would be
/// arbitrary.
constexpr std::int64_t box_slack_30 = std::int64_t{1} << 14; // 15 um

/// The incident box in the frame of the reference box.
struct Clip {
    Long3 half, incident_half; // 24 fraction bits
    Long3 center_54;           // of the incident box
    Long3 axes[3];             // of the incident box, 30
    int axis, p, q;            // the reference face's normal axis, and the two in the face
    std::int64_t sign;         // the outward normal is sign * axis
    int incident_axis, u, v;   // the same axes of the incident face
};

Clip set_up(const BoxPair& g, bool reference_is_b, int axis) {
    Clip c;
    c.half = reference_is_b ? g.b : g.a;
    c.incident_half = reference_is_b ? g.a : g.b;
    c.axis = axis;
    c.p = (axis + 1) % 3;
    c.q = (axis + 2) % 3;
    if (reference_is_b) {
        c.center_54 = {-dot(g.t, g.r[0]), -dot(g.t, g.r[1]), -dot(g.t, g.r[2])};
        for (int i = 0; i < 3; ++i) c.axes[i] = {g.r[0][i], g.r[1][i], g.r[2][i]};
        c.sign = c.center_54[axis] > 0
                     ? 1
                     : -1; // for equal centres the normal from A to B is +r, so B's face normal is -r
    } else {
        c.center_54 = up(g.t, 30);
        for (int j = 0; j < 3; ++j) c.axes[j] = g.r[j];
        c.sign = sign_of(g.t[axis]);
    }
    c.incident_axis = 0;
    for (int j = 1; j < 3; ++j)
        if (absolute(c.axes[j][axis]) > absolute(c.axes[c.incident_axis][axis])) c.incident_axis = j;
    c.u = (c.incident_axis + 1) % 3;
    c.v = (c.incident_axis + 2) % 3;
    return c;
}

/// The incident face's corners in cyclic order: (+u +v), (-u +v), (-u -v), (+u -v). Edge k runs from corner k to k + 1.
constexpr bool corner_u[4] = {true, false, false, true};
constexpr bool corner_v[4] = {true, true, false, false};

/// The normal of the incident face is opposed to that of the reference face.
bool incident_positive(const Clip& c) { return c.sign * c.axes[c.incident_axis][c.axis] < 0; }

void incident_corners(const Clip& c, ClipPoint* out) {
    const int g = c.incident_axis;
    const Long3 face =
        c.center_54 + c.axes[g] * (incident_positive(c) ? c.incident_half[g] : -c.incident_half[g]);
    const Long3 along_u = c.axes[c.u] * c.incident_half[c.u], along_v = c.axes[c.v] * c.incident_half[c.v];
    for (int k = 0; k < 4; ++k) {
        const Long3 half_way = corner_u[k] ? face + along_u : face - along_u;
        const Long3 x = shifted(corner_v[k] ? half_way + along_v : half_way - along_v, 24);
        out[k] = {x[c.p], x[c.q], c.sign * x[c.axis] - up(c.half[c.axis], 6),
                  static_cast<std::uint8_t>((k + 3) % 4), static_cast<std::uint8_t>(k)};
    }
}

/// a + (b - a) part / 2^bits.
ClipPoint between(const ClipPoint& a, const ClipPoint& b, std::int64_t part, int bits) {
    const auto mix = [&](std::int64_t x, std::int64_t y) {
        return x + shift_right_rounded((y - x) * part, bits);
    };
    return {mix(a.p, b.p), mix(a.q, b.q), mix(a.height, b.height), 0, 0};
}

struct CutFace {
    ClipPoint points[face_points_max];
    int count;
};

/// Keeps the part where inside(x) = limit - sign * x.*coordinate >= 0; `line` is the number of the side.
void clip_side(CutFace& polygon, std::int64_t ClipPoint::*coordinate, std::int64_t sign, std::int64_t limit,
               std::uint8_t line, int part_bits) {
    std::int64_t inside[face_points_max], least = 0;
    const int count = polygon.count;
    for (int k = 0; k < count; ++k) {
        inside[k] = limit - sign * polygon.points[k].*coordinate;
        least = smaller(least, inside[k]);
    }
    if (least >= -box_slack_30) return;
    ClipPoint whole[face_points_max];
    for (int k = 0; k < count; ++k) whole[k] = polygon.points[k];
    ClipPoint* out = polygon.points;
    int n = 0;
    for (int k = 0; k < count && n < face_points_max; ++k) {
        const int next = k + 1 == count ? 0 : k + 1;
        const ClipPoint &a = whole[k], &b = whole[next];
        const bool a_stays = inside[k] >= -box_slack_30, b_stays = inside[next] >= -box_slack_30;
        if (a_stays) out[n++] = a;
        if (a_stays == b_stays || n == face_points_max) continue;
        if (inside[a_stays ? k : next] <= 0) continue; // the corner that stays is on the side
        const std::int64_t part = up(inside[k], part_bits) / (inside[k] - inside[next]);
        ClipPoint cut = between(a, b, part, part_bits);
        cut.*coordinate = sign * limit;
        cut.line_in = a_stays ? a.line_out : line;
        cut.line_out = a_stays ? line : a.line_out;
        out[n++] = cut;
    }
    polygon.count = n;
}

/// Number of fraction bits for a position along an edge, so that products fit: 24 for the largest boxes, 30 for
/// small ones.
int part_bits_for(const Clip& c) {
    std::int64_t reach = absolute(c.center_54[c.p] >> 24) + absolute(c.center_54[c.q] >> 24) +
                         absolute(c.center_54[c.axis] >> 24);
    for (int i = 0; i < 3; ++i) reach += up(2 * c.incident_half[i] + c.half[i], 6);
    const int bits = 62 - bit_length(static_cast<std::uint64_t>(reach));
    return bits < 24 ? 24 : bits > 30 ? 30 : bits;
}

void clip_polygon(const Clip& c, CutFace& polygon) {
    const int bits = part_bits_for(c);
    const std::int64_t limit_p = up(c.half[c.p], 6), limit_q = up(c.half[c.q], 6);
    clip_side(polygon, &ClipPoint::p, 1, limit_p, 4, bits);
    clip_side(polygon, &ClipPoint::p, -1, limit_p, 5, bits);
    clip_side(polygon, &ClipPoint::q, 1, limit_q, 6, bits);
    clip_side(polygon, &ClipPoint::q, -1, limit_q, 7, bits);
}

/// Computes the name of a polygon corner from the corners and edges of the boxes whose lines meet there.
struct Names {
    const Clip& c;
    bool reference_is_b;

    std::uint32_t incident_corner(int k) const {
        return bit(incident_positive(c), c.incident_axis) | bit(corner_u[k], c.u) | bit(corner_v[k], c.v);
    }
    /// Sides 4..7 are +p, -p, +q, -q.
    std::uint32_t side_bit(int line) const { return line < 6 ? bit(line == 4, c.p) : bit(line == 6, c.q); }
    std::uint32_t face_bit() const { return bit(c.sign > 0, c.axis); }

    std::uint32_t operator()(const ClipPoint& x) const {
        const int low = x.line_in < x.line_out ? x.line_in : x.line_out;
        const int high = x.line_in < x.line_out ? x.line_out : x.line_in;
        if (high < 4) { // two incident edges k - 1 and k: corner k
            const std::uint32_t corner = incident_corner(x.line_out);
            return reference_is_b ? corner_feature_a(corner) : corner_feature_b(corner);
        }
        if (low >= 4) {
            const std::uint32_t corner = face_bit() | side_bit(low) | side_bit(high);
            return reference_is_b ? corner_feature_b(corner) : corner_feature_a(corner);
        }
        const std::uint32_t incident = edge_id(low % 2 == 0 ? c.u : c.v, incident_corner(low));
        const std::uint32_t reference = edge_id(high < 6 ? c.q : c.p, face_bit() | side_bit(high));
        return reference_is_b ? edge_feature(incident, reference) : edge_feature(reference, incident);
    }

  private:
    static std::uint32_t bit(bool positive, int at) { return positive ? 1u << at : 0u; }
};

} // namespace

int reduce_points(ClipPoint* points, int count) {
    if (count <= 4) return count;
    constexpr std::int64_t noise_30 = 1 << 17; // 0.12 mm
    std::int64_t low = points[0].height;
    for (int k = 1; k < count; ++k)
        if (points[k].height < low) low = points[k].height;
    low += noise_30;
    int low_left = 0;
    for (int k = 0; k < count; ++k) low_left += points[k].height <= low ? 1 : 0;
    const auto must_stay = [&](int k) { return low_left == 1 && points[k].height <= low; };

    // Twice the area that corner k cuts off. Coordinates have 20 fraction bits, so that products fit.
    const auto cut = [&](int k) {
        const ClipPoint &a = points[k == 0 ? count - 1 : k - 1], &b = points[k],
                        &c = points[k + 1 == count ? 0 : k + 1];
        const auto way = [](std::int64_t from, std::int64_t to) { return (to >> 10) - (from >> 10); };
        return absolute(way(a.p, b.p) * way(a.q, c.q) - way(a.q, b.q) * way(a.p, c.p));
    };
    for (; count > 4; --count) {
        int least = must_stay(0) ? 1 : 0;
        std::int64_t least_cut = cut(least);
        for (int k = least + 1; k < count; ++k) {
            if (must_stay(k)) continue;
            if (const std::int64_t x = cut(k); x < least_cut - (least_cut >> 4)) least = k, least_cut = x;
        }
        if (points[least].height <= low) --low_left;
        for (int k = least + 1; k < count; ++k) points[k - 1] = points[k];
    }
    return count;
}

void clip_faces(const BoxPair& g, bool reference_is_b, int axis, Length margin, Manifold& out) {
    const Clip c = set_up(g, reference_is_b, axis);
    CutFace polygon;
    incident_corners(c, polygon.points);
    polygon.count = 4;
    clip_polygon(c, polygon);
    int count = 0;
    for (int k = 0; k < polygon.count; ++k)
        if (polygon.points[k].height <= up(margin.raw, 6)) polygon.points[count++] = polygon.points[k];
    count = reduce_points(polygon.points, count);

    Long3 normal{};
    normal[axis] = c.sign << 30;
    out.normal = unit_of_30(reference_is_b ? -(g.r[axis] * c.sign) : normal);
    out.on_face = 1;
    const Names name{c, reference_is_b};
    for (int k = 0; k < count; ++k) {
        const ClipPoint& x = polygon.points[k];
        Long3 at{};
        at[c.p] = x.p;
        at[c.q] = x.q;
        at[axis] = c.sign * (up(c.half[axis], 6) + (x.height >> 1));
        if (reference_is_b) {
            const Long3 b = shifted(at, 6);
            at = shifted(up(g.t, 30) + g.r[0] * b[0] + g.r[1] * b[1] + g.r[2] * b[2], 24);
        }
        add_point(out, at, x.height, margin, name(x));
    }
}

} // namespace lockstone::collide
