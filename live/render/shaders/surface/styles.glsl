// The styles of all groups, and what a dancer's own chance makes of them. After surface.glsl.
#include "style_values.glsl"

vec4 who(int dancer) { return material(5, dancer); }   // group, three numbers by chance
int group_of(vec4 who_) { return int(who_.x * 255.0 + 0.5); }

// solid, silhouette, ink, xray
vec4 amounts(int group) {
    return vec4(style_solid(group), style_silhouette(group), style_ink(group), style_xray(group));
}

// How much of her body hides what is behind it.
float fill_of(vec4 amount) { return min(amount.x + amount.y + amount.z, 1.0); }

// How much of a shadow she casts.
float presence(int group) {
    vec4 amount = amounts(group);
    return max(fill_of(amount), 0.4 * max(amount.w, style_particles(group)));
}

// The colour of a dancer's light: of her clothes, as bright as can be.
vec3 glow_of(int dancer) {
    vec3 cloth = material(0, dancer).rgb;
    cloth *= cloth;
    return cloth / max(max(cloth.r, max(cloth.g, cloth.b)), 1e-3);
}

// How much brighter all colours of a group are now than without the beat.
float answer(int group) { return 1.0 + style_pulse(group) * (1.5 * key_direction.w - 0.35); }

float hash3(vec3 p) {
    p = fract(p * vec3(0.1031, 0.1030, 0.0973));
    p += dot(p, p.yxz + 33.33);
    return fract((p.x + p.y) * p.z);
}

float noise3(vec3 p) {
    vec3 i = floor(p), f = p - i;
    f *= f * (3.0 - 2.0 * f);
    vec4 low = vec4(hash3(i), hash3(i + vec3(1, 0, 0)), hash3(i + vec3(0, 1, 0)), hash3(i + vec3(1, 1, 0)));
    vec4 high = vec4(hash3(i + vec3(0, 0, 1)), hash3(i + vec3(1, 0, 1)), hash3(i + vec3(0, 1, 1)), hash3(i + vec3(1, 1, 1)));
    vec4 flat_ = mix(low, high, f.z);
    vec2 line = mix(flat_.xz, flat_.yw, f.x);
    return mix(line.x, line.y, f.y);
}
