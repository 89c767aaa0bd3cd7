#version 330 core
// A line as a rectangle of constant width on the picture. Four corners per instance; no vertex buffer.

layout(location = 0) in vec4 from_width;
layout(location = 1) in vec4 to;
layout(location = 2) in vec4 colour;

uniform mat4 view_projection;
uniform vec2 viewport;  // [px]

flat out vec4 ends;  // both ends [px]
flat out float half_width;
flat out vec4 marker_colour;
out vec2 here;  // [px]

const float near = 0.02;  // smallest w, before the near plane

// The part of a towards b that lies before the eye.
vec4 clip_to_near(vec4 a, vec4 b) { return a.w >= near ? a : mix(a, b, (near - a.w) / (b.w - a.w)); }

void main() {
    vec4 a = view_projection * vec4(from_width.xyz, 1.0);
    vec4 b = view_projection * vec4(to.xyz, 1.0);
    if (a.w < near && b.w < near) {
        gl_Position = vec4(2.0, 2.0, 2.0, 1.0);  // behind the eye: outside the picture
        return;
    }
    vec4 a_seen = clip_to_near(a, b), b_seen = clip_to_near(b, a);
    vec2 a_px = (0.5 + 0.5 * a_seen.xy / a_seen.w) * viewport;
    vec2 b_px = (0.5 + 0.5 * b_seen.xy / b_seen.w) * viewport;
    vec2 way = b_px - a_px;
    vec2 along = dot(way, way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);

    bool at_end = gl_VertexID >= 2;
    half_width = 0.5 * from_width.w;
    float reach = half_width + 1.0;  // one more pixel for the soft edge
    here = (at_end ? b_px + along * reach : a_px - along * reach) + across * (gl_VertexID % 2 == 0 ? -reach : reach);
    ends = vec4(a_px, b_px);
    marker_colour = colour;
    vec4 seen = at_end ? b_seen : a_seen;
    // Already divided by w, so `here` and depth are linear on the picture. The bias lets a marker on a surface win.
    gl_Position = vec4(2.0 * here / viewport - 1.0, seen.z / seen.w - 2e-5, 1.0);
}
