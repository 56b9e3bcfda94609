// Light gathered along the longest way around a pixel, where what is there moves over it or it moves over what is there
// (McGuire et al. 2012, A reconstruction filter for plausible motion blur). TILE: side of a tile [pixels of the picture]
#include "frame.glsl"
in vec2 at;
uniform sampler2D light;
uniform sampler2D velocity;
uniform sampler2D tiles;
out vec4 shown;

const float SOFT = 0.15;      // depth over which one thing is before another [m]

float cone(float apart, float way) { return clamp(1.0 - apart / max(way, 1e-3), 0.0, 1.0); }
float cylinder(float apart, float way) { return 1.0 - smoothstep(0.95 * way, 1.05 * way + 1e-3, apart); }
float before(float a, float b) { return clamp(1.0 - (a - b) / SOFT, 0.0, 1.0); }   // 1: a is before b

void main() {
    vec4 way = texelFetch(tiles, min(ivec2(gl_FragCoord.xy) / TILE, textureSize(tiles, 0) - 1), 0);
    vec4 own = textureLod(velocity, at, 0.0);
    vec3 here = texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb;
    float weight = 1.0 / max(own.w, 1.0);
    vec3 sum = here * weight;
    int taps = way.w > 0.5 ? TAPS : 0;
    float jitter = fract(52.9829189 * fract(dot(gl_FragCoord.xy + picture_part.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    for (int i = 0; i < taps; ++i) {
        float share = (float(i) + 0.5 + 0.9 * jitter) / float(TAPS) * 2.0 - 1.0;
        vec2 there = at + way.xy * share * picture.zw;
        vec4 other = textureLod(velocity, there, 0.0);
        float apart = abs(share) * way.w;
        float covers = before(other.z, own.z) * cone(apart, other.w) + before(own.z, other.z) * cone(apart, own.w)
                     + 2.0 * cylinder(apart, other.w) * cylinder(apart, own.w);
        weight += covers;
        sum += textureLod(light, there, 0.0).rgb * covers;
    }
    shown = vec4(sum / weight, 1.0);
}
