// How far each place moves while the shutter is open, half of it [pixels of the picture], and its distance [m]. A
// dancer's pixel moves with the nearest bone; everything else with the camera.
#include "frame.glsl"
#include "distance.glsl"
in vec2 at;
uniform sampler2D who;
uniform sampler2D motion;     // of each joint: bone's begin and end, rotation since the last picture, begin in it
uniform int motion_rows;
uniform mat4 last_clip;       // of the last picture's camera
uniform float shutter;
uniform float most;           // longest way [pixels]
out vec4 velocity;            // way x, y, distance, its length

vec3 turned(vec4 q, vec3 v) {
    vec3 t = 2.0 * cross(q.xyz, v);
    return v + q.w * t + cross(q.xyz, t);
}

vec3 before(int dancer, vec3 place) {
    ivec2 base = ivec2(dancer / motion_rows * 4 * JOINTS, dancer % motion_rows);
    int best = 0;
    float nearest = 1e9;
    for (int joint = 0; joint < JOINTS; ++joint) {
        vec3 a = texelFetch(motion, base + ivec2(4 * joint, 0), 0).xyz;
        vec3 bone = texelFetch(motion, base + ivec2(4 * joint + 1, 0), 0).xyz - a, to = place - a;
        vec3 off = to - bone * clamp(dot(to, bone) / max(dot(bone, bone), 1e-6), 0.0, 1.0);
        float apart = dot(off, off);
        best = apart < nearest ? joint : best;
        nearest = min(nearest, apart);
    }
    vec3 a = texelFetch(motion, base + ivec2(4 * best, 0), 0).xyz;
    vec4 back = texelFetch(motion, base + ivec2(4 * best + 2, 0), 0);
    return texelFetch(motion, base + ivec2(4 * best + 3, 0), 0).xyz + turned(back, place - a);
}

void main() {
    vec2 middle = (floor(at * picture.xy) + 0.5) * picture.zw;
    float away = distance_at(middle);
    vec3 place = eye.xyz + ray_at(middle) * away;
    vec4 identity = textureLod(who, middle, 0.0);
    int number = int(identity.r * 255.0 + 0.5) + 256 * int(identity.g * 255.0 + 0.5);
    vec3 last = place;
    if (number > 0) last = before(number - 1, place);
    vec4 clip = last_clip * vec4(last, 1.0);
    vec2 way = clip.w > 0.05 ? (middle - (clip.xy / clip.w * 0.5 + 0.5)) * picture.xy * (0.5 * shutter) : vec2(0.0);
    float far = length(way);
    way *= min(1.0, most / max(far, 1e-4));
    velocity = vec4(way, away, min(far, most));
}
