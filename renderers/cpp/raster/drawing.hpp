// A picture: limbs are placed, the z-buffer is filled and shaded strip by strip, and edges are made smooth: on people,
// and where the z-buffer has an edge; elsewhere textures stay sharp.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../meshes.hpp"
#include "clones.hpp"
#include "filling.hpp"
#include "shading.hpp"
#include "threads.hpp"

namespace vbbench::renderers {

constexpr double kStep = 0.05;   ///< neighbours whose depths differ by more than this share are on different surfaces
constexpr double kLeast = 24.0;  ///< edges with less contrast (sum of three bands, 0 … 765) stay as they are
constexpr int kNobody = -1;      ///< id of surroundings

/// A picture of H rows.
struct Picture {
  std::uint8_t* rgb;  ///< [H, W, 3] sRGB
  float* depth;       ///< [H, W]
  int* ids;           ///< [H, W]
};

/// Whether two pixels show different surfaces.
inline bool differ(const Buffer& buffer, const int* owners, Int one, Int other) {
  const float near = buffer.nearness[one], beside = buffer.nearness[other];
  return owners[buffer.limbs[one]] != owners[buffer.limbs[other]] ||
         std::abs(near - beside) > kStep * std::max(near, beside);
}

/// The colour of a pixel on an edge, smooth along it.
///
/// The direction of an edge is that along which brightness changes least; colours are the mean of three places along
/// it (after Lottes 2009, "FXAA"), mixed from the 3 x 3 neighbourhood.
inline void mix(const Buffer& buffer, const std::array<int, 3>& columns, const std::array<int, 3>& rows,
                std::uint8_t* rgb) {
  const auto at = [&](int column, int row) -> const Bytes& { return buffer.colours[buffer.pixel(column, row)]; };
  const auto bright = [&](int column, int row) -> double {
    const Bytes& colour = at(columns[column], rows[row]);
    return colour[0] + colour[1] + colour[2];
  };
  const double nw = bright(0, 0), ne = bright(2, 0), sw = bright(0, 2), se = bright(2, 2);
  const double along_x = (sw + se) - (nw + ne), along_y = (nw + sw) - (ne + se);
  const double size = std::max(std::abs(along_x), std::abs(along_y));
  const double x = size >= kLeast ? std::abs(along_x) / size : 0.0, y = size >= kLeast ? std::abs(along_y) / size : 0.0;
  const int ahead_x = columns[along_x > 0.0 ? 2 : 0], back_x = columns[along_x > 0.0 ? 0 : 2];
  const int ahead_y = rows[along_y > 0.0 ? 2 : 0], back_y = rows[along_y > 0.0 ? 0 : 2];
  for (int band = 0; band < 3; ++band) {
    const double here = at(columns[1], rows[1])[band];
    const auto between = [&](int column, int row) {  // bilinear between four neighbours
      const int beside = at(column, rows[1])[band], over = at(columns[1], row)[band], across = at(column, row)[band];
      return (1.0 - y) * ((1.0 - x) * here + x * beside) + y * ((1.0 - x) * over + x * across);
    };
    const double both = between(ahead_x, ahead_y) + between(back_x, back_y);
    rgb[band] = static_cast<std::uint8_t>(0.34 * here + 0.33 * both + 0.5);
  }
}

/// Writes a column of the picture, with smooth edges.
///
/// `owners` [N + 1]: id of each limb's person, kNobody for surroundings, less for the sky.
VBBENCH_WIDE_WHOLE inline void finish_column(const Rays& rays, const Buffer& buffer, const int* owners, int column,
                                             const Picture& picture) {
  const int width = rays.width, height = rays.height;
  const int left = rays.closed ? (column + width - 1) % width : std::max(column - 1, 0);
  const int right = rays.closed ? (column + 1) % width : std::min(column + 1, width - 1);
  for (int row = 0; row < height; ++row) {
    const Int here = buffer.pixel(column, row), out = static_cast<Int>(row) * width + column;
    const int above = std::max(row - 1, 0), below = std::min(row + 1, height - 1), owner = owners[buffer.limbs[here]];
    picture.depth[out] = 1.0f / buffer.nearness[here];
    picture.ids[out] = std::max(owner, kNobody);
    const auto edge = [&](int u, int v) { return differ(buffer, owners, here, buffer.pixel(u, v)); };
    if (owner >= 0 || edge(left, row) || edge(right, row) || edge(column, above) || edge(column, below))
      mix(buffer, {left, column, right}, {above, row, below}, picture.rgb + 3 * out);
    else
      std::copy_n(buffer.colours[here].data(), 3, picture.rgb + 3 * out);
  }
}

/// Draws limbs in an `order` [N], near ones first; `owners` as `finish_column` has them.
inline void draw(const Shading& shading, const int* order, const int* owners, const Picture& picture, Team& team) {
  const Rays& rays = shading.rays;
  Buffer buffer(rays);
  const auto for_strips = [&](const auto& work) {
    team.run((rays.width + kStrip - 1) / kStrip,
             [&](int number) { work(Strip{number * kStrip, std::min(rays.width, (number + 1) * kStrip)}); });
  };
  for_strips([&](const Strip& strip) {
    fill(shading.meshes, shading.placed, order, rays, strip, buffer);
    for (int column = strip.begin; column < strip.end; ++column) shade_column(shading, buffer, column);
  });
  for_strips([&](const Strip& strip) {
    for (int column = strip.begin; column < strip.end; ++column) finish_column(rays, buffer, owners, column, picture);
  });
}

}  // namespace vbbench::renderers
