// People's places given the pose: the cascade's second energy, with the interactions of people.
//
// E_p = Σ_k U_k(x_k) + λ Σ_(i,k) V(‖x_i − x_k‖) (arXiv 2111.05060, section IV-C; V below), a person's own
// energy, given the pose, being
//
//     U_k(x) = ρ(‖x − p_k‖/σ_k) + ½‖z_k − Rᵀ(x − c)‖²_{N_k⁻¹}   (see `ego_motion.hpp`).
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

#include "ego_motion.hpp"
#include "elementary.hpp"

namespace vbbench::cascade {

// The crowd graph: who interacts with whom, and how strongly; see `vbbench_baselines.cascade`.

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

// Min-sum (max-product) message passing on a graph of discrete choices: O(E S² T).
//
// Minimises Σ_k U_k(s_k) + Σ_(i,j) V_ij(s_i, s_j). Exact on trees; on graphs with loops a good minimum, not a certain
// one.

/// A choice for each of K nodes: energies [K, S], inf = no such choice; edges [E, 2] and energies [E, S, S] of pairs.
struct Choices {
  const double* unary;
  int nodes, samples;
  const std::int64_t* edges;
  const double* pair;
  int count;  ///< of edges
};

/// Stopping rule: a number of rounds, or no message changed by more; `damping` in [0, 1) is the share of an old
/// message.
struct Passing {
  int rounds;
  double damping, tolerance;
};

/// Updates `message` [S] of a node with `belief` that had `received` [S]; returns the greatest change.
///
/// `first`: the energies `pair` [S, S] are by the choices of the receiver and then of the sender.
inline double send(const double* belief, const double* received, const double* pair, bool first, int samples,
                   double damping, double* fresh, double* message) {
  std::fill_n(fresh, samples, kInfinity);
  if (first) {
    for (int s = 0; s < samples; ++s)
      for (int r = 0; r < samples; ++r) fresh[s] = std::min(fresh[s], belief[r] - received[r] + pair[s * samples + r]);
  } else {
    for (int r = 0; r < samples; ++r)
      for (int s = 0; s < samples; ++s) fresh[s] = std::min(fresh[s], belief[r] - received[r] + pair[r * samples + s]);
  }
  const double least = *std::min_element(fresh, fresh + samples);
  double change = 0.0;
  for (int s = 0; s < samples; ++s) {
    const double wanted = fresh[s] - least, value = wanted + damping * (message[s] - wanted);
    change = std::max(change, std::abs(value - message[s]));
    message[s] = value;
  }
  return change;
}

/// The min-marginals [K, S], up to a constant for each node, and the number of rounds; all messages are passed at once.
inline std::vector<double> pass_beliefs(const Choices& choices, const Passing& how, int& rounds) {
  const std::size_t samples = choices.samples;
  const std::vector<double> unary(choices.unary, choices.unary + choices.nodes * samples);
  std::vector<double> belief = unary, fresh(samples);
  std::vector<double> messages(2 * samples * choices.count);  // of each edge: to i from j, to j from i
  for (rounds = 0; rounds < how.rounds;) {
    const std::vector<double> last = messages;
    double change = 0.0;
    for (int e = 0; e < choices.count; ++e) {
      const double* i = belief.data() + choices.edges[2 * e] * samples;
      const double* j = belief.data() + choices.edges[2 * e + 1] * samples;
      const double* pair = choices.pair + e * samples * samples;
      const std::size_t to_i = 2 * e * samples, to_j = to_i + samples;
      const double a = send(j, &last[to_j], pair, true, choices.samples, how.damping, fresh.data(), &messages[to_i]);
      const double b = send(i, &last[to_i], pair, false, choices.samples, how.damping, fresh.data(), &messages[to_j]);
      change = std::max({change, a, b});
    }
    ++rounds;
    if (change <= how.tolerance) break;
    belief = unary;
    for (int e = 0; e < choices.count; ++e)
      for (int end = 0; end < 2; ++end)
        for (std::size_t s = 0; s < samples; ++s)
          belief[choices.edges[2 * e + end] * samples + s] += messages[(2 * e + end) * samples + s];
  }
  return belief;
}

/// The choice [K] of each node, by its min-marginal.
inline std::vector<std::int64_t> pass_messages(const Choices& choices, const Passing& how, int& rounds) {
  const std::vector<double> belief = pass_beliefs(choices, how, rounds);
  std::vector<std::int64_t> chosen(choices.nodes);
  for (int k = 0; k < choices.nodes; ++k) {
    const auto row = belief.begin() + static_cast<std::ptrdiff_t>(k) * choices.samples;
    chosen[k] = std::min_element(row, row + choices.samples) - row;
  }
  return chosen;
}

// Samples along the rays, and the descent.

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

/// Probability [K, S] of each person's samples by the messages: exp(−belief), of sum 1.
///
/// Beliefs are min-marginals: a sample has the probability of the best joint choice that contains it.
inline std::vector<double> ray_beliefs(const Choices& choices, const Passing& how) {
  int rounds = 0;
  std::vector<double> beliefs = pass_beliefs(choices, how, rounds);
  for (int k = 0; k < choices.nodes; ++k) {
    double* row = beliefs.data() + static_cast<std::size_t>(k) * choices.samples;
    const double least = *std::min_element(row, row + choices.samples);
    double total = 0.0;
    for (int s = 0; s < choices.samples; ++s) total += row[s] = elementary::exp(least - row[s]);
    for (int s = 0; s < choices.samples; ++s) row[s] /= total;
  }
  return beliefs;
}

}  // namespace vbbench::cascade
