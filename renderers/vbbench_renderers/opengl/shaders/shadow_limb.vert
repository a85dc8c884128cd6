in vec3 position;
in vec4 row_x;
in vec4 row_y;
in vec4 row_z;

void main() {
    vec4 point = vec4(position, 1.0);
    vec3 at = along_sun(vec3(dot(row_x, point), dot(row_y, point), dot(row_z, point)), window);
    gl_Position = vec4(at.xy, 2.0 * at.z - 1.0, 1.0);
}
