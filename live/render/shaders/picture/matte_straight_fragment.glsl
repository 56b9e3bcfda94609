// The full colour of what covers a pixel, however little of it, and the light over it.
#include "matte.glsl"
in vec2 at;
out vec4 shown;

void main() {
    vec4 solid = texelFetch(kept, ivec2(gl_FragCoord.xy), 0);
    vec3 colour = solid.a > 0.0 ? min(solid.rgb / solid.a, 1.0) : vec3(0.0);
    vec3 light = light_over(solid);
    shown = vec4(max(colour + light * (1.0 - colour), 0.0), 1.0);
}
