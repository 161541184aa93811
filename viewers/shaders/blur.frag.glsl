#version 330
in vec2 place;
uniform sampler2D image;
uniform vec2 step_size;  // one texel along the direction of this pass
out vec4 result;

void main() {
    vec2 c = texture(image, place).rg;
    vec2 near = texture(image, place + 1.4 * step_size).rg + texture(image, place - 1.4 * step_size).rg;
    vec2 far = texture(image, place + 3.3 * step_size).rg + texture(image, place - 3.3 * step_size).rg;
    vec2 farther = texture(image, place + 5.2 * step_size).rg + texture(image, place - 5.2 * step_size).rg;
    float sharp = 0.4 * c.r + 0.3 * near.r;
    float soft = 0.19 * c.g + 0.2 * near.g + 0.13 * far.g + 0.075 * farther.g;
    result = vec4(sharp, soft, 0.0, 1.0);
}
