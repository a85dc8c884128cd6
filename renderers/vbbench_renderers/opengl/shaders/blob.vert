in vec2 centre;        // m
in vec3 axes;          // lower triangle l00, l10, l11: the ellipse is its image of the unit circle, in m
in vec3 effect;        // share of the sun and of the sky it takes; radius within which it takes all of it
out vec2 place;
flat out vec3 strength;

void main() {
    place = vec2(float(gl_VertexID & 1), float(gl_VertexID >> 1)) * 2.0 - 1.0;
    strength = effect;
    vec2 point = centre + vec2(axes.x * place.x, axes.y * place.x + axes.z * place.y);
    gl_Position = vec4((point - window.xy) * window.z, 0.0, 1.0);
}
