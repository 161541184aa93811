#version 330
in vec2 place;
in vec3 ray;
uniform vec3 eye;
uniform vec2 focus;       // middle of the lit floor
uniform float reach;      // metres over which the floor fades
uniform float aspect;
uniform vec3 centre;      // sRGB
uniform vec3 edge;
uniform vec3 ground;
uniform vec3 lines;
uniform float has_floor;
out vec4 result;

void main() {
    vec2 from = (place - vec2(0.0, -0.12)) * vec2(min(aspect, 1.8) * 0.62, 0.86);
    float away = min(dot(from, from), 1.0);
    vec3 sky = mix(centre, edge, away * (2.0 - away) * 0.5 + away * 0.5);
    float below = max(-ray.y, 1e-4);
    vec2 hit = eye.xz + ray.xz * (eye.y / below);
    vec2 off = hit - focus;
    float fade = has_floor * float(ray.y < 0.0) * exp(-dot(off, off) / (reach * reach));
    vec2 width = fwidth(hit);
    vec2 cell = abs(fract(hit - 0.5) - 0.5);
    vec2 line = clamp(1.3 - cell / max(width, 1e-5), 0.0, 1.0) * clamp(1.2 - 3.0 * width, 0.0, 1.0);
    vec3 tiles = mix(ground, lines, 0.55 * max(line.x, line.y));
    float pool = exp(-dot(off, off) / (0.12 * reach * reach + 2.0));
    vec3 colour = mix(sky, mix(tiles, sky, 0.25) + 0.03 * pool, fade);
    float noise = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    result = vec4(colour + (noise - 0.5) / 255.0, 1.0);
}
