// Light on the floor where an element acts: attractor, repulsor, spreader.
#include "frame.glsl"

in vec2 offset;
flat in float kind;
flat in float level;
out vec4 light;

vec3 attractor(float away, float pulse) {
    float pool = exp(-square(away / (0.62 + 0.08 * pulse)));
    float ring = exp(-square((away - 0.95 - 0.10 * pulse) / 0.07)) * 0.28;
    return vec3(1.0, 0.52, 0.18) * (pool * (0.42 + 0.16 * pulse) + ring * (0.4 + 0.6 * pulse));
}

vec3 repulsor(float away, float pulse) {
    float ring = exp(-square((away - 0.85) / 0.085));
    float outer = exp(-square((away - 1.15 - 0.30 * (1.0 - pulse)) / 0.10)) * 0.35 * pulse;
    float within = (1.0 - smoothstep(0.55, 0.85, away)) * 0.05;
    return vec3(0.20, 0.55, 1.0) * (ring * 0.55 + outer + within);
}

vec3 spreader(float away, float pulse) {
    vec2 cell = abs(fract(offset / 0.8) - 0.5) * 0.8;
    float line = max(exp(-square((0.4 - cell.x) / 0.022)), exp(-square((0.4 - cell.y) / 0.022)));
    float halo = exp(-square((away - 2.2 - 0.4 * (1.0 - pulse)) / 0.22)) * 0.35;
    float fade = 1.0 - smoothstep(1.0, 2.7, away);
    return vec3(0.62, 0.95, 0.72) * (line * fade * 0.16 + fade * 0.035 + halo * 0.5);
}

void main() {
    float away = length(offset);
    float pulse = square(1.0 - floor_colour.w);
    vec3 colour = kind < 0.5 ? attractor(away, pulse) : (kind < 1.5 ? repulsor(away, pulse) : spreader(away, pulse));
    light = vec4(colour * level * 0.55, 0.0);
}
