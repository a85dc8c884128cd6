// How many pixels each person would cover alone.
#pragma once

#include <array>
#include <vector>

#include "filling.hpp"

namespace vbbench::renderers {

/// Pixels, those inside a window, and those on its border.
using Counts = std::array<Int, 3>;

/// First column and row, and last column and row.
using Window = std::array<int, 4>;

/// Counts of K people, of whom limbs [N] are in ascending order; triangles that show both sides do not count.
inline std::vector<Counts> count_alone(const Meshes& meshes, const Placed& placed, const int* person, int people,
                                       const Rays& rays, const Window& window, Team& team) {
  const int strips = Strip::count(rays.width);
  std::vector<std::vector<Counts>> found(strips, std::vector<Counts>(people));
  team.run(strips, [&](int number) {
    const Strip strip = Strip::of(number, rays.width);
    std::vector<int> stamps(static_cast<std::size_t>(strip.end - strip.begin) * rays.height, -1);
    for (Int limb = 0; limb < placed.count(); ++limb) {
      if (placed.side[limb] == 0 || !reaches(placed.reach[limb], strip, rays)) continue;
      Counts& counts = found[number][person[limb]];
      for_faces(meshes, placed, limb, rays, strip, [&](const Triangle& triangle, int first, int last, Int) {
        const Face face(placed, triangle, placed.side[limb], rays);
        if (!face.seen()) return;
        for (int column = first; column <= last; ++column) {
          const Rows rows = face.rows(column);
          if (!(rows.top < rows.bottom)) continue;
          const bool aside = column < window[0] || column > window[2];
          const bool border = column == window[0] || column == window[2];
          for (int row = static_cast<int>(rows.top), bottom = static_cast<int>(rows.bottom); row < bottom; ++row) {
            int& stamp = stamps[static_cast<std::size_t>(column - strip.begin) * rays.height + row];
            if (stamp == person[limb] || !(rows.level + rows.fall * row <= 1.0 / kNear)) continue;
            stamp = person[limb];
            ++counts[0];
            if (aside || row < window[1] || row > window[3]) continue;
            ++counts[1];
            counts[2] += border || row == window[1] || row == window[3];
          }
        }
      });
    }
  });
  std::vector<Counts> sum(people);
  for (const auto& strip : found)
    for (int k = 0; k < people; ++k)
      for (int n = 0; n < 3; ++n) sum[k][n] += strip[k][n];
  return sum;
}

}  // namespace vbbench::renderers
