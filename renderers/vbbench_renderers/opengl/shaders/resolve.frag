// Half the size: colours through a tent two pixels wide, ids and depth from the sample at the pixel's centre.
uniform sampler2D fine_picture;
uniform sampler2D fine_truth;
layout(location = 0) out vec4 picture;
layout(location = 1) out vec2 truth;

void main() {
    ivec2 centre = 2 * ivec2(gl_FragCoord.xy) + 1;
    vec2 texel = 1.0 / vec2(textureSize(fine_picture, 0));
    vec2 at = (vec2(centre) + 0.5) * texel;
    vec2 half_texel = 0.5 * texel;
    picture = 0.25 * (texture(fine_picture, at - half_texel) + texture(fine_picture, at + half_texel)
        + texture(fine_picture, at + half_texel * vec2(1.0, -1.0))
        + texture(fine_picture, at + half_texel * vec2(-1.0, 1.0)));
    truth = texelFetch(fine_truth, centre, 0).xy;
}
