#version 330
uniform vec4 box;  // corner and size in clip space
out vec2 place;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    place = corner;
    gl_Position = vec4(box.xy + corner * box.zw, 0.0, 1.0);
}
