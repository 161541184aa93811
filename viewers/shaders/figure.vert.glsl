#version 330
// Lit at the vertices: bodies are finely meshed, and a software rasteriser spends its time on pixels. Where there is a
// texture the light travels on to the pixels, which have colours of their own.
#include "skin.glsl"
in vec3 in_normal;
in vec4 in_colour;  // alpha: how much of a texture it covers

uniform mat4 view_projection;
uniform float floor_clip;  // lowest height that is drawn
uniform vec3 eye;
uniform vec3 key_direction;
uniform vec3 key_light;
uniform vec3 sky_light;
uniform vec3 ground_light;

#ifdef TEXTURED
in vec2 in_uv;
out vec2 place;
out vec4 dye;
out vec3 light;
out vec3 sheen;
#else
uniform vec3 faded;  // linear colour a ghost fades to
uniform float fade;  // how far it has
out vec3 shade;
#endif

void main() {
    mat3x4 m = blended();
    vec3 world = vec4(in_position, 1.0) * m;
    vec3 n = normalize(vec4(in_normal, 0.0) * m);
    vec3 v = normalize(eye - world);
    float lit = max(0.0, 0.22 + 0.78 * dot(n, key_direction));
    vec3 falling = mix(ground_light, sky_light, 0.5 + 0.5 * n.y) + key_light * lit * lit;
    float edge = 1.0 - max(dot(n, v), 0.0);
    float rim = edge * edge * edge * (0.25 + 0.75 * max(n.y, 0.0));
    float gloss = max(dot(n, normalize(v + key_direction)), 0.0);
    gloss *= gloss; gloss *= gloss; gloss *= gloss; gloss *= gloss;
    vec3 thrown = sky_light * (0.4 * rim) + key_light * (0.05 * gloss);
#ifdef TEXTURED
    place = in_uv;
    dye = in_colour;
    light = falling;
    sheen = thrown;
#else
    vec3 colour = in_colour.rgb * in_colour.rgb;  // to linear light, near enough
    shade = sqrt(mix(colour * falling + thrown, faded, fade));
#endif
    gl_ClipDistance[0] = world.y - floor_clip;
    gl_Position = view_projection * vec4(world, 1.0);
}
