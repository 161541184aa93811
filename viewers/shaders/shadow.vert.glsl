#version 330
// The body laid flat on the floor along the key light, seen from above.
#include "skin.glsl"
uniform vec4 patch_area;  // centre x, z and 1 / half size, of the tile of floor
uniform vec2 slant;       // x and z a shadow moves for each metre of height

out float height;

void main() {
    vec3 world = vec4(in_position, 1.0) * blended();
    vec2 place = (world.xz - slant * max(world.y, 0.0) - patch_area.xy) * patch_area.z;
    height = max(world.y, 0.0);
    gl_Position = vec4(place, 0.0, 1.0);
}
