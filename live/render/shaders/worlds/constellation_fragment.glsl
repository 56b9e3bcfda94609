// Space: nearly black, with a faint band of dust; the stars and lines are points and strokes of their own.
#include "backdrop.glsl"

void main() {
    vec3 d = normalize(ray);
    // a band that leans across the picture
    float band = exp(-square((d.y - 0.10 - 0.32 * d.x) / 0.30));
    float dust = clouds(vec2(d.x, d.y) * 0.85 + 0.17), fine = clouds(vec2(d.y, d.x) * 2.3 + 0.6);
    float glow = band * smoothstep(0.25, 1.0, 0.65 * dust + 0.35 * fine);
    vec3 tint = mix(vec3(0.16, 0.20, 0.62), vec3(0.62, 0.22, 0.50), smoothstep(0.3, 0.8, fine));
    vec3 colour = own_background(0.012) + tint * (rim_light.rgb + 0.4) * (0.050 * glow);
    // ground that is hardly there: a breath of light below the dancers
    float to_floor = floor_reach(d);
    vec3 p = eye.xyz + d * min(to_floor, 80.0);
    vec2 off = p.xz / (stage.xy * 1.15);
    float here = step(to_floor, 79.0) * exp(-dot(off, off) * 1.1);
    colour += (own_floor(0.02) * 1.3 + rim_light.rgb * 0.012) * here;
    keep(colour, here);
}
