// A dancer's surface, to be lit later: small triangles cost a software renderer whole blocks of pixels each.
#include "frame.glsl"
#include "surface.glsl"

in vec4 facing;   // normal, openness
in vec4 body;     // place in the rest pose, dancer

layout(location = 0) out vec4 cover;   // square root of the colour (finer steps in the dark), openness
layout(location = 1) out vec4 shape;   // normal, sheen

void main() {
    vec4 colour = surface(body.xyz, int(body.w + 0.5));
    cover = vec4(colour.rgb, facing.w);
    shape = vec4(facing.xyz * 0.5 + 0.5, colour.a);
}
