#version 330 core

layout(location = 0) in vec2 position;  // [px], from the upper left
layout(location = 1) in vec2 uv;
layout(location = 2) in vec4 colour;

uniform vec2 viewport;  // [px]

out vec2 glyph_uv;
out vec4 glyph_colour;

void main() {
    glyph_uv = uv;
    glyph_colour = colour;
    gl_Position = vec4(2.0 * position.x / viewport.x - 1.0, 1.0 - 2.0 * position.y / viewport.y, 0.0, 1.0);
}
