// Pools of the beams on the floor map.
#include "frame.glsl"
#include "beams.glsl"

in vec2 at;
out vec4 shown;

void main() {
    vec2 place = (at - 0.5) * 2.0 * stage.zw;
    vec3 sum = vec3(0.0);
    for (int k = 0; k < LAMPS; ++k) {
        vec3 lamp = beam_lamp(k);
        vec2 foot = beam_foot(k), off = place - foot;
        float width = 0.06 + light_beams_width() * distance(lamp, vec3(foot, 0.0).xzy);
        off.y /= 1.0 + 0.5 * abs(foot.y - lamp.z) / lamp.y;   // it falls aslant
        sum += beam_tint(k) * exp(-2.0 * dot(off, off) / square(1.25 * width)) * 0.6;
    }
    vec2 beside = abs(at - 0.5);
    float inside = smoothstep(0.5, 0.44, max(beside.x, beside.y));
    shown = vec4(sum * beam_answer() * (0.03 + 1.7 * light_floor()) * inside, 0.0);
}
