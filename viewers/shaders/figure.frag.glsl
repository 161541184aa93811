#version 330
in vec3 shade;
uniform float alpha;
out vec4 result;

void main() {
    result = vec4(shade, alpha);
}
