// A set piece lit while drawn.
#include "frame.glsl"
#define WORN 1
#include "surface.glsl"
#include "light.glsl"
#include "finish.glsl"
#include "dissolve.glsl"
in vec3 place;
in vec4 facing;
out vec4 shown;

void main() {
    if (amount < 1.0) dissolve();
    vec3 n = bumped(outward(normalize(facing.xyz)), place), glow = emitted();
    vec4 colour = surface(vec3(0.0), 0, 0);
    vec3 light = lit(place, n, colour.rgb * colour.rgb, colour.a, facing.w) + glow;
    shown = vec4(compressed(light * key_light.w), 1.0);
}
