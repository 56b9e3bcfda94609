
void main() {
    vec4 own_made_ = pass(at);
    vec3 own_sum_ = max(mix(light(at), own_made_.rgb, clamp(own_made_.a, 0.0, 1.0) * amount), 0.0);
    if (any(isnan(own_sum_)) || any(isinf(own_sum_))) own_sum_ = vec3(0.0);   // it would never leave the trails
    own_shown_ = vec4(own_sum_ / (1.0 + max(own_sum_.r, max(own_sum_.g, own_sum_.b))), 1.0);
}
