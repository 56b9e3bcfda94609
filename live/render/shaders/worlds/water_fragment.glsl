// Dark water to the horizon under a night sky with a band of last light; its waves come later (stage_fragment.glsl).
#include "backdrop.glsl"

vec3 sky(vec3 d) {
    float up = max(d.y, 0.0);
    float middle = exp(-square(d.x / 0.55));
    vec3 glow = rim_light.rgb * (0.17 * exp(-up * 17.0) + 0.030 * exp(-up * 5.0)) * (0.25 + 0.75 * middle);
    glow += key_light.rgb * (0.26 * exp(-up * 26.0) * middle);
    float veil = clouds(vec2(d.x * 0.8, up * 3.2) + 0.2);
    glow *= 0.65 + 0.55 * smoothstep(0.25, 0.85, veil);
    return own_background(0.02) * (1.4 + 1.2 * exp(-up * 3.0)) + glow;
}

void main() {
    vec3 d = normalize(ray);
    float to_floor = floor_reach(d);
    if (to_floor > 900.0) {
        keep(sky(d), 0.0);
        return;
    }
    vec3 p = eye.xyz + d * to_floor;
    // Schlick 1994, for water
    float fresnel = 0.02 + 0.98 * pow(1.0 - clamp(-d.y, 0.0, 1.0), 5.0);
    vec3 mirrored = vec3(d.x, max(-d.y, 0.004), d.z);
    vec2 off = p.xz / (stage.xy + vec2(1.0, 1.4));
    float pool = 1.0 / (1.0 + square(dot(off, off)) * 0.8);
    vec3 deep = own_floor(0.02) * (0.5 + 1.4 * pool) + key_light.rgb * own_floor(0.02) * (1.5 * pool);
    float away = smoothstep(60.0, 4.0, to_floor);
    vec3 colour = deep * (1.0 - fresnel) + sky(mirrored) * fresnel * 0.9;
    float horizon = smoothstep(-0.022, 0.0, d.y);
    colour = mix(colour, sky(vec3(d.x, 0.0, d.z)) * 0.85, horizon);
    keep(colour, away);
}
