#version 330
uniform mat4 view_projection;
uniform vec4 patch_area;
uniform vec4 tile;  // corner and size of this actor's tile in the atlas
out vec2 place;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec2 floor_place = patch_area.xy + (corner * 2.0 - 1.0) / patch_area.z;
    place = tile.xy + corner * tile.zw;
    gl_Position = view_projection * vec4(floor_place.x, 0.0, floor_place.y, 1.0);
}
