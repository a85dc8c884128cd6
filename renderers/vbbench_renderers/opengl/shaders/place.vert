in vec3 position;
in vec3 normal;
in vec3 colour;
in vec3 uv;            // z: layer
#ifdef PANORAMA
in float base;
#else
const float base = 0.0;
#endif
out vec3 shaded;       // light of sky and ground, coloured
out vec3 sunlit;       // light of the sun, coloured
out vec3 at;
out vec3 fixed_at;
out vec3 ground_at;

void main() {
    shaded = colour * ambient(normal);
    sunlit = colour * sun_colour.rgb * max(dot(normal, sun_direction.xyz), 0.0);
    at = uv;
    fixed_at = in_map(position, normal, fixed_window, 2.0 * fixed_window.w);
    ground_at = on_ground(position);
    gl_Position = project(position, base);
}
