// Linear blend skinning: joint matrices as rows of 3x4, bound as one range of a buffer that holds the whole clip.
layout(std140) uniform Pose { vec4 rows[ROWS]; };

in vec3 in_position;
in uvec4 in_joints;
in vec4 in_weights;

mat3x4 blended() {  // written out: Mesa's software rasteriser takes an eighth longer over a loop
    ivec4 r = 3 * ivec4(in_joints);
    vec4 w = in_weights;
    return mat3x4(
        w.x * rows[r.x] + w.y * rows[r.y] + w.z * rows[r.z] + w.w * rows[r.w],
        w.x * rows[r.x + 1] + w.y * rows[r.y + 1] + w.z * rows[r.z + 1] + w.w * rows[r.w + 1],
        w.x * rows[r.x + 2] + w.y * rows[r.y + 2] + w.z * rows[r.z + 2] + w.w * rows[r.w + 2]
    );
}
