// Behind the dancers: the kept backdrop, with this moment's shadows, elements and mirror images on the floor.
#include "frame.glsl"
#include "finish.glsl"

in vec2 at;
in vec3 ray;

uniform sampler2D backdrop;
uniform sampler2D floor_map;
uniform sampler2D mirror;

out vec4 shown;

#if EDGE
float wash(vec2 place, vec2 size) {
    vec2 at_stage = place / (size + vec2(0.3, 0.5));
    return 1.0 / (1.0 + 1.6 * square(dot(at_stage, at_stage)));
}

// What the floor's light becomes where the stage is not as large as the kept backdrop has it: a border can be seen.
vec3 resized(vec3 colour, vec2 place) {
    vec2 beyond = abs(place) - edge.xy;
    float off = max(beyond.x, beyond.y);
    float lit = wash(place, edge.xy) / wash(place, stage.xy) * (1.0 - 0.65 * edge.z * smoothstep(-0.05, 0.35, off));
    return colour * lit + rim_light.rgb * (0.10 * edge.z * exp(-square(off / 0.04)));
}
#endif

#if POOLS
#include "beams.glsl"
// Pools of the follow spots and of the beams on the floor.
vec3 pools(vec3 place) {
    vec3 sum = vec3(0.0);
    if (light_beams() > 0.0) {
        for (int k = 0; k < LAMPS; ++k) {
            vec3 lamp = beam_lamp(k);
            vec2 foot = beam_foot(k), off = place.xz - foot;
            float width = 0.06 + light_beams_width() * distance(lamp, vec3(foot, 0.0).xzy);
            float longer = 1.0 + 0.5 * abs(foot.y - lamp.z) / lamp.y;   // it falls aslant
            off.y /= longer;
            sum += beam_tint(k) * exp(-2.0 * dot(off, off) / square(1.25 * width)) * 0.6;
        }
        sum *= beam_answer();
    }
    for (int k = 0; k < 4; ++k) {
        if (spot_place[k].w > 0.0) sum += spot_light[k].rgb * spot_reach(k, place);
    }
    return sum * (0.03 + 1.7 * light_floor());
}
#endif

void main() {
    // while light or camera move it may be smaller than the picture
    vec4 kept = textureSize(backdrop, 0).x == int(picture.x) ? texelFetch(backdrop, ivec2(gl_FragCoord.xy), 0)
                                                             : texture(backdrop, at);
    vec3 colour = kept.rgb;
#if FLOOR
    vec2 place = eye.xz - ray.xz * (eye.y / min(ray.y, -1e-3));
#if EDGE
    colour = mix(colour, resized(colour, place), kept.a);
#endif
    vec4 here = texture(floor_map, place / (2.0 * stage.zw) + 0.5);
    colour *= 1.0 - kept.a * here.a;
    colour += (here.rgb + square3(texture(mirror, at).rgb)) * kept.a;
#endif
#if FLOOR && POOLS
    colour += pools(vec3(place.x, 0.0, place.y)) * kept.a * (1.0 - 0.8 * here.a);
#endif
    colour *= key_light.w * answer() * light_stage();
#if HDR
    shown = vec4(compressed(colour), 1.0);
#else
    shown = vec4(to_picture(colour, gl_FragCoord.xy), 1.0);
#endif
}
