in vec3 position;

void main() {
    vec3 at = along_sun(position, fixed_window);
    gl_Position = vec4(at.xy, 2.0 * at.z - 1.0, 1.0);
}
