// A corner of an output's triangles: the card divides by w, so that the corner pin is exact in every pixel.
in vec3 in_place;     // x w, y w, w in the window, y down
in vec2 in_frame;     // in the frame, y down

out vec2 frame;

void main() {
    frame = in_frame;
    gl_Position = vec4(2.0 * in_place.x - in_place.z, in_place.z - 2.0 * in_place.y, 0.0, in_place.z);
}
