// Crowds step by step: goals, forces, and the semi-implicit integration v += F·Δt, x += v·Δt.
//
// Scenes run in parallel, or one large crowd at a time with the work of each step divided among threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "basics.hpp"
#include "groups.hpp"
#include "moussaid.hpp"
#include "threads.hpp"
#include "walls.hpp"

namespace vbbench::social_force {

constexpr double kBrakeRadius = 0.2;  ///< m from the goal at which a person brakes, as in pysocialforce
/// Parts into which the people of a large crowd fall; fixed, so that sums do not depend on the number of threads.
constexpr int kBlocks = 16;

/// Where the people, goals and groups of a scene start and end among those of all crowds.
struct Scene {
  std::int64_t first, last, first_goal, last_goal, first_group, last_group;
};

/// Concatenated crowds, and the parameters of their simulation.
struct Crowds {
  std::span<const Scene> scenes;
  std::int64_t people = 0;                ///< N, of all scenes
  const double* states = nullptr;         ///< [4, N] x, y, vx, vy in m and m/s
  const double* speeds = nullptr;         ///< [N] desired, in m/s
  const double* goals = nullptr;          ///< [P, 2] in m, of one person after the other
  const std::int64_t* members = nullptr;  ///< indices, within their scene, of people in groups
  const std::int64_t* groups = nullptr;   ///< where each group starts among the members, and the last ends
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

/// The state of a scene during its simulation.
class Walk {
 public:
  Walk(const Scene& scene, const Crowds& crowds)
      : crowds_(crowds),
        scene_(scene),
        rows_(People::kRows * (scene.last - scene.first)),
        people_(rows_.data(), static_cast<int>(scene.last - scene.first)),
        goals_((scene.last_goal - scene.first_goal) / people_.count),
        current_(people_.count) {
    for (int row = 0; row < 4; ++row)
      std::copy_n(crowds.states + row * crowds.people + scene.first, people_.count, rows_.data() + row * people_.count);
  }

  const People& people() const { return people_; }

  /// Assigns the next goal to people who have arrived, and computes direction and distance of goals.
  void aim() {
    for (int k = 0; k < people_.count; ++k) {
      const double* own = crowds_.goals + 2 * (scene_.first_goal + k * goals_);
      double dx, dy, distance;
      for (;; ++current_[k]) {
        dx = own[2 * current_[k]] - people_.x[k];
        dy = own[2 * current_[k] + 1] - people_.y[k];
        distance = std::sqrt(dx * dx + dy * dy);
        if (distance > crowds_.settings.arrival_radius || current_[k] == goals_ - 1) break;
      }
      people_.distance[k] = distance;
      people_.ahead_x[k] = distance > 0.0 ? dx / distance : 0.0;
      people_.ahead_y[k] = distance > 0.0 ? dy / distance : 0.0;
    }
  }

  /// Adds forces within groups and takes a step, given the `forces` of all else.
  void move(Forces& forces) {
    for (std::int64_t g = scene_.first_group; g < scene_.last_group; ++g)
      add_group_forces(people_, {crowds_.members + crowds_.groups[g], crowds_.members + crowds_.groups[g + 1]},
                       crowds_.settings, forces);
    const double step = crowds_.dt / crowds_.substeps;
    for (int k = 0; k < people_.count; ++k) step_of(k, forces.x[k], forces.y[k], step);
  }

  /// Writes everybody's place into the row [N, 2] of a frame.
  void record(double* places) const {
    for (int k = 0; k < people_.count; ++k) {
      places[2 * (scene_.first + k)] = people_.x[k];
      places[2 * (scene_.first + k) + 1] = people_.y[k];
    }
  }

 private:
  /// The desired force is (speed · e − v)/τ, −v/τ at the goal; the speed is capped; who has arrived stands still.
  void step_of(int k, double fx, double fy, double step) {
    const Settings& s = crowds_.settings;
    const double desired = crowds_.speeds[scene_.first + k], distance = people_.distance[k];
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

  const Crowds& crowds_;
  Scene scene_;
  std::vector<double> rows_;
  People people_;
  std::int64_t goals_;  ///< of each person
  std::vector<std::int64_t> current_;
};

/// Simulates one scene: steps(walk) takes the steps of a frame; `paths` [T, N, 2] in m.
template <class Steps>
void march_frames(const Scene& scene, const Crowds& crowds, int frames, double* paths, const Steps& step) {
  Walk walk(scene, crowds);
  walk.record(paths);
  for (int frame = 1; frame < frames; ++frame) {
    for (int n = 0; n < crowds.substeps; ++n) {
      walk.aim();
      step(walk);
    }
    walk.record(paths + frame * crowds.people * 2);
  }
}

/// Simulates scenes, each on one thread of the team, and fills `paths` [T, N, 2] in m.
inline void march(const Crowds& crowds, int frames, double* paths, Team& team) {
  team.run(static_cast<int>(crowds.scenes.size()), [&](int n) {
    const Scene& scene = crowds.scenes[n];
    const int people = static_cast<int>(scene.last - scene.first);
    Pairs pairs(people);
    Forces forces(people);
    march_frames(scene, crowds, frames, paths, [&](Walk& walk) {
      std::ranges::fill(forces.x, 0.0);
      std::ranges::fill(forces.y, 0.0);
      add_row_forces(walk.people(), 0, 1, crowds.walls, crowds.settings, pairs, forces);
      walk.move(forces);
    });
  });
}

/// Simulates large scenes one after the other: blocks of people are divided among the team, and summed in order.
inline void march_large(const Crowds& crowds, int frames, double* paths, Team& team) {
  for (const Scene& scene : crowds.scenes) {
    const int people = static_cast<int>(scene.last - scene.first);
    std::vector<Forces> forces(kBlocks, Forces(people));
    march_frames(scene, crowds, frames, paths, [&](Walk& walk) {
      team.run(kBlocks, [&](int block) {
        Pairs pairs(people);
        std::ranges::fill(forces[block].x, 0.0);
        std::ranges::fill(forces[block].y, 0.0);
        add_row_forces(walk.people(), block, kBlocks, crowds.walls, crowds.settings, pairs, forces[block]);
      });
      for (int block = 1; block < kBlocks; ++block) {
        for (int k = 0; k < people; ++k) {
          forces[0].x[k] += forces[block].x[k];
          forces[0].y[k] += forces[block].y[k];
        }
      }
      walk.move(forces[0]);
    });
  }
}

}  // namespace vbbench::social_force
