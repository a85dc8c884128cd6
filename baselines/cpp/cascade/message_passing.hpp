// Min-sum (max-product) message passing on a graph of discrete choices: O(E S² T).
//
// Minimises Σ_k U_k(s_k) + Σ_(i,j) V_ij(s_i, s_j). Exact on trees; on graphs with loops a good minimum, not a certain
// one.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "ego_motion.hpp"

namespace vbbench::cascade {

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

}  // namespace vbbench::cascade
