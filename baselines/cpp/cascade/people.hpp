// People's places given the pose: the cascade's second energy, with the interactions of people.
//
// E_p = Σ_k U_k(x_k) + λ Σ_(i,k) V(‖x_i − x_k‖) (arXiv 2111.05060, section IV-C; V in `factors.py`), a person's own
// energy, given the pose, being
//
//     U_k(x) = ρ(‖x − p_k‖/σ_k) + ½‖z_k − Rᵀ(x − c)‖²_{N_k⁻¹}   (see `reweighting.hpp`).
//
// Message passing over samples along the viewing rays finds the basin, and a descent from there its minimum between
// samples. In each step of the descent ρ is replaced by its weighted square and V by its tangent; what remains is a
// Kalman update with p_k moved by −σ_k²/w_k·λ∇V.
//
// The samples stand δ of height apart on the ray about the person's own optimum, as many as ±SPAN standard deviations
// of the height take, at most S. Box noise across the ray moves each sample to where, at that height, U_k is least
// under the weights at the optimum; without box noise all samples are on the ray. People known to less than δ/2 have
// one sample.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "crowd_graph.hpp"
#include "elementary.hpp"
#include "reweighting.hpp"

namespace vbbench::cascade {

/// Places [K, S, 2] along the viewing rays in m, sample 0 the person's own optimum, and energies [K, S] less that at
/// the optimum; inf = unused.
struct Samples {
  std::vector<double> places, energies;
};

/// A person's height given its own terms: the variance in m², and dz/dh (right, forward).
struct OpenHeight {
  double variance, right, forward;
};

/// Both from the covariance P = (1/spread² + N⁻¹)⁻¹ of z: var h = uᵀPu with u = ρ/‖ρ‖², dz/dh = P u/(uᵀPu).
inline OpenHeight open_height(const double* ray, const double* covariance, double spread) {
  const double v = square(spread), squared = ray[0] * ray[0] + ray[1] * ray[1];
  const double u_r = ray[0] / squared, u_f = ray[1] / squared;
  const auto [rr, rf, ff] = information(covariance, v);
  // P = v − v (N + v)⁻¹ v
  const double right = v * (u_r - v * (rr * u_r + rf * u_f)), forward = v * (u_f - v * (rf * u_r + ff * u_f));
  const double variance = u_r * right + u_f * forward;
  return {variance, right / variance, forward / variance};
}

/// Everyone's samples; people without expectation stay where they are.
///
/// Positions [K, 2] and weights [K] are as `minimise` gives them; rays [K, 2] are places in m of a person one metre
/// tall; `most`, odd, and `spacing` are S and δ in m of height.
inline Samples sample_rays(double yaw, const double* positions, const double* weights, const double* rays,
                           const Factors& factors, double softness, int most, double spacing) {
  constexpr double kSpan = 3.0;  // standard deviations of the height on either side of the optimum
  const double sin = elementary::sin(yaw), cos = elementary::cos(yaw);
  const std::size_t total = static_cast<std::size_t>(factors.people) * most;
  Samples found{std::vector<double>(2 * total), std::vector<double>(total, kInfinity)};
  for (int k = 0; k < factors.people; ++k) {
    const double x = positions[2 * k], y = positions[2 * k + 1], std = factors.std[k];
    double* places = found.places.data() + 2 * static_cast<std::size_t>(k) * most;
    double* energies = found.energies.data() + static_cast<std::size_t>(k) * most;
    for (int s = 0; s < most; ++s) places[2 * s] = x, places[2 * s + 1] = y;
    energies[0] = 0.0;
    const double spread = std / std::sqrt(weights[k]);
    const auto [variance, right, forward] = open_height(rays + 2 * k, factors.covariance + 3 * k, spread);
    if (!(variance >= 0.25 * square(spacing))) continue;
    const double step_x = (right * sin + forward * cos) * spacing, step_y = (forward * sin - right * cos) * spacing;
    // Away from the optimum x the box term has the gradient −∇ρ = −(w/σ²)(x − p) and its own curvature.
    const double off_x = x - factors.expected[2 * k], off_y = y - factors.expected[2 * k + 1];
    const double start = std::sqrt((off_x * off_x + off_y * off_y) / square(std) + square(softness));
    const double slope = weights[k] / square(std) * (off_x * step_x + off_y * step_y);
    const double squared = step_x * step_x + step_y * step_y;
    const double curvature =
        std::max(square(spacing) / variance - squared / square(spread), 0.0);  // N⁻¹ = P⁻¹ − 1/spread²
    const int half = static_cast<int>(std::min<double>(most / 2, std::ceil(kSpan * std::sqrt(variance) / spacing)));
    for (int s = 1; s <= 2 * half; ++s) {
      const double n = s % 2 ? (s + 1) / 2 : -(s / 2);
      const double moved_x = off_x + n * step_x, moved_y = off_y + n * step_y;
      const double walk = std::sqrt((moved_x * moved_x + moved_y * moved_y) / square(std) + square(softness)) - start;
      places[2 * s] = x + n * step_x, places[2 * s + 1] = y + n * step_y;
      energies[s] = walk - n * slope + 0.5 * n * n * curvature;
    }
  }
  return found;
}

/// The edges [E', 2] along which a choice makes a difference, and λV there, [E', S, S].
struct Table {
  std::vector<std::int64_t> edges;
  std::vector<double> pair;
};

inline Table tabulate(const double* places, const double* energies, int samples, const CrowdGraph& graph) {
  Table table;
  const auto unused = [&](std::int64_t k, int s) { return std::isinf(energies[k * samples + s]); };
  for (int e = 0; e < graph.count; ++e) {
    const std::int64_t i = graph.edges[2 * e], j = graph.edges[2 * e + 1];
    if (samples == 1 || (unused(i, 1) && unused(j, 1))) continue;
    for (int s = 0; s < samples; ++s)
      for (int r = 0; r < samples; ++r) {
        const double *a = places + 2 * (i * samples + s), *b = places + 2 * (j * samples + r);
        const double dx = a[0] - b[0], dy = a[1] - b[1];
        const bool none = unused(i, s) || unused(j, r);
        table.pair.push_back(none ? 0.0 : graph.strength * potential(dx * dx + dy * dy, graph.sigma));
      }
    table.edges.insert(table.edges.end(), {i, j});
  }
  return table;
}

/// Positions [K, 2] of least E_p near `start` [K, 2].
inline std::vector<double> descend(const Pose& pose, const double* start, const Factors& factors, double softness,
                                   const CrowdGraph& graph, const Stop& stop) {
  const int people = factors.people;
  std::vector<double> positions(start, start + 2 * people), last(2 * people), pulled(2 * people), gradient(2 * people);
  std::vector<double> weights(people), spread(people);
  Factors weighted = factors;
  weighted.std = spread.data();
  weighted.expected = pulled.data();
  weigh(positions.data(), factors, softness, weights.data());
  for (int round = 0; round < stop.rounds; ++round) {
    spread_by(factors, weights.data(), spread.data());
    pull(positions.data(), people, graph, gradient.data());
    for (int i = 0; i < 2 * people; ++i) pulled[i] = factors.expected[i] - square(spread[i / 2]) * gradient[i];
    last.swap(positions);
    localise(pose, weighted, positions.data());
    if (!moved(last.data(), positions.data(), people, stop.tolerance)) break;
    weigh(positions.data(), factors, softness, weights.data());
  }
  return positions;
}

}  // namespace vbbench::cascade
