#version 330
// A rectangle for each strip of the picture that figures may touch.
uniform vec4 strips[12];  // left, top, right, bottom in clip space

void main() {
    vec4 strip = strips[gl_InstanceID];
    gl_Position = vec4((gl_VertexID & 1) == 0 ? strip.x : strip.z, gl_VertexID < 2 ? strip.y : strip.w, 0.0, 1.0);
}
