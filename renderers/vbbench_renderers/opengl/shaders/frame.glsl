// What every program of a frame knows. World frame: z up, metres.
layout(std140) uniform Frame {
    vec4 eye;             // x, y, height; w: nearest distance drawn
    vec4 heading;         // cos yaw, sin yaw
    vec4 lens;            // clip x = lens.x right + lens.y w, clip y = lens.z down + lens.w w
    vec4 tilt_right;      // the camera's right, down and forward among those of a level one; level in a panorama
    vec4 tilt_down;
    vec4 tilt_forward;
    vec4 sun_direction;   // w: haze distance
    vec4 sun_colour;
    vec4 zenith;
    vec4 horizon;
    vec4 ground_glow;
    vec4 window;          // maps of people's shadows: centre x, y; 1 / half width; texel in m
    vec4 fixed_window;    // the same of everything that does not move
};
uniform vec2 shift;       // of the sample grid, in clip units

const float PI = 3.14159265358979;

// Right and forward of the eye.
vec2 relative(vec2 place) {
    vec2 d = place - eye.xy;
    return vec2(d.x * heading.y - d.y * heading.x, dot(d, heading.xy));
}

// Where the sun's rays through a point meet the ground, in a shadow map: -1 … 1; z is 0 high up … 1 deep down.
vec3 along_sun(vec3 point, vec4 map) {
    vec2 foot = point.xy - sun_direction.xy / sun_direction.z * point.z;
    return vec3((foot - map.xy) * map.z, 1.0 - (point.z + 2.0) / 64.0);
}
