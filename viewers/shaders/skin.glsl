// Linear blend skinning: joint matrices as rows of 3x4, bound as one range of a buffer that holds the whole clip.
layout(std140) uniform Pose { vec4 rows[ROWS]; };

in vec3 in_position;
in uvec4 in_joints;
in vec4 in_weights;

mat3x4 blended() {
    mat3x4 m = mat3x4(0.0);
    for (int k = 0; k < 4; k++) {
        int row = 3 * int(in_joints[k]);
        float w = in_weights[k];
        m[0] += w * rows[row];
        m[1] += w * rows[row + 1];
        m[2] += w * rows[row + 2];
    }
    return m;
}
