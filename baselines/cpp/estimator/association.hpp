// Data association: whether the newest box of a track is of the same person as those before it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "window.hpp"

namespace vbbench {

/// Errors of a box's cues, whitened by its noise, with their covariances if it is of the expected person, and if it is
/// of another person nearby.
struct Innovation {
  static constexpr double kAside = 0.4, kFarther = 0.3;  ///< σ of another's place, in box heights and of the range
  int cues = 0;
  std::array<double, 3> e{};
  double same[3][3] = {}, other[3][3] = {};
};

/// Finds identity switches: compares the density of a box under its person's prediction with that of another person
/// nearby.
class Association {
 public:
  void start() {
    switches_ = 1.0;
    kept_ = 100.0;
  }

  template <class Archive>
  void archive(Archive& a) {
    a(switches_), a(kept_);
  }

  /// Indices of the people of the window whose newest boxes are more probably of another person.
  std::vector<int> switched(const Window& window, const Model& model) {
    std::vector<int> found;
    int again = 0;
    const int newest = static_cast<int>(window.frames.size()) - 1;
    for (int p = 0; p < static_cast<int>(window.people.size()); ++p) {
      const Person& person = window.people[p];
      if (person.last() != newest || person.frames() < 2) continue;
      const Node& node = person.nodes.back();
      if (!node.seen || node.given || node.box.cut) continue;
      ++again;
      Innovation one;
      if (surprise(window, person, model) > kDoubt && innovate(window, person, model, one) && is_another(one, model))
        found.push_back(p);
    }
    count(found, again);
    return found;
  }

  /// Whether a box is more probably of another person.
  bool is_another(const Innovation& one, const Model& model) const {
    const double rate = switches_ / (switches_ + kept_), nu = model.people.noise.nu;
    const double better = log_density(one, one.same, nu) - log_density(one, one.other, nu);
    return rate > (1.0 - rate) * elementary::exp(std::min(better, 300.0));
  }

  /// Counts the switches `found` among those who are seen `again`. None remain if they are half of these: then the
  /// camera's motion is the likelier cause.
  void count(std::vector<int>& found, int again) {
    if (2 * static_cast<int>(found.size()) >= again) found.clear();
    switches_ += static_cast<double>(found.size());
    kept_ += static_cast<double>(again);
  }

 private:
  static constexpr double kDoubt = 10.0;  ///< squared σ from which a box is examined
  static constexpr int kRounds = 4;
  static constexpr double kStill = 0.01;  ///< m: a shorter step is the last one

  /// Sum of squares of a person's newest whitened residuals.
  static double surprise(const Window& window, const Person& person, const Model& model) {
    const int last = person.frames() - 1;
    double sum = 0.0;
    person_rows(person, window.frames, window.calibration, model.people, RowVisitor([&](const Row& row) {
                  if (row.cue >= 0) sum += row.e * row.e;
                  if (row.walk) sum += row.e * row.e / (model.people.walk.sigma * model.people.walk.sigma);
                }),
                {last, last});
    return sum;
  }

  /// Computes the innovation of a person's newest box, of which the path before predicts the place; false if the system
  /// is not positive definite.
  bool innovate(const Window& window, const Person& person, const Model& model, Innovation& one) {
    const int last = person.frames() - 1, newest = static_cast<int>(window.frames.size()) - 1;
    Layout alone;  // camera and calibration are held
    alone.frames = alone.held = newest + 1;
    Reduced nothing;
    nothing.reset(kGlobals);
    Person expected = person;
    expected.nodes.back().seen = false;
    std::erase_if(expected.between, [&](const Between& between) { return between.node == last && !between.given; });
    std::vector<double> step;
    const std::vector<double> none(kGlobals, 0.0);
    for (int round = 0; round < kRounds; ++round) {
      elimination_.reset(expected, alone, 0.0);
      const auto add = [&](const Row& row) { elimination_.add(row, nothing); };
      person_rows(expected, window.frames, window.calibration, model.people, RowVisitor(add));
      own_rows(expected, model.people, add);
      elimination_.add_prior(expected, window.calibration, nothing);
      if (!elimination_.eliminate(nothing)) return false;
      elimination_.back_substitute(none, step);
      double moved = 0.0;
      for (int i = 0; i <= last; ++i)
        for (int axis = 0; axis < 2; ++axis) {
          expected.nodes[i].at[axis] += step[2 * i + axis];
          moved = std::max(moved, std::abs(step[2 * i + axis]));
        }
      expected.log_height += step[elimination_.local - 2];
      expected.own_edge += step[elimination_.local - 1];
      if (moved < kStill) break;
    }
    expected.nodes.back().seen = true;
    const Frame& camera = window.frames.back();
    const Node& node = expected.nodes.back();
    const double dx = node.at[0] - camera.at[0], dy = node.at[1] - camera.at[1], r = elementary::hypot(dx, dy) + 1e-9;
    const double along = Innovation::kFarther * r, aside = Innovation::kAside * node.box.width * r;
    int cue[3] = {};
    double by_place[3][2] = {}, by_height[3] = {};
    std::array<std::vector<double>, 3> spread;
    person_rows(expected, window.frames, window.calibration, model.people, RowVisitor([&](const Row& row) {
                  if (row.cue < 0) return;
                  cue[one.cues] = row.cue;
                  one.e[one.cues] = row.e;
                  std::vector<double>& g = spread[one.cues];
                  g.assign(elimination_.local, 0.0);
                  row.each(0, [&](const Variable& v, double by) {
                    const int i = elimination_.index_of(v);
                    if (i >= 0) g[i] += by;
                  });
                  for (int a = 0; a < 2; ++a) by_place[one.cues][a] = row.by[kSlotPlace + a];
                  by_height[one.cues] = row.by[kSlotHeight];
                  elimination_.whiten(g.data());
                  ++one.cues;
                }),
                {last, last});
    for (int a = 0; a < one.cues; ++a)
      for (int b = 0; b < one.cues; ++b) {
        one.same[a][b] = one.other[a][b] = a == b ? model.people.noise.excess[cue[a]] : 0.0;
        for (int i = 0; i < elimination_.local; ++i) one.same[a][b] += spread[a][i] * spread[b][i];
        const double far_a = along * (by_place[a][0] * dx + by_place[a][1] * dy) / r;
        const double far_b = along * (by_place[b][0] * dx + by_place[b][1] * dy) / r;
        const double side_a = aside * (by_place[a][1] * dx - by_place[a][0] * dy) / r;
        const double side_b = aside * (by_place[b][1] * dx - by_place[b][0] * dy) / r;
        one.other[a][b] += far_a * far_b + side_a * side_b + square(person.height_std) * by_height[a] * by_height[b];
      }
    return true;
  }

  /// Log density of a Student-t law with the scale matrix s, up to a constant.
  static double log_density(const Innovation& one, const double (&s)[3][3], double nu) {
    double l[3][3] = {}, w[3], away = 0.0, volume = 0.0;
    for (int i = 0; i < one.cues; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = s[i][j];
        for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
        l[i][j] = i == j ? std::sqrt(std::max(sum, 1e-12)) : sum / l[j][j];
      }
      double rest = one.e[i];
      for (int k = 0; k < i; ++k) rest -= l[i][k] * w[k];
      w[i] = rest / l[i][i];
      away += w[i] * w[i];
      volume += elementary::log(l[i][i]);
    }
    return -volume - 0.5 * (nu + one.cues) * elementary::log1p(away / nu);
  }

  double switches_ = 1.0, kept_ = 100.0;
  Elimination elimination_;
};

}  // namespace vbbench
