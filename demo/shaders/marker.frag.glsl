#version 330 core

flat in vec4 ends;
flat in float half_width;
flat in vec4 marker_colour;
in vec2 here;

uniform float opacity;

out vec4 pixel;

void main() {
    vec2 way = ends.zw - ends.xy;
    float t = clamp(dot(here - ends.xy, way) / max(dot(way, way), 1e-6), 0.0, 1.0);
    float distance = length(here - ends.xy - t * way);
    float cover = clamp(half_width + 0.5 - distance, 0.0, 1.0);
    pixel = vec4(marker_colour.rgb, marker_colour.a * opacity * cover);
}
