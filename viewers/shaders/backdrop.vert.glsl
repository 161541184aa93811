#version 330
uniform mat4 unproject;  // clip to world, without the eye's place: gives directions
out vec2 place;
out vec3 ray;

void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2) * 2.0 - 1.0;
    place = corner;
    ray = (unproject * vec4(corner, 1.0, 1.0)).xyz;
    gl_Position = vec4(corner, 0.0, 1.0);
}
