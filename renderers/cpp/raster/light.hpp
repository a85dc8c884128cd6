// How bright a surface is: sun, sky, ground, highlight and haze; and the sky itself.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "../meshes.hpp"

namespace vbbench::renderers {

/// A sky; linear RGB.
struct Light {
  Vec sun;         ///< unit vector towards it
  Vec sun_colour;  ///< irradiance of a surface that faces it
  Vec zenith, horizon, ground_glow;
  double haze_distance;  ///< m
};

/// sRGB bytes of linear values from 0 to 1, in `steps` steps.
struct Encoding {
  const std::uint8_t* bytes;  ///< [steps + 1]
  int steps;

  std::uint8_t operator()(double value) const {
    return bytes[value > 0.0 ? static_cast<int>(std::min(value, 1.0) * steps + 0.5) : 0];
  }
};

/// Light that leaves a surface.
///
/// `normal` and `towards` the eye are unit vectors; `gloss`: strength of highlight and rim; `sun` and `sky`: shares of
/// them that reach the point.
inline Vec lit(const Light& light, const Vec& albedo, const Vec& normal, const Vec& towards, double gloss, double sun,
               double sky) {
  const double facing = std::max(0.0, dot(normal, light.sun)) * sun;
  const double above = 0.5 + 0.5 * normal[2], direct = facing * (0.5 + 0.5 * sky);
  double mirrored = 0.0, glare = 0.0;
  if (gloss > 0.0) {
    const Vec half{towards[0] + light.sun[0], towards[1] + light.sun[1], towards[2] + light.sun[2]};
    const double shine = std::max(0.0, dot(normal, half) / std::sqrt(dot(half, half) + 1e-12));
    mirrored = gloss * 0.6 * facing * squared(shine, 5);
    glare = gloss * 0.35 * squared(1.0 - std::max(0.0, dot(normal, towards)), 2);
  }
  Vec colour;
  for (int band = 0; band < 3; ++band) {
    const double heaven = 0.4 * light.horizon[band] + 0.6 * light.zenith[band];
    const double ambient = (above * heaven + (1.0 - above) * light.ground_glow[band]) * sky;
    colour[band] = albedo[band] * (ambient + light.sun_colour[band] * direct) + light.sun_colour[band] * mirrored +
                   glare * ambient;
  }
  return colour;
}

/// A colour seen from a distance in m; exp(−distance / haze) is taken as a 16th power, to 0.001 within one haze.
inline Vec through_air(const Light& light, const Vec& colour, double distance) {
  const double step = distance / (16.0 * light.haze_distance);
  const double clear = squared(1.0 / (1.0 + step + 0.5 * step * step), 4);
  Vec seen;
  for (int band = 0; band < 3; ++band) seen[band] = clear * colour[band] + (1.0 - clear) * light.horizon[band];
  return seen;
}

/// The sky in a direction, with the sun and its glow; below the horizon it is as on the horizon.
inline Vec sky_colour(const Light& light, const Vec& direction) {
  const double mix = std::sqrt(std::max(direction[2], 0.0)), along = std::max(0.0, dot(direction, light.sun));
  const double edge = std::min(std::max((along - 0.99955) / 0.00025, 0.0), 1.0), near = squared(along, 3);
  const double glow = 0.04 * near + 0.12 * squared(near, 2) + 2.0 * edge * edge * (3.0 - 2.0 * edge);
  Vec colour;
  for (int band = 0; band < 3; ++band)
    colour[band] =
        light.horizon[band] + mix * (light.zenith[band] - light.horizon[band]) + glow * light.sun_colour[band];
  return colour;
}

/// From the world to eye coordinates.
using Eye = std::array<std::array<double, 4>, 3>;

}  // namespace vbbench::renderers
