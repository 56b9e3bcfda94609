// Colour grade: temperature in linear light; lift, gamma, gain and contrast where steps look even.
#include "finish.glsl"
in vec2 at;
uniform sampler2D light;
uniform float amount;
uniform vec3 lift;
uniform vec3 gamma;
uniform vec3 gain;
uniform float contrast;
uniform float temperature;   // -1: cold, 1: warm
out vec4 shown;

const float MIDDLE = 0.42;   // what contrast leaves as it is: the square root of mid grey, compressed

void main() {
    vec3 here = texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb;
    vec3 tint = exp2(temperature * vec3(0.45, 0.05, -0.65));
    tint /= dot(tint, vec3(0.2126, 0.7152, 0.0722));
    vec3 seen = sqrt(compressed(expanded(here) * tint));
    seen = max((seen - MIDDLE) * contrast + MIDDLE, 0.0);
    seen = max(seen * gain + 0.5 * lift * (1.0 - seen) * min(key_light.w, 1.0), 0.0);
    seen = pow(min(seen, 0.99), 1.0 / gamma);
    shown = vec4(mix(here, seen * seen, amount), 1.0);
}
