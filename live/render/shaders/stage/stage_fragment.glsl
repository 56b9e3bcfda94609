// Behind the dancers: the kept backdrop, with this moment's shadows, elements and mirror images on the floor.
#include "frame.glsl"
#include "finish.glsl"
#if BEAMS
#include "beams.glsl"
#endif

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

#if FLOOR && BEAMS
// Pools of the follow spots on the floor; those of the beams are soft, so they are on the floor map.
vec3 pools(vec3 place) {
    vec3 sum = vec3(0.0);
    for (int k = spots_begin(); k < spots_end(); ++k) sum += spot_light[k].rgb * spot_reach(k, place);
    return sum * (0.03 + 1.7 * light_floor());
}
#endif

#if PATTERNS || WATER
#include "moving.glsl"
#endif

#if PATTERNS
// Light of the floor's patterns: how bright each is here, and all together.
float patterns(vec2 place, float height) {
    float size = floor_pattern_size(), phase = edge.w;
    vec2 p = place / size, fine = fwidth(p) + 1e-4;
    float sum = floor_pattern_rings() * clamp(height * 1.6, 0.0, 1.0);
    vec2 line = abs(fract(p + 0.5) - 0.5);
    vec2 drawn = 1.0 - smoothstep(vec2(0.018), vec2(0.018) + fine * 1.2, line);
    sum += floor_pattern_grid() * max(drawn.x, drawn.y) * min(0.03 / max(fine.x, fine.y), 1.0) * (0.55 + 0.45 * key_direction.w);
    // squares that change places: each fades over a whole beat, so that nothing flashes
    float turn = 0.5 - 0.5 * cos(3.14159265 * beam_light.w);
    vec2 side = clamp((0.25 - abs(fract(p * 0.5) - 0.5)) / (fine * 0.75) , -1.0, 1.0);
    float square_ = 0.5 + 0.5 * side.x * side.y;
    sum += floor_pattern_checker() * mix(square_, 1.0 - square_, turn);
    float moved = floor(beam_light.w) + smoothstep(0.0, 0.6, phase);
    float stripe = (0.25 - abs(fract((p.x + moved) * 0.5) - 0.5)) / (fine.x * 0.75);
    sum += floor_pattern_stripes() * clamp(0.5 + stripe, 0.0, 1.0);
    vec2 beyond = abs(place) - edge.xy;
    return sum * smoothstep(0.5, -0.4, max(beyond.x, beyond.y));
}

#endif

void main() {
    vec2 bend = vec2(0.0);
#if FLOOR
    vec2 place = eye.xz - ray.xz * (eye.y / min(ray.y, -1e-3));
#if PATTERNS || WATER
    vec3 ring = rings(place);
#endif
#if WATER
    float away = distance(vec3(place.x, 0.0, place.y), eye.xyz);
    vec2 slope = (waves(place) * 0.16 + ring.xy * 0.8) / (1.0 + 0.06 * away);
    bend = slope * vec2(0.16 * 16.0 / 9.0 * whole_picture.y * whole_picture.z, 0.22) * (share_water() / (1.0 + 0.05 * away));
    bend.y = min(bend.y, max(-ray.y * picture_part.w / max(ray_up.y, 1e-3 * picture_part.w) - 0.004, 0.0));   // never above the horizon
    bend /= picture_part.zw;
#endif
#endif
    vec4 kept = textureLod(backdrop, at + bend, 0.0);   // one texel; while light or camera move it may be smaller
    vec3 colour = square3(kept.rgb);
#if FLOOR
#if EDGE
    colour = mix(colour, resized(colour, place), kept.a);
#endif
    vec4 here = textureLod(floor_map, place / (2.0 * stage.zw) + 0.5, 0.0);
    colour *= 1.0 - kept.a * here.a;
#if PATTERNS
    float other = clamp(0.16 + 0.4 * fill_above.g, 0.0, 0.7);   // light that comes from elsewhere
    colour *= mix(1.0, other + (1.0 - other) * gobo_at(vec3(place.x, 0.0, place.y)), kept.a);
#endif
    colour += (here.rgb + square3(textureLod(mirror, at + bend, 0.0).rgb)) * kept.a;
#if PATTERNS
    float lit = patterns(place, ring.z) * kept.a * (1.0 - 0.7 * here.a);
    colour += floor_pattern_colour() * (lit * (0.05 + 0.55 * light_floor()));
    colour *= mix(vec3(1.0), floor_pattern_colour(), min(lit, 1.0) * 0.8 * min(light_floor() * 1.4, 1.0));
#endif
#if WATER
    // glints of the light behind on the backs of the waves, and the web of light below them
    float glint = smoothstep(0.03, 0.22, slope.y) * kept.a * share_water();
    colour += rim_light.rgb * (glint * 0.11) + key_light.rgb * (glint * glint * 0.03);
    vec2 middle = place / (stage.xy + 0.6);
    colour += (key_light.rgb * 0.028 + rim_light.rgb * 0.020) * (share_water() * kept.a * caustics(place + slope * 1.5) / (1.0 + square(dot(middle, middle))));
#endif
#endif
#if FLOOR && BEAMS
    colour += pools(vec3(place.x, 0.0, place.y)) * kept.a * (1.0 - 0.8 * here.a);
#endif
    colour *= key_light.w * answer() * light_stage();
#if BEAMS
    colour = beams_over(colour, at, 1.0);
#endif
#if HDR
    shown = vec4(compressed(colour), 1.0);
#else
    shown = vec4(to_picture(colour, gl_FragCoord.xy), 1.0);
#endif
}
