// Dual quaternions that move the rest pose to each dancer's pose (Kavan et al. 2007): two texels a joint.
uniform sampler2D joint_position;   // x, y, z [m] of each joint in texels of their own
uniform sampler2D joint_rotation;   // w, x, y, z of each joint
uniform vec3 rest[JOINTS];          // joints in the rest pose [m]

out vec4 dual_quaternion;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 at = ivec2(pixel.x >> 1, pixel.y);
    vec4 q = texelFetch(joint_rotation, at, 0).yzwx;
    if ((pixel.x & 1) == 0) {
        dual_quaternion = q;
        return;
    }
    vec3 place;
    for (int axis = 0; axis < 3; ++axis) place[axis] = texelFetch(joint_position, ivec2(3 * at.x + axis, at.y), 0).x;
    vec3 r = rest[at.x % JOINTS], c = cross(q.xyz, r);
    vec3 t = place - (r + 2.0 * (q.w * c + cross(q.xyz, c)));
    dual_quaternion = 0.5 * vec4(t * q.w + cross(t, q.xyz), -dot(t, q.xyz));
}
