// The picture where it is sharp, and what was gathered where it is not.
#include "frame.glsl"
#include "finish.glsl"
#include "distance.glsl"
in vec2 at;
uniform sampler2D light;
uniform sampler2D gathered;
uniform sampler2D spread;
uniform float focus;
uniform float widest;     // in pixels of the whole picture
uniform float most;       // largest radius in pixels of the gathered picture
out vec4 shown;

void main() {
    vec2 size = vec2(textureSize(gathered, 0)), half_pixel = 0.5 / size;
    vec4 over = 0.25 * (texture(gathered, at - half_pixel) + texture(gathered, at + half_pixel)
                        + texture(gathered, at + vec2(-half_pixel.x, half_pixel.y))
                        + texture(gathered, at + vec2(half_pixel.x, -half_pixel.y)));
    float away = distance_at(at), radius = widest * (away - focus) / away, small = clamp(radius * size.x / picture.x, -most, most);
    // behind what is sharp its colour must not come from the sharp thing's pixels
    vec2 place = at * size - 0.5, share = fract(place);
    vec3 sum = over.rgb * 1e-3;
    float weights = 1e-3;
    for (int i = 0; i < 4; ++i) {
        ivec2 step = ivec2(i & 1, i >> 1), texel = clamp(ivec2(floor(place)) + step, ivec2(0), ivec2(size) - 1);
        vec2 near = mix(1.0 - share, share, vec2(step));
        float weight = (near.x * near.y + 0.15) * clamp(1.5 - abs(texelFetch(spread, texel, 0).a - small), 0.0, 1.0);
        sum += texelFetch(gathered, texel, 0).rgb * weight;
        weights += weight;
    }
    float soft = smoothstep(0.5, SMALLEST, abs(radius));
    vec3 light_here = mix(texelFetch(light, ivec2(gl_FragCoord.xy), 0).rgb, compressed(sum / weights), soft);
    float front = over.a * smoothstep(0.0, 0.5, over.a);
    shown = vec4(mix(light_here, compressed(over.rgb), front), 1.0);
}
