// Dark where the set stands, with a rim of the light from behind; a real dancer stands in a soft ring.
#include "frame.glsl"

in vec2 place;
flat in vec4 ends;
flat in vec2 form;
uniform float texel;
out vec4 shown;

void main() {
    vec2 way = ends.zw - ends.xy, from = place - ends.xy;
    vec2 off = from - way * clamp(dot(from, way) / max(dot(way, way), 1e-9), 0.0, 1.0);
    float d = length(off) - form.x;
    if (form.y < 0.5) {
        float ring = exp(-square(d / max(0.10, 0.6 * texel))) * 0.5 + exp(-square(d / 0.35)) * 0.25;
        shown = vec4(key_light.rgb * (0.16 * ring), 0.0);
        return;
    }
    float dark = 1.0 - smoothstep(-texel, texel, d);
    float soft = exp(-max(d, 0.0) / 0.22) * 0.35 * (1.0 - smoothstep(0.3, 0.6, d));   // it takes some light from the floor around it, too
    float width = max(0.035, 0.95 * texel);
    float rim = exp(-square(d / width)) * sqrt(0.035 / width);
    float back = 0.5 - 0.5 * normalize(off + vec2(1e-5, 0.0)).y;   // the lamps stand behind
    shown = vec4(rim_light.rgb * (rim * (0.10 + 0.24 * back)), max(dark * 0.72, soft));
}
