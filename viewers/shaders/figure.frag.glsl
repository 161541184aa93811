#version 330
uniform float alpha;
out vec4 result;

#ifdef TEXTURED
uniform sampler2D skin;
uniform vec3 faded;  // linear colour a ghost fades to
uniform float fade;  // how far it has
in vec2 place;
in vec4 dye;
in vec3 light;
in vec3 sheen;

void main() {
    vec3 colour = mix(texture(skin, place).rgb, dye.rgb, dye.a);
    result = vec4(sqrt(mix(colour * colour * light + sheen, faded, fade)), alpha);
}
#else
in vec3 shade;

void main() {
    result = vec4(shade, alpha);
}
#endif
