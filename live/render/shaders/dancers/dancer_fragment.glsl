// A dancer lit while drawn.
#include "frame.glsl"
#include "surface.glsl"
#include "light.glsl"
#include "finish.glsl"

in vec3 place;
in vec4 facing;   // normal, openness
in vec4 body;     // place on the usual body, 16 times the dancer and the part

out vec4 shown;

void main() {
    vec3 n = bumped(outward(normalize(facing.xyz)), place), glow = emitted();
    int own = int(body.w + 0.5);
    vec4 colour = surface(body.xyz, own >> 4, own & 15);
    vec3 light = lit(place, n, colour.rgb * colour.rgb, colour.a, facing.w) + glow;
    shown = vec4(compressed(light * key_light.w), 1.0);
}
