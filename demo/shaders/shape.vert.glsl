#version 330 core
#include "shape.glsl"

uniform mat4 view_projection;

// Centroid: at a silhouette the middle of a pixel may lie off the triangle, and a bevel's normal beyond it is wrong.
centroid out vec3 world_position;
centroid out vec3 world_normal;
centroid out vec3 local_position;
centroid out vec2 texture_uv;
flat out vec4 instance_colour;

void main() {
    local_position = shape_position();
    vec4 world = pose * vec4(local_position, 1.0);
    // The cofactor matrix turns normals rightly under any scale, and needs no inverse.
    mat3 cofactor = mat3(cross(pose[1].xyz, pose[2].xyz), cross(pose[2].xyz, pose[0].xyz),
                         cross(pose[0].xyz, pose[1].xyz));
    world_position = world.xyz;
    world_normal = cofactor * shape_normal();
    texture_uv = uv;
    instance_colour = colour_highlight;
    gl_Position = view_projection * world;
}
