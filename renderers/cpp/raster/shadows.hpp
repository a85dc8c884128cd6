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
constexpr int kBlock = 16;                 ///< texels along a side of a block, which divides a band
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
  Grid highest;             ///< of each block of texels: where nothing reaches a point, no texel need be read
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
    const bool one_block = column % kBlock < kBlock - 1 && row % kBlock < kBlock - 1;
    if (one_block && highest.at(row / kBlock, column / kBlock) <= level)
      return (1.0 - fx) * (1.0 - fy) + fx * (1.0 - fy) + (1.0 - fx) * fy + fx * fy;
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
    const double share = openness((point[0] - x) * texels - 0.5, (point[1] - y) * texels - 0.5);
    return share + (1.0 - share) * std::min(std::max(point[2] / kOverGround, 0.0), 1.0);
  }

 private:
  /// Bilinear; 1 outside.
  double openness(double u, double v) const {
    if (!open.inside(u, v)) return 1.0;
    const int column = static_cast<int>(u), row = static_cast<int>(v);
    const double fx = u - column, fy = v - row;
    const double upper = (1.0 - fx) * open.at(row, column) + fx * open.at(row, column + 1);
    const double lower = (1.0 - fx) * open.at(row + 1, column) + fx * open.at(row + 1, column + 1);
    return (1.0 - fy) * upper + fy * lower;
  }
};

/// A spot on the ground: place and radius in m, and how dark it is in the middle.
struct Spot {
  double x, y, radius, depth;
};

/// Darkens a grid [S, S] under spots; its outer corner is at x, y (m), with `scale` numbers a metre.
inline void stain(Int count, const Spot* spots, double x, double y, double scale, int size, float* open) {
  for (Int n = 0; n < count; ++n) {
    const double u = (spots[n].x - x) * scale, v = (spots[n].y - y) * scale, radius = spots[n].radius * scale;
    const auto from = [&](double middle) {
      return static_cast<int>(std::max(0.0, std::min<double>(size, middle - radius)));
    };
    const auto to = [&](double middle) {
      return static_cast<int>(std::max(-1.0, std::min(size - 1.0, middle + radius)));
    };
    for (int row = from(v); row <= to(v); ++row) {
      for (int column = from(u); column <= to(u); ++column) {
        const double across = column + 0.5 - u, along = row + 0.5 - v;
        const double fall = std::max(0.0, 1.0 - (across * across + along * along) / (radius * radius));
        float& value = open[static_cast<std::size_t>(row) * size + column];
        value = static_cast<float>(value * (1.0 - spots[n].depth * fall * fall));
      }
    }
  }
}

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

/// The number of blocks along a side of a map.
inline int blocks(int size) { return (size + kBlock - 1) / kBlock; }

/// Heights [S, S] of limbs by their transforms [N] to texel columns, texel rows and m, and the highest of each block.
inline void cast(const Meshes& meshes, Int limbs, const int* mesh, const Transform* joined, int size, float* heights,
                 float* highest, Team& team) {
  struct Bounds {
    double low_x = kInfinity, high_x = -kInfinity, low_y = kInfinity, high_y = -kInfinity;
  };
  const std::vector<Int> first = first_points(meshes, limbs, mesh);
  std::vector<Bounds> bounds(limbs);
  std::vector<Point> points(first.back());
  const auto highest_of = [&](int row, int column) {
    return highest + static_cast<std::size_t>(row / kBlock) * blocks(size) + column / kBlock;
  };
  team.run(static_cast<int>(limbs), [&](int limb) {
    const Int begin = meshes.first_vertex[mesh[limb]], count = meshes.first_vertex[mesh[limb] + 1] - begin;
    Point* own = points.data() + first[limb];
    move(count, meshes.vertices + begin, joined[limb], own);
    Bounds& b = bounds[limb];
    for (Int n = 0; n < count; ++n) {
      b.low_x = std::min<double>(b.low_x, own[n][0]);
      b.high_x = std::max<double>(b.high_x, own[n][0]);
      b.low_y = std::min<double>(b.low_y, own[n][1]);
      b.high_y = std::max<double>(b.high_y, own[n][1]);
    }
  });
  team.run((size + kBand - 1) / kBand, [&](int band) {
    const int begin = band * kBand, end = std::min(size, (band + 1) * kBand);
    std::fill(heights + static_cast<std::size_t>(begin) * size, heights + static_cast<std::size_t>(end) * size,
              kNothing);
    for (Int limb = 0; limb < limbs; ++limb) {
      const Bounds& b = bounds[limb];
      if (!(b.low_y < end && b.high_y > begin && b.low_x < size && b.high_x > 0.0)) continue;
      const Int shift = first[limb] - meshes.first_vertex[mesh[limb]];
      for (Int row = meshes.first_triangle[mesh[limb]]; row < meshes.first_triangle[mesh[limb] + 1]; ++row) {
        const Corners& corners = meshes.triangles[row];
        cast_face(points[corners[0] + shift], points[corners[1] + shift], points[corners[2] + shift], begin, end, size,
                  heights);
      }
    }
    for (int first_row = begin; first_row < end; first_row += kBlock) {
      std::vector<float> columns(size, kNothing);
      for (int row = first_row; row < std::min(end, first_row + kBlock); ++row)
        for (int n = 0; n < size; ++n)
          columns[n] = std::max(columns[n], heights[static_cast<std::size_t>(row) * size + n]);
      for (int n = 0; n < size; n += kBlock)
        *highest_of(first_row, n) =
            *std::max_element(columns.begin() + n, columns.begin() + std::min(size, n + kBlock));
    }
  });
}

}  // namespace vbbench::renderers
