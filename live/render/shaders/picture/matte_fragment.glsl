// The picture with its alpha. What covers a pixel is as opaque as its cover; light alone gets the least alpha with
// which it looks the same over black.
#include "frame.glsl"
#include "finish.glsl"
#include "matte.glsl"
in vec2 at;
uniform sampler2D picture_drawn;
uniform float brightness;
out vec4 shown;
const float LEAST = 4.0 / 255.0;   // fainter light has no hue in 8 bits; the rest begins there, so that no edge is seen

void main() {
    vec4 solid = texelFetch(kept, ivec2(gl_FragCoord.xy), 0);
    vec3 colour = texelFetch(picture_drawn, ivec2(gl_FragCoord.xy), 0).rgb;
    float cover = clamp(solid.a, 0.0, 1.0);
    vec3 light = cover > 0.0 ? clamp(film(expanded(max(light_over(solid), 0.0))), 0.0, 1.0) : colour;
    float bright = max(light.r, max(light.g, light.b));
    light *= max(bright - LEAST, 0.0) / max(bright * (1.0 - LEAST), 1e-4);
    vec3 over_black = cover * colour + (1.0 - cover) * light;
    float alpha = cover + (1.0 - cover) * max(light.r, max(light.g, light.b));
    shown = alpha > 0.0 ? vec4(min(over_black / alpha, 1.0), alpha * brightness) : vec4(0.0);
}
