uniform sampler2DShadow people_shadow;
uniform sampler2DShadow fixed_shadow;
uniform sampler2D contact;

// Share of the sun that reaches a point, 0 … 1.
float sunlight(vec3 point, vec3 normal) {
    vec3 lifted = point + normal * 0.03;
    vec3 at = along_sun(lifted, window) * vec3(0.5, 0.5, 1.0) + vec3(0.5, 0.5, -0.0005);
    vec3 fixed_at = along_sun(point + normal * 2.0 * fixed_window.w, fixed_window);
    fixed_at = fixed_at * vec3(0.5, 0.5, 1.0) + vec3(0.5, 0.5, -0.001);
    float spread = 0.7 * window.z * window.w;
    float lit = texture(people_shadow, at + vec3(-spread, -0.4 * spread, 0.0));
    lit += texture(people_shadow, at + vec3(0.4 * spread, -spread, 0.0));
    lit += texture(people_shadow, at + vec3(spread, 0.4 * spread, 0.0));
    lit += texture(people_shadow, at + vec3(-0.4 * spread, spread, 0.0));
    return 0.25 * lit * texture(fixed_shadow, fixed_at);
}

// How open a point near the ground is towards the sky: dark between and under feet.
float openness(vec3 point) {
    float open = texture(contact, (point.xy - window.xy) * window.z * 0.5 + 0.5).r;
    return mix(open, 1.0, clamp(point.z * 3.0, 0.0, 1.0));
}

vec3 sky(vec3 direction) {
    float up = max(direction.z, 0.0);
    float along = max(dot(direction, sun_direction.xyz), 0.0);
    float near = along * along;
    near *= near;
    near *= near;
    float halo = near * near * near * near;
    vec3 glow = sun_colour.rgb * (0.04 * near + 0.12 * halo + 2.0 * smoothstep(0.99955, 0.9998, along));
    return mix(horizon.rgb, zenith.rgb, sqrt(up)) + glow;
}

// Irradiance of a surface, given the share of the sun that reaches it.
vec3 light_on(vec3 point, vec3 normal, float lit) {
    float open = openness(point);
    float facing = max(dot(normal, sun_direction.xyz), 0.0);
    vec3 above = mix(horizon.rgb, zenith.rgb, 0.6);
    vec3 ambient = mix(ground_glow.rgb, above, normal.z * 0.5 + 0.5) * open;
    return ambient + sun_colour.rgb * (lit * facing * mix(1.0, open, 0.5));
}

// Highlight of the sun and the sky's mirror image at grazing angles.
vec3 mirrored(vec3 point, vec3 normal, float lit) {
    vec3 towards = normalize(eye.xyz - point);
    float shine = max(dot(normal, normalize(towards + sun_direction.xyz)), 0.0);
    shine *= shine;
    shine *= shine;
    shine *= shine;
    shine *= shine;
    float rim = 1.0 - max(dot(normal, towards), 0.0);
    rim *= rim;
    return sun_colour.rgb * (0.6 * lit * shine * shine) + horizon.rgb * (0.3 * rim * rim);
}

vec3 through_air(vec3 colour, vec3 point) {
    float seen = exp(-distance(point, eye.xyz) / sun_direction.w);
    return mix(horizon.rgb, colour, seen);
}

// Linear light to sRGB; the roots approximate the power to 0.3 %.
vec3 encode(vec3 light) {
    light = clamp(light, 0.0, 1.0);
    vec3 a = sqrt(light), b = sqrt(a), c = sqrt(b);
    return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * light;
}
