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

  void start(const BoxNoise& first, double spread, double dt, double key_frame) {
    nu_ = first.nu;
    dt_ = dt;
    key_frame_ = key_frame;
    noise_ = first;
    for (int s = 0; s < kShares; ++s) share_[s] = 0.002 * elementary::exp(s * (elementary::log(80.0) / (kShares - 1)));
    for (int t = 0; t < kTimes; ++t) {
      time_[t] = 0.05 * elementary::exp(t * (elementary::log(400.0) / (kTimes - 1)));
      memory_[t] = elementary::exp(-dt_ / time_[t]);
      rest_[t] = rest(time_[t]);
    }
    for (int c = 0; c < 3; ++c)
      for (int s = 0; s < kShares; ++s)
        for (int t = 0; t < kTimes; ++t) {
          const double off = elementary::log(share_[s] / first.share[c]) / spread;
          const double later = elementary::log(time_[t] / first.time[c]) / 2.0;
          weight_[c][s * kTimes + t] = -0.5 * (off * off + later * later);
        }
    for (int c = 0; c < 3; ++c) summarise(c);
    noise_.share = first.share;
    noise_.time = first.time;
  }

  /// Updates the posterior with the boxes of the frame `kLate` before the newest.
  void learn(const Window& window, const Model& model) {
    const int frame = static_cast<int>(window.frames.size()) - 1 - kLate;
    if (frame < 0) return;
    for (const Person& person : window.people) {
      const int i = frame - person.first;
      if (i < 0 || i >= person.frames() || !person.nodes[i].seen) continue;
      const Node& node = person.nodes[i];
      std::array<Cue, 3> before{};
      double time = -1.0;  // of the box before, in key frames
      if (i > 0 && person.nodes[i - 1].seen) {
        before = cues(window, person, i - 1, 1.0, person.nodes[i - 1].box, model);
        time = 0.0;
      }
      const auto next = [&](double share, const Box& box) {
        const std::array<Cue, 3> now = cues(window, person, i, share, box, model);
        const bool adjacent = time >= 0.0 && (share - time) * model.people.stride < 1.5;
        add(now, adjacent ? before : std::array<Cue, 3>{}, box, node.leverage);
        before = now;
        time = share;
      };
      for (const Between& one : person.between)
        if (one.seen && one.node == i) next(one.share, one.box);
      next(1.0, node.box);
    }
    for (int c = 0; c < 3; ++c) summarise(c);
  }

  const BoxNoise& noise() const { return noise_; }

 private:
  /// Share of the variance that an innovation in a key frame has, by the correlation time.
  double rest(double time) const {
    const double rho = elementary::exp(-key_frame_ / time);
    return 1.0 - rho * rho;
  }

  /// Computes means of ln σ and ln τ of a cue, and the excess of the expected variance of innovations in a key frame.
  void summarise(int c) {
    double top = -1e300, sum = 0.0, share = 0.0, time = 0.0, variance = 0.0;
    for (const double w : weight_[c]) top = std::max(top, w);
    for (int s = 0; s < kShares; ++s)
      for (int t = 0; t < kTimes; ++t) {
        weight_[c][s * kTimes + t] -= top;
        const double p = elementary::exp(weight_[c][s * kTimes + t]);
        sum += p;
        share += p * elementary::log(share_[s]);
        time += p * elementary::log(time_[t]);
        variance += p * (share_[s] * share_[s] * rest_[t]);
      }
    noise_.share[c] = elementary::exp(share / sum);
    noise_.time[c] = elementary::exp(time / sum);
    noise_.excess[c] = variance / sum / (noise_.share[c] * noise_.share[c] * rest(noise_.time[c]));
  }

  /// Weighs the grid by the cues of a box, given those of the box before, if that was in the frame before.
  void add(const std::array<Cue, 3>& now, const std::array<Cue, 3>& before, const Box& box,
           const std::array<double, 3>& leverage) {
    const double counts = std::sqrt(std::min(1.0, dt_ / 0.4)), pixel = noise_.pixel / box.pixels;
    Innovation innovation;
    for (int c = 0; c < 3; ++c) {
      if (!now[c].used || box.cut || box.hidden) continue;
      const double decided = std::max(0.05, 1.0 - leverage[c]);  // share that the fit leaves
      const double white = (c == 1 ? 2.0 : 1.0) * pixel * pixel;
      for (int s = 0; s < kShares; ++s) {
        const double variance = share_[s] * share_[s] + white, correlated = share_[s] * share_[s] / variance;
        for (int t = 0; t < kTimes; ++t) {
          const double rho = before[c].used ? correlated * memory_[t] : 0.0, e = now[c].q - rho * before[c].q;
          const double rest = variance * (1.0 - rho * rho);
          innovation.variance[s * kTimes + t] = rest;
          innovation.square[s * kTimes + t] = e * e / decided / rest;
        }
      }
      add_costs(innovation, nu_, -0.5 * counts * decided, weight_[c].data());
    }
  }

  static std::array<Cue, 3> cues(const Window& window, const Person& person, int i, double share, const Box& box,
                                 const Model& model) {
    const int older = std::max(0, i - 1);
    const auto &now = person.nodes[i].at, &before = person.nodes[older].at;
    const auto &next = window.frames[person.first + i].at, &last = window.frames[person.first + older].at;
    std::array<double, kFrame> camera;
    for (int k = 0; k < kFrame; ++k) camera[k] = share == 1.0 ? next[k] : last[k] + share * (next[k] - last[k]);
    const double rest = 1.0 - share;
    const BoxState at(now[0] * share + rest * before[0], now[1] * share + rest * before[1], person.log_height,
                      camera.data(), window.calibration.at.data());
    return box_cues(box, at, model.people.noise);
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

  double nu_ = 6.0, dt_ = 0.4, key_frame_ = 0.4;  ///< dt_, key_frame_: s from one frame, and key frame, to the next
  BoxNoise noise_;
  std::array<double, kShares> share_;
  std::array<double, kTimes> time_, memory_, rest_;  ///< s; correlation of boxes one frame apart; `rest` of the time
  std::array<std::array<double, kGrid>, 3> weight_;
};

}  // namespace vbbench
