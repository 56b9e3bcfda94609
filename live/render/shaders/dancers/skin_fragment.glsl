// All vertices of all bodies that any pass of this frame draws, moved by the poses: a texel for each.
#include "poses.glsl"

uniform usampler2D meshes;       // two texels a vertex: position and joints, normal and weights
uniform isampler2D skin_rows;    // of each row: mesh's first vertex, its vertices, vertices of its dancers before the row, place in the list
uniform isampler2D skin_list;    // dancers
uniform int mesh_shift;          // binary logarithms of the widths
uniform int list_shift;
#ifdef MORPH_TEXELS
uniform usampler2D morph_index;  // of each vertex: number of its first movement, times 256, and how many there are
uniform usampler2D morphs;       // movements: position and normal as 16-bit numbers, channel
#endif

out uvec4 skin;                  // position, normal

int dancer_at(int place) {
    return texelFetch(skin_list, ivec2(place & ((1 << list_shift) - 1), place >> list_shift), 0).x;
}

#ifdef MORPH_TEXELS
vec2 signed_pair(uint numbers) { return (unpackUnorm2x16(numbers) * 65535.0 - 32768.0) / 32767.0; }

// What a character's face does to a vertex: the dancer's weights stand after the own joints.
void add_morphs(int dancer, int vertex, inout vec3 position, inout vec3 normal) {
    int mask = (1 << mesh_shift) - 1;
    uint found = texelFetch(morph_index, ivec2(vertex & mask, vertex >> mesh_shift), 0).x;
    ivec2 who = ivec2((dancer / pose_layout.x + 1) * own_texels - MORPH_TEXELS, dancer % pose_layout.x);
    for (int i = int(found >> 8u), end = i + int(found & 255u); i < end; ++i) {
        uvec4 movement = texelFetch(morphs, ivec2(i & mask, i >> mesh_shift), 0);
        int channel = int(movement.w);
        float weight = texelFetch(own_poses, who + ivec2(channel >> 2, 0), 0)[channel & 3];
        vec2 xy = signed_pair(movement.x), zn = signed_pair(movement.y);
        position += weight * float(MORPH_RANGE) * vec3(xy, zn.x);
        normal += weight * float(NORMAL_RANGE) * vec3(zn.y, signed_pair(movement.z));
    }
}
#endif

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec4 row = texelFetch(skin_rows, ivec2(pixel.y, 0), 0);
    int place = row.z + pixel.x, which = int((float(place) + 0.5) / float(row.y));   // dividing integers is slow
    int vertex = place - which * row.y, past = vertex < 0 ? -1 : int(vertex >= row.y);
    which += past;
    int number = row.x + vertex - past * row.y;
    vertex = 2 * number;
    ivec2 at = ivec2(vertex & ((1 << mesh_shift) - 1), vertex >> mesh_shift);
    uvec4 first = texelFetch(meshes, at, 0), second = texelFetch(meshes, at + ivec2(1, 0), 0);
    uvec4 joint = (uvec4(first.w) >> uvec4(0u, 8u, 16u, 24u)) & 255u;
    vec4 weights = unpackUnorm4x8(second.w);
    vec3 position = uintBitsToFloat(first.xyz), normal = uintBitsToFloat(second.xyz);
    int dancer = dancer_at(row.w + which);
#ifdef MORPH_TEXELS
    add_morphs(dancer, number, position, normal);
#endif
    Skinned here = posed(dancer, joint, weights, position, normal);
    vec3 n = here.normal / (abs(here.normal.x) + abs(here.normal.y) + abs(here.normal.z));
    vec2 side = n.z >= 0.0 ? n.xy : (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    skin = uvec4(floatBitsToUint(here.place), packUnorm2x16(side * 0.5 + 0.5));
}
