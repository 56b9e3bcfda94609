// A drawing of the picture: washes of watercolour, hatching in the shade, ink along contours and folds, on paper.
#include "finish.glsl"
#include "noise.glsl"
#if BODIES
#include "ink_lines.glsl"
#endif

// Where the processor draws, both ways of a branch cost; a loop that runs for no pixel costs next to nothing.
in vec2 at;
uniform sampler2D light;
uniform vec2 stroke;     // where in the noise this drawing's hand is
uniform vec2 levels;     // of the noise's smaller copies: for the sheet, for the hand
uniform int fading;      // 1: another world is seen, too
out vec4 shown;

// Strokes of a pen side by side: how much ink, where so much of the white is to be covered.
float hatch(vec2 pixel, vec2 across, float apart, float tremble, float cover) {
    float t = abs(fract(dot(pixel, across) / apart + tremble) - 0.5) * 2.0;
    return smoothstep(1.0 - cover - 0.18, 1.0 - cover + 0.18, 1.0 - t) * step(0.02, cover);
}

void main() {
    float scale = whole_picture.y / 720.0;
    vec2 pixel = (gl_FragCoord.xy + picture_part.xy) / scale;
    vec4 sheet = textureLod(noise_map, pixel / 460.0, levels.x);
    vec4 hand = textureLod(noise_map, pixel / 620.0 + stroke, levels.y);
    // the hand is not quite steady
    vec2 place = at + (hand.rg - 0.5) * (3.4 * scale) * picture.zw;
    float level = max(key_light.w, 1e-3);
#if BODIES
    vec3 lit = expanded(textureLod(light, place, 0.0).rgb) / level;
#else
    ivec2 pixel_there = clamp(ivec2(place * picture.xy), ivec2(0), ivec2(picture.xy) - 1);   // beyond bodies all is soft
    vec3 lit = expanded(texelFetch(light, pixel_there, 0).rgb) / level;
#endif
    float bright = dot(lit, vec3(0.2126, 0.7152, 0.0722));
    // hatching: in the shade of bodies along two directions, in shadows on the ground along one
    float body = 0.0, turned = 0.5, dark = smoothstep(0.50, 0.14, bright), lines = 0.0;
    vec3 drawn = lit;
#if BODIES
    vec4 name = textureLod(who, place, 0.0);
    body = name.a;
    for (int k = 0; k < int(body > 0.0); ++k) {
        vec4 broad = textureLod(noise_map, pixel / 1500.0 + stroke, 0.0);
        vec3 n = textureLod(shape, place, 0.0).xyz * 2.0 - 1.0;
        float value = max(lit.r, max(lit.g, lit.b));
        vec3 hue = lit / max(value, 1e-3);
        hue = mix(vec3(dot(hue, vec3(0.30, 0.59, 0.11))), hue, 1.12);

        // washes: pale in the light, where the paper is left, denser in two steps towards the shade; pigment runs to the border
        turned = dot(n, key_direction.xyz) * 0.5 + 0.5;
        float tone = value * 0.55 + turned * 0.45 + (broad.r - 0.5) * 0.34;
        float first = smoothstep(1.08, 0.84, tone), second = smoothstep(0.66, 0.56, tone);
        vec2 reach = picture.zw * (6.0 * scale);
        const vec2 WAYS[3] = vec2[3](vec2(0.0, 1.0), vec2(-0.87, -0.5), vec2(0.87, -0.5));
        float border = 0.0;
        for (int i = 0; i < 3; ++i) border += textureLod(who, place + reach * WAYS[i], 0.0).rg == name.rg ? 0.0 : 0.33;
        float pigment = 0.34 + 0.36 * first + 0.42 * second + 0.42 * border + 0.26 * (hand.g - 0.5);
        pigment *= 0.82 + 0.36 * sheet.b;   // it settles in the grain
        vec3 paper = light_background() * (key_light.rgb * 0.5 + fill_above.rgb * 0.25);
        vec3 thin = mix(vec3(1.0), clamp(hue, 0.02, 1.0), clamp(pigment * 1.05, 0.0, 1.0));
        vec3 wash = paper * thin * mix(1.0, 0.30, smoothstep(0.62, 0.02, value) * clamp(pigment + 0.35, 0.0, 1.0));
        wash = mix(wash, paper, 0.75 * smoothstep(1.12, 1.30, tone) );
        drawn = mix(lit, wash, body);
        dark = mix(dark, max(smoothstep(0.60, 0.36, tone), 0.9 * smoothstep(0.16, 0.03, value)), body);
        lines = body * hatch(pixel, vec2(0.97, 0.24), 6.2, (hand.g - 0.5) * 0.7, smoothstep(0.72, 1.0, dark) * 0.34);
    }
#endif
    lines = max(lines, hatch(pixel, vec2(0.707, 0.707), 5.2, (hand.r - 0.5) * 0.7, dark * 0.36));
    const vec3 INK = vec3(0.020, 0.018, 0.030);
    drawn = mix(drawn, INK, lines * (0.52 + 0.25 * sheet.b) * mix(0.6, 1.0, body));

#if BODIES
    // ink: thick away from the light and where the hand presses, thin and sometimes dry in the light
    float press = (0.55 + 1.15 * hand.r) * (1.45 - 0.8 * turned * body);
    float ink = line(place, 1.55 * scale * press) * mix(0.62, 1.0, smoothstep(0.12, 0.42, hand.g + 0.25 * sheet.b));
    drawn = mix(drawn, INK, ink);
#endif

    // the sheet itself: its grain in a low light, and fibres
    drawn *= 1.0 + 0.085 * (sheet.b - 0.5) + 0.10 * (sheet.a - 0.5) + 0.05 * (sheet.g - 0.5);
    drawn = max(drawn, 0.0) * level;
    for (int k = 0; k < fading; ++k) drawn = mix(expanded(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb), drawn, share_paper());
    shown = vec4(compressed(drawn), 1.0);
}
