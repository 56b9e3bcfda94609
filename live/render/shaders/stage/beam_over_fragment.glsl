// Beams over the lit scene, compressed.
#include "frame.glsl"
#include "finish.glsl"

in vec2 at;
uniform sampler2D beams;
uniform float share;
out vec4 shown;

void main() { shown = vec4(compressed(texture(beams, at).rgb * share), 1.0); }
