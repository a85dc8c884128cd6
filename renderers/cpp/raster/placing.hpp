// Limbs brought into eye coordinates, with the columns that they may cover.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "../meshes.hpp"
#include "elementary.hpp"
#include "threads.hpp"

namespace vbbench::renderers {

using Transform = std::array<std::array<double, 4>, 3>;
using Span = std::pair<double, double>;  ///< of columns; first > second for nothing

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// N limbs of the meshes `mesh`, of which those parts count that are in front of the camera.
struct Placed {
  std::vector<int> mesh;
  std::vector<int> side;       ///< the side of the triangles that is drawn: 1, −1 where they are clockwise, 0 for both
  std::vector<Point> points;   ///< vertices in eye coordinates, limb after limb
  std::vector<float> columns;  ///< of the points, in px; anything where they are not in front of the camera
  std::vector<Int> first;      ///< [N + 1] first point of each limb
  std::vector<Span> reach;     ///< columns that a limb may cover; in a closed picture they may leave [0, W)

  Int count() const { return static_cast<Int>(mesh.size()); }
};

/// Columns in a perspective picture; a limb that reaches behind the camera may cover all of them.
inline Span columns_ahead(Int count, const Point* points, float* columns, const Rays& rays) {
  double low = kInfinity, high = -kInfinity;
  bool behind = false;
  for (Int n = 0; n < count; ++n) {
    if (points[n][2] < kNear) {
      behind = true;
    } else {
      columns[n] = static_cast<float>(rays.centre + rays.across * (points[n][0] / points[n][2]));
      low = std::min<double>(low, columns[n]);
      high = std::max<double>(high, columns[n]);
    }
  }
  if (behind && low <= high) return {0.0, rays.width};
  return {low, high};
}

/// Columns in a closed picture; a limb that may reach around the camera covers all of them.
inline Span columns_around(Int count, const Point* points, float* columns, double width) {
  constexpr double pi = 3.141592653589793;
  double start = 0.0, low = 0.0, high = 0.0;
  for (Int n = 0; n < count; ++n) {
    const double column = (elementary::atan2(points[n][0], points[n][2]) / (2.0 * pi) + 0.5) * width;
    columns[n] = static_cast<float>(column);
    if (n == 0) start = column;
    const double offset = column - start - width * std::floor((column - start) / width + 0.5);
    low = std::min(low, offset);
    high = std::max(high, offset);
  }
  if (high - low > 0.45 * width) return {0.0, width};
  return {start + low, start + high};
}

inline void move(Int count, const Point* vertices, const Transform& joined, Point* points) {
  for (Int n = 0; n < count; ++n) {
    const auto [x, y, z] = vertices[n];
    for (int row = 0; row < 3; ++row)
      points[n][row] =
          static_cast<float>(joined[row][0] * x + joined[row][1] * y + joined[row][2] * z + joined[row][3]);
  }
}

/// [N + 1] the first vertex of each limb where they lie limb after limb, and their number.
inline std::vector<Int> first_points(const Meshes& meshes, Int limbs, const int* mesh) {
  std::vector<Int> first{0};
  for (Int limb = 0; limb < limbs; ++limb)
    first.push_back(first.back() + meshes.first_vertex[mesh[limb] + 1] - meshes.first_vertex[mesh[limb]]);
  return first;
}

/// Limbs of meshes by their transforms [N] to eye coordinates.
inline Placed place(const Meshes& meshes, std::vector<int> mesh, std::vector<int> side, const Transform* joined,
                    const Rays& rays, Team& team) {
  Placed placed;
  placed.mesh = std::move(mesh);
  placed.side = std::move(side);
  placed.first = first_points(meshes, placed.count(), placed.mesh.data());
  placed.reach.resize(placed.mesh.size());
  placed.points.resize(static_cast<std::size_t>(placed.first.back()));
  placed.columns.resize(placed.points.size());
  team.run(static_cast<int>(placed.count()), [&](int limb) {
    const int part = placed.mesh[limb];
    const Int begin = meshes.first_vertex[part], count = meshes.first_vertex[part + 1] - begin;
    Point* points = placed.points.data() + placed.first[limb];
    float* columns = placed.columns.data() + placed.first[limb];
    move(count, meshes.vertices + begin, joined[limb], points);
    placed.reach[limb] =
        rays.closed ? columns_around(count, points, columns, rays.width) : columns_ahead(count, points, columns, rays);
  });
  return placed;
}

}  // namespace vbbench::renderers
