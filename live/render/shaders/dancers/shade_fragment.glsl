// Light on the surfaces that were drawn before, once for each pixel.
#include "frame.glsl"
#include "light.glsl"
#include "finish.glsl"
#include "beams.glsl"

in vec2 at;
in vec3 ray;

uniform sampler2D cover;
uniform sampler2D shape;
uniform sampler2D depth;

out vec4 shown;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 c = texelFetch(cover, pixel, 0);
    vec4 s = texelFetch(shape, pixel, 0);
    float z = texelFetch(depth, pixel, 0).r * 2.0 - 1.0;
    float away = 2.0 * FAR * NEAR / (FAR + NEAR - z * (FAR - NEAR));
    vec3 n = normalize(s.xyz - 0.5);
    vec3 colour = lit(eye.xyz + ray * away, n, c.rgb * c.rgb, s.w, c.a);
    colour = beams_over(colour * key_light.w, at, BEFORE_DANCERS);
#if HDR
    shown = vec4(compressed(colour), 1.0);
#else
    shown = vec4(to_picture(colour, gl_FragCoord.xy), 1.0);
#endif
}
