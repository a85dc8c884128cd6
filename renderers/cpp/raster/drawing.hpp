// A picture: limbs are placed, the z-buffer is filled and shaded strip by strip, and edges are made smooth.
#pragma once

#include <vector>

#include "shading.hpp"
#include "smoothing.hpp"
#include "threads.hpp"

namespace vbbench::renderers {

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
