// A dancer's surface, to be lit later: small triangles cost a software renderer whole blocks of pixels each.
#include "frame.glsl"
#include "surface.glsl"

in vec4 facing;   // normal, openness
in vec4 body;     // place on the usual body, 16 times the dancer and the part

layout(location = 0) out vec4 cover;   // square root of the colour (finer steps in the dark), openness
layout(location = 1) out vec4 shape;   // normal, sheen
#if WHO
layout(location = 2) out vec4 who;     // number of the dancer from 1 on in two bytes, group
#endif

void main() {
    int own = int(body.w + 0.5);
    vec4 colour = surface(body.xyz, own >> 4, own & 15);
#ifdef WORN
    colour.rgb = sqrt(min(colour.rgb * colour.rgb + emitted(), 1.0));   // light cloth, for there is no place for light
#endif
    cover = vec4(colour.rgb, facing.w);
#if WHO
    int number = (own >> 4) + 1;
    who = vec4(float(number & 255), float((number >> 8) & 255), 0.0, 255.0) / 255.0;
#endif
    shape = vec4(outward(facing.xyz) * 0.5 + 0.5, colour.a);
}
