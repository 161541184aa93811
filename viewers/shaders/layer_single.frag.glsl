#version 330
// The figures' layer where it is not multisampled.
uniform sampler2D image;
out vec4 result;

void main() {
    result = texelFetch(image, ivec2(gl_FragCoord.xy), 0);
}
