// An item lit while drawn.
#include "frame.glsl"
#include "light.glsl"
#include "finish.glsl"

in vec3 place;
in vec3 facing;
in vec4 colour;
out vec4 shown;

void main() {
    vec3 light = lit(place, normalize(facing), colour.rgb * colour.rgb, 0.15, colour.a);
    shown = vec4(compressed(light * key_light.w), 1.0);
}
