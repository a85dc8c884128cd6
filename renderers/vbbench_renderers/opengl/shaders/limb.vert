in vec3 position;
in vec3 normal;
in vec3 colour;
in vec4 row_x;
in vec4 row_y;
in vec4 row_z;
in vec4 first_dye;     // w: pattern
in vec4 second_dye;    // w: gloss
in float base;
in float person;
out vec3 world;
out vec3 upright;
out vec3 local;
out vec3 tint;
flat out vec4 first;
flat out vec4 second;
flat out float who;

void main() {
    vec4 point = vec4(position, 1.0);
    world = vec3(dot(row_x, point), dot(row_y, point), dot(row_z, point));
    // Cofactors turn normals, also where the limb is scaled or sheared.
    vec3 x = cross(row_y.xyz, row_z.xyz), y = cross(row_z.xyz, row_x.xyz), z = cross(row_x.xyz, row_y.xyz);
    float side = dot(row_x.xyz, x) < 0.0 ? -1.0 : 1.0;
    upright = side * vec3(dot(x, normal), dot(y, normal), dot(z, normal));
    upright = normalize(upright);
    local = position;
    tint = colour;
    first = first_dye;
    second = second_dye;
    who = person;
    gl_Position = project(world, base);
}
