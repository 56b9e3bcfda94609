// What moves in the key light and on the floor: gobos, waves, caustics.
#include "noise.glsl"
uniform sampler2D gobo_map;
uniform sampler2D ripple_map;   // of the floor: slopes of the rings to the right and to the front, their height

// How much of the key light comes through the gobo to a place.
float gobo_at(vec3 place) {
    vec2 p = place.xz - key_direction.xz / key_direction.y * place.y;
    vec2 at = vec2(dot(p, gobo.xy), dot(p, vec2(-gobo.y, gobo.x))) + 0.5;
    vec4 amount = vec4(light_gobo_leaves(), light_gobo_window(), light_gobo_blinds(), light_gobo_breakup());
    vec2 off = p / (stage.xy + 2.5);   // one lamp lights no more than the stage
    float here = 1.0 - smoothstep(0.9, 2.2, dot(off, off));
    return 1.0 + here * (dot(texture(gobo_map, at), amount) - gobo.z) / max(gobo.z, 1.0);
}

// Slopes of small waves on the water: two that cross; the same after 64 beats.
vec2 waves(vec2 p) {
    float t = beam_light.w / 64.0;
    vec2 a = texture(noise_map, p * 0.11 + vec2(2.0, 3.0) * t).rg - 0.5;
    vec2 b = texture(noise_map, p.yx * 0.23 + vec2(-5.0, 4.0) * t).rg - 0.5;
    return a + 0.6 * b;
}

vec3 rings(vec2 p) {
    vec2 at = p / (2.0 * stage.zw) + 0.5, beside = abs(at - 0.5);
    return texture(ripple_map, at).rgb * smoothstep(0.5, 0.46, max(beside.x, beside.y));
}

// The web of light that waves throw: bright where two soft noises are both near their middle.
float caustics(vec2 p) {
    float t = beam_light.w / 64.0;
    float a = texture(noise_map, p * 0.16 + vec2(3.0, -2.0) * t).r - 0.5;
    float b = texture(noise_map, p.yx * 0.19 + vec2(-2.0, -4.0) * t).r - 0.5;
    float web = 1.0 - min(abs(a) + abs(b) * 0.8, 0.5) * 2.0;
    web *= web;
    return web * web;
}
