// One direction of a Gaussian blur whose width differs by channel: sharp at the feet, soft from above.
#include "frame.glsl"
in vec2 at;
uniform sampler2D layers;
uniform vec2 stride;     // one step in the direction of this pass
uniform vec3 weights[TAPS + 1];   // of each channel, so many steps away; all together 1
out vec4 shown;

#if LAST
// the source is as large as the target: no filtering needed
ivec2 last = textureSize(layers, 0) - 1;
vec3 layer(float step) {
    return texelFetch(layers, clamp(ivec2(gl_FragCoord.xy) + ivec2(0, int(step)), ivec2(0), last), 0).rgb;
}
#else
vec3 layer(float step) { return texture(layers, at + stride * step).rgb; }
#endif

void main() {
    vec3 sum = layer(0.0) * weights[0];
    for (int i = 1; i <= TAPS; ++i) sum += (layer(float(i)) + layer(float(-i))) * weights[i];
#if LAST
    // alpha: how much light the shadow takes; red, green and blue are for the elements
    vec3 left = 1.0 - vec3(0.80, 0.62, 0.35) * sum;
    shown = vec4(0.0, 0.0, 0.0, (1.0 - left.r * left.g * left.b) * pass_shadow());
#else
    shown = vec4(sum, 1.0);
#endif
}
