// A body's vertex as skin_fragment.glsl has moved it for all passes of this frame.
uniform usampler2D skin;
uniform int skin_shift;      // binary logarithm of the texture's width

in ivec2 in_instance;        // dancer, texel of the first vertex
#define VERTEX 1
#ifdef WORN                  // a character with images of its own
in vec2 in_uv;
in vec4 in_tint;
in vec4 in_finish;
out vec4 worn_at;            // place on the image, layer, opacity where it ends
out vec4 worn_tint;
flat out int worn_extra;     // which row of worn_extras
#endif

struct Skinned { vec3 place; vec3 normal; };

Skinned skinned() {
#ifdef WORN
    worn_at = vec4(in_uv, in_finish.x * 255.0, in_finish.y / max(in_finish.z, 0.004));
    worn_tint = in_tint;
    worn_extra = int(in_finish.w * 255.0 + 0.5);
#endif
    int at = in_instance.y + gl_VertexID;
    uvec4 texel = texelFetch(skin, ivec2(at & ((1 << skin_shift) - 1), at >> skin_shift), 0);
    // the normal on an octahedron (Cigolle et al. 2014)
    vec2 side = unpackUnorm2x16(texel.w) * 2.0 - 1.0;
    vec3 normal = vec3(side, 1.0 - abs(side.x) - abs(side.y));
    float fold = max(-normal.z, 0.0);
    normal.x += normal.x >= 0.0 ? -fold : fold;
    normal.y += normal.y >= 0.0 ? -fold : fold;
    return Skinned(uintBitsToFloat(texel.xyz), normalize(normal));
}
