// Data association: whether the newest box of a track is of the same person as those before it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "elementary.hpp"
#include "window.hpp"

namespace vbbench {

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

  /// Indices of the people of the window whose newest boxes are more probably of another person. None if they are half
  /// of those who are seen again: then the camera's motion is the likelier cause.
  std::vector<int> switched(const Window& window, const Model& model) {
    std::vector<int> found;
    int again = 0;
    const int newest = static_cast<int>(window.frames.size()) - 1;
    for (int p = 0; p < static_cast<int>(window.people.size()); ++p) {
      const Person& person = window.people[p];
      if (person.last() != newest || person.frames() < 2) continue;
      const Node& node = person.nodes.back();
      if (!node.seen || node.given || person.given_between() || node.box.cut) continue;
      ++again;
      const double chance = surprise(window, person, model) > kDoubt ? another(window, person, model) : 0.0;
      kept_ += 1.0;
      if (chance > 0.5) found.push_back(p);
    }
    if (2 * static_cast<int>(found.size()) >= again) found.clear();
    switches_ += static_cast<double>(found.size());
    return found;
  }

 private:
  static constexpr double kDoubt = 10.0;                 ///< squared σ from which a box is examined
  static constexpr double kAside = 0.4, kFarther = 0.3;  ///< σ of another's place, in box heights and of the range
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

  double another(const Window& window, const Person& person, const Model& model) {
    const int last = person.frames() - 1, newest = static_cast<int>(window.frames.size()) - 1;
    Layout alone;  // camera and calibration are held
    alone.frames = alone.held = newest + 1;
    Reduced nothing;
    nothing.reset(kGlobals);
    Person expected = person;
    expected.nodes.back().seen = false;
    std::erase_if(expected.between, [&](const Between& one) { return one.node == last; });
    std::vector<double> step;
    const std::vector<double> none(kGlobals, 0.0);
    for (int round = 0; round < kRounds; ++round) {
      elimination_.reset(expected, alone, 0.0);
      const auto add = [&](const Row& row) { elimination_.add(row, nothing); };
      person_rows(expected, window.frames, window.calibration, model.people, RowVisitor(add));
      own_rows(expected, model.people, add);
      elimination_.add_prior(expected, window.calibration, nothing);
      if (!elimination_.eliminate(nothing)) return 0.0;
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
    const double along = kFarther * r, aside = kAside * node.box.width * r;
    int cues = 0;
    double e[3], same[3][3] = {}, other[3][3] = {}, by_place[3][2] = {}, by_height[3] = {};
    std::array<std::vector<double>, 3> spread;
    person_rows(expected, window.frames, window.calibration, model.people, RowVisitor([&](const Row& row) {
                  if (row.cue < 0) return;
                  e[cues] = row.e;
                  std::vector<double>& g = spread[cues];
                  g.assign(elimination_.local, 0.0);
                  row.each(0, [&](const Variable& v, double by) {
                    const int i = elimination_.index_of(v);
                    if (i >= 0) g[i] += by;
                  });
                  for (int a = 0; a < 2; ++a) by_place[cues][a] = row.by[kSlotPlace + a];
                  by_height[cues] = row.by[kSlotHeight];
                  elimination_.whiten(g.data());
                  ++cues;
                }),
                {last, last});
    for (int a = 0; a < cues; ++a)
      for (int b = 0; b < cues; ++b) {
        same[a][b] = other[a][b] = a == b ? 1.0 : 0.0;
        for (int i = 0; i < elimination_.local; ++i) same[a][b] += spread[a][i] * spread[b][i];
        const double far_a = along * (by_place[a][0] * dx + by_place[a][1] * dy) / r;
        const double far_b = along * (by_place[b][0] * dx + by_place[b][1] * dy) / r;
        const double side_a = aside * (by_place[a][1] * dx - by_place[a][0] * dy) / r;
        const double side_b = aside * (by_place[b][1] * dx - by_place[b][0] * dy) / r;
        other[a][b] += far_a * far_b + side_a * side_b + square(person.height_std) * by_height[a] * by_height[b];
      }
    const double rate = switches_ / (switches_ + kept_), nu = model.people.noise.nu;
    const double better = log_density(e, same, cues, nu) - log_density(e, other, cues, nu);
    return rate / (rate + (1.0 - rate) * elementary::exp(std::min(better, 300.0)));
  }

  /// Log density of a Student-t law with the scale matrix s, up to a constant.
  static double log_density(const double* e, const double (&s)[3][3], int n, double nu) {
    double l[3][3] = {}, w[3], away = 0.0, volume = 0.0;
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = s[i][j];
        for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
        l[i][j] = i == j ? std::sqrt(std::max(sum, 1e-12)) : sum / l[j][j];
      }
      double rest = e[i];
      for (int k = 0; k < i; ++k) rest -= l[i][k] * w[k];
      w[i] = rest / l[i][i];
      away += w[i] * w[i];
      volume += elementary::log(l[i][i]);
    }
    return -volume - 0.5 * (nu + n) * elementary::log1p(away / nu);
  }

  double switches_ = 1.0, kept_ = 100.0;
  Elimination elimination_;
};

}  // namespace vbbench
