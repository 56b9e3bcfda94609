// A circle, and in it a triangle that points to where she faces.
#include "frame.glsl"
#include "finish.glsl"
in vec2 offset;
flat in vec3 tint;
uniform float amount;
out vec4 shown;

void main() {
    float pixel = max(length(fwidth(offset)) * 0.7, 1e-4);
    float off = length(offset) - 0.36;
    float disc = 1.0 - smoothstep(-pixel, pixel, off);
    float ring = 1.0 - smoothstep(0.016, 0.016 + pixel, abs(off + 0.02));
    // corners at (0, 0.28) and (+-0.19, -0.19)
    vec2 p = vec2(abs(offset.x), offset.y);
    float side = dot(p - vec2(0.0, 0.28), normalize(vec2(0.47, 0.19)));
    float arrow = 1.0 - smoothstep(-0.5 * pixel, 0.5 * pixel, max(side, -0.19 - p.y));
    vec3 colour = mix(tint * 0.30, tint * 1.05, max(ring, arrow));
    float cover = max(disc * 0.80, ring);
    shown = vec4(compressed(colour * key_light.w), cover * amount);
}
