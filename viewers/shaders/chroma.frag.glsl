#version 330
// Two bytes for each square of four pixels; linear filtering at their common corner is their mean.
in vec2 place;
uniform sampler2D image;
out vec2 result;

void main() {
    vec3 c = texture(image, place).rgb;
    result = 0.50196 + vec2(dot(c, vec3(-0.100644, -0.338572, 0.439216)), dot(c, vec3(0.439216, -0.398942, -0.040274)));
}
