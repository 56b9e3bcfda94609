// An image or a video in linear light, compressed.
#include "frame.glsl"
#include "finish.glsl"
in vec2 texel;
in vec2 inside;
in float up;
uniform sampler2D shown_texture;
uniform vec4 wall;
uniform float amount;
uniform float brightness;
uniform int mirrored;
out vec4 shown;

void main() {
    vec3 s = texture(shown_texture, texel).rgb;
    vec3 light = mix(s / 12.92, pow((s + 0.055) / 1.055, vec3(2.4)), step(0.04045, s));   // IEC 61966-2-1
    float cover = amount;
    if (wall.z > 0.0) {
        vec2 edge_soft = smoothstep(vec2(0.0), vec2(0.03), inside) * smoothstep(vec2(0.0), vec2(0.03), 1.0 - inside);
        cover *= edge_soft.x * (mirrored == 1 ? 1.0 : mix(edge_soft.y, 1.0, wall.y <= 0.0 && inside.y < 0.5 ? 1.0 : 0.0));
        if (mirrored == 1) cover *= 0.16 * pass_mirror() * exp(-up * 0.9);
        light *= answer();
    }
    shown = vec4(compressed(light * brightness * key_light.w), cover);
}
