// Where an instance's vertex is. See Vertex in mesh.h for the rule.

layout(location = 0) in vec3 anchor;
layout(location = 1) in vec3 offset;
layout(location = 2) in vec3 normal;
layout(location = 3) in vec2 uv;
layout(location = 4) in mat4 pose;
layout(location = 8) in vec4 scale_radius;
layout(location = 9) in vec4 colour_highlight;

vec3 shape_position() { return anchor * scale_radius.xyz + offset * scale_radius.w; }

vec3 shape_normal() {
    if (dot(offset, offset) > 0.0) return offset;
    return normalize(normal / max(scale_radius.xyz, vec3(1e-6)));
}
