#version 330
// Flat marks on the floor: dots of a trail, prints of feet.
in vec2 in_centre;
in vec2 in_along;    // unit direction of the long side
in vec2 in_radii;    // along and across, metres
in vec2 in_span;     // seconds from when to when it holds

uniform mat4 view_projection;
uniform vec2 shift;
uniform float now;
uniform vec3 opacity;  // before, during, after
uniform float least;   // smallest radius in pixels
uniform float pixel;   // metres a pixel covers, one metre away

out vec2 place;
out float strength;

void main() {
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0;
    vec2 centre = in_centre + shift;
    vec4 middle = view_projection * vec4(centre.x, 0.003, centre.y, 1.0);
    vec2 radii = in_radii * max(1.0, least * pixel * max(middle.w, 0.1) / in_radii.y);
    vec2 across = vec2(-in_along.y, in_along.x);
    vec2 at = centre + corner.x * radii.x * in_along + corner.y * radii.y * across;
    place = corner;
    strength = now < in_span.x ? opacity.x : (now <= in_span.y ? opacity.y : opacity.z);
    gl_Position = view_projection * vec4(at.x, 0.003, at.y, 1.0);
}
