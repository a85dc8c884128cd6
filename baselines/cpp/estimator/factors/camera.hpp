// Factors of the camera alone: motion modes, odometry, sway, given poses, and the prior of the calibration.
#pragma once

#include <functional>
#include <vector>

#include "person.hpp"

namespace vbbench {

/// Another hypothesis to minimise from: it excludes the modes `out` from the newest `steps`.
struct Trial {
  int steps = 0;
  std::array<bool, kModes> out{};
};

/// −ln of the density of every step of the window under every mode; steps that odometry measured have none.
/// In the `trial.steps` newest steps the modes of `trial.out` are not probable.
void mode_costs(const std::vector<Frame>& frames, const EgoMotion& motion, const Trial& trial,
                std::vector<Modes>& costs);

/// Learns the roughness of the camera's motion by expectation maximisation, with a prior of weight `own`.
void learn_roughness(const std::vector<Frame>& frames, const std::vector<Modes>& posterior, double own,
                     EgoMotion& motion);

/// Visits the rows of the camera, without those of people. `posterior[t − 1]` holds the modes of the step into t.
void camera_rows(const std::vector<Frame>& frames, const Calibration& calibration, const EgoMotion& motion,
                 const std::vector<Modes>& posterior, double sway_memory, int held,
                 const std::function<void(const CameraRow&)>& visit);

}  // namespace vbbench
