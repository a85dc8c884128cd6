// The state: frames with the camera's pose and sway, people with their paths, and the calibration that all share.
#pragma once

#include <array>
#include <deque>
#include <vector>

#include "constants.hpp"
#include "factors/box.hpp"
#include "factors/ego.hpp"
#include "linear.hpp"

namespace vbbench {

constexpr int kPose = 3, kFrame = 5;  ///< unknowns of a pose, and of a frame with its sway
constexpr int kHeld = 2;              ///< number of frames at the beginning of a full window whose poses are held fixed
constexpr double kBetween = 0.05;     ///< m/s by which people and camera leave straight lines between key frames
constexpr double kBetweenTurn = 0.3;  ///< rad/s by which the yaw does
constexpr double kGiven = 1e-3;       ///< m, standard deviation of a given place
constexpr double kGivenPose = 1e-5;   ///< m and rad, of a given pose

/// Motion of the camera since the frame before, as its odometry measured it, with its information.
struct Motion {
  bool measured = false;
  std::array<double, 3> moved{};                ///< forward, left in m, turn in rad
  std::array<std::array<double, 3>, 3> root{};  ///< lower triangular: whitens the error
};

/// A frame of the window.
struct Frame {
  std::array<double, kFrame> at{};  ///< x, y in m, yaw in rad; pitch and roll in rad from the recording's means
  bool given = false;               ///< whether the pose is
  std::array<double, 3> given_pose{};
  double between = 0.0;  ///< share of the time since the frame before at which a pose was given; 0: none
  std::array<double, 3> between_pose{};
  bool anchored() const { return given || between > 0.0; }
  Motion motion;
  std::array<double, 3> information{};  ///< 1/m², 1/m², 1/rad²: of boxes about the camera's innovation into the frame
  int left = 0;                         ///< in the window's first frame: number of `past` poses
  std::array<std::array<double, 3>, kSpan - 2> past{};  ///< poses of frames that have left the window, the newest first
};

/// A person in one frame of the window.
struct Node {
  std::array<double, 2> at{};
  int column = -1;  ///< column of the solver's arrays that shows the person in this frame; −1: none
  bool seen = false, given = false;
  std::array<bool, 3> box_absorbed{};
  bool walk_absorbed = false;  ///< whether the marginal prior holds its factor
  Box box;
  std::array<double, 3> leverage{};  ///< leverage of each cue of the box, w gᵀ H⁻¹ g in [0, 1]
  double growth = 0.0;               ///< derivative of the walk's cost into the node by the log scale of the path
  std::array<double, 2> given_at{};
  double given_std = kGiven;  ///< m
};

/// What was measured of a person between two key frames: the state is interpolated between a node and the node before.
struct Between {
  int node = 0;
  double share = 0.0;  ///< of the time from the node before to the node
  bool seen = false, given = false;
  Box box;
  std::array<double, 2> given_at{};
};

/// Unknowns of a person's marginal prior: the first `kReach` places, log height, globals.
constexpr int kPriorPlaces = 2 * kReach, kPrior = kPriorPlaces + 1 + kGlobals;

/// Information about a person from frames that have left the window: the cost ½ (x − x₀)ᵀ Λ (x − x₀) − ηᵀ(x − x₀).
struct MarginalPrior {
  bool any = false;
  std::array<std::array<double, kPrior>, kPrior> information{};
  std::array<double, kPrior> vector{}, about{};
};

/// A person of the window.
struct Person {
  int column = -1;  ///< column of the newest box; −1 once that column's boxes are of another person
  int first = 0;    ///< frame of nodes[0] in the window

  std::vector<Node> nodes;
  std::vector<Between> between;  ///< in the order of time
  double log_height = 0.54;
  double height_mean = 0.54, height_std = 0.055;
  double variance = 1.0;              ///< of the innovations, in units of σ²
  double squares = 0.0, count = 0.0;  ///< of the innovations so far
  MarginalPrior prior;

  int frames() const { return static_cast<int>(nodes.size()); }
  int last() const { return first + frames() - 1; }

  /// Moves path and log height by a multiple of a step.
  void move(const std::vector<double>& step, double by = 1.0) {
    const int path = 2 * frames();
    for (int i = 0; i < path; ++i) nodes[i / 2].at[i % 2] += by * step[i];
    log_height += by * step[path];
  }

  /// What was given last between the newest two key frames, if anything was.
  const Between* given_between() const {
    for (auto one = between.rbegin(); one != between.rend() && one->node == frames() - 1; ++one)
      if (one->given) return &*one;
    return nullptr;
  }

  template <class Archive>
  void archive(Archive& a) {
    a(column), a(first), a(nodes), a(between), a(log_height), a(height_mean), a(height_std), a(variance);
    a(squares), a(count);
    a(prior);
  }
};

/// The calibration that all frames share, with its Gaussian prior.
struct Calibration {
  std::array<double, kGlobals> at{};
  std::array<bool, kGlobals> free{};
  Matrix information{kGlobals, kGlobals};  ///< of the prior
  std::array<double, kGlobals> vector{}, about{};
  std::array<double, 2> sway_std{};  ///< 0: the camera does not sway
};

}  // namespace vbbench
