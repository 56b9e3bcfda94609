// What runs along lines, or over them: crossings, paths, uniform flows.
#include "frame.glsl"
#include "element_light.glsl"

in vec2 at;
in vec2 place;
flat in vec2 ends;
flat in vec2 whole;
flat in int kind;
flat in float level;
flat in float radius;
flat in float way;
flat in int everywhere;
out vec4 light;

float on_stage() {
    vec2 beyond = max(abs(place) - edge.xy, 0.0);
    return 1.0 - smoothstep(0.0, 0.9, length(beyond));
}

// A bar from edge to edge; sparks go over it on each measure of length, turn and turn about to either side.
vec3 crossing(float pulse) {
    float lane = floor(at.x / 0.7);
    float to = mod(lane, 2.0) < 0.5 ? 1.0 : -1.0;
    float phase = fract(beat * 0.5 + 0.13 * hash(lane));
    float head = (phase * 2.0 - 1.0) * 1.15;
    float behind = head - at.y * to;
    float spark = behind > 0.0 ? exp(-behind / 0.28) : bell(behind, 0.05);
    spark *= hairline(at.x - (lane + 0.5) * 0.7, 0.05) * smoothstep(0.0, 0.2, phase) * (1.0 - smoothstep(0.75, 1.0, phase));
    float bar = hairline(at.y, 0.05) * (0.34 + 0.14 * pulse) + bell(at.y, 0.30) * 0.09;
    return LILAC * (bar + spark * 0.42) * on_stage();
}

// Dashes that march to the beat.
vec3 path() {
    float beyond = max(max(ends.x - at.x, at.x - ends.y), 0.0);
    if (beyond > 0.3) return vec3(0.0);
    float period = whole.y > 0.5 ? whole.x / max(round(whole.x / 0.55), 1.0) : 0.55;
    float step = fract(clamp(at.x, ends.x, ends.y) / period - beat * 0.25) - 0.5;
    float off = length(vec2(max(abs(step) * period - 0.13, 0.0), at.y));
    float dash = beyond > 0.0 ? 0.0 : hairline(off, 0.05);
    float fade = whole.y > 0.5 ? 1.0 : smoothstep(0.0, 0.25, at.x) * (1.0 - smoothstep(whole.x - 0.25, whole.x, at.x));
    float side = length(vec2(beyond, at.y));
    float band = radius > 0.0 ? 0.035 * (1.0 - smoothstep(radius - 0.1, radius + 0.25, side)) : 0.04 * bell(side, 0.18);
    return PALE * (dash * fade * 0.50 + band);
}

vec3 current() {
    float lane = floor(at.y / 0.24);
    float middle = (lane + 0.5) * 0.24 + (hash(lane + 5.0) - 0.5) * 0.08;
    float light = stream(way * at.x, lane + 100.0, at.y - middle, 0.045, 2.4);
    float beyond = max(max(ends.x - at.x, at.x - ends.y), 0.0);
    float fade;
    if (everywhere == 1) fade = on_stage() * 0.6;
    else fade = 1.0 - smoothstep(radius - 0.3, radius + 0.5, length(vec2(beyond, at.y)));
    return SILVER * (light * 0.62 + (everywhere == 1 ? 0.0 : 0.02)) * fade;
}

void main() {
    float pulse = square(1.0 - edge.w);
    vec3 colour = kind == CROSSING ? crossing(pulse) : (kind == PATH ? path() : current());
    light = vec4(colour * level * ELEMENT_LIGHT, 0.0);
}
