in vec4 spot;  // x, y, radius in m, strength
out vec2 place;
flat out float strength;

void main() {
    place = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
    strength = spot.w;
    gl_Position = vec4((spot.xy + place * spot.z - window.xy) * window.z, 0.0, 1.0);
}
