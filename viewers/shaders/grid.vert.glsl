#version 330
// Lines on the floor, one a metre, cut into pieces that fade with distance; each piece is a strip as wide as two pixels.
uniform mat4 view_projection;
uniform vec2 focus;
uniform float reach;   // 1 / square metres at which the lines have faded away
uniform int count;     // lines on either side of the middle one
uniform int pieces;    // of each line
uniform vec2 size;     // of the picture, pixels
uniform float near;

out float across;
out float strength;

void main() {
    int line = gl_InstanceID / pieces;
    float piece = float(gl_InstanceID % pieces);
    bool along_x = line > 2 * count;
    float step = float(2 * count) / float(pieces);
    vec2 middle = round(focus);
    float beside = float(along_x ? line - 2 * count - 1 : line) - float(count);
    vec2 first = vec2(beside, -float(count) + piece * step);
    vec2 last = vec2(beside, first.y + step);
    if (along_x) { first = first.yx; last = last.yx; }
    first += middle;
    last += middle;
    vec4 a = view_projection * vec4(first.x, 0.0, first.y, 1.0);
    vec4 b = view_projection * vec4(last.x, 0.0, last.y, 1.0);
    bool hidden = a.w < near && b.w < near;
    if (a.w < near) a = mix(a, b, (near - a.w) / (b.w - a.w));
    if (b.w < near) b = mix(b, a, (near - b.w) / (a.w - b.w));
    vec2 way = (b.xy / b.w - a.xy / a.w) * size;
    vec2 side = normalize(vec2(-way.y, way.x) + 1e-6) * 2.6 / size;
    bool end = gl_VertexID >= 2;
    across = (gl_VertexID & 1) == 0 ? -1.3 : 1.3;
    vec2 off = (end ? last : first) - focus;
    float left = max(1.0 - dot(off, off) * reach, 0.0);
    strength = 0.42 * min(1.0, size.y / 560.0) * left * left;  // thinner in small pictures
    vec4 place = end ? b : a;
    place.xy += side * sign(across) * place.w;
    gl_Position = hidden ? vec4(2.0, 2.0, 2.0, 1.0) : place;
}
