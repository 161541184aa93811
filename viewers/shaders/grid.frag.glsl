#version 330
in float across;
in float strength;
uniform vec3 lines;
out vec4 result;

void main() {
    result = vec4(lines, strength * clamp(1.3 - abs(across), 0.0, 1.0));
}
