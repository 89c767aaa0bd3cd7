#version 330 core
#include "sky.glsl"
#include "shadow.glsl"

uniform vec3 material_colour;
uniform float material_roughness;
uniform float material_metalness;
uniform int material_pattern;
uniform sampler2D material_texture;

centroid in vec3 world_position;
centroid in vec3 world_normal;
centroid in vec3 local_position;
centroid in vec2 texture_uv;
flat in vec4 instance_colour;

out vec4 pixel;

// -1 or 1 by the sign of v, with an edge one pixel wide.
float soft_sign(float v) { return clamp(1.5 * v / max(fwidth(v), 1e-6), -1.0, 1.0); }

// The mean of a checkerboard of unit squares over a pixel, -1 .. 1.
// Source: Inigo Quilez, "Filtering procedural textures".
float checker(vec2 p) {
    vec2 w = max(fwidth(p), vec2(1e-4));
    vec2 i = 2.0 * (abs(fract((p - 0.5 * w) * 0.5) - 0.5) - abs(fract((p + 0.5 * w) * 0.5) - 0.5)) / w;
    return i.x * i.y;
}

// The share of a pixel that grid lines of `width` cover, one line every `spacing` [m, both].
float grid(vec2 p, float spacing, float width) {
    vec2 w = max(fwidth(p), vec2(1e-4));
    vec2 distance = abs(fract(p / spacing + 0.5) - 0.5) * spacing;
    vec2 drawn = max(vec2(width), w);
    vec2 line = (1.0 - smoothstep(drawn * 0.5, drawn * 0.5 + w, distance)) * clamp(vec2(width) / w, 0.0, 1.0);
    return max(line.x, line.y);
}

float pattern_shade() {
    if (material_pattern == 1) {
        float shade = 1.0 + 0.055 * checker(local_position.xz);
        return shade * (1.0 - 0.22 * grid(local_position.xz, 10.0, 0.05));
    }
    if (material_pattern == 2)
        return 0.88 + 0.12 * soft_sign(local_position.x) * soft_sign(local_position.y) * soft_sign(local_position.z);
    if (material_pattern == 3) return 0.91 + 0.09 * soft_sign(local_position.x) * soft_sign(local_position.z);
    return 1.0;
}

// Cook-Torrance highlight of the sun: GGX, Smith's visibility in Hammon's approximation, Schlick's Fresnel.
vec3 sun_highlight(vec3 n, vec3 v, vec3 f0, float n_dot_l) {
    vec3 h = normalize(v + to_sun);
    float n_dot_h = max(dot(n, h), 0.0), n_dot_v = max(dot(n, v), 1e-3);
    float a = material_roughness * material_roughness, a2 = a * a;
    float d = n_dot_h * n_dot_h * (a2 - 1.0) + 1.0;
    float visibility = 0.5 / mix(2.0 * n_dot_l * n_dot_v, n_dot_l + n_dot_v, a);
    vec3 fresnel = f0 + (1.0 - f0) * pow(1.0 - max(dot(v, h), 0.0), 5.0);
    return fresnel * min(a2 / (d * d) * visibility, 6.0) * n_dot_l;
}

// The share of the sky's mirror image that a surface gives back. Source: Karis, "Physically based shading on mobile",
// 2014, a fit to the split-sum table.
vec3 sky_share(vec3 f0, float n_dot_v) {
    const vec4 c0 = vec4(-1.0, -0.0275, -0.572, 0.022), c1 = vec4(1.0, 0.0425, 1.04, -0.04);
    vec4 r = material_roughness * c0 + c1;
    float t = min(r.x * r.x, exp2(-9.28 * n_dot_v)) * r.x + r.y;
    vec2 ab = vec2(-1.04, 1.04) * t + r.zw;
    return f0 * ab.x + ab.y;
}

void main() {
    vec3 n = normalize(world_normal);
    vec3 v = normalize(eye - world_position);
    if (!gl_FrontFacing) n = -n;

    vec3 albedo = to_linear(material_colour * instance_colour.rgb * texture(material_texture, texture_uv).rgb);
    albedo *= pattern_shade();
    vec3 f0 = mix(vec3(0.04), albedo, material_metalness);
    vec3 matt = albedo * (1.0 - material_metalness);

    float n_dot_l = max(dot(n, to_sun), 0.0);
    vec3 sun = sun_strength * sun_tint * sun_visibility(world_position, n, n_dot_l);
    vec3 light = sun * (matt * n_dot_l + sun_highlight(n, v, f0, n_dot_l));
    light += matt * ambient_light(n);

    light += sky_share(f0, max(dot(n, v), 0.0)) * sky_radiance(mix(reflect(-v, n), n, material_roughness));

    float rim = pow(1.0 - max(dot(n, v), 0.0), 2.0);
    light = mix(light, vec3(1.1, 0.72, 0.20), instance_colour.a * min(0.30 + 1.2 * rim, 1.0));
    pixel = vec4(to_pixel(add_haze(light, world_position)), 1.0);
}
