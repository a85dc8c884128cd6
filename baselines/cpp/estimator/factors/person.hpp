// All factors of one person: boxes, walk, pace, given places, height and the marginal prior, as rows of residuals.
#pragma once

#include <array>

#include "../state.hpp"

namespace vbbench {

/// A variable of a row: a coordinate of the person's path, the person's own numbers, a global, or a frame's.
struct Variable {
  enum Kind : int { kPath, kHeight, kOwn, kShared, kCamera };
  Kind kind;
  int index;  ///< 2 · node + axis; none; `Global`; kFrame · frame + component
};

/// One residual e with weight w: it adds ½ w e² to the quadratic model, and `cost` to the cost.
struct Row {
  double e = 0.0, w = 0.0, cost = 0.0;
  int count = 0, cue = -1;
  bool walk = false;  ///< an innovation of the path
  std::array<Variable, 24> variables;
  std::array<double, 24> by;

  void add(Variable::Kind kind, int index, double value) {
    variables[count] = {kind, index};
    by[count++] = value;
  }
};

/// What the factors of people need beside their state.
struct PeopleModel {
  Walk walk;
  BoxNoise noise;
  double pace = 0.3, first_speed = 1.2, own_edge_std = 0.08;
};

constexpr double kStroll = 1.3, kStrollStd = 0.35;  ///< m/s: how fast people walk
constexpr double kRestStd = 0.25, kResting = 0.25;  ///< m/s and the share of those who stand

/// The log-determinant term of the integral over a person's place, −s ln r − s' ln(r − δ) with the leverages s of
/// the column and s' of height and foot: a box is
/// surer of the place of a person who is nearer. Without it smaller worlds, whose people move less, are more probable.
inline Row volume_row(const Node& node, const BoxState& at, int i, int camera) {
  constexpr double kTiny = 1e-7;  // a gradient without curvature
  const double across = node.volume[0], along = node.volume[1] + node.volume[2];
  const double dx = at.x - at.pose[0], dy = at.y - at.pose[1], r = std::sqrt(dx * dx + dy * dy) + 1e-9;
  const double rho = std::max(r - at.global[kEdge] - at.own_edge, kNearest), by_r = across / r + along / rho;
  Row row;
  row.w = kTiny;
  row.e = -1.0 / kTiny;
  row.cost = -across * std::log(r) - along * std::log(rho);
  row.add(Variable::kPath, 2 * i, by_r * dx / r);
  row.add(Variable::kPath, 2 * i + 1, by_r * dy / r);
  row.add(Variable::kCamera, camera, -by_r * dx / r);
  row.add(Variable::kCamera, camera + 1, -by_r * dy / r);
  row.add(Variable::kShared, kEdge, -along / rho);
  row.add(Variable::kOwn, 0, -along / rho);
  return row;
}

/// Visits the rows of one person; `Visit(const Row&, int node)` with the newest node of the row, −1 for its own
/// numbers.
template <class Visit>
void person_rows(const Person& person, const std::vector<Frame>& frames, const Calibration& calibration,
                 const PeopleModel& model, Visit&& visit) {
  const int n = person.frames();
  std::array<Cue, 3> before{};
  int before_node = -2;
  for (int i = 0; i < n; ++i) {
    const Node& node = person.nodes[i];
    const int frame = person.first + i;
    if (node.given) {
      for (int axis = 0; axis < 2; ++axis) {
        Row row;
        row.e = node.at[axis] - node.given_at[axis];
        row.w = 1.0 / (kGiven * kGiven);
        row.cost = 0.5 * row.w * row.e * row.e;
        row.add(Variable::kPath, 2 * i + axis, 1.0);
        visit(row, i);
      }
    }
    if (node.seen) {
      const Frame& camera = frames[frame];
      const BoxState at{node.at[0],           node.at[1],       person.log_height,
                        person.own_edge,      camera.at.data(), camera.at.data() + kPose,
                        calibration.at.data()};
      const std::array<Cue, 3> cues = box_cues(node.box, at, model.noise);
      for (int c = 0; c < 3; ++c) {
        if (!cues[c].used || node.box_absorbed[c]) continue;
        const Cue& now = cues[c];
        double rho = 0.0;
        const bool chained = before_node == i - 1 && before[c].used;
        if (chained)
          rho = std::exp(-model.walk.dt / model.noise.time[c]) * std::sqrt(now.correlated * before[c].correlated);
        const double factor = rho * now.std / before[c].std;
        const double std = now.std * std::sqrt(1.0 - rho * rho);
        Row row;
        row.cue = c;
        row.e = (now.q - (chained ? factor * before[c].q : 0.0)) / std;
        const Robust robust = student(row.e * row.e, model.noise.nu, 1.0);
        row.w = robust.weight;
        row.cost = robust.cost;
        const double scale = 1.0 / std, back = chained ? -factor / std : 0.0;
        row.add(Variable::kPath, 2 * i, scale * now.by[kX]);
        row.add(Variable::kPath, 2 * i + 1, scale * now.by[kY]);
        if (chained) {
          row.add(Variable::kPath, 2 * i - 2, back * before[c].by[kX]);
          row.add(Variable::kPath, 2 * i - 1, back * before[c].by[kY]);
        }
        const auto both = [&](int k) { return scale * now.by[k] + back * before[c].by[k]; };
        row.add(Variable::kHeight, 0, both(kLogHeight));
        row.add(Variable::kOwn, 0, both(kOwnEdge));
        for (int g = 0; g < 5; ++g)
          row.add(Variable::kShared, g, scale * now.by_global[g] + back * before[c].by_global[g]);
        for (int k = 0; k < kFrame; ++k) {
          row.add(Variable::kCamera, kFrame * frame + k, scale * now.by[kPoseX + k]);
          if (chained) row.add(Variable::kCamera, kFrame * (frame - 1) + k, back * before[c].by[kPoseX + k]);
        }
        visit(row, i);
      }
      visit(volume_row(node, at, i, kFrame * frame), i);
      before = cues;
      before_node = i;
    }
    if (i == 0) continue;
    const double dx = node.at[0] - person.nodes[i - 1].at[0], dy = node.at[1] - person.nodes[i - 1].at[1];
    if (i == 1 && !node.walk_absorbed) {
      for (int axis = 0; axis < 2; ++axis) {
        Row row;
        row.e = axis ? dy : dx;
        row.w = 1.0 / (model.first_speed * model.first_speed * model.walk.dt * model.walk.dt);
        row.cost = 0.5 * row.w * row.e * row.e;
        row.add(Variable::kPath, 2 * i + axis, 1.0);
        row.add(Variable::kPath, 2 * i - 2 + axis, -1.0);
        visit(row, i);
      }
    } else if (!node.walk_absorbed) {
      std::array<double, kReach + 1> c;
      const double scale = model.walk.coefficients(i, c), variance = scale * scale * person.variance;
      const int reach = std::min(i, kReach);
      double e[2] = {0.0, 0.0};
      for (int j = 0; j <= reach; ++j)
        for (int axis = 0; axis < 2; ++axis) e[axis] += c[j] * person.nodes[i - j].at[axis];
      const Robust robust = student((e[0] * e[0] + e[1] * e[1]) / variance, model.walk.nu, 2.0);
      for (int axis = 0; axis < 2; ++axis) {
        Row row;
        row.walk = true;
        row.e = e[axis];
        row.w = robust.weight / variance;
        row.cost = axis ? 0.0 : robust.cost + std::log(variance);
        for (int j = 0; j <= reach; ++j) row.add(Variable::kPath, 2 * (i - j) + axis, c[j]);
        visit(row, i);
      }
    }
    if (model.pace > 0.0) {  // a mixture of those who walk and those who stand, as expectation maximisation sees it
      const double dt = model.walk.dt, speed = std::sqrt(dx * dx + dy * dy) / dt + 1e-9;
      const double walking =
          (1.0 - kResting) / kStrollStd * std::exp(-0.5 * std::pow((speed - kStroll) / kStrollStd, 2));
      const double resting = kResting / kRestStd * std::exp(-0.5 * speed * speed / (kRestStd * kRestStd)) + 1e-12;
      const double share = walking / (walking + resting), weight = model.pace * dt;
      const double spread = 1.0 / dt;
      Row row;
      row.e = speed - kStroll;
      row.w = weight * share / (kStrollStd * kStrollStd);
      row.cost = -weight * std::log(walking + resting);
      const double ux = dx / (speed * dt), uy = dy / (speed * dt);
      row.add(Variable::kPath, 2 * i, ux * spread);
      row.add(Variable::kPath, 2 * i + 1, uy * spread);
      row.add(Variable::kPath, 2 * i - 2, -ux * spread);
      row.add(Variable::kPath, 2 * i - 1, -uy * spread);
      visit(row, i);
      for (int axis = 0; axis < 2; ++axis) {
        Row rest;
        rest.e = (axis ? dy : dx) / dt;
        rest.w = weight * (1.0 - share) / (kRestStd * kRestStd);
        rest.add(Variable::kPath, 2 * i + axis, spread);
        rest.add(Variable::kPath, 2 * i - 2 + axis, -spread);
        visit(rest, i);
      }
    }
  }
}

/// Visits the Gaussian rows about a person's own numbers, which the marginal prior replaces once there is one.
template <class Visit>
void own_rows(const Person& person, const PeopleModel& model, Visit&& visit) {
  if (person.prior.any) return;
  Row row;
  row.e = person.log_height - person.height_mean;
  row.w = 1.0 / (person.height_std * person.height_std);
  row.cost = 0.5 * row.w * row.e * row.e;
  row.add(Variable::kHeight, 0, 1.0);
  visit(row, -1);
  Row own;
  own.e = person.own_edge;
  own.w = 1.0 / (model.own_edge_std * model.own_edge_std);
  own.cost = 0.5 * own.w * own.e * own.e;
  own.add(Variable::kOwn, 0, 1.0);
  visit(own, -1);
}

}  // namespace vbbench
