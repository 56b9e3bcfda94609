// A set piece's surface, to be lit later, as gbuffer_fragment.glsl has it.
#include "frame.glsl"
#define WORN 1
#include "surface.glsl"
#include "dissolve.glsl"
in vec3 place;
in vec4 facing;

layout(location = 0) out vec4 cover;
layout(location = 1) out vec4 shape;
layout(location = 2) out vec4 who;   // nobody; goes nowhere where nobody asks

void main() {
    if (amount < 1.0) dissolve();
    vec4 colour = surface(vec3(0.0), 0, 0);
    colour.rgb = sqrt(min(colour.rgb * colour.rgb + emitted(), 1.0));
    cover = vec4(colour.rgb, facing.w);
    shape = vec4(outward(normalize(facing.xyz)) * 0.5 + 0.5, colour.a);
    who = vec4(0.0, 0.0, 0.0, 1.0);
}
