#version 330
in vec3 world;
in vec3 normal;
in vec3 colour;

uniform vec3 eye;
uniform vec3 key_direction;
uniform vec3 key_light;
uniform vec3 sky_light;
uniform vec3 ground_light;
uniform vec4 fade;  // linear colour a ghost fades to, and how far it has faded

uniform float alpha;

out vec4 result;

void main() {
    vec3 n = normalize(normal);
    vec3 v = normalize(eye - world);
    float key = dot(n, key_direction);
    float lit = max(0.0, 0.22 + 0.78 * key);
    vec3 light = mix(ground_light, sky_light, 0.5 + 0.5 * n.y) + key_light * lit * lit;
    float edge = 1.0 - max(dot(n, v), 0.0);
    float rim = edge * edge * edge * (0.35 + 0.65 * max(n.y, 0.0));
    float h = max(dot(n, normalize(v + key_direction)), 0.0);
    h *= h; h *= h; h *= h; h *= h;
    vec3 shaded = colour * light + sky_light * (0.55 * rim) + key_light * (0.05 * h);
    shaded = mix(shaded, fade.rgb, fade.a);
    result = vec4(sqrt(shaded), alpha);
}
