// The longest way in each tile, and then among its neighbours (McGuire et al. 2012, TileMax and NeighborMax).
uniform sampler2D source;
uniform int tile;             // side of a tile [pixels of source]; 0: the source's pixels are tiles
out vec4 most;

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(source, 0) - 1;
    vec4 found = vec4(0.0);
    int low = tile > 0 ? 0 : -1, high = tile > 0 ? tile : 2, side = tile > 0 ? tile : 1;
    for (int y = low; y < high; ++y) {
        for (int x = low; x < high; ++x) {
            vec4 there = texelFetch(source, clamp(here * side + ivec2(x, y), ivec2(0), last), 0);
            found = there.w > found.w ? there : found;
        }
    }
    most = found;
}
