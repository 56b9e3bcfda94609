// The largest circle of each tile, and then of its neighbours, which may spread into it.
uniform sampler2D source;
uniform int tile;         // side of a tile [pixels of source]; 0: the source's pixels are tiles
out vec4 most;

void main() {
    ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(source, 0) - 1;
    float found = 0.0;
    if (tile > 0) {
        for (int y = 0; y < tile; ++y)
            for (int x = 0; x < tile; ++x) found = max(found, abs(texelFetch(source, min(here * tile + ivec2(x, y), last), 0).a));
    } else {
        for (int y = -1; y <= 1; ++y)
            for (int x = -1; x <= 1; ++x) found = max(found, texelFetch(source, clamp(here + ivec2(x, y), ivec2(0), last), 0).r);
    }
    most = vec4(found);
}
