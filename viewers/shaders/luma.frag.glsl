#version 330
// BT.709, studio range.
uniform sampler2D image;
out float result;

void main() {
    vec3 c = texelFetch(image, ivec2(gl_FragCoord.xy), 0).rgb;
    result = 0.0625 + dot(c, vec3(0.182586, 0.614231, 0.062007));
}
