// Dual quaternions that move the rest pose to each dancer's pose (Kavan et al. 2007): two texels a drawn joint.
uniform sampler2D joint_position;   // x, y, z [m] of each joint of the skeleton in texels of their own
uniform sampler2D joint_rotation;   // w, x, y, z of each joint
uniform sampler2D expression;       // face and hands: EXPRESSION texels a dancer
uniform vec3 rest[JOINTS];          // joints of the skeleton in the rest pose [m]
uniform vec4 detail[4 * DETAILS];   // see drawn_joints.py

out vec4 dual_quaternion;

struct Motion { vec4 turn; vec3 move; };   // x to turn(x) + move

vec3 turned(vec4 q, vec3 v) {
    vec3 t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

vec4 product(vec4 a, vec4 b) {
    return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz));
}

Motion after(Motion a, Motion b) { return Motion(product(a.turn, b.turn), turned(a.turn, b.move) + a.move); }

float column(int dancer_block, int row, float which) {
    return texelFetch(expression, ivec2(dancer_block * EXPRESSION + int(which + 0.5), row), 0).x;
}

// What a detail joint does beside the joint that it hangs on.
Motion detail_motion(int which, int block, int row) {
    vec3 pivot = detail[4 * which].xyz;
    vec4 first = detail[4 * which + 1], second = detail[4 * which + 2];
    vec3 around = first.xyz * column(block, row, first.w) + second.xyz * column(block, row, second.w);
    float angle = length(around);
    vec4 q = angle > 1e-5 ? vec4(around * (sin(0.5 * angle) / angle), cos(0.5 * angle)) : vec4(0.0, 0.0, 0.0, 1.0);
    return Motion(q, pivot - turned(q, pivot));
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int drawn = pixel.x >> 1, block = drawn / (JOINTS + DETAILS), joint = drawn - block * (JOINTS + DETAILS);
    int which = joint - JOINTS;
    int anchor = which < 0 ? joint : int(detail[4 * which].w + 0.5);
    ivec2 at = ivec2(block * JOINTS + anchor, pixel.y);
    Motion all;
    all.turn = texelFetch(joint_rotation, at, 0).yzwx;
    for (int axis = 0; axis < 3; ++axis) all.move[axis] = texelFetch(joint_position, ivec2(3 * at.x + axis, at.y), 0).x;
    all.move -= turned(all.turn, rest[anchor]);
    if (which >= 0) {
        int parent = int(floor(detail[4 * which + 3].x + 0.5));
        if (parent >= 0) all = after(all, detail_motion(parent, block, pixel.y));
        all = after(all, detail_motion(which, block, pixel.y));
    }
    vec4 q = all.turn;
    vec3 t = all.move;
    dual_quaternion = (pixel.x & 1) == 0 ? q : 0.5 * vec4(t * q.w + cross(t, q.xyz), -dot(t, q.xyz));
}
