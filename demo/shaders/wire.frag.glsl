#version 330 core

out vec4 pixel;

void main() { pixel = vec4(0.05, 0.07, 0.10, 0.40); }
