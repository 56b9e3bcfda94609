// From linear light to the picture: vignette, film curve, sRGB, and a grain finer than one step against banding.
float grain(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

vec3 film(vec3 light) {
    // filmic fit by Narkowicz (2015)
    return clamp((light * (2.51 * light + 0.03)) / (light * (2.43 * light + 0.59) + 0.14), 0.0, 1.0);
}

vec3 encode_srgb(vec3 x) {
    // roots instead of powers: within half a step of 255 of the exact curve, but for the darkest
    vec3 s = sqrt(x);
    return max(0.585122381 * s + 0.783140355 * sqrt(s) - 0.368262736 * sqrt(sqrt(s)), 0.0);
}

vec3 to_picture(vec3 light, vec2 pixel) {
    vec2 side = pixel * picture.zw - 0.5;
    float vignette = 1.0 - 0.6 * dot(side, side);
    return encode_srgb(film(light * vignette)) + (grain(pixel) - 0.5) / 255.0;
}
