// Light as targets in half floats hold it. After finish.glsl.
vec4 shown_as(vec3 light) {
    return vec4(compressed(light * key_light.w), 1.0);
}

// Light that is laid over what is there already, and hides so much of it: where there is much, less is added.
vec4 laid_over(vec3 light, float hides) {
    vec3 over = compressed(light * key_light.w);
    return vec4(over, max(hides, 0.8 * max(over.r, max(over.g, over.b))));
}
