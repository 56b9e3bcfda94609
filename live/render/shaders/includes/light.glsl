// The light on a dancer: key, two rim lamps behind, the haze's own light, the floor's warmth, the elements' glow.
uniform sampler2D floor_map;

const vec3 RIM_LEFT = vec3(-0.6276, 0.4602, -0.6276);
const vec3 RIM_RIGHT = vec3(0.6276, 0.4602, -0.6276);

// Lamps that are dark in the usual light: low from both sides, straight behind, follow spots. Where the processor draws
// a program without them is used while they are dark: a branch would cost it as much as the lamps.
#ifndef BESIDE
#define BESIDE 1
#endif
#if BESIDE
vec3 beside(vec3 place, vec3 n, vec3 albedo, vec3 to_eye, float edge, float openness) {
    const vec3 LEFT = vec3(-0.94, 0.24, 0.24), RIGHT = vec3(0.94, 0.24, 0.24), BACK = vec3(0.0, 0.62, -0.78);
    float left = clamp((dot(n, LEFT) + 0.12) / 1.12, 0.0, 1.0), right = clamp((dot(n, RIGHT) + 0.12) / 1.12, 0.0, 1.0);
    vec3 sides = side_left.rgb * left + side_right.rgb * right;
    vec3 colour = sides * (albedo * 1.25 * (0.5 + 0.5 * openness) + 0.35 * edge);
    float back = max(dot(n, BACK), 0.0);
    colour += back_light.rgb * back * (albedo * 0.9 + edge * 1.1) * (0.4 + 0.6 * openness);
    for (int k = 0; k < 4; ++k) {
        if (spot_place[k].w <= 0.0) continue;
        vec3 to_lamp = normalize(spot_lamp(k) - place);
        float front = clamp((dot(n, to_lamp) + 0.10) / 1.10, 0.0, 1.0);
        float shine = pow(max(dot(n, normalize(to_lamp + to_eye)), 0.0), 24.0);
        colour += spot_light[k].rgb * spot_reach(k, place) * (albedo * front * 1.4 * (0.5 + 0.5 * openness) + 0.12 * shine);
    }
    return colour;
}
#endif

vec3 lit(vec3 place, vec3 n, vec3 albedo, float sheen, float openness) {
    vec3 to_eye = normalize(eye.xyz - place);
    float edge = square(1.0 - max(dot(n, to_eye), 0.0));
    float height = max(place.y, 0.0);

    float key = clamp((dot(n, key_direction.xyz) + 0.18) / 1.18, 0.0, 1.0);
    float pool = key_pool(place.xz);
    float shine = max(dot(n, normalize(key_direction.xyz + to_eye)), 0.0);
    shine *= shine; shine *= shine; shine *= shine; shine *= shine * sheen;
    // two lamps behind the stage, left and right: what cuts the figure out of the dark
    float rim = max(dot(n, RIM_LEFT), 0.0) + max(dot(n, RIM_RIGHT), 0.0);
    rim *= min(2.5 * openness, 1.0);   // deep hollows, such as a mouth, have no rim

    vec3 light = key_light.rgb * (key * pool * 1.45 * (0.45 + 0.55 * openness));
    light += rim_light.rgb * (rim * (0.30 + edge));
    light += light_ambient_colour() * (rim_light.rgb * 0.35 + 0.12) * (light_ambient() * (0.8 + 0.5 * n.y) * openness);
    float below = (0.5 - 0.5 * n.y) / (1.0 + 1.4 * height);
    light += key_light.rgb * light_floor() * (pool * 2.0 * below);
    vec3 glow = texture(floor_map, place.xz / (2.0 * stage.zw) + 0.5).rgb;
    light += glow * ((1.1 - 0.6 * n.y) * 2.0 / (1.0 + 2.0 * height * height));

    vec3 colour = albedo * light;
#if BESIDE
    vec4 more = vec4(side_left.rgb + side_right.rgb + back_light.rgb, spot_light[0].w);
    if (dot(more, vec4(1.0)) > 0.0) colour += beside(place, n, albedo, to_eye, edge, openness);
#endif
    colour += key_light.rgb * (shine * pool * 0.5);
    colour += rim_light.rgb * (rim * edge * 0.75 * (0.4 + 0.6 * openness));
    colour *= answer();
    return mix(min(colour, vec3(1.6)), haze_light(place.y), haze_at(place));
}
