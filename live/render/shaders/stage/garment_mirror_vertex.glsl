// Garments seen in the floor: upside down, lit simply, as mirror_vertex.glsl lights bodies.
#include "frame.glsl"
#include "garment.glsl"
#define VERTEX 1
#include "surface.glsl"
#if STYLED
#include "styles.glsl"
#endif

out vec3 light;
out float height;

void main() {
    Worn here = worn();
    height = here.place.y;
    vec3 n = here.normal, to_eye = vec3(eye.x, -eye.y, eye.z) - here.place;
    n = dot(n, to_eye) < 0.0 ? -n : n;
    vec3 cloth = surface(on_cloth(), in_worn.x, 0).rgb;
    cloth *= cloth;
    float key = max(dot(n, key_direction.xyz), 0.0) * key_pool(here.place.xz);
    float rim = max(-n.z, 0.0) + 0.4 * abs(n.x);
    light = cloth * (key_light.rgb * key * 2.0 + rim_light.rgb * (rim * 0.6 + light_ambient()));
#if STYLED
    int dancer = in_worn.x, group = group_of(who(dancer));
    vec4 amount = amounts(group);
    float fill = fill_of(amount);
    vec3 glow = glow_of(dancer) * answer(group);
    light = (light * answer(group) + glow * style_emission(group) * 0.6) * min(amount.x, max(fill - amount.y, 0.0));
    light += style_silhouette_colour(group) * amount.y + style_ink_colour(group) * (0.10 * amount.z);
#endif
    gl_Position = world_to_clip * vec4(here.place.x, -here.place.y, here.place.z, 1.0);
}
