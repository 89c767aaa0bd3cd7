#version 330 core

out vec2 clip_position;

// One triangle that covers the viewport, at the far plane.
void main() {
    clip_position = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
    gl_Position = vec4(clip_position, 1.0, 1.0);
}
