#include "frame.glsl"
#include "finish.glsl"
#include "shown.glsl"

flat in vec4 ink;

#if SURFACE
layout(location = 0) out vec4 cover;   // as in gbuffer_fragment.glsl
layout(location = 1) out vec4 shape;
layout(location = 2) out vec4 name;

void main() {
    cover = vec4(0.0, 0.0, 0.0, 1.0);
    shape = vec4(0.5, 0.5, 1.0, 0.0);
    name = vec4(0.0, 0.0, 0.0, 1.0);
}
#else
out vec4 shown;

void main() {
    shown = shown_as(ink.rgb * ink.a);
}
#endif
