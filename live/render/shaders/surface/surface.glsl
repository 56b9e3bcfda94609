// Cloth, tights, skin and hair by place on the body in the rest pose.
uniform sampler2D wardrobe;   // a dancer's colours (square roots) and sheen
uniform int wardrobe_rows;


vec4 material(int which, int dancer) {
    return texelFetch(wardrobe, ivec2(which + dancer / wardrobe_rows * 9, dancer % wardrobe_rows), 0);
}

#ifdef GARMENT
#include "garment_surface.glsl"
#else
#ifdef WORN
uniform sampler2DArray images;   // square roots of colours
#ifdef VERTEX
vec4 surface(vec3 rest, int dancer, int part) {
    return vec4(textureLod(images, vec3(in_uv, in_finish.x * 255.0), 4.0).rgb * in_tint.rgb, in_tint.a);
}
#else
in vec4 worn_at;
in vec4 worn_tint;
flat in int worn_extra;
uniform vec4 worn_extras[64];    // two of each material: layer of the normals, strength, layer of the glow, whether; its light

// Normals of an image bend the surface's own; where it lies in space and on the image says how (Schueler 2013).
vec3 bumped(vec3 n, vec3 place) {
    vec3 right = dFdx(place), up = dFdy(place);
    vec2 du = dFdx(worn_at.xy), dv = dFdy(worn_at.xy);
    vec4 extra = worn_extras[2 * worn_extra];
    if (extra.x == 0.0) return n;
    vec3 image = textureGrad(images, vec3(worn_at.xy, extra.x), du, dv).rgb * 2.0 - 1.0;
    vec3 a = cross(up, n), b = cross(n, right);
    vec3 along = a * du.x + b * dv.x, down = a * du.y + b * dv.y;
    float size = inversesqrt(max(max(dot(along, along), dot(down, down)), 1e-20));
    return normalize((along * image.x - down * image.y) * (size * extra.y) + n * max(image.z, 0.05));
}

// The light that it gives itself.
vec3 emitted() {
    vec2 du = dFdx(worn_at.xy), dv = dFdy(worn_at.xy);
    vec4 extra = worn_extras[2 * worn_extra];
    if (extra.w == 0.0) return vec3(0.0);
    vec3 image = textureGrad(images, vec3(worn_at.xy, extra.z), du, dv).rgb;
    return worn_extras[2 * worn_extra + 1].rgb * image * image;
}

vec4 surface(vec3 rest, int dancer, int part) {
    vec4 image = texture(images, worn_at.xyz);
    if (image.a < worn_at.w) discard;
    return vec4(image.rgb * worn_tint.rgb, worn_tint.a);
}

// Hair and skirts are seen from behind, too.
vec3 outward(vec3 normal) { return gl_FrontFacing ? normal : -normal; }
#endif

float seams(vec3 rest, int dancer) { return 1.0; }
#else
vec3 outward(vec3 normal) { return normal; }
vec3 bumped(vec3 n, vec3 place) { return n; }
vec3 emitted() { return vec3(0.0); }

const int SKIN = 2, HAIR = 3, SHOE = 4, IDENTITY = 5, SHIRT = 6, SOLE = 7;   // see wardrobe.py
const int HAIR_PART = 6, NAIL_PART = 7, GARMENT_PART = 8;                    // see surface_parts.py

#if defined(HEAD) && !defined(VERTEX)
#include "head_surface.glsl"
vec4 surface(vec3 rest, int dancer, int part) { return head_surface(rest, dancer, part); }
float seams(vec3 rest, int dancer) { return 1.0; }
#else
// What a place on the body shows: the number of a material (wardrobe.py), and how far the next border is [m].
struct Wear { int which; float border; };

void put(inout Wear wear, int which, float inside) {
    if (which == wear.which) return;
    if (inside > 0.0) wear = Wear(which, inside);   // hides the borders below it
    else wear.border = min(wear.border, -inside);
}

// By the cut of her costume and shoes: lengths in the rest pose, see wardrobe.py.
Wear worn_at_place(vec3 rest, int dancer) {
    vec4 neck = material(6, dancer), hem = material(7, dancer), feet = material(8, dancer);
    int pair = int(feet.a * 255.0 + 0.5);
    float side = abs(rest.x), front = smoothstep(-0.05, 0.05, rest.z);
    float above = rest.y - mix(0.60, 1.20, hem.x) - hem.y * side * mix(0.70, 1.30, front);
    Wear wear = Wear(pair >> 3, 1.0);
    put(wear, pair & 7, above);
    // the midriff of a short top
    put(wear, SKIN, hem.z > 0.0 ? min(above, 0.3 * hem.z - above) : -1.0);
    // an open front over a shirt, from the neck to its button
    float lapel = 0.1 * neck.z * clamp((rest.y - 1.06) * 3.0, 0.0, 1.2) - side;
    put(wear, SHIRT, neck.z > 0.0 && rest.z > 0.0 ? min(lapel, rest.y - 1.06) : -1.0);
    // neckline: deeper behind the lower it is; arms beyond the sleeves; legs below their end
    float line = rest.y - mix(1.20, 1.45, neck.x) - (rest.z > -0.02 ? 0.0 : 0.195 * neck.x - 0.147);
    float scoop = min(line - 3.5 * side * side, 0.2 * neck.y - side);
    float arms = min(side - 0.7 * neck.w - 0.8 * square(max(1.36 - rest.y, 0.0)), rest.y - 1.20);
    put(wear, SKIN, max(max(scoop, rest.y - 1.428), arms));
    put(wear, SKIN, min(hem.w - rest.y, -above));
    // shoes
    float instep = min(rest.z + 0.010, 0.118 - rest.z);      // open above the toes' box
    float shoe = 0.5 * feet.x - rest.y - feet.y * max(min(instep * 4.0, 0.5 * feet.x - 0.022), 0.0);
    put(wear, SHOE, shoe);
    put(wear, SOLE, min(0.1 * feet.z - rest.y, shoe));
    return wear;
}

// Square root of the colour, and sheen. Where pixels are dear there are no seams.
vec4 surface(vec3 rest, int dancer, int part) {
#ifdef VERTEX
    if (part == HAIR_PART || min(0.012 + 0.42 * (rest.y - 1.60) - rest.z, rest.y - 1.536) > 0.0) return material(HAIR, dancer);
#endif
    if (part == NAIL_PART) return vec4(mix(material(SKIN, dancer).rgb, vec3(0.93, 0.76, 0.74), 0.5), 0.6);
    Wear wear = worn_at_place(rest, dancer);
    if (part >= GARMENT_PART) wear = Wear(part - GARMENT_PART, 1.0);
    vec4 colour = wear.which >= SHIRT ? vec4(0.93, 0.92, 0.90, 0.12) : material(wear.which, dancer);
#if SOFT
    colour.rgb *= 0.72 + 0.28 * smoothstep(0.0, 0.004, wear.border);   // the seam's shade
#else
    // far away a head has but the shades of a face: brows and eyes, mouth
    float eye = square((abs(rest.x) - 0.031) * 62.0) + square((rest.y - 1.601) * 90.0);
    float mouth = square(rest.x * 42.0) + square((rest.y - 1.527) * 150.0);
    colour.rgb *= min(eye, mouth) < 1.0 && rest.z > 0.03 ? 0.62 : 1.0;
#endif
    return colour;
}

// How far a place on the body is from a border of her clothes, in the rest pose [m].
float seams(vec3 rest, int dancer) { return worn_at_place(rest, dancer).border; }
#endif
#endif
#endif
