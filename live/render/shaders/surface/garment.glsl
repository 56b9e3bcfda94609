// A garment's particles, as the show has moved them: a grid that is smooth between them (Catmull-Rom in both directions).
uniform sampler2D particles;       // places [m], row by row of each garment
uniform int particles_shift;       // binary logarithm of the texture's width
uniform ivec3 grid;                // rows, columns, 1 if the last column is joined to the first
uniform vec2 cell;                 // length between two rows, and between two columns [m]

in vec2 in_cell;                   // place in the grid: row, column
in ivec2 in_worn;                  // dancer, first particle

struct Worn { vec3 place; vec3 normal; vec3 down; vec3 along; };

vec3 particle(int row, int column) {
    row = clamp(row, 0, grid.x - 1);
    column = grid.z == 1 ? (column + grid.y) % grid.y : clamp(column, 0, grid.y - 1);
    int at = in_worn.y + row * grid.y + column;
    return texelFetch(particles, ivec2(at & ((1 << particles_shift) - 1), at >> particles_shift), 0).xyz;
}

#if FINE
// Weights of four neighbours at t between the second and the third, and their derivatives.
void catmull_rom(float t, out vec4 value, out vec4 slope) {
    float tt = t * t, ttt = tt * t;
    value = vec4(-ttt + 2.0 * tt - t, 3.0 * ttt - 5.0 * tt + 2.0, -3.0 * ttt + 4.0 * tt + t, ttt - tt) * 0.5;
    slope = vec4(-3.0 * tt + 4.0 * t - 1.0, 9.0 * tt - 10.0 * t, -9.0 * tt + 8.0 * t + 1.0, 3.0 * tt - 2.0 * t) * 0.5;
}
#endif

Worn worn() {
    int row = int(in_cell.x), column = int(in_cell.y);
    vec3 place, down, along;
#if FINE
    vec4 by_row, down_row, by_column, along_column;
    catmull_rom(in_cell.x - float(row), by_row, down_row);
    catmull_rom(in_cell.y - float(column), by_column, along_column);
    place = down = along = vec3(0.0);
    for (int i = 0; i < 4; ++i) {
        vec3 line = vec3(0.0), change = vec3(0.0);
        for (int j = 0; j < 4; ++j) {
            vec3 one = particle(row - 1 + i, column - 1 + j);
            line += by_column[j] * one;
            change += along_column[j] * one;
        }
        place += by_row[i] * line;
        down += down_row[i] * line;
        along += by_row[i] * change;
    }
#else
    place = particle(row, column);
    down = particle(row + 1, column) - particle(row - 1, column);
    along = particle(row, column + 1) - particle(row, column - 1);
#endif
    vec3 normal = cross(down, along);
    float size = dot(normal, normal);
    return Worn(place, size > 1e-16 ? normal * inversesqrt(size) : vec3(0.0, 0.0, 1.0), down, along);
}

// A place in the picture; in depth it is a little nearer, so that no skin shows through cloth that lies on it.
vec4 seen_at(vec3 place, float nearer) {
    vec4 at = world_to_clip * vec4(place, 1.0);
    vec4 before = world_to_clip * vec4(place + normalize(eye.xyz - place) * nearer, 1.0);
    at.z = before.z / before.w * at.w;
    return at;
}

// The place on the flat cloth [m], for grain and seams.
vec3 on_cloth() { return vec3(in_cell.y * cell.y, -in_cell.x * cell.x, 0.0); }
