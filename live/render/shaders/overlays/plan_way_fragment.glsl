#include "frame.glsl"
#include "finish.glsl"
in vec4 colour;
in float across;
uniform float amount;
out vec4 shown;

void main() {
    float soft = 1.0 - smoothstep(0.45, 1.0, abs(across));
    shown = vec4(compressed(colour.rgb * 0.9 * key_light.w), colour.a * soft * 0.85 * amount);
}
