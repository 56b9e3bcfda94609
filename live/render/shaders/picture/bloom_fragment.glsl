// The picture and its glow.
#include "finish.glsl"
in vec2 at;
uniform sampler2D light;
uniform sampler2D glow;
uniform float strength;
out vec4 shown;

void main() {
    vec3 sum = expanded(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb) + texture(glow, at).rgb * strength;
    shown = vec4(compressed(sum), 1.0);
}
