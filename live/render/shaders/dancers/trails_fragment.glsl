// The picture, and what is left of the one before wherever that was brighter.
#include "frame.glsl"
in vec2 at;
uniform sampler2D light;
uniform sampler2D last;
uniform float left;     // of what was brighter
uniform float shrink;   // below 1 the last picture grows
uniform vec3 tint;
out vec4 shown;

void main() {
    vec3 here = texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb;
    vec3 before = shrink == 1.0 ? texelFetch(last, ivec2(gl_FragCoord.xy), 0).rgb
                                : textureLod(last, part_place((picture_place(at) - 0.5) * shrink + 0.5), 0.0).rgb;
#if SHOWN
    shown = vec4(max(here, before * left * tint), 1.0);
#else
    shown = vec4(here + max(before - here, 0.0) * left * tint, 1.0);   // so that what stands still does not glow
#endif
}
