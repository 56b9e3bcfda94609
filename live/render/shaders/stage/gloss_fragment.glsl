// A dull floor's mirror image: blurred, most of all towards the eye.
#include "frame.glsl"
in vec2 at;
uniform sampler2D drawn;
out vec4 shown;

void main() {
    vec2 texel = mix(1.0, 0.4, share_water()) / vec2(textureSize(drawn, 0));
    vec3 sum = texture(drawn, at + texel * vec2(-0.7, 0.8)).rgb + texture(drawn, at + texel * vec2(0.7, 0.8)).rgb
             + texture(drawn, at + texel * vec2(-0.7, -0.8)).rgb + texture(drawn, at + texel * vec2(0.7, -0.8)).rgb
             + texture(drawn, at + texel * vec2(0.0, 2.4)).rgb + texture(drawn, at - texel * vec2(0.0, 2.4)).rgb;
    shown = vec4(sum / 6.0 * sqrt(pass_mirror()), 1.0);
}
