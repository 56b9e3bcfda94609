// Lit body, flat silhouette and ink's paper in any shares; what is left of the whole body dissolves into grains.
#include "frame.glsl"
#include "surface.glsl"
#include "styles.glsl"
#include "light.glsl"
#include "finish.glsl"
#include "shown.glsl"

in vec3 place;
in vec4 facing;
in vec4 body;
flat in ivec2 own;

#if SURFACE
layout(location = 0) out vec4 cover;   // as in gbuffer_fragment.glsl
layout(location = 1) out vec4 shape;
layout(location = 2) out vec4 name;
#else
out vec4 shown;
#endif

void main() {
    int dancer = own.x, group = own.y;
    vec4 amount = amounts(group);
    float fill = fill_of(amount), burn = 0.0;
    if (fill < 1.0) {
        float grain_ = 0.62 * noise3(body.xyz * 34.0) + 0.38 * hash3(floor(body.xyz * 190.0));
        float left = fill * 1.06 - 0.03 - grain_;
        if (left < 0.0) discard;
        burn = exp(-left * 16.0) * min(4.0 * fill * (1.0 - fill), 1.0);
    }
#if SURFACE
    vec4 seen = surface(body.xyz, dancer, int(body.w + 0.5));
    int number = dancer + 1;
    cover = vec4(seen.rgb, facing.w);
    shape = vec4(outward(normalize(facing.xyz)) * 0.5 + 0.5, seen.a);
    name = vec4(float(number & 255), float((number >> 8) & 255), float(group), 255.0) / 255.0;
#else
    vec3 n = bumped(outward(normalize(facing.xyz)), place), own_light = emitted();
    vec4 cloth = surface(body.xyz, dancer, int(body.w + 0.5));
    vec3 glow = glow_of(dancer), albedo = cloth.rgb * cloth.rgb;
    vec3 colour = lit(place, n, albedo, cloth.a, facing.w) + own_light;
    float beat = answer(group);
    bool clad = dot(abs(albedo - square3(material(0, dancer).rgb)), vec3(1.0)) < 0.01
             || dot(abs(albedo - square3(material(1, dancer).rgb)), vec3(1.0)) < 0.01;
    float edge = square(1.0 - max(dot(n, normalize(eye.xyz - place)), 0.0));
    colour += glow * (style_emission(group) * (clad ? 0.55 + 0.5 * edge : 0.08) * beat);
    colour = colour * beat + glow * (style_pulse(group) * key_direction.w * (0.10 + 0.9 * edge * edge));

    float flat_ = clamp(amount.y / max(fill, 1e-3), 0.0, 1.0);
    float solid = clamp(amount.x / max(fill - amount.y, 1e-3), 0.0, 1.0);
    vec3 paper = light_background() * 0.35;
    colour = mix(mix(paper, colour, solid), style_silhouette_colour(group) * (1.8 * beat), flat_);
    // ink along the borders of her clothes, too
    float fine = length(fwidth(body.xyz)), seam = seams(body.xyz, dancer) / max(fine, 1e-6);
    float pen = style_ink_width(group) * whole_picture.y / 1080.0 * 0.75;
    colour = mix(colour, style_ink_colour(group) * (2.0 * beat), amount.z * (1.0 - smoothstep(0.5 * pen, 0.5 * pen + 1.0, seam)) * 0.8 * smoothstep(0.016, 0.006, fine));
    colour += glow * (burn * 1.3);
    shown = shown_as(colour);
#endif
}
