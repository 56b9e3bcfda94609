// The dancers seen in the floor: upside down, lit simply.
#include "frame.glsl"
#include "skinned.glsl"
#include "surface.glsl"
#if STYLED
#include "styles.glsl"
#endif

in vec4 in_rest;   // place on the usual body, part

out vec3 light;
out float height;

void main() {
    Skinned skin = skinned();
    height = skin.place.y;
    vec3 n = skin.normal;
    vec3 cloth = surface(in_rest.xyz, in_instance.x, int(in_rest.w + 0.5)).rgb;
    cloth *= cloth;
    float key = max(dot(n, key_direction.xyz), 0.0) * key_pool(skin.place.xz);
    float rim = max(-n.z, 0.0) + 0.4 * abs(n.x);
    light = cloth * (key_light.rgb * key * 2.0 + rim_light.rgb * (rim * 0.6 + light_ambient()));
#if STYLED
    int dancer = in_instance.x, group = group_of(who(dancer));
    vec4 amount = amounts(group);
    float fill = fill_of(amount);
    vec3 glow = glow_of(dancer) * answer(group);
    light = (light * answer(group) + glow * style_emission(group) * 0.6) * min(amount.x, max(fill - amount.y, 0.0));
    light += style_silhouette_colour(group) * amount.y + style_ink_colour(group) * (0.10 * amount.z);
    light += glow * (0.30 * max(amount.w, style_particles(group)) * (1.0 - fill));
#endif
    gl_Position = world_to_clip * vec4(skin.place.x, -skin.place.y, skin.place.z, 1.0);
}
