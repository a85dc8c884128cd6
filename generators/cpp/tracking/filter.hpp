// The tracker's Kalman filters: each of a box's four coordinates has its own, on value and speed.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "boxes.hpp"

namespace vbbench::tracking {

/// Value in px and speed in px/s of centre column, centre row, width and height.
using Mean = std::array<std::array<double, 2>, 4>;
/// Their covariances (P_00, P_01, P_11).
using Spread = std::array<std::array<double, 3>, 4>;

constexpr int kHeight = 3;  ///< index of the height among a box's coordinates

/// Predicts states `dt` seconds ahead; `wander` and `acceleration` are in heights.
inline void move_on(std::int64_t count, Mean* mean, Spread* spread, double dt, double wander, double acceleration) {
  for (std::int64_t n = 0; n < count; ++n) {
    const double height = std::max(mean[n][kHeight][0], 1.0);
    const double place = (wander * height) * (wander * height) * dt;
    const double pace = (acceleration * height) * (acceleration * height) * dt;
    for (int c = 0; c < 4; ++c) {
      const auto [p, q, s] = spread[n][c];
      mean[n][c][0] += dt * mean[n][c][1];
      spread[n][c] = {p + dt * (2.0 * q + dt * s) + place, q + dt * s, s + pace};
    }
  }
}

/// Updates states with boxes; `measurement` is the standard deviation of a coordinate in heights.
inline void take_in(std::int64_t count, Mean* mean, Spread* spread, const Box* boxes, double measurement,
                    double period) {
  for (std::int64_t n = 0; n < count; ++n) {
    const double std = measurement * std::max(mean[n][kHeight][0], 1.0), noise = std * std;
    const std::array<double, 4> seen{boxes[n].u, boxes[n].v, boxes[n].width, boxes[n].height};
    for (int c = 0; c < 4; ++c) {
      const auto [p, q, s] = spread[n][c];
      const double total = p + noise, apart = seen[c] - mean[n][c][0];
      const double surprise = c == 0 ? shorter(apart, period) : apart;
      mean[n][c][0] += p / total * surprise;
      mean[n][c][1] += q / total * surprise;
      spread[n][c] = {p - p * p / total, q - p * q / total, s - q * q / total};
    }
  }
}

}  // namespace vbbench::tracking
