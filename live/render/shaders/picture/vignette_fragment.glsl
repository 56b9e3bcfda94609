// Darker corners.
#include "finish.glsl"
in vec2 at;
uniform sampler2D light;
uniform float strength;
out vec4 shown;

void main() {
    vec2 side = picture_place(at) - 0.5;
    vec3 here = expanded(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb);
    shown = vec4(compressed(here * (1.0 - strength * dot(side, side))), 1.0);
}
