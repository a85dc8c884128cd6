// A crowd step by step: goals, forces, and the semi-implicit integration v += F·Δt, x += v·Δt.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "basics.hpp"
#include "moussaid.hpp"
#include "walls.hpp"

namespace vbbench::social_force {

constexpr double kBrakeRadius = 0.2;  ///< m from the goal at which a person brakes, as in pysocialforce
/// From so many people on, forces are summed in blocks of people, and the blocks in order: this fixes their last bits.
constexpr int kLarge = 256, kBlocks = 16;

/// A crowd of K people, and the parameters of its simulation.
struct Crowd {
  int people = 0;
  std::int64_t goals_each = 0;     ///< G
  const double* states = nullptr;  ///< [4, K] x, y, vx, vy in m and m/s
  const double* speeds = nullptr;  ///< [K] desired, in m/s
  const double* goals = nullptr;   ///< [K, G, 2] in m
  std::span<const Wall> walls;
  Settings settings;
  double dt = 0.0;  ///< seconds per frame
  int substeps = 1;
};

/// Adds repulsion and walls for the people first, first + stride, … in m/s².
inline void add_row_forces(const People& people, int first, int stride, std::span<const Wall> walls, const Settings& s,
                           Pairs& pairs, Forces& forces) {
  add_moussaid(people, first, stride, s, pairs, forces);
  for (int k = first; k < people.count; k += stride) {
    for (const Wall& wall : walls) {
      const auto [fx, fy] = sampled_wall(people.x[k], people.y[k], wall, s);
      forces.x[k] += fx;
      forces.y[k] += fy;
    }
  }
}

/// The state of a crowd during its simulation.
class Walk {
 public:
  explicit Walk(const Crowd& crowd)
      : crowd_(crowd),
        rows_(People::kRows * crowd.people),
        people_(rows_.data(), crowd.people),
        current_(crowd.people) {
    std::copy_n(crowd.states, 4 * crowd.people, rows_.data());
  }

  const People& people() const { return people_; }

  /// Assigns the next goal to people who have arrived, and computes direction and distance of goals.
  void aim() {
    for (int k = 0; k < people_.count; ++k) {
      const double* own = crowd_.goals + 2 * k * crowd_.goals_each;
      double dx, dy, distance;
      for (;; ++current_[k]) {
        dx = own[2 * current_[k]] - people_.x[k];
        dy = own[2 * current_[k] + 1] - people_.y[k];
        distance = std::sqrt(dx * dx + dy * dy);
        if (distance > crowd_.settings.arrival_radius || current_[k] == crowd_.goals_each - 1) break;
      }
      people_.distance[k] = distance;
      people_.ahead_x[k] = distance > 0.0 ? dx / distance : 0.0;
      people_.ahead_y[k] = distance > 0.0 ? dy / distance : 0.0;
    }
  }

  /// Takes a step, given the `forces` of all but the goals.
  void move(const Forces& forces) {
    const double step = crowd_.dt / crowd_.substeps;
    for (int k = 0; k < people_.count; ++k) step_of(k, forces.x[k], forces.y[k], step);
  }

  /// Writes everybody's place into the row [K, 2] of a frame.
  void record(double* places) const {
    for (int k = 0; k < people_.count; ++k) {
      places[2 * k] = people_.x[k];
      places[2 * k + 1] = people_.y[k];
    }
  }

 private:
  /// The desired force is (speed · e − v)/τ, −v/τ at the goal; the speed is capped; who has arrived stands still.
  void step_of(int k, double fx, double fy, double step) {
    const Settings& s = crowd_.settings;
    const double desired = crowd_.speeds[k], distance = people_.distance[k];
    const double wish = distance > kBrakeRadius ? desired : 0.0;
    const double ax = (wish * people_.ahead_x[k] - people_.vx[k]) / s.relaxation_time + fx;
    const double ay = (wish * people_.ahead_y[k] - people_.vy[k]) / s.relaxation_time + fy;
    const double vx = people_.vx[k] + step * ax, vy = people_.vy[k] + step * ay;
    const double speed = std::sqrt(vx * vx + vy * vy), top = desired * s.top_speed;
    double share = speed > 0.0 ? std::min(1.0, top / speed) : 0.0;
    share = distance < s.stop_radius ? 0.0 : share;
    people_.vx[k] = share * vx;
    people_.vy[k] = share * vy;
    people_.x[k] += people_.vx[k] * step;
    people_.y[k] += people_.vy[k] * step;
  }

  const Crowd& crowd_;
  std::vector<double> rows_;
  People people_;
  std::vector<std::int64_t> current_;
};

/// Simulates a crowd and fills `paths` [T, K, 2] in m.
inline void march(const Crowd& crowd, int frames, double* paths) {
  const int people = crowd.people, blocks = people < kLarge ? 1 : kBlocks;
  Walk walk(crowd);
  Pairs pairs(people);
  std::vector<Forces> forces(blocks, Forces(people));
  walk.record(paths);
  for (int n = 0; n < (frames - 1) * crowd.substeps; ++n) {
    walk.aim();
    for (int block = 0; block < blocks; ++block) {
      std::ranges::fill(forces[block].x, 0.0);
      std::ranges::fill(forces[block].y, 0.0);
      add_row_forces(walk.people(), block, blocks, crowd.walls, crowd.settings, pairs, forces[block]);
      for (int k = 0; block > 0 && k < people; ++k) {
        forces[0].x[k] += forces[block].x[k];
        forces[0].y[k] += forces[block].y[k];
      }
    }
    walk.move(forces[0]);
    if ((n + 1) % crowd.substeps == 0)
      walk.record(paths + static_cast<std::int64_t>((n + 1) / crowd.substeps) * people * 2);
  }
}

}  // namespace vbbench::social_force
