// Occlusion: finds boxes that end at the outline of a nearer person, who hides the feet.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "window.hpp"

namespace vbbench {

/// Marks boxes with hidden feet.
class Occlusion {
 public:
  /// Marks the boxes of the newest frame that end at a nearer outline, with those since the frame before. Returns the
  /// people whose mark has changed.
  static std::vector<int> mark(Window& window, const Model& model) {
    std::vector<Outline> outlines;
    const int newest = static_cast<int>(window.frames.size()) - 1;
    for (int p = 0; p < static_cast<int>(window.people.size()); ++p) {
      Person& person = window.people[p];
      if (person.last() == newest && person.nodes.back().seen)
        outlines.push_back(outline(p, person, window.frames[newest], window.calibration));
    }
    std::vector<int> changed;
    for (const Outline& one : outlines) {
      double row;
      bool hidden = false;
      if (covered(one, outlines, row)) {
        const double pixel = model.people.noise.pixel / one.box->pixels, scale = one.length;
        const double sharp = square(model.people.noise.share[2]) + pixel * pixel;
        const double walk = one.fresh ? kFreshSpread : model.people.walk.sigma / one.range * (one.foot / scale + 1.0);
        const double at_feet = density((one.box->foot - one.foot) / scale, std::sqrt(sharp + walk * walk));
        const double at_edge = density((one.box->foot - row) / scale, std::sqrt(sharp + kOutline * kOutline));
        hidden = at_edge > at_feet;
      }
      if (one.box->hidden != hidden) changed.push_back(one.person);
      one.box->hidden = hidden;
    }
    for (int p = 0; p < static_cast<int>(window.people.size()); ++p) {
      Person& person = window.people[p];
      if (person.last() != newest) continue;
      const int last = person.frames() - 1;
      for (Between& shown : person.between) {
        if (shown.node != last) continue;
        const bool hidden = person.nodes[last].box.hidden || person.nodes[last - 1].box.hidden;
        if (shown.box.hidden != hidden) changed.push_back(p);
        shown.box.hidden = hidden;
      }
    }
    return changed;
  }

 private:
  struct Outline {
    Box* box;
    int person;                 ///< index of who has it
    double azimuth, width;      ///< rad, the width of one height
    double foot, head, length;  ///< slopes that the person's state predicts
    double range;               ///< m
    bool fresh;                 ///< whether this box is the first
  };

  /// The outline of a person's newest box where the state expects the person.
  static Outline outline(int p, Person& person, const Frame& camera, const Calibration& calibration) {
    Box& box = person.nodes.back().box;
    const std::array<double, 2>& at = person.nodes.back().at;
    const auto& global = calibration.at;
    const double r = elementary::hypot(at[0] - camera.at[0], at[1] - camera.at[1]);
    const double rho = std::max(r - global[kEdge], 0.3), length = elementary::exp(person.log_height) / rho;
    const double pitch = global[kPitch] + camera.at[kPose], roll = global[kRoll] + camera.at[kPose + 1];
    const double lift = -pitch * box.cos + roll * box.sin;
    const double foot = global[kMount] / rho - lift, width = box.width * length / std::max(box.length, 1e-6);
    return {&box, p, box.azimuth, width, foot, foot - length, length, r, person.frames() == 1};
  }

  static constexpr double kBody = 0.12, kHead = 0.05, kShoulders = 0.8;  ///< outline, in heights of the person
  static constexpr double kCore = 0.08;        ///< half the width that must be covered, in heights
  static constexpr double kOutline = 0.03;     ///< by which an outline's border is uncertain, in heights
  static constexpr double kFreshSpread = 0.3;  ///< of the feet of a person without a path, in heights
  static constexpr double kTail = 1e-3;        ///< density of outliers
  static constexpr int kColumns = 7;

  static double density(double e, double sigma) {
    return elementary::exp(-0.5 * e * e / (sigma * sigma)) / sigma + kTail;
  }

  /// Whether nearer outlines cover the feet of `one`; `row` is then its lowest visible row.
  static bool covered(const Outline& one, const std::vector<Outline>& outlines, double& row) {
    row = -1e9;
    for (int i = 0; i < kColumns; ++i) {
      const double column = one.azimuth + (2.0 * i / (kColumns - 1) - 1.0) * kCore * one.width;
      double skyline = 1e9;
      for (const Outline& other : outlines) {
        if (other.box == one.box || other.foot <= one.foot || other.range >= one.range) continue;
        const double aside = std::abs(wrap(column - other.azimuth));
        if (aside < kHead * other.width) {
          skyline = std::min(skyline, other.head);
        } else if (aside < kBody * other.width) {
          skyline = std::min(skyline, other.foot - kShoulders * other.length);
        }
      }
      if (skyline >= one.foot) return false;
      row = std::max(row, skyline);
    }
    return row > one.head;
  }
};

}  // namespace vbbench
