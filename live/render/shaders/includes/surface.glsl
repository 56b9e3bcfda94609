// Cloth, tights, skin and hair by place on the body in the rest pose.
uniform sampler2D wardrobe;   // a dancer's colours (square roots) and sheen
uniform int wardrobe_rows;


vec4 material(int which, int dancer) {
    return texelFetch(wardrobe, ivec2(which + dancer / wardrobe_rows * 5, dancer % wardrobe_rows), 0);
}

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

float seams(vec3 rest) { return 1.0; }
#else
vec3 outward(vec3 normal) { return normal; }
vec3 bumped(vec3 n, vec3 place) { return n; }
vec3 emitted() { return vec3(0.0); }

#if defined(HEAD) && !defined(VERTEX)
#include "head_surface.glsl"
vec4 surface(vec3 rest, int dancer, int part) { return head_surface(rest, dancer, part); }
#else
// Square root of the colour, and sheen. Where pixels are dear the borders are sharp.
vec4 surface(vec3 rest, int dancer, int part) {
#ifdef VERTEX
    if (part == 6) return material(3, dancer);   // hair
#endif
    float side = abs(rest.x);
    float waist = rest.y - 0.808 - side * mix(0.42, 0.78, smoothstep(-0.05, 0.05, rest.z));
    // a leotard with straps: scooped between them, cut round the arms
    float scoop = min(rest.y - (rest.z > -0.02 ? 1.318 : 1.262) - 3.5 * side * side, 0.086 - side);
    float arms = min(side - 0.124 - 0.8 * square(max(1.36 - rest.y, 0.0)), rest.y - 1.20);
    float bare = max(max(scoop, rest.y - 1.428), max(arms, 0.108 - rest.y));
#if SOFT
    vec4 colour = mix(material(1, dancer), material(0, dancer), smoothstep(-0.004, 0.004, waist));
    return mix(colour, material(2, dancer), smoothstep(-0.004, 0.004, bare));
#else
    vec4 colour = material(bare > 0.0 ? 2 : (waist > 0.0 ? 0 : 1), dancer);
    // far away a head has but shades of a face: brows and eyes, mouth
    float eye = square((side - 0.031) * 62.0) + square((rest.y - 1.601) * 90.0);
    float mouth = square(side * 42.0) + square((rest.y - 1.527) * 150.0);
    colour.rgb *= min(eye, mouth) < 1.0 && rest.z > 0.03 ? 0.62 : 1.0;
    return colour;
#endif
}
#endif

// How far a place on the body is from a border of her clothes, in the rest pose [m].
float seams(vec3 rest) {
#if defined(HEAD) && !defined(VERTEX)
    return 1.0;
#endif
    float side = abs(rest.x);
    float waist = rest.y - 0.808 - side * mix(0.42, 0.78, smoothstep(-0.05, 0.05, rest.z));
    float scoop = min(rest.y - (rest.z > -0.02 ? 1.318 : 1.262) - 3.5 * side * side, 0.086 - side);
    float arms = min(side - 0.124 - 0.8 * square(max(1.36 - rest.y, 0.0)), rest.y - 1.20);
    float bare = max(max(scoop, rest.y - 1.428), max(arms, 0.108 - rest.y));
    return min(abs(bare), abs(waist));
}
#endif
