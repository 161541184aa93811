#version 330
// Sky and floor without its lines. Both change slowly over the picture, so a coarse net of vertices carries them.
in vec2 in_place;  // -1 to 1, y down the picture

uniform mat4 unproject;  // clip to directions from the eye
uniform vec3 eye;
uniform vec2 focus;      // middle of the lit floor
uniform float reach;     // 1 / square metres at which the floor has faded away; 0 without a floor
uniform float aspect;
uniform vec3 centre;     // sRGB
uniform vec3 edge;
uniform vec3 ground;

noperspective out vec3 shade;

void main() {
    vec2 from = (in_place - vec2(0.0, -0.12)) * vec2(min(aspect, 1.8) * 0.62, 0.86);
    float away = min(dot(from, from), 1.0);
    shade = mix(centre, edge, away * (1.5 - 0.5 * away));
    vec3 ray = (unproject * vec4(in_place, 1.0, 1.0)).xyz;
    if (reach > 0.0 && ray.y < -1e-4 && eye.y > 0.0) {
        vec2 off = eye.xz - ray.xz * (eye.y / ray.y) - focus;
        float left = max(1.0 - dot(off, off) * reach, 0.0);
        float pool = left * left * left * left;
        shade = mix(shade, mix(ground, shade, 0.25) + 0.035 * pool * pool, left * left);
    }
    gl_Position = vec4(in_place, 0.0, 1.0);
}
