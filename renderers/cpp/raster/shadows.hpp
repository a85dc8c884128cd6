// Shadow maps along the sun, and how much light reaches the ground under feet.
//
// A map is a grid on the ground. A point is entered where the sun's ray through it meets the ground, with its height;
// a texel keeps the greatest height, and what lies deeper on the same ray is in the shade.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../meshes.hpp"
#include "clones.hpp"
#include "placing.hpp"
#include "threads.hpp"

namespace vbbench::renderers {

constexpr float kNothing = -1e9f;          ///< height in a map where nothing blocks the sun
constexpr int kBand = 32;                  ///< rows of a map that one thread draws at a time
constexpr double kOverGround = 1.0 / 3.0;  ///< m up to which contact shadows reach

/// S x S numbers about the ground.
struct Grid {
  const float* values;
  int size;

  /// Whether (x, y) is between four of them.
  bool inside(double x, double y) const { return 0.0 <= x && x < size - 1.0 && 0.0 <= y && y < size - 1.0; }
  float at(int row, int column) const { return values[static_cast<std::size_t>(row) * size + column]; }
};

/// Heights along the sun's rays.
struct ShadowMap {
  Grid heights;             ///< in m
  Grid open;                ///< share of the sky that the ground sees, 0 … 1
  double x, y;              ///< the ground point at the outer corner of texel (0, 0), in m
  double scale;             ///< texels a metre
  double slope_x, slope_y;  ///< ground metres a metre of height, away from the sun

  /// Share of the sun at a point, looked up `lift` m above its surface and `slack` m higher along the ray.
  double sun_at(const Vec& point, const Vec& normal, double lift, double slack) const {
    const double height = point[2] + lift * normal[2];
    const double u = (point[0] + lift * normal[0] + slope_x * height - x) * scale - 0.5;
    const double v = (point[1] + lift * normal[1] + slope_y * height - y) * scale - 0.5;
    if (!heights.inside(u, v)) return 1.0;
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const double fx = u - column, fy = v - row, level = height + slack;
    double lit = 0.0;
    if (heights.at(row, column) <= level) lit += (1.0 - fx) * (1.0 - fy);
    if (heights.at(row, column + 1) <= level) lit += fx * (1.0 - fy);
    if (heights.at(row + 1, column) <= level) lit += (1.0 - fx) * fy;
    if (heights.at(row + 1, column + 1) <= level) lit += fx * fy;
    return lit;
  }

  /// Share of the sky that a point sees past the feet next to it.
  double sky_at(const Vec& point) const {
    if (point[2] >= kOverGround) return 1.0;
    const double texels = 0.25 * scale;
    const double u = (point[0] - x) * texels - 0.5, v = (point[1] - y) * texels - 0.5;
    if (!open.inside(u, v)) return 1.0;
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const double fx = u - column, fy = v - row;
    const double upper = (1.0 - fx) * open.at(row, column) + fx * open.at(row, column + 1);
    const double lower = (1.0 - fx) * open.at(row + 1, column) + fx * open.at(row + 1, column + 1);
    const double share = (1.0 - fy) * upper + fy * lower;
    return share + (1.0 - share) * std::min(std::max(point[2] / kOverGround, 0.0), 1.0);
  }
};

/// Enters a triangle, facing either way, at the centres of the texels that it covers, in the rows begin … end − 1.
VBBENCH_WIDE inline void cast_face(const Point& a, const Point& b, const Point& c, int begin, int end, int size,
                                   float* heights) {
  const float ax = a[0], ay = a[1], bx = b[0] - ax, by = b[1] - ay, cx = c[0] - ax, cy = c[1] - ay;
  const float area = bx * cy - by * cx;
  const auto lowest = [](float start, float to_b, float to_c) {
    return std::ceil(std::max(start + std::min<double>(std::min<double>(0.0, to_b), to_c), -1.0) - 0.5);
  };
  const auto highest = [](float start, float to_b, float to_c) {
    return std::floor(std::min(start + std::max<double>(std::max<double>(0.0, to_b), to_c), 1e6) - 0.5);
  };
  const int top = static_cast<int>(std::max<double>(begin, std::min<double>(lowest(ay, by, cy), end)));
  const int bottom = static_cast<int>(std::min<double>(end - 1, std::max(highest(ay, by, cy), -1.0)));
  if (area == 0.0f || top > bottom) return;
  const int first = static_cast<int>(std::max<double>(0.0, std::min<double>(lowest(ax, bx, cx), size)));
  const int last = static_cast<int>(std::min<double>(size - 1, std::max(highest(ax, bx, cx), -1.0)));
  const float rise_b = (b[2] - a[2]) / area, rise_c = (c[2] - a[2]) / area;
  const double sign = area > 0.0f ? 1.0 : -1.0;
  for (int v = top; v <= bottom; ++v) {
    const double y = v + 0.5 - ay;
    float* const row = heights + static_cast<std::size_t>(v) * size;
    for (int u = first; u <= last; ++u) {
      const double x = u + 0.5 - ax, share_b = x * cy - y * cx, share_c = y * bx - x * by;
      if (share_b * sign >= 0.0 && share_c * sign >= 0.0 && (area - share_b - share_c) * sign >= 0.0)
        row[u] = static_cast<float>(std::max<double>(row[u], a[2] + share_b * rise_b + share_c * rise_c));
    }
  }
}

/// Heights [S, S] of limbs by their transforms [N] to texel columns, texel rows and m.
inline void cast(const Meshes& meshes, Int limbs, const int* mesh, const Transform* joined, int size, float* heights,
                 Team& team) {
  const std::vector<Int> first = first_points(meshes, limbs, mesh);
  std::vector<Span> reach(limbs, {kInfinity, -kInfinity});  // rows of the map
  std::vector<Point> points(first.back());
  team.run(static_cast<int>(limbs), [&](int limb) {
    const Int begin = meshes.first_vertex[mesh[limb]], count = meshes.first_vertex[mesh[limb] + 1] - begin;
    Point* own = points.data() + first[limb];
    move(count, meshes.vertices + begin, joined[limb], own);
    for (Int n = 0; n < count; ++n)
      reach[limb] = {std::min<double>(reach[limb].first, own[n][1]), std::max<double>(reach[limb].second, own[n][1])};
  });
  team.run((size + kBand - 1) / kBand, [&](int band) {
    const int begin = band * kBand, end = std::min(size, (band + 1) * kBand);
    std::fill(heights + static_cast<std::size_t>(begin) * size, heights + static_cast<std::size_t>(end) * size,
              kNothing);
    for (Int limb = 0; limb < limbs; ++limb) {
      if (!(reach[limb].first < end && reach[limb].second > begin)) continue;
      const Int shift = first[limb] - meshes.first_vertex[mesh[limb]];
      for (Int row = meshes.first_triangle[mesh[limb]]; row < meshes.first_triangle[mesh[limb] + 1]; ++row) {
        const Corners& corners = meshes.triangles[row];
        cast_face(points[corners[0] + shift], points[corners[1] + shift], points[corners[2] + shift], begin, end, size,
                  heights);
      }
    }
  });
}

}  // namespace vbbench::renderers
