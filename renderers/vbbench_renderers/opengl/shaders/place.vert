in vec3 position;
in vec3 normal;
in vec3 colour;
in vec3 uv;            // z: layer
#ifdef PANORAMA
in float base;
#else
const float base = 0.0;
#endif
out vec3 world;
out vec3 upright;
out vec3 tint;
out vec3 at;

void main() {
    world = position;
    upright = normal;
    tint = colour;
    at = uv;
    gl_Position = project(world, base);
}
