out vec2 place;  // -1 … 1, y down

void main() {
    place = vec2(float(gl_VertexID >> 1), float(gl_VertexID & 1)) * 4.0 - 1.0;
    gl_Position = vec4(place, 1.0, 1.0);
}
