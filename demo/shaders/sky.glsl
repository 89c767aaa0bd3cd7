// Colours of the air, and the way from light to a pixel.

uniform vec3 to_sun;
uniform float sun_strength;
uniform float sky_strength;
uniform float haze_distance;
uniform vec3 eye;

const vec3 sun_tint = vec3(1.12, 1.02, 0.88);
const vec3 horizon_tint = vec3(0.62, 0.73, 0.84);
const vec3 zenith_tint = vec3(0.12, 0.29, 0.60);
const vec3 ground_tint = vec3(0.40, 0.42, 0.44);

vec3 to_linear(vec3 srgb) { return pow(srgb, vec3(2.2)); }

// Light that comes from `direction`.
vec3 sky_radiance(vec3 direction) {
    float height = direction.y;
    vec3 sky = mix(horizon_tint, zenith_tint, 1.0 - exp(-4.2 * max(height, 0.0)));
    vec3 ground = mix(horizon_tint, ground_tint, 1.0 - exp(4.0 * min(height, 0.0)));
    vec3 colour = height > 0.0 ? sky : ground;
    float glow = max(dot(direction, to_sun), 0.0);
    colour += sun_tint * sun_strength * (0.10 * pow(glow, 8.0) + 0.25 * pow(glow, 120.0));
    return sky_strength * colour;
}

// Light that a matt surface of normal `n` gathers from sky and ground.
vec3 ambient_light(vec3 n) {
    const vec3 from_above = vec3(0.42, 0.48, 0.57);
    const vec3 from_below = vec3(0.24, 0.22, 0.19);
    return sky_strength * mix(from_below, from_above, 0.5 + 0.5 * n.y);
}

vec3 add_haze(vec3 colour, vec3 position) {
    vec3 way = position - eye;
    float distance = length(way);
    float ratio = distance / haze_distance;
    vec3 level = normalize(vec3(way.x, max(0.0, way.y), way.z) + vec3(1e-5, 0.0, 0.0));
    return mix(sky_radiance(level), colour, exp(-ratio * ratio * ratio));
}

// Khronos "PBR Neutral" tone mapper: keeps hue and leaves what is below 0.76 almost as it is.
vec3 tone_map(vec3 colour) {
    const float start = 0.8 - 0.04;
    const float desaturation = 0.15;
    float low = min(colour.r, min(colour.g, colour.b));
    float shift = low < 0.08 ? low - 6.25 * low * low : 0.04;
    colour -= shift;
    float peak = max(colour.r, max(colour.g, colour.b));
    if (peak < start) return colour;
    float rest = 1.0 - start;
    float new_peak = 1.0 - rest * rest / (peak + rest - start);
    colour *= new_peak / peak;
    float grey = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(colour, vec3(new_peak), grey);
}

// Light to sRGB, with half a step of noise so that the sky shows no bands.
vec3 to_pixel(vec3 light) {
    vec3 srgb = pow(clamp(tone_map(light), 0.0, 1.0), vec3(1.0 / 2.2));
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    return srgb + (noise - 0.5) / 255.0;
}
