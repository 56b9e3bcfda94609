uniform sampler2D atlas;

in vec2 across;
in vec2 texel;
in float pixels;
flat in vec2 what;

out vec4 shown;

// A ring with a point in it, dark beside so that it is seen on any picture; the chosen one glows.
vec4 point_mark(bool chosen) {
    float far = length(across) * pixels, radius = 0.62 * pixels;
    float ring = 1.0 - smoothstep(1.0, 2.2, abs(far - radius));
    float middle = 1.0 - smoothstep(1.0, 2.4, far);
    float around = 1.0 - smoothstep(0.75 * pixels, 0.98 * pixels, far);
    vec3 colour = chosen ? vec3(1.0, 0.75, 0.1) : vec3(0.35, 0.85, 1.0);
    float lit = max(ring, middle);
    if (chosen) lit = max(lit, 0.45 * (1.0 - smoothstep(0.0, radius, far)));
    return vec4(colour * lit, max(lit, 0.55 * around));
}

void main() {
    if (what.x < 0.5) shown = vec4(0.02, 0.02, 0.03, 0.72);
    else if (what.x < 1.5) shown = vec4(0.93, 0.94, 0.96, texelFetch(atlas, ivec2(texel), 0).r);
    else shown = point_mark(what.y > 0.5);
}
