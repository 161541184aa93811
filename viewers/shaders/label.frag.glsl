#version 330
in vec2 place;
uniform sampler2D image;
uniform vec3 colour;
out vec4 result;

void main() {
    result = vec4(colour, texture(image, place).r);
}
