#define LETTER 1
#define TRACK 2
#define BAR 3

uniform sampler2D atlas;
uniform float level;      // opacity of the whole caption

in vec2 texel;
in vec2 inside;
flat in vec2 box;
flat in int what;
flat in float first;

out vec4 shown;

// How much of a pixel is in the box with round corners.
float rounded(float radius) {
    vec2 off = abs(inside - 0.5 * box) - 0.5 * box + radius;
    return clamp(0.5 + radius - length(max(off, 0.0)), 0.0, 1.0);
}

void main() {
    vec4 colour;
    if (what == LETTER) colour = vec4(0.95, 0.96, 0.98, texture(atlas, texel / vec2(textureSize(atlas, 0))).r);
    else if (what == TRACK) colour = vec4(1.0, 1.0, 1.0, 0.16 * rounded(0.5 * box.y));
    else if (what == BAR) colour = vec4(1.0, 1.0, 1.0, mix(0.55, 0.95, first) * rounded(0.5 * box.y));
    else colour = vec4(0.02, 0.02, 0.03, 0.5 * rounded(first));
    shown = vec4(colour.rgb, colour.a * level);
}
