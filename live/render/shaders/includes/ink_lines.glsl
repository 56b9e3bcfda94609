// Where a line of ink is due: where one thing ends and another begins, by dancer, by depth, by normal.
uniform sampler2D depth;
uniform sampler2D shape;
uniform sampler2D who;

float away(vec2 place) {
    float z = textureLod(depth, place, 0.0).r * 2.0 - 1.0;
    return 2.0 * FAR * NEAR / (FAR + NEAR - z * (FAR - NEAR));
}

#ifndef TAPS
#define TAPS 8   // or 4, where pixels are dear
#endif
const int EVERY = 8 / TAPS;

// `width` [pixels]
float line(vec2 place, float width) {
    const vec2 RING[8] = vec2[8](vec2(1.0, 0.0), vec2(0.7, 0.7), vec2(0.0, 1.0), vec2(-0.7, 0.7),
                                 vec2(-1.0, 0.0), vec2(-0.7, -0.7), vec2(0.0, -1.0), vec2(0.7, -0.7));
    vec2 reach = picture.zw * (width + 1e-3);   // never between two texels, where rounding would decide
    vec4 here = textureLod(who, place, 0.0);
    // a contour, half as wide on either side: the share of the ring that is somebody else
    float others = 0.0;
    for (int i = 0; i < TAPS; ++i) {
        vec4 there = textureLod(who, place + reach * RING[EVERY * i], 0.0);
        others += there.rg == here.rg ? 0.0 : float(EVERY);
    }
    float drawn = smoothstep(0.5, 3.0, others);
    // within a body: depth that leaps (a leg before the other), normals that break (an armpit, a bent knee). A loop that
    // runs for no pixel costs next to nothing where the processor draws; a branch would cost it as much as the lines.
    for (int k = 0; k < int(here.a > 0.0); ++k) {
        float middle = away(place), leap = 0.0, fold = 0.0;
        for (int i = 0; i < TAPS / 2; ++i) {
            vec2 a = place + reach * RING[EVERY * i], b = place - reach * RING[EVERY * i];
            leap = max(leap, abs(away(a) + away(b) - 2.0 * middle));
            vec3 na = normalize(textureLod(shape, a, 0.0).xyz - 0.5), nb = normalize(textureLod(shape, b, 0.0).xyz - 0.5);
            fold = max(fold, 1.0 - dot(na, nb));
        }
        drawn = max(drawn, max(smoothstep(0.05, 0.12, leap), 0.75 * smoothstep(0.75, 1.3, fold)));
    }
    return drawn;
}
