#version 330
// The figures, drawn on a multisampled layer of their own, laid over the picture.
uniform sampler2DMS image;
uniform ivec2 corner;  // of the layer in the picture
out vec4 result;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy) - corner;
    vec4 total = vec4(0.0);
    for (int i = 0; i < SAMPLES; i++) total += texelFetch(image, at, i);
    result = total / float(SAMPLES);
}
