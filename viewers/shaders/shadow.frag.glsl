#version 330
in float height;
out vec4 result;  // red: near the floor, kept sharp; green: everything, to be blurred more

void main() {
    result = vec4(exp(-6.0 * height), 0.35 + 0.65 * exp(-1.1 * height), 0.0, 1.0);
}
