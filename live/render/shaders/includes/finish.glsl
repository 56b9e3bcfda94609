// From linear light to the picture: vignette, film curve, sRGB, and a grain finer than one step against banding.
#include "frame.glsl"
float grain(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

// Film curve (fit by Narkowicz 2015) and sRGB in one: within two steps of 255 of both, without powers.
vec3 film(vec3 light) {
    return light * (6.046 * light + 0.7193) / (light * (5.927 * light + 1.411) + 0.1336);
}

vec3 to_picture(vec3 light, vec2 pixel) {
    vec2 side = picture_place(pixel * picture.zw) - 0.5;
    float vignette = 1.0 - back_light.w * dot(side, side);
    float grey = dot(light, vec3(0.2126, 0.7152, 0.0722));
    light = max(light * light_saturation() + grey * (1.0 - light_saturation()), 0.0);
    return film(light * vignette) + (grain(pixel + picture_part.xy) - 0.5) / 255.0;
}

// Samples are averaged in a compressed range, or one bright sample would outshine the three dark ones of an edge.
vec3 compressed(vec3 light) { return light / (1.0 + max(light.r, max(light.g, light.b))); }
vec3 expanded(vec3 light) { return light / max(1.0 - max(light.r, max(light.g, light.b)), 0.02); }
