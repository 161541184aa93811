#version 330
in vec2 place;
uniform sampler2D image;
uniform float strength;
out vec4 result;

void main() {
    vec2 s = texture(image, place).rg;
    result = vec4(0.0, 0.0, 0.0, strength * (1.0 - (1.0 - 0.42 * s.r) * (1.0 - 0.62 * s.g)));
}
