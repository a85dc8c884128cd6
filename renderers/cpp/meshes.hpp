// Meshes, the rays of a camera, and limbs: what all that is drawn here consists of.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace vbbench::renderers {

using Int = std::int64_t;
using Vec = std::array<double, 3>;
using Point = std::array<float, 3>;
using Corners = std::array<int, 3>;  ///< of a triangle, rows of vertices
using Bytes = std::array<std::uint8_t, 3>;

constexpr double kNear = 0.1;  ///< m of depth; surfaces nearer than this are not drawn

inline double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// M meshes, joined.
struct Meshes {
  const Point *vertices, *normals, *colours;  ///< [V]
  const std::array<float, 2>* uv;             ///< [V]
  const int* layers;                          ///< [F] texture layer of each triangle
  const float* grain;                         ///< [F] texture widths a metre of each triangle
  const Corners* triangles;                   ///< [F]
  const Int *first_vertex, *first_triangle;   ///< [M + 1]
};

/// Texture widths a metre of a triangle, the geometric mean of both directions.
inline float grain_of(const Point* vertices, const std::array<float, 2>* uv, const Corners& t) {
  std::array<Vec, 2> side;
  std::array<std::array<double, 2>, 2> step;
  for (int n = 0; n < 2; ++n) {
    for (int axis = 0; axis < 3; ++axis)
      side[n][axis] = static_cast<double>(vertices[t[n + 1]][axis]) - vertices[t[0]][axis];
    for (int axis = 0; axis < 2; ++axis) step[n][axis] = static_cast<double>(uv[t[n + 1]][axis]) - uv[t[0]][axis];
  }
  const auto& [a, b] = side;
  const Vec normal{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
  const double cover = std::abs(step[0][0] * step[1][1] - step[0][1] * step[1][0]);
  return static_cast<float>(std::sqrt(cover / std::max(std::sqrt(dot(normal, normal)), 1e-12)));
}

/// Rays of a W x H picture; the ray of a pixel is (side[column], (horizon − row) / focal, ahead[column]).
struct Rays {
  const double *side, *ahead;  ///< [W]
  int width, height;
  double focal;    ///< of the rows, in px
  double across;   ///< of the columns, in px; unused in a panorama
  double horizon;  ///< row of the horizon of a level camera, counted between pixel centres
  double centre;   ///< column of the optical axis in px; unused in a panorama
  bool closed;     ///< whether the picture closes on itself
};

/// Two to the n-th power of x: x squared n times.
inline double squared(double x, int times) {
  for (int n = 0; n < times; ++n) x *= x;
  return x;
}

/// How N limbs look.
struct Looks {
  const Point *colour, *second_colour;  ///< linear RGB
  const int* pattern;                   ///< see `patterned`; below 0 for what is seen from both sides
  const float* gloss;
  const std::array<Point, 3>* normal;  ///< from normals of the limb's frame to normals in the world
};

enum Pattern { kPlain, kRings, kChecks };
constexpr double kRingsPerM = 12.0, kChecksPerM = 14.0;

inline bool low(double value) { return value - std::floor(value) < 0.5; }

/// Three numbers of the corners, weighted.
inline Vec blend(const Point* values, const Corners& corners, const Vec& weights) {
  const Point &a = values[corners[0]], &b = values[corners[1]], &c = values[corners[2]];
  const auto [w0, w1, w2] = weights;
  return {w0 * a[0] + w1 * b[0] + w2 * c[0], w0 * a[1] + w1 * b[1] + w2 * c[1], w0 * a[2] + w1 * b[2] + w2 * c[2]};
}

/// Whether a limb shows its second colour at a point of its frame.
inline bool patterned(int pattern, const Vec& point) {
  if (pattern == kRings) return low(kRingsPerM * point[2]);
  return pattern == kChecks && low(kChecksPerM * point[0]) != low(kChecksPerM * point[2]);
}

/// The dye of a limb at a point of a triangle, by the weights of its corners.
inline const Point& dye_of(const Looks& looks, Int limb, const Point* vertices, const Corners& corners,
                           const Vec& weights) {
  const int pattern = looks.pattern[limb];
  return pattern > 0 && patterned(pattern, blend(vertices, corners, weights)) ? looks.second_colour[limb]
                                                                              : looks.colour[limb];
}

}  // namespace vbbench::renderers
