// Picture = film curve of light and glow.
#include "frame.glsl"
#include "finish.glsl"
in vec2 at;
uniform sampler2D light;
#if GLOW
uniform sampler2D glow;
uniform float strength;
#endif
out vec4 shown;

void main() {
    vec3 sum = expanded(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb);
#if GLOW
    sum += texture(glow, at).rgb * strength;
#endif
    shown = vec4(to_picture(sum, gl_FragCoord.xy), 1.0);
}
