// Faces, eyes and hair by part (surface_parts.py) and by place on the usual head. After surface.glsl's material().
#ifndef VERTEX
const vec2 EYE_AT = vec2(0.0310, 1.5940);   // side, height [m]
const float IRIS = 0.0061, PUPIL = 0.0025;

float streak(vec2 p) {   // chance without sines (Hoskins, Hash without Sine, 2014)
    vec3 q = fract(p.xyx * 0.1031);
    q += dot(q, q.yzx + 33.33);
    return fract((q.x + q.y) * q.z);
}

float uneven(vec2 p) {   // smooth chance, about 0.5
    vec2 i = floor(p), f = p - i;
    f *= f * (3.0 - 2.0 * f);
    return mix(mix(streak(i), streak(i + vec2(1.0, 0.0)), f.x), mix(streak(i + vec2(0.0, 1.0)), streak(i + 1.0), f.x), f.y);
}

// What is finer than a pixel where pixels are dear.
#if SOFT
float grain_of(vec2 p) { return uneven(p); }
#else
float grain_of(vec2 p) { return 0.5; }
#endif

float bulge(float squared) { return square(max(1.0 - 0.25 * squared, 0.0)) * max(1.0 - 0.25 * squared, 0.0); }   // about exp(-squared)

// White, iris and pupil by the offset from where the eye looks [m]; square roots of colours.
vec3 eye_colour(vec2 off, int dancer, float skin_light) {
    vec3 own = material(IDENTITY, dancer).yzw;
    float kind = own.y;   // the paler the skin, the more eyes are not brown
    vec3 brown = mix(vec3(0.25, 0.15, 0.10), vec3(0.46, 0.29, 0.16), own.z);
    vec3 light = kind < 0.35 ? vec3(0.36, 0.47, 0.58) : (kind < 0.6 ? vec3(0.40, 0.45, 0.32) : vec3(0.47, 0.40, 0.24));
    vec3 iris = own.x * 1.3 < (skin_light - 0.56) * 3.2 ? light : brown;
    float away = length(off), turn = atan(off.y, off.x);
    float fibre = 0.82 + 0.36 * grain_of(vec2(turn * 5.0 + 20.0, away * 1400.0));
    iris *= fibre * mix(1.15, 0.72, smoothstep(0.55, 1.0, away / IRIS)) * (0.94 - 34.0 * off.y);
    vec3 white = vec3(0.79, 0.765, 0.74) * mix(0.74, 1.0, skin_light) - vec3(0.02, 0.10, 0.10) * smoothstep(0.007, 0.011, abs(off.x));
    white *= 1.0 - 0.34 * smoothstep(-0.001, 0.005, off.y);   // in the upper lid's shadow
    vec3 colour = mix(iris, white, smoothstep(IRIS - 0.0006, IRIS + 0.0003, away));
    colour *= smoothstep(PUPIL - 0.0004, PUPIL + 0.0004, away) * 0.96 + 0.04;
    return mix(colour, vec3(1.0), 0.92 * (1.0 - smoothstep(0.0007, 0.0013, length(off - vec2(-0.0020, 0.0024)))));
}

vec4 face_colour(vec3 rest, int dancer, bool painted) {
    vec4 skin = material(SKIN, dancer), hair = material(HAIR, dancer);
    vec3 own = material(IDENTITY, dancer).yzw;
    float s = abs(rest.x), y = rest.y;
    float front = smoothstep(0.030, 0.055, rest.z);
    vec3 colour = skin.rgb;
    float bright = dot(colour, vec3(0.3, 0.6, 0.1));
    // blood: cheeks, tip of the nose, chin; cooler around the eyes
    vec2 cheek = vec2(s - 0.045, y - 1.562) / vec2(0.019, 0.016), tip = vec2(s, y - 1.558) / vec2(0.013, 0.010);
    float warm = bulge(dot(cheek, cheek)) * 0.65 + bulge(dot(tip, tip)) * 0.5 * smoothstep(0.09, 0.10, rest.z);
    colour *= mix(vec3(1.0), vec3(1.05, 0.915, 0.90), warm * front);
    vec2 eye = vec2(s, y) - EYE_AT;
    vec2 socket = (eye - vec2(-0.003, 0.002)) / vec2(0.021, 0.0135);
    colour *= mix(vec3(1.0), vec3(0.90, 0.87, 0.88), bulge(dot(socket, socket)) * front);
    colour *= 0.985 + 0.03 * grain_of(rest.xy * 420.0);
    // lips between the curves of their borders
    float t = min(s / 0.0247, 1.0);
    float upper = 1.53685 - 0.0093 * t * t - 0.0007 * bulge(square(s / 0.0028)), lower = 1.5174 + 0.0101 * t * t * sqrt(t);
    float lips = smoothstep(-0.0004, 0.0007, min(upper - y, y - lower)) * (1.0 - smoothstep(0.0236, 0.0250, s)) * step(0.06, rest.z);
    vec3 red = colour * mix(vec3(0.95, 0.76, 0.76), vec3(0.90, 0.56, 0.59), own.z * own.z) * (y > 1.5276 ? 0.92 : 1.0);
    colour = mix(colour, red, 0.85 * lips);
    float sheen = mix(skin.a, 0.30, lips);
    if (painted) {
        colour *= 1.0 - 0.55 * (1.0 - smoothstep(0.0008, 0.0018, abs(y - 1.5277))) * (1.0 - smoothstep(0.018, 0.024, s)) * front;
    } else {
        // inside the mouth
        float depth = 0.0950 - 21.0 * s * s - rest.z;
        float inside = smoothstep(0.0032, 0.0062, depth) * step(abs(y - 1.527), 0.0085) * step(s, 0.0236) * step(0.055, rest.z);
        colour = mix(colour, mix(vec3(0.34, 0.13, 0.12), vec3(0.12, 0.04, 0.04), smoothstep(0.006, 0.025, depth)), inside);
    }
    vec3 nostril = (vec3(s, y, rest.z) - vec3(0.0080, 1.5495, 0.0950)) / vec3(0.0046, 0.0034, 0.0052);
    colour *= 1.0 - 0.60 * (1.0 - smoothstep(0.45, 1.15, dot(nostril, nostril))) ;
    // lid's edge with its lashes, the lids' shadow
    float edge = square(eye.x / 0.0150) + square((eye.y - 0.0001) / (eye.y > 0.0 ? 0.0041 : 0.0054));
    if (painted) {
        vec2 off = vec2(eye.x * sign(rest.x), eye.y);
        colour = mix(colour, eye_colour(off, dancer, bright), front * (1.0 - smoothstep(0.8, 1.1, edge)));
    }
    else colour = mix(colour, mix(colour, vec3(0.74, 0.46, 0.43), 0.5), (1.0 - smoothstep(0.72, 0.92, edge)) * front);
    float lash = (1.0 - smoothstep(0.10, painted ? 0.45 : 0.27, abs(edge - 1.02))) * mix(0.22, 0.88, smoothstep(-0.0030, 0.0004, eye.y)) * front;
    colour = mix(colour, hair.rgb * 0.55, lash * (1.0 - 0.5 * hair.g));
    float fold = bulge(square((eye.y - 0.0086 + 22.0 * square(eye.x - 0.001)) / 0.0011)) * step(abs(eye.x), 0.017);
    colour *= 1.0 - 0.20 * fold * front;
    // brows: hair from the inner end up to the arch, thinner outwards
    float along = (s - 0.0125) / 0.0385;
    float line = 1.6096 + 0.0050 * (1.0 - square((s - 0.0335) / 0.0270)) - 0.0016 * smoothstep(0.55, 1.0, along);
    float thick = mix(0.0031, 0.0010, smoothstep(0.15, 1.0, along)) * (0.80 + 0.5 * own.x);
    float comb = 0.72 + 0.5 * grain_of(vec2(s * 900.0 - (y - line) * 700.0, (y - line) * 250.0));
    float brow = (1.0 - smoothstep(0.45 * thick, thick, abs(y - line))) * smoothstep(0.0, 0.12, along) * (1.0 - smoothstep(0.86, 1.02, along));
    colour = mix(colour, hair.rgb * 0.9, min(brow * comb * (0.62 + 0.38 * smoothstep(0.0, 0.3, along)), 0.9) * front);
    return vec4(colour, sheen);
}

// Across and along the strands from the hairline [m], and whether it is curly.
vec4 hair_colour(vec3 at, int dancer) {
    vec4 hair = material(HAIR, dancer);
    vec3 scalp = material(SKIN, dancer).rgb;
    float near = clamp(0.0005 / max(max(fwidth(at.x), fwidth(at.y)), 1e-6), 0.0, 1.0);   // far away its border is even
    bool curly = at.z > 0.5;
    float fine = uneven(curly ? at.xy * 230.0 : vec2(at.x * 1300.0, at.y * 22.0));
    if (curly) {
        float curl = fine * 0.6 + grain_of(at.xy * 520.0 + 9.0) * 0.4;
        if (at.y < near * (0.010 * curl - 0.001)) discard;
        return vec4(hair.rgb * (0.66 + 0.50 * curl), 0.10 + 0.15 * curl * curl);
    }
    float broad = grain_of(vec2(at.x * 330.0, at.y * 12.0 + 5.0));
    if (at.y < near * (0.0026 * fine + 0.0012 * broad - 0.0006)) discard;   // it begins strand by strand
    float strand = 0.55 * fine + 0.45 * broad;
    float full = smoothstep(-0.002, 0.013, at.y - 0.004 * fine);   // the scalp is seen between the first strands
    vec3 colour = mix(mix(scalp, hair.rgb, 0.3), hair.rgb * (0.62 + 0.70 * strand), mix(1.0, full, near));
    return vec4(colour, hair.a * (0.10 + 0.95 * strand * strand) * full);
}

vec4 head_surface(vec3 rest, int dancer, int part) {
    if (part == HAIR_PART) return hair_colour(rest, dancer);
    if (part == 1 || part == 2) return face_colour(rest, dancer, part == 2);
    vec4 skin = material(SKIN, dancer);
    if (part == 3) {
        vec3 off = rest - vec3(EYE_AT.x * sign(rest.x), EYE_AT.y, 0.0648);
        return vec4(off.z > 0.0 ? eye_colour(off.xy, dancer, dot(skin.rgb, vec3(0.3, 0.6, 0.1))) : vec3(0.5), 0.4);
    }
    float gap = smoothstep(0.35, 0.5, abs(fract(rest.x * 125.0) - 0.5));   // between teeth
    if (part == 4) return vec4(vec3(0.70, 0.66, 0.60) * (1.0 - 0.25 * gap), 0.3);
    return vec4(skin.rgb * vec3(1.02, 0.92, 0.90), skin.a);   // ears
}
#endif
