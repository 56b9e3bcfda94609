// One bone: a quad along it that faces the camera; its ends hang on two joints.
#include "frame.glsl"
#include "skin.glsl"
#include "surface.glsl"
#include "styles.glsl"

in vec4 in_begin;     // place in the rest pose [m], joint
in vec4 in_end;
in vec4 in_bone;      // radius [m], which end (0 or 1), side (-1 or 1), brightness

out vec3 across;      // places along and across the bone and its length, in radii of its glow
flat out vec4 light;

vec3 carried(vec4 point) {
    int dancer = in_dancer;
    ivec2 at = ivec2(dancer / pose_layout.x * pose_layout.y + 2 * int(point.w + 0.5), dancer % pose_layout.x);
    vec4 real = texelFetch(poses, at, 0), dual = texelFetch(poses, at + ivec2(1, 0), 0);
    return turned(real, point.xyz) + 2.0 * (real.w * dual.xyz - dual.w * real.xyz + cross(real.xyz, dual.xyz));
}

void main() {
    int dancer = in_dancer, group = group_of(who(dancer));
    vec4 a = world_to_clip * vec4(carried(in_begin), 1.0), b = world_to_clip * vec4(carried(in_end), 1.0);
    float scale = ray_corner.w;
    vec4 at = in_bone.y < 0.5 ? a : b;
    float reach = max(in_bone.x * 2.6 * scale / at.w, 1.5);      // of the glow [pixels]
    vec2 pa = a.xy / a.w * picture.xy * 0.5, pb = b.xy / b.w * picture.xy * 0.5;
    float long_ = length(pb - pa);
    vec2 way = long_ > 1e-3 ? (pb - pa) / long_ : vec2(1.0, 0.0);
    float end = in_bone.y * 2.0 - 1.0;
    vec2 off = (way * end + vec2(-way.y, way.x) * in_bone.z) * reach;
    at.xy += off * 2.0 * picture.zw * at.w;
    across = vec3(in_bone.y * long_ / reach + end, in_bone.z, long_ / reach);
    vec3 glow = glow_of(dancer);
    float beat = 0.85 + 0.45 * key_direction.w;
    light = vec4(glow, amounts(group).w * in_bone.w * beat * answer(group) * min(in_bone.x * 2.6 * scale / at.w / 1.5, 1.0));
    gl_Position = min(a.w, b.w) > 0.05 ? at : vec4(2.0, 2.0, 2.0, 1.0);
}
