// A picture in linear light, compressed: on a wall, on the floor with its shadows, or on a gauze before the dancers.
#include "frame.glsl"
#include "finish.glsl"
in vec2 texel;
in vec2 inside;
in vec3 place;
uniform sampler2D shown_texture;
uniform sampler2D floor_map;
uniform float amount;
uniform float brightness;
uniform int kind;         // 0: the whole picture, 1: a wall, 2: the floor, 3: a gauze
uniform int adds;         // 1: its light is added
uniform int grounded;     // 1: its lower edge is on the floor, and sharp
uniform int mirrored;
out vec4 shown;           // premultiplied

const float BORDER = 0.03;   // how much of it is soft at its edges

void main() {
    vec4 s = texture(shown_texture, texel);
    vec3 light = mix(s.rgb / 12.92, pow((s.rgb + 0.055) / 1.055, vec3(2.4)), step(0.04045, s.rgb));   // IEC 61966-2-1
    float cover = amount * s.a;
    if (kind > 0) {
        vec2 soft = smoothstep(vec2(0.0), vec2(BORDER), inside) * smoothstep(vec2(0.0), vec2(BORDER), 1.0 - inside);
        if (mirrored == 1 || grounded == 1 && inside.y < 0.5) soft.y = 1.0;
        cover *= soft.x * soft.y;
        if (mirrored == 1) cover *= 0.16 * pass_mirror() * exp(-place.y * 0.9);
        light *= answer();
    }
    if (kind == 2) {
        vec4 here = texture(floor_map, place.xz / (2.0 * stage.zw) + 0.5);
        light = light * (1.0 - here.a) + here.rgb;
        cover *= (1.0 - 0.12 * pass_mirror()) * (1.0 - haze_at(place));   // the floor's own gloss lies over it
    }
    vec3 over = compressed(light * brightness * key_light.w) * cover;
    // added light hides as much as keeps the sum in the compressed range
    shown = vec4(over, adds == 1 ? max(over.r, max(over.g, over.b)) : cover);
}
