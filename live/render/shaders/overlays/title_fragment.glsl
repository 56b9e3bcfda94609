// A letter from its distance field (Green 2007): sharp at every size, with a soft shadow where it lies on a picture.
#include "frame.glsl"
#include "finish.glsl"
in vec2 texel;
in float across;
in float shows;
in vec3 place;
uniform sampler2D field;
uniform int standing;
uniform int entrance;
uniform int mirrored;
uniform float progress;
uniform float level;
uniform vec3 colour;
out vec4 shown;           // premultiplied in the stage, else straight

void main() {
    float away = texture(field, texel).r;
    float pixel = max(length(vec2(dFdx(away), dFdy(away))), 1e-4);
    float fill = clamp((away - 0.5) / pixel + 0.5, 0.0, 1.0);
    float seen = level * shows;
    if (entrance == 3) seen *= smoothstep(across - 0.04, across, progress * 1.04);
    if (standing == 1) {
        float cover = fill * seen;
        if (mirrored == 1) cover *= 0.22 * pass_mirror() * exp(-place.y * 0.7);
        vec3 light = mix(colour * answer(), haze_light(place.y), haze_at(place));
        shown = vec4(compressed(light * key_light.w) * cover, cover);
        return;
    }
    float shadow = 0.55 * smoothstep(0.05, 0.5, away) * (1.0 - fill);
    float cover = fill + shadow;
    vec3 light = film(colour * 1.25);
    shown = vec4(light * fill / max(cover, 1e-4), cover * seen * min(key_light.w, 1.0));
}
