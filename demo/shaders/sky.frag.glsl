#version 330 core
#include "sky.glsl"

uniform mat4 from_clip;

in vec2 clip_position;
out vec4 pixel;

void main() {
    // A point half way into the depth range: the far plane itself would lose precision.
    vec4 world = from_clip * vec4(clip_position, 0.5, 1.0);
    vec3 direction = normalize(world.xyz / world.w - eye);
    pixel = vec4(to_pixel(sky_radiance(direction)), 1.0);
}
