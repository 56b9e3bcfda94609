// The picture where it is sharp, and what was gathered where it is not.
#include "frame.glsl"
#include "finish.glsl"
#include "distance.glsl"
in vec2 at;
uniform sampler2D light;
uniform sampler2D gathered;
uniform float focus;
uniform float widest;     // in pixels of the whole picture
out vec4 shown;

void main() {
    vec2 half_pixel = 0.5 / vec2(textureSize(gathered, 0));
    vec4 soft = 0.25 * (texture(gathered, at - half_pixel) + texture(gathered, at + half_pixel)
                        + texture(gathered, at + vec2(-half_pixel.x, half_pixel.y))
                        + texture(gathered, at + vec2(half_pixel.x, -half_pixel.y)));
    float away = distance_at(at), radius = widest * (away - focus) / away;
    float share = max(smoothstep(0.5, SMALLEST, abs(radius)), soft.a * smoothstep(0.0, 0.5, soft.a));
    vec3 sharp = texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb;
    shown = vec4(mix(sharp, compressed(soft.rgb), share), 1.0);
}
