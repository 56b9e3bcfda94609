// The light on a dancer: key, two rim lamps behind, the haze's own light, the floor's warmth, the elements' glow.
uniform sampler2D floor_map;

const vec3 RIM_LEFT = vec3(-0.6276, 0.4602, -0.6276);
const vec3 RIM_RIGHT = vec3(0.6276, 0.4602, -0.6276);

// Lamps that are dark in the usual light: low from both sides, straight behind. Where the processor draws a program
// without them is used while they are dark: a branch would cost it as much as the lamps. So it is with what moves in the
// light: gobos, and what water throws up. A loop that runs for no spot costs next to nothing.
#ifndef BESIDE
#define BESIDE 1
#endif
#ifndef MOVING
#define MOVING 1
#endif
#if MOVING
#include "moving.glsl"
#endif
#if BESIDE
vec3 beside(vec3 n, vec3 albedo, float grazing, float openness) {
    const vec3 LEFT = vec3(-0.94, 0.24, 0.24), RIGHT = vec3(0.94, 0.24, 0.24), BACK = vec3(0.0, 0.62, -0.78);
    float left = clamp((dot(n, LEFT) + 0.12) / 1.12, 0.0, 1.0), right = clamp((dot(n, RIGHT) + 0.12) / 1.12, 0.0, 1.0);
    vec3 sides = side_left.rgb * left + side_right.rgb * right;
    vec3 colour = sides * (albedo * 1.25 * (0.5 + 0.5 * openness) + 0.5 * grazing);
    float back = max(dot(n, BACK), 0.0);
    colour += back_light.rgb * back * (albedo * 0.9 + grazing * 1.5) * (0.4 + 0.6 * openness);
    return colour;
}
#endif

vec3 spots(vec3 place, vec3 n, vec3 albedo, vec3 to_eye, float openness) {
    vec3 colour = vec3(0.0);
    for (int k = spots_begin(); k < spots_end(); ++k) {
        vec3 to_lamp = normalize(spot_lamp(k) - place);
        float front = clamp((dot(n, to_lamp) + 0.10) / 1.10, 0.0, 1.0);
        float shine = max(dot(n, normalize(to_lamp + to_eye)), 0.0);
        shine *= shine; shine *= shine; shine *= shine;
        shine *= shine * shine;   // to the power of 24
        colour += spot_light[k].rgb * spot_reach(k, place) * (albedo * front * 1.4 * (0.5 + 0.5 * openness) + 0.12 * shine);
    }
    return colour;
}

vec3 lit(vec3 place, vec3 n, vec3 albedo, float sheen, float openness) {
    vec3 to_eye = normalize(eye.xyz - place);
    float edge = square(1.0 - max(dot(n, to_eye), 0.0));
    // what a surface throws on towards the eye from behind: a narrow edge (Schlick 1994), less of it where the surface is
    // dark, for most of it comes out of fuzz and strands: dark hair and skin are not chalk
    float pale = sqrt(dot(albedo, vec3(0.3, 0.6, 0.1)));
    float grazing = edge * (0.35 + 0.65 * edge) * (0.22 + 0.78 * pale);
    float height = max(place.y, 0.0);

    // The key light wraps softly around the body; below skin red light goes farthest, so its border is warm (after
    // Gosselin, Real-Time Skin Rendering, 2004, who widens Lambert's law by colour). Skin is known by its sheen.
    float skin = 1.0 - smoothstep(0.01, 0.03, abs(sheen - 0.14));
    float facing = dot(n, key_direction.xyz);
    vec3 wrap = vec3(0.16) + skin * vec3(0.24, 0.07, 0.0);
    vec3 key = clamp((facing + wrap) / (1.0 + wrap), 0.0, 1.0);
    key *= 0.45 + 0.55 * key;
    float pool = key_pool(place.xz);
#if MOVING
    if (gobo.z > 0.0) pool *= gobo_at(place);
#endif
    float shine = max(dot(n, normalize(key_direction.xyz + to_eye)), 0.0);
    shine *= shine; shine *= shine; shine *= shine; shine *= shine * sheen;
    // two lamps behind the stage, left and right: what cuts the figure out of the dark
    float rim = max(dot(n, RIM_LEFT), 0.0) + max(dot(n, RIM_RIGHT), 0.0);
    rim *= min(2.5 * openness, 1.0);   // deep hollows, such as a mouth, have no rim

    vec3 light = key_light.rgb * key * (pool * 1.55 * (0.45 + 0.55 * openness));
    light += mix(fill_below.rgb, fill_above.rgb, 0.5 + 0.5 * n.y) * (0.25 + 0.75 * openness);
    light += rim_light.rgb * (rim * (0.30 + edge));
    light += light_ambient_colour() * (rim_light.rgb * 0.35 + 0.12) * (light_ambient() * (0.8 + 0.5 * n.y) * openness);
    float below = (0.5 - 0.5 * n.y) / (1.0 + 1.4 * height);
    light += key_light.rgb * light_floor() * (pool * 2.0 * below);
    vec3 glow = texture(floor_map, place.xz / (2.0 * stage.zw) + 0.5).rgb;
    light += glow * ((1.1 - 0.6 * n.y) * 2.0 / (1.0 + 2.0 * height * height));

    vec3 colour = albedo * light;
#if BESIDE
    if (dot(side_left.rgb + side_right.rgb + back_light.rgb, vec3(1.0)) > 0.0) colour += beside(n, albedo, grazing, openness);
#endif
    colour += spots(place, n, albedo, to_eye, openness);
#if MOVING
    if (share_water() > 0.0) {   // light that the water throws up
        float web = caustics(place.xz * 1.3 + place.y * 0.6) * (0.75 - 0.55 * n.y) * exp(-height * 0.85);
        colour += (key_light.rgb * 0.35 + rim_light.rgb * 0.30) * (albedo + 0.04) * (web * share_water() * 1.3);
    }
#endif
    colour += key_light.rgb * (shine * pool * 0.5);
    // the nap of cloth shines where it is looked along (after Ashikhmin and others, A Microfacet-Based BRDF Generator, 2000)
    colour += (1.0 - skin) * sheen * edge * edge * (0.3 + 0.7 * key.g) * pool * key_light.rgb * (0.30 * pale + albedo);
    colour += rim_light.rgb * (rim * grazing * 1.1 * (0.4 + 0.6 * openness));
    colour *= answer();
    return mix(min(colour, vec3(1.6)), haze_light(place.y), haze_at(place));
}
