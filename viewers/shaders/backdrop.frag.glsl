#version 330
noperspective in vec3 shade;
out vec4 result;

void main() {
#ifdef GRAIN
    // half a step of noise hides the bands of a slow gradient in eight bits
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    result = vec4(shade + (noise - 0.5) / 255.0, 1.0);
#else
    result = vec4(shade, 1.0);
#endif
}
