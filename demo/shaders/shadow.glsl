// How much of the sun reaches a point.

uniform sampler2DShadow shadow_map;
uniform mat4 shadow_matrix;
uniform float shadow_texel;     // width of a texel [m]
uniform float shadow_strength;  // 0 or 1

// A 5 x 5 tent filter in nine taps: each tap is placed between texels so that the hardware's own blend of four gives it
// the weights it needs. Source: Ignacio Castano, "Shadow mapping summary", The Witness, 2013.
float tent_filter(vec3 p) {
    vec2 size = vec2(textureSize(shadow_map, 0));
    vec2 texel = p.xy * size;
    vec2 base = floor(texel + 0.5);
    vec2 f = texel + 0.5 - base;
    vec2 w0 = 4.0 - 3.0 * f, w1 = vec2(7.0), w2 = 1.0 + 3.0 * f;
    vec2 o0 = (3.0 - 2.0 * f) / w0 - 2.0, o1 = (3.0 + f) / w1, o2 = f / w2 + 2.0;
    base = base - 0.5;

    vec2 offsets[3] = vec2[3](o0, o1, o2);
    vec2 weights[3] = vec2[3](w0, w1, w2);
    float sum = 0.0;
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
            vec2 uv = (base + vec2(offsets[x].x, offsets[y].y)) / size;
            sum += weights[x].x * weights[y].y * texture(shadow_map, vec3(uv, p.z));
        }
    }
    return sum / 144.0;
}

float sun_visibility(vec3 position, vec3 n, float n_dot_sun) {
    if (shadow_strength == 0.0 || n_dot_sun <= 0.0) return 1.0;
    // Stepping out along the normal, more at grazing light, cures acne without lifting shadows off their casters.
    float step_out = shadow_texel * (0.6 + 2.4 * sqrt(1.0 - n_dot_sun * n_dot_sun));
    vec4 clip = shadow_matrix * vec4(position + step_out * n, 1.0);
    vec3 p = 0.5 + 0.5 * clip.xyz;
    return tent_filter(vec3(p.xy, clamp(p.z, 0.0, 1.0)));
}
