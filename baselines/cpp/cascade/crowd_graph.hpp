// The crowd graph: who interacts with whom, and how strongly; see `factors.py`.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ego_motion.hpp"
#include "elementary.hpp"

namespace vbbench::cascade {

/// Interacting pairs [E, 2], the strength λ and the σ in m of their potential λV.
struct CrowdGraph {
  const std::int64_t* edges;
  int count;
  double strength, sigma;
};

/// Edges (i, j), i < j, where j is among i's `most` nearest within `reach` m, or i among j's, of positions [K, 2].
///
/// NaN has no neighbours. At most K·`most` edges, so that what follows is linear in K.
inline std::vector<std::int64_t> link(const double* positions, int people, double reach, int most) {
  std::vector<char> linked(static_cast<std::size_t>(people) * people);
  std::vector<double> near(most);
  std::vector<int> ids(most);
  for (int i = 0; i < people; ++i) {
    int count = 0;
    for (int j = 0; j < people; ++j) {
      const double dx = positions[2 * j] - positions[2 * i], dy = positions[2 * j + 1] - positions[2 * i + 1];
      const double squared = dx * dx + dy * dy;
      if (i == j || !(squared < reach * reach) || (count == most && squared >= near[most - 1])) continue;
      int slot = std::min(count, most - 1);
      for (; slot > 0 && near[slot - 1] > squared; --slot) near[slot] = near[slot - 1], ids[slot] = ids[slot - 1];
      near[slot] = squared, ids[slot] = j;
      count = std::min(count + 1, most);
    }
    for (int slot = 0; slot < count; ++slot) {
      const auto [first, second] = std::minmax(i, ids[slot]);
      linked[static_cast<std::size_t>(first) * people + second] = 1;
    }
  }
  std::vector<std::int64_t> edges;
  for (int i = 0; i < people; ++i)
    for (int j = i + 1; j < people; ++j)
      if (linked[static_cast<std::size_t>(i) * people + j]) edges.insert(edges.end(), {i, j});
  return edges;
}

/// V at the squared distance d² in m².
inline double potential(double squared, double sigma) {
  return std::sqrt(squared) / square(sigma) * elementary::exp(-0.5 * squared / square(sigma));
}

/// Gradient [K, 2] in 1/m of λ Σ V over the edges, at positions [K, 2] in m.
inline void pull(const double* positions, int people, const CrowdGraph& graph, double* gradient) {
  std::fill_n(gradient, 2 * people, 0.0);
  const double variance = square(graph.sigma);
  for (int e = 0; e < graph.count; ++e) {
    const std::int64_t i = 2 * graph.edges[2 * e], j = 2 * graph.edges[2 * e + 1];
    const double dx = positions[i] - positions[j], dy = positions[i + 1] - positions[j + 1];
    const double squared = dx * dx + dy * dy, distance = std::max(std::sqrt(squared), 1e-9);
    const double slope =
        graph.strength * (1.0 - squared / variance) / variance * elementary::exp(-0.5 * squared / variance) / distance;
    gradient[i] += slope * dx;
    gradient[i + 1] += slope * dy;
    gradient[j] -= slope * dx;
    gradient[j + 1] -= slope * dy;
  }
}

}  // namespace vbbench::cascade
