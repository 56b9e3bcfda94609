// A garment pushed aside by the breadth of the pen, behind itself: what is seen of it around it is the line.
#include "frame.glsl"
#include "garment.glsl"
#define VERTEX 1
#include "surface.glsl"
#include "styles.glsl"

uniform float nearer;    // [m]
uniform float side;      // 1 and -1: a sheet has an outline on both sides

flat out vec4 ink;

invariant gl_Position;

void main() {
    Worn here = worn();
    int group = group_of(who(in_worn.x));
    float amount = amounts(group).z;
    vec4 at = seen_at(here.place, nearer);
    vec3 out_ = here.normal * side;
    bool last = in_cell.x > float(grid.x) - 1.01, first = grid.z == 0 && in_cell.y < 0.01;
    bool end = grid.z == 0 && in_cell.y > float(grid.y) - 1.01;
    if (last) out_ = normalize(here.down);                      // a hem's line is drawn beyond it
    else if (first || end) out_ = normalize(here.along) * (end ? 1.0 : -1.0);
    vec2 aside = clip_way(world_to_clip * vec4(out_, 0.0)) * picture.xy;
    float pen = style_ink_width(group) * whole_picture.y / 1080.0 * smoothstep(0.0, 1.0, amount);
    pen *= clamp(9.0 / at.w, 0.45, 1.6);
    at.xy += normalize(aside + vec2(1e-6)) * max(pen, 0.001) * 2.0 * picture.zw * at.w;
    at.z += 0.0012 * at.w;
    gl_Position = at;
    ink = vec4(style_ink_colour(group) * (2.0 * answer(group)), amount);
}
