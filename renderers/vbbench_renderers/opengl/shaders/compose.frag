// People before their surroundings. People are sampled twice as finely in both directions: their colours are
// averaged around the centre of a pixel, ids and depth come from the sample at the pixel's centre.
uniform sampler2D people_picture;
uniform sampler2D people_truth;
uniform sampler2D place_picture;
uniform sampler2D place_depth;
layout(location = 0) out vec4 picture;
layout(location = 1) out vec2 truth;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec2 texel = 1.0 / vec2(textureSize(people_picture, 0));
    vec2 at = (vec2(2 * pixel) + 1.5) * texel;
    vec4 people = 0.5 * (texture(people_picture, at - 0.5 * texel) + texture(people_picture, at + 0.5 * texel));
    vec2 person = texelFetch(people_truth, 2 * pixel + 1, 0).xy;
#ifdef FINE_PLACE
    texel = 1.0 / vec2(textureSize(place_picture, 0));
    at = (vec2(2 * pixel) + 1.5) * texel;
    vec3 place = 0.5 * (texture(place_picture, at - 0.5 * texel) + texture(place_picture, at + 0.5 * texel)).rgb;
    float depth = texelFetch(place_depth, 2 * pixel + 1, 0).x;
#else
    vec3 place = texelFetch(place_picture, pixel, 0).rgb;
    float depth = texelFetch(place_depth, pixel, 0).x;
#endif
    bool hidden = person.x > 0.5 && person.y > depth;
    picture = vec4(hidden ? place : people.rgb + place * (1.0 - people.a), 1.0);
    truth = person.x > 0.5 && !hidden ? vec2(person.x - 1.0, person.y) : vec2(-1.0, depth);
}
