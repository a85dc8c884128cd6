// The numbers of the estimator's densities in one table, with unit and source.
#pragma once

#include <array>
#include <cmath>

#include "dual.hpp"

namespace vbbench {

/// Sources: [L] literature, [F] a fit to true trajectories, [S] a sweep over all families of benchmarks/families.
struct Constants {
  // Boxes.
  std::array<double, 3> noise_share{0.04, 0.02, 0.04};  ///< σ of column, log height, foot, in box heights; learned [S]
  std::array<double, 3> noise_time{0.4, 3.0, 3.0};      ///< s, time over which these errors are correlated; learned [S]
  double noise_spread = 1.0;                            ///< standard deviation of the prior of ln σ [S]
  double noise_nu = 10.0;                               ///< degrees of freedom of the errors [S]
  double pixel = 0.1;                                   ///< px, least σ of a box's border [S]
  double edge = 0.22, edge_std = 0.04;                  ///< m, near edge of the source of boxes [S]
  double height_std = 0.055;                            ///< least σ of the log height: posture, hats, shoes [L]
  // Calibration.
  double tilt_std = 0.03;                    ///< rad, pitch and roll where no deviation is given [S]
  double mount_std = 0.15;                   ///< m, height over the ground where none is given [S]
  double offset_std = 0.005;                 ///< rad, offset of the columns [S]
  double sway_std = 0.008, sway_time = 1.1;  ///< rad and s, AR(1) of pitch and roll about their means [S]
  // People.
  double acceleration = 0.03;                 ///< m²/s³, power density of acceleration [F]
  double gait_speed = 0.15, gait_time = 0.1;  ///< m/s and s, velocity noise within a stride [F]
  double walk_nu = 5.0;                       ///< degrees of freedom of the innovations [F]
  double walk_people = 20.0;                  ///< weight in innovations of the prior of the crowd's variance [F]
  double walk_own = 8.0;  ///< of the crowd's variance as prior of a person's, of the camera's scale at .4 s [S]
  double pace = 0.15;     ///< 1/s, weight of the prior of speed [S]
  double walking = 1.3, walking_std = 0.35;  ///< m/s, speed of people who walk [L]
  double walking_mean_std = 0.1;             ///< m/s, standard deviation of a crowd's mean about it [S]
  double axis_std = 0.35, axis_share = 0.25, axis_weight = 5.0;  ///< rad; share of directions about an axis [S]
  double standing = 0.06, standing_weight = 0.25;  ///< m/s, Cauchy scale of people who stand, and its weight [F]
  double running = 2.0, running_std = 0.5;         ///< m/s, speed up to which people walk, and σ beyond it [L]
  // Camera.
  std::array<double, 3> drive{0.7, 0.05, 0.04};  ///< m/s^1.5 forward and sideways, rad/s^1.5: changes of velocity [S]
  double curve = 0.16, drive_nu = 4.0;           ///< rad/s^1.5, changes of the turn in curves; degrees of freedom [S]
  std::array<double, 2> slip{0.12, 0.03};        ///< m/s sideways and rad/s, Cauchy scales of a vehicle [S]
  double drive_speed = 4.0;                      ///< m/s, of a vehicle [L]
  std::array<double, 2> stand{0.01, 0.0015};     ///< m and rad, a step of a camera that stands [S]
  double stay = 30.0;                            ///< s, mean time in a motion mode [S]
  std::array<double, 2> head_lag{0.8, 0.1};      ///< s, a head follows the path by one of these [L]
  std::array<double, 3> head_scale{0.02, 0.1, 0.03};  ///< rad, Cauchy scales: lagging, loose, wandering (at .4 s) [F]
};

}  // namespace vbbench
