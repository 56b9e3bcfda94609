// Smooth skinning by blended dual quaternions (Kavan et al. 2007) from the pose texture.
uniform sampler2D poses;
uniform ivec2 pose_layout;   // rows, texels a dancer
#ifdef OWN_FIRST             // a scene with characters: joints from OWN_FIRST on are their own
uniform sampler2D own_poses;
uniform int own_texels;      // texels a dancer
#endif

vec3 turned(vec4 q, vec3 v) {
    vec3 t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

struct Skinned { vec3 place; vec3 normal; };

vec4 joint_pose(ivec2 dancer, int joint, int part) {   // dancer: block, row
#ifdef OWN_FIRST
    if (joint >= OWN_FIRST) {
        return texelFetch(own_poses, ivec2(dancer.x * own_texels + 2 * (joint - OWN_FIRST) + part, dancer.y), 0);
    }
#endif
    return texelFetch(poses, ivec2(dancer.x * pose_layout.y + 2 * joint + part, dancer.y), 0);
}

Skinned posed(int dancer, uvec4 joint, vec4 weights, vec3 position, vec3 normal) {
    ivec2 who = ivec2(dancer / pose_layout.x, dancer % pose_layout.x);
    vec4 first = joint_pose(who, int(joint.x), 0);
    vec4 real = first * weights.x;
    vec4 dual = joint_pose(who, int(joint.x), 1) * weights.x;
    for (int i = 1; i < 4; ++i) {
        float weight = weights[i];
        if (weight <= 0.0) break;
        vec4 next = joint_pose(who, int(joint[i]), 0);
        weight = dot(first, next) < 0.0 ? -weight : weight;
        real += next * weight;
        dual += joint_pose(who, int(joint[i]), 1) * weight;
    }
    float scale = inversesqrt(dot(real, real));
    real *= scale;
    dual *= scale;
    vec3 moved = 2.0 * (real.w * dual.xyz - dual.w * real.xyz + cross(real.xyz, dual.xyz));
    return Skinned(turned(real, position) + moved, turned(real, normal));
}
