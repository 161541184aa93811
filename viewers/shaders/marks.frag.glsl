#version 330
in vec2 place;
in float strength;
uniform vec3 colour;
out vec4 result;

void main() {
    float r = length(place);
    result = vec4(colour, strength * clamp((1.0 - r) / max(fwidth(r), 1e-4), 0.0, 1.0));
}
