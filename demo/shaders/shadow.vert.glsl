#version 330 core
#include "shape.glsl"

uniform mat4 view_projection;

void main() { gl_Position = view_projection * pose * vec4(shape_position(), 1.0); }
