#version 330 core

uniform sampler2D glyphs;

in vec2 glyph_uv;
in vec4 glyph_colour;
out vec4 pixel;

void main() { pixel = vec4(glyph_colour.rgb, glyph_colour.a * texture(glyphs, glyph_uv).r); }
