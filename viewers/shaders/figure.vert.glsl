#version 330
#include "skin.glsl"
in vec3 in_normal;
in vec3 in_colour;

uniform mat4 view_projection;
uniform float floor_clip;  // lowest height that is drawn

out vec3 world;
out vec3 normal;
out vec3 colour;

void main() {
    mat3x4 m = blended();
    vec4 rest = vec4(in_position, 1.0);
    world = rest * m;
    normal = vec4(in_normal, 0.0) * m;
    colour = in_colour * in_colour;  // to linear light, near enough
    gl_ClipDistance[0] = world.y - floor_clip;
    gl_Position = view_projection * vec4(world, 1.0);
}
