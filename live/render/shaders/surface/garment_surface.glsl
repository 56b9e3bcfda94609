// The surface of garments: cloth in the dancer's colour, hair in strands, ribbons. Both sides are seen.
uniform ivec2 garment;     // material (wardrobe.py), and 0: cloth, 1: hair, 2: ribbon
uniform vec2 garment_size; // length and width [m]

vec3 bumped(vec3 n, vec3 place) { return n; }
vec3 emitted() { return vec3(0.0); }

float strand(float x) { return fract(sin(floor(x) * 12.9898) * 43758.5453); }

#ifndef VERTEX
vec3 outward(vec3 normal) { return gl_FrontFacing ? normal : -normal; }
#endif

vec4 surface(vec3 rest, int dancer, int part) {
    vec4 colour = material(garment.x, dancer);
#ifndef VERTEX
    float along = -rest.y / garment_size.x;
    if (garment.y == 1) {
        float fine = rest.x * 420.0, broad = rest.x * 95.0;
        float light = mix(strand(broad), strand(broad + 1.0), smoothstep(0.0, 1.0, fract(broad)));
        colour.rgb *= 0.80 + 0.34 * light + 0.14 * strand(fine);
        colour.a *= 0.08 + 0.42 * light * light * (0.5 + 0.5 * strand(fine));   // strand by strand, not one sheet
        if (along > 0.80 + 0.20 * strand(rest.x * 160.0)) discard;   // no two strands end at the same height
    } else if (garment.y == 0) {
        colour.rgb *= gl_FrontFacing ? 1.0 : 0.78;                    // the lining
        colour.rgb *= along > 0.985 ? 0.88 : 1.0;                    // the hem's stitches
    } else {
        colour.rgb = sqrt(min(colour.rgb * colour.rgb * 1.5 + 0.02, 1.0));
        colour.a = min(colour.a * 2.2, 1.0);                          // satin
    }
#endif
    return colour;
}

// How far a place is from the hem [m].
float seams(vec3 rest, int dancer) { return garment.y == 1 ? 1.0 : garment_size.x + rest.y; }
