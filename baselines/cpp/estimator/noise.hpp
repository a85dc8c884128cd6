// Estimation of the noise of boxes, and of its correlation time, during a recording.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "window.hpp"

namespace vbbench {

/// A grid posterior of σ and τ for each cue, by the density of each box given the one before.
class NoiseLearner {
 public:
  static constexpr int kShares = 19, kTimes = 6, kGrid = kShares * kTimes,
                       kLate = 2;  ///< boxes count once so many later frames are solved

  void start(const BoxNoise& first, double spread, double dt) {
    nu_ = first.nu;
    dt_ = dt;
    noise_ = first;
    for (int s = 0; s < kShares; ++s) share_[s] = 0.002 * elementary::exp(s * (elementary::log(80.0) / (kShares - 1)));
    for (int t = 0; t < kTimes; ++t) time_[t] = 0.05 * elementary::exp(t * (elementary::log(400.0) / (kTimes - 1)));
    for (int c = 0; c < 3; ++c)
      for (int s = 0; s < kShares; ++s)
        for (int t = 0; t < kTimes; ++t) {
          const double off = elementary::log(share_[s] / first.share[c]) / spread;
          const double later = elementary::log(time_[t] / first.time[c]) / 2.0;
          weight_[c][s * kTimes + t] = -0.5 * (off * off + later * later);
        }
  }

  /// Updates the posterior with the boxes of the frame `kLate` before the newest.
  void learn(const Window& window, const Model& model) {
    const int frame = static_cast<int>(window.frames.size()) - 1 - kLate;
    if (frame < 0) return;
    std::array<double, kTimes> memory;
    for (int t = 0; t < kTimes; ++t) memory[t] = elementary::exp(-dt_ / time_[t]);
    const double counts = std::sqrt(std::min(1.0, dt_ / 0.4));
    Innovation innovation;
    for (const Person& person : window.people) {
      const int i = frame - person.first;
      if (i < 0 || i >= person.frames() || !person.nodes[i].seen) continue;
      const bool chained = i > 0 && person.nodes[i - 1].seen;
      const std::array<Cue, 3> now = cues(window, person, i, model);
      std::array<Cue, 3> before{};
      if (chained) before = cues(window, person, i - 1, model);
      const double pixel = noise_.pixel / person.nodes[i].box.pixels;
      for (int c = 0; c < 3; ++c) {
        if (!now[c].used || person.nodes[i].box.cut || person.nodes[i].box.hidden) continue;
        const double decided = std::max(0.05, 1.0 - person.nodes[i].leverage[c]);  // share that the fit leaves
        const double white = (c == 1 ? 2.0 : 1.0) * pixel * pixel;
        const bool follows = chained && before[c].used;
        for (int s = 0; s < kShares; ++s) {
          const double variance = share_[s] * share_[s] + white, correlated = share_[s] * share_[s] / variance;
          for (int t = 0; t < kTimes; ++t) {
            const double rho = follows ? correlated * memory[t] : 0.0, e = now[c].q - rho * before[c].q;
            const double rest = variance * (1.0 - rho * rho);
            innovation.variance[s * kTimes + t] = rest;
            innovation.square[s * kTimes + t] = e * e / decided / rest;
          }
        }
        add_costs(innovation, nu_, -0.5 * counts * decided, weight_[c].data());
      }
    }
    for (int c = 0; c < 3; ++c) {
      double top = -1e300, sum = 0.0, share = 0.0, time = 0.0;
      for (const double w : weight_[c]) top = std::max(top, w);
      for (int s = 0; s < kShares; ++s)
        for (int t = 0; t < kTimes; ++t) {
          weight_[c][s * kTimes + t] -= top;
          const double p = elementary::exp(weight_[c][s * kTimes + t]);
          sum += p;
          share += p * elementary::log(share_[s]);
          time += p * elementary::log(time_[t]);
        }
      noise_.share[c] = elementary::exp(share / sum);
      noise_.time[c] = elementary::exp(time / sum);
    }
  }

  const BoxNoise& noise() const { return noise_; }

 private:
  static std::array<Cue, 3> cues(const Window& window, const Person& person, int i, const Model& model) {
    const Node& node = person.nodes[i];
    const BoxState at(node.at[0], node.at[1], person.log_height, person.own_edge,
                      window.frames[person.first + i].at.data(), window.calibration.at.data());
    return box_cues(node.box, at, model.people.noise);
  }

  /// What a cue adds to the cue before, under each σ and τ: its variance, and its square in variances.
  struct Innovation {
    std::array<double, kGrid> variance, square;
  };

  /// Adds to each weight a share of the cost under its σ and τ, by a Student-t law.
  VBBENCH_WIDE_WHOLE static void add_costs(const Innovation& innovation, double nu, double share,
                                           double* __restrict weights) {
    for (int n = 0; n < kGrid; ++n) {
      const double cost = (nu + 1.0) * elementary::log(1.0 + innovation.square[n] / nu);
      weights[n] += share * (cost + elementary::log(innovation.variance[n]));
    }
  }

  double nu_ = 6.0, dt_ = 0.4;
  BoxNoise noise_;
  std::array<double, kShares> share_;
  std::array<double, kTimes> time_;
  std::array<std::array<double, kGrid>, 3> weight_;
};

}  // namespace vbbench
