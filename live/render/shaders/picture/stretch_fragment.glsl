// A smaller picture on a larger one.
#include "frame.glsl"
in vec2 at;
uniform sampler2D small;
out vec4 shown;

void main() {
    shown = vec4(texture(small, at).rgb, 1.0);
}
