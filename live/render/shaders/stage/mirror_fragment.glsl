// Water mirrors all of a dancer, a dull floor her feet and legs.
#include "frame.glsl"
in vec3 light;
in float height;
out vec4 shown;

void main() {
    if (height < 0.0) discard;
    shown = vec4(sqrt(light * exp(-height * mix(1.7, 0.30, share_water())) * mix(0.30, 0.62, share_water())), 1.0);
}
