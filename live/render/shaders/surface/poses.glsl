// Smooth skinning by blended dual quaternions (Kavan et al. 2007) from the pose texture.
uniform sampler2D poses;
uniform ivec2 pose_layout;   // rows, texels a dancer

vec3 turned(vec4 q, vec3 v) {
    vec3 t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

struct Skinned { vec3 place; vec3 normal; };

Skinned posed(int dancer, uvec4 joint, vec4 weights, vec3 position, vec3 normal) {
    ivec2 base = ivec2(dancer / pose_layout.x * pose_layout.y, dancer % pose_layout.x);
    ivec2 at = base + ivec2(2 * int(joint.x), 0);
    vec4 first = texelFetch(poses, at, 0);
    vec4 real = first * weights.x;
    vec4 dual = texelFetch(poses, at + ivec2(1, 0), 0) * weights.x;
    for (int i = 1; i < 4; ++i) {
        float weight = weights[i];
        if (weight <= 0.0) break;
        at = base + ivec2(2 * int(joint[i]), 0);
        vec4 next = texelFetch(poses, at, 0);
        weight = dot(first, next) < 0.0 ? -weight : weight;
        real += next * weight;
        dual += texelFetch(poses, at + ivec2(1, 0), 0) * weight;
    }
    float scale = inversesqrt(dot(real, real));
    real *= scale;
    dual *= scale;
    vec3 moved = 2.0 * (real.w * dual.xyz - dual.w * real.xyz + cross(real.xyz, dual.xyz));
    return Skinned(turned(real, position) + moved, turned(real, normal));
}
