// Picture = film curve of light and glow.
#include "frame.glsl"
#include "finish.glsl"
in vec2 at;
uniform sampler2D light;
uniform sampler2D glow;
out vec4 shown;

void main() {
    vec3 sum = expanded(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb) + texture(glow, at).rgb * 0.22;
    shown = vec4(to_picture(sum, gl_FragCoord.xy), 1.0);
}
