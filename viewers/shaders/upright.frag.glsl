#version 330
// A picture whose first row is its top, for a screen whose first row is its bottom.
in vec2 place;
uniform sampler2D image;
out vec4 result;

void main() {
    result = vec4(texture(image, vec2(place.x, 1.0 - place.y)).rgb, 1.0);
}
