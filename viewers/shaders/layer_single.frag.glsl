#version 330
// The figures' layer where it is not multisampled.
uniform sampler2D image;
uniform ivec2 corner;  // of the layer in the picture
out vec4 result;

void main() {
    result = texelFetch(image, ivec2(gl_FragCoord.xy) - corner, 0);
}
