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

/// Turns columns into a picture with smooth edges.
///
/// The direction of an edge is that along which brightness changes least; colours are the mean of three places along
/// it (after Lottes 2009, "FXAA").
class Smoothing {
 public:
  using Bytes = std::array<std::uint8_t, 3>;

  /// `owners` [N + 1]: id of each limb's person, kNobody for surroundings, less for the sky; `colours` [W, H] sRGB.
  Smoothing(const Rays& rays, const Buffer& buffer, const int* owners, const Bytes* colours, const Picture& picture)
      : rays_(rays), buffer_(buffer), owners_(owners), colours_(colours), picture_(picture) {}

  VBBENCH_WIDE_WHOLE void finish_column(int column) const {
    const int width = rays_.width, height = rays_.height;
    const int left = rays_.closed ? (column + width - 1) % width : std::max(column - 1, 0);
    const int right = rays_.closed ? (column + 1) % width : std::min(column + 1, width - 1);
    for (int row = 0; row < height; ++row) {
      const Int here = pixel(column, row), out = static_cast<Int>(row) * width + column;
      const int above = std::max(row - 1, 0), below = std::min(row + 1, height - 1), owner = owner_of(here);
      picture_.depth[out] = 1.0f / buffer_.nearness[here];
      picture_.ids[out] = std::max(owner, kNobody);
      std::uint8_t* rgb = picture_.rgb + 3 * out;
      if (owner >= 0 || differ(here, pixel(left, row)) || differ(here, pixel(right, row)) ||
          differ(here, pixel(column, above)) || differ(here, pixel(column, below))) {
        mix({left, column, right}, {above, row, below}, rgb);
      } else {
        std::copy_n(colours_[here].data(), 3, rgb);
      }
    }
  }

 private:
  Int pixel(int column, int row) const { return static_cast<Int>(column) * rays_.height + row; }
  int owner_of(Int pixel) const { return owners_[buffer_.limbs[pixel]]; }

  /// Whether two pixels show different surfaces.
  bool differ(Int one, Int other) const {
    const float near = buffer_.nearness[one], beside = buffer_.nearness[other];
    return owner_of(one) != owner_of(other) || std::abs(near - beside) > kStep * std::max(near, beside);
  }

  double brightness(int column, int row) const {
    const Bytes& colour = colours_[pixel(column, row)];
    return colour[0] + colour[1] + colour[2];
  }

  /// The colour of a pixel on an edge; positions in between are mixed from the 3 x 3 neighbourhood.
  void mix(const std::array<int, 3>& columns, const std::array<int, 3>& rows, std::uint8_t* rgb) const {
    const double nw = brightness(columns[0], rows[0]), ne = brightness(columns[2], rows[0]);
    const double sw = brightness(columns[0], rows[2]), se = brightness(columns[2], rows[2]);
    const double along_x = (sw + se) - (nw + ne), along_y = (nw + sw) - (ne + se);
    const double size = std::max(std::abs(along_x), std::abs(along_y));
    const double x = size >= kLeast ? std::abs(along_x) / size : 0.0,
                 y = size >= kLeast ? std::abs(along_y) / size : 0.0;
    const int ahead_x = columns[along_x > 0.0 ? 2 : 0], back_x = columns[along_x > 0.0 ? 0 : 2];
    const int ahead_y = rows[along_y > 0.0 ? 2 : 0], back_y = rows[along_y > 0.0 ? 0 : 2];
    const auto at = [&](int column, int row) -> const Bytes& { return colours_[pixel(column, row)]; };
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

  const Rays& rays_;
  const Buffer& buffer_;
  const int* owners_;
  const Bytes* colours_;
  Picture picture_;
};

/// Draws limbs in an `order` [N], near ones first; `owners` as `Smoothing` has them.
inline void draw(const Shading& shading, const int* order, const int* owners, const Picture& picture, Team& team) {
  const Rays& rays = shading.rays;
  Buffer buffer(rays);
  std::vector<Smoothing::Bytes> colours(buffer.nearness.size());
  team.run(Strip::count(rays.width), [&](int number) {
    const Strip strip = Strip::of(number, rays.width);
    fill(shading.meshes, shading.placed, order, rays, strip, buffer);
    for (int column = strip.begin; column < strip.end; ++column)
      shade_column(shading, buffer, column, colours[static_cast<std::size_t>(column) * rays.height].data());
  });
  const Smoothing smoothing(rays, buffer, owners, colours.data(), picture);
  team.run(Strip::count(rays.width), [&](int number) {
    const Strip strip = Strip::of(number, rays.width);
    for (int column = strip.begin; column < strip.end; ++column) smoothing.finish_column(column);
  });
}

}  // namespace vbbench::renderers
