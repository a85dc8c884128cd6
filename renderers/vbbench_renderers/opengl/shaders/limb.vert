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
out vec4 local;        // point in the limb's frame; w: cosine towards the sun
out vec4 mirrored;     // sun's highlight where lit
out vec3 tint;
out vec3 around;       // light of sky and ground
out vec3 map;
flat out vec4 first;
flat out vec3 second;
flat out float who;

void main() {
    vec4 point = vec4(position, 1.0);
    vec3 world = vec3(dot(row_x, point), dot(row_y, point), dot(row_z, point));
    // Cofactors turn normals, also where the limb is scaled or sheared.
    vec3 x = cross(row_y.xyz, row_z.xyz), y = cross(row_z.xyz, row_x.xyz), z = cross(row_x.xyz, row_y.xyz);
    vec3 upright = normalize(vec3(dot(x, normal), dot(y, normal), dot(z, normal)));
    vec3 towards = normalize(eye.xyz - world);
    float shine = max(dot(upright, normalize(towards + sun_direction.xyz)), 0.0);
    shine *= shine;
    shine *= shine;
    shine *= shine;
    shine *= shine;
    float rim = 1.0 - max(dot(upright, towards), 0.0);
    rim *= rim;
    float open = clamp(0.55 + 0.9 * world.z, 0.0, 1.0);
    float sunny = textureLod(fixed_shadow, in_map(world, upright, fixed_window, 2.0 * fixed_window.w), 0.0);
    local = vec4(position, dot(upright, sun_direction.xyz) * sunny);
    mirrored = second_dye.w * vec4(0.3 * rim * rim * horizon.rgb, 0.6 * shine * shine * sunny);
    around = ambient(upright) * open;
    map = in_map(world, upright, window, 0.03);
    tint = colour;
    first = first_dye;
    second = second_dye.rgb;
    who = person;
    gl_Position = project(world, base);
}
