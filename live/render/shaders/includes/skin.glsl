// Smooth skinning by blended dual quaternions (Kavan et al. 2007) from the pose texture.
uniform sampler2D poses;
uniform ivec2 pose_layout;   // rows, texels a dancer

in vec3 in_position;
in vec3 in_normal;
in uvec4 in_joint;
in vec4 in_weight;
in float in_dancer;          // index
#define VERTEX 1
#ifdef WORN                  // a character with images of its own
in vec2 in_uv;
in vec4 in_tint;
in vec4 in_finish;
out vec4 worn_at;            // place on the image, layer, opacity where it ends
out vec4 worn_tint;
flat out int worn_extra;     // which row of worn_extras
#endif

vec3 turned(vec4 q, vec3 v) {
    vec3 t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

struct Skinned { vec3 place; vec3 normal; };

Skinned skinned(vec3 position, vec3 normal) {
#ifdef WORN
    worn_at = vec4(in_uv, in_finish.x * 255.0, in_finish.y / max(in_finish.z, 0.004));
    worn_tint = in_tint;
    worn_extra = int(in_finish.w * 255.0 + 0.5);
#endif
    int dancer = int(in_dancer);
    ivec2 base = ivec2(dancer / pose_layout.x * pose_layout.y, dancer % pose_layout.x);
    ivec2 at = base + ivec2(2 * int(in_joint.x), 0);
    vec4 first = texelFetch(poses, at, 0);
    vec4 real = first * in_weight.x;
    vec4 dual = texelFetch(poses, at + ivec2(1, 0), 0) * in_weight.x;
    for (int i = 1; i < 4; ++i) {
        float weight = in_weight[i];
        if (weight <= 0.0) break;
        at = base + ivec2(2 * int(in_joint[i]), 0);
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
