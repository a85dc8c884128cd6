// All factors of one person: boxes, walk, pace, given places, height and the marginal prior, as rows of residuals.
#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "../state.hpp"
#include "elementary.hpp"

namespace vbbench {

/// A variable of a row: a coordinate of the path, the person's log height, a `Global`, or one of a frame.
struct Variable {
  enum Kind : int { kPath, kHeight, kShared, kCamera };
  Kind kind;
  int index;  ///< 2 · node + axis; none; `Global`; kFrame · frame + component
};

/// What number `a` of a marginal prior is about.
inline Variable prior_variable(int a) {
  if (a < kPriorPlaces) return {Variable::kPath, a};
  return a == kPriorPlaces ? Variable{Variable::kHeight, 0} : Variable{Variable::kShared, a - kPriorPlaces - 1};
}

/// Order of a row's gradient: the person's variables, which are eliminated, then −residual for the right-hand side,
/// then the variables of the reduced system. Camera and place are those of the row's node and of the node before.
enum Slot : int {
  kSlotPlace = 0,
  kSlotPlaceBefore = 2,
  kSlotHeight = 4,
  kSlotResidual,
  kSlotShared,
  kSlotCameraBefore = kSlotShared + kBoxGlobals,
  kSlotCamera = kSlotCameraBefore + kFrame,
  kSlotEnd = kSlotCamera + kFrame,
  kSlots = 24
};

/// One residual e with weight w of a person: it adds ½ w e² to the quadratic model, and `cost` + `power` · ln `base` to
/// the cost.
struct Row {
  enum Law { kGaussian, kBox, kWalk, kSpread, kPace, kLaws };  ///< rows of one law have the same power

  double e = 0.0, w = 0.0, cost = 0.0, power = 0.0, base = 1.0;
  int node = -1;  ///< the newest node of the row; −1: the row depends on the height alone
  int cue = -1;   ///< index of a box's cue, in a key frame
  Law law = kGaussian;
  bool of_box = false, walk = false;  ///< residual of a box; innovation of the path, whose gradient is `chain`
  int axis = 0, reach = 0;            ///< axis of an innovation; number of nodes before the newest one
  std::array<double, kReach + 1> chain{};
  std::array<double, kSlots> by{};

  /// The row of a Gaussian law with standard deviation `sigma`.
  static Row gaussian(int node, double e, double sigma) {
    Row row;
    row.node = node;
    row.e = e;
    row.w = 1.0 / (sigma * sigma);
    row.cost = 0.5 * row.w * e * e;
    return row;
  }

  /// Calls `visit(Variable, derivative)` for each variable; `first` is the frame of the person's node 0.
  template <class Visit>
  void each(int first, Visit&& visit) const {
    for (int j = 0; walk && j <= reach; ++j) visit(Variable{Variable::kPath, 2 * (node - j) + axis}, chain[j]);
    if (walk) return;
    for (int a = 0; node >= 0 && a < 2; ++a) visit(Variable{Variable::kPath, 2 * node + a}, by[kSlotPlace + a]);
    for (int a = 0; reach > 0 && a < 2; ++a)
      visit(Variable{Variable::kPath, 2 * node - 2 + a}, by[kSlotPlaceBefore + a]);
    visit(Variable{Variable::kHeight, 0}, by[kSlotHeight]);
    if (!of_box) return;
    for (int g = 0; g < kBoxGlobals; ++g) visit(Variable{Variable::kShared, g}, by[kSlotShared + g]);
    for (int k = 0; k < kFrame; ++k) {
      visit(Variable{Variable::kCamera, kFrame * (first + node) + k}, by[kSlotCamera + k]);
      if (reach > 0) visit(Variable{Variable::kCamera, kFrame * (first + node - 1) + k}, by[kSlotCameraBefore + k]);
    }
  }
};

/// A residual e of the camera with weight w and `count` derivatives `by` its `variables`; it adds `cost` to the cost.
struct CameraRow {
  double e = 0.0, w = 0.0, cost = 0.0;
  int count = 0;
  std::array<Variable, 3 * (kReach + 1)> variables;
  std::array<double, 3 * (kReach + 1)> by;

  static CameraRow gaussian(double e, double variance) {
    CameraRow row;
    row.e = e;
    row.w = 1.0 / variance;
    row.cost = 0.5 * row.w * e * e;
    return row;
  }

  void add(Variable::Kind kind, int index, double value) {
    variables[count] = {kind, index};
    by[count++] = value;
  }
};

/// Densities of the factors of people.
struct PeopleModel {
  Walk walk;
  BoxNoise noise;
  VelocityPrior pace;
  int stride = 1;          ///< frames from one key frame to the next
  double height_nu = 1e9;  ///< degrees of freedom of log heights
};

/// The scale-free prior of a path, −g ln r, r being the distance from the camera and g `Node::growth` of the last
/// solution. It cancels the scale bias of the walk factor, under which smaller worlds are more probable.
inline void set_scale_row(const Node& node, const Frame& camera, Row& row) {
  const double dx = node.at[0] - camera.at[0], dy = node.at[1] - camera.at[1];
  const double square = std::max(dx * dx + dy * dy, 1e-6);
  const double by_x = node.growth * dx / square, by_y = node.growth * dy / square;
  row.cost = -0.5 * node.growth * elementary::log(square);
  row.by[kSlotPlace] = by_x;
  row.by[kSlotPlace + 1] = by_y;
  row.by[kSlotCamera] = -by_x;
  row.by[kSlotCamera + 1] = -by_y;
}

/// Nodes of a path, from the first one up to the last one, and whether rows of their boxes are visited.
struct Nodes {
  int first = 0, last = 1 << 30;
  bool boxes = true;
};

/// Visits the rows of one person whose newest nodes are among `nodes`, `Visit(const Row&)`, one node after another.
template <class Visit>
void person_rows(const Person& person, const std::vector<Frame>& frames, const Calibration& calibration,
                 const PeopleModel& model, Visit&& visit, Nodes nodes = {}) {
  const int end = std::min(person.frames(), nodes.last + 1);
  std::array<double, 3> memory;
  for (int c = 0; c < 3; ++c) memory[c] = elementary::exp(-model.walk.dt / model.stride / model.noise.time[c]);
  std::array<Cue, 3> before{};  // of the box before, at `before_time` in key frames from the first node
  double before_time = -2.0;
  auto between = person.between.begin();
  Row box, growth, walk, pacing, crossing, resting;  // of each kind one, of which every node changes the same numbers
  constexpr double kTiny = 1e-7;                     // a gradient without curvature
  box.of_box = growth.of_box = true;
  growth.w = kTiny;
  growth.e = -1.0 / kTiny;
  box.law = Row::kBox;
  const double tempered = 1.0 / std::sqrt(static_cast<double>(model.stride));
  box.power = tempered * 0.5 * (model.noise.nu + 1.0);
  walk.walk = true;
  pacing.reach = crossing.reach = resting.reach = 1;
  // A box at a share of the time from node i − 1 to node i. Its own share of a gradient is that of the newer node.
  const auto add_box = [&](int i, double share, const Box& shown, double x, double y, const double* camera,
                           bool visited) {
    const bool in_key_frame = share == 1.0;
    const BoxState at(x, y, person.log_height, camera, calibration.at.data());
    const std::array<Cue, 3> cues = box_cues(shown, at, model.noise);
    const double time = i - 1.0 + share, earlier = before_time - (i - 1.0);  // share of the box before
    const int steps = static_cast<int>((time - before_time) * model.stride + 0.5);
    for (int c = 0; c < 3; ++c) {
      const Cue &now = cues[c], &last = before[c];
      if (!visited || !now.used || (in_key_frame && person.nodes[i].box_absorbed[c])) continue;
      const bool chained = earlier >= 0.0 && last.used;
      double rho = 0.0;
      if (chained) {
        rho = memory[c] * std::sqrt(now.correlated * last.correlated);
        for (int step = 1; step < steps; ++step) rho *= memory[c];
      }
      const double by = 1.0 / (now.std * std::sqrt(1.0 - rho * rho));  // whitened: by · now + back · last
      const double back = chained ? -rho * now.std / last.std * by : 0.0;
      box.node = i;
      box.cue = in_key_frame ? c : -1;
      box.reach = chained || !in_key_frame;
      box.e = by * now.q + back * last.q;
      const double scaled = box.e * box.e / model.noise.nu;
      box.w = tempered * (model.noise.nu + 1.0) / (model.noise.nu * (1.0 + scaled));
      box.base = 1.0 + scaled;
      const double now_newer = by * share, last_newer = back * earlier;
      const double now_older = by * (1.0 - share), last_older = back * (1.0 - earlier);
      for (int a = 0; a < 2; ++a) {
        box.by[kSlotPlace + a] = now_newer * now.by[kX + a] + last_newer * last.by[kX + a];
        box.by[kSlotPlaceBefore + a] = now_older * now.by[kX + a] + last_older * last.by[kX + a];
      }
      box.by[kSlotHeight] = by * now.by[kLogHeight] + back * last.by[kLogHeight];
      for (int g = 0; g < kBoxGlobals; ++g) box.by[kSlotShared + g] = by * now.by_global[g] + back * last.by_global[g];
      for (int k = 0; k < kFrame; ++k) {
        box.by[kSlotCamera + k] = now_newer * now.by[kPoseX + k] + last_newer * last.by[kPoseX + k];
        box.by[kSlotCameraBefore + k] = now_older * now.by[kPoseX + k] + last_older * last.by[kPoseX + k];
      }
      visit(box);
    }
    before = cues;
    before_time = time;
  };
  for (int i = std::max(0, nodes.first - 1); i < end; ++i) {
    const Node& node = person.nodes[i];
    const bool visited = i >= nodes.first;
    if (visited && node.given) {
      for (int axis = 0; axis < 2; ++axis) {
        Row row = Row::gaussian(i, node.at[axis] - node.given_at[axis], node.given_std);
        row.by[kSlotPlace + axis] = 1.0;
        visit(row);
      }
    }
    while (between != person.between.end() && between->node < i) ++between;
    for (; nodes.boxes && between != person.between.end() && between->node == i; ++between) {
      const std::array<double, kFrame>&last = frames[person.first + i - 1].at, &next = frames[person.first + i].at;
      const double s = between->share, *place = person.nodes[i - 1].at.data();
      std::array<double, kFrame> camera;
      for (int k = 0; k < kFrame; ++k) camera[k] = last[k] + s * (next[k] - last[k]);
      for (int axis = 0; visited && between->given && axis < 2; ++axis) {
        Row row = Row::gaussian(i, place[axis] + s * (node.at[axis] - place[axis]) - between->given_at[axis],
                                kBetween * model.walk.dt * std::min(s, 1.0 - s));
        row.reach = 1;
        row.by[kSlotPlace + axis] = s;
        row.by[kSlotPlaceBefore + axis] = 1.0 - s;
        visit(row);
      }
      if (!between->seen) continue;
      add_box(i, s, between->box, place[0] + s * (node.at[0] - place[0]), place[1] + s * (node.at[1] - place[1]),
              camera.data(), visited);
    }
    if (node.seen && nodes.boxes)
      add_box(i, 1.0, node.box, node.at[0], node.at[1], frames[person.first + i].at.data(), visited);
    if (visited && nodes.boxes) {
      growth.node = i;
      set_scale_row(node, frames[person.first + i], growth);
      visit(growth);
    }
    if (i == 0 || !visited) continue;
    const double dx = node.at[0] - person.nodes[i - 1].at[0], dy = node.at[1] - person.nodes[i - 1].at[1];
    if (i > 1 && !node.walk_absorbed) {
      const double scale = model.walk.coefficients(i, walk.chain), variance = scale * scale * person.variance;
      walk.node = i;
      walk.reach = std::min(i, kReach);
      double e[2] = {0.0, 0.0};
      for (int j = 0; j <= walk.reach; ++j)
        for (int axis = 0; axis < 2; ++axis) e[axis] += walk.chain[j] * person.nodes[i - j].at[axis];
      const double nu = model.walk.nu, scaled = (e[0] * e[0] + e[1] * e[1]) / variance / nu;
      walk.w = (nu + 2.0) / (nu * (1.0 + scaled)) / variance;
      for (int axis = 0; axis < 2; ++axis) {
        walk.axis = axis;
        walk.e = e[axis];
        walk.law = axis ? Row::kSpread : Row::kWalk;
        walk.power = axis ? 1.0 : 0.5 * (nu + 2.0);
        walk.base = axis ? variance : 1.0 + scaled;
        visit(walk);
      }
    }
    if (model.pace.weight > 0.0) {
      const double dt = model.walk.dt, speed = std::sqrt(dx * dx + dy * dy) / dt + 1e-9;
      const double lasting = i == 1 && !node.walk_absorbed ? std::max(dt, VelocityPrior::kFirst) : dt;
      const std::array<double, 2>& normal = model.pace.normal;
      crossing.e = (normal[0] * dx + normal[1] * dy) / dt;
      const Pace pace = model.pace.at(speed, crossing.e, lasting);
      const double spread = 1.0 / dt, ux = dx / (speed * dt), uy = dy / (speed * dt);
      pacing.node = crossing.node = resting.node = i;
      pacing.e = speed - model.pace.walking;
      pacing.w = pace.walk;
      pacing.law = lasting > dt ? Row::kGaussian : Row::kPace;
      pacing.power = lasting > dt ? 0.0 : -model.pace.weight * dt;
      pacing.cost = lasting > dt ? -model.pace.weight * lasting * elementary::log(pace.density) : 0.0;
      pacing.base = pace.density;
      pacing.by[kSlotPlace] = ux * spread;
      pacing.by[kSlotPlace + 1] = uy * spread;
      pacing.by[kSlotPlaceBefore] = -ux * spread;
      pacing.by[kSlotPlaceBefore + 1] = -uy * spread;
      visit(pacing);
      crossing.w = pace.across;
      for (int a = 0; a < 2; ++a) {
        crossing.by[kSlotPlace + a] = normal[a] * spread;
        crossing.by[kSlotPlaceBefore + a] = -normal[a] * spread;
      }
      if (crossing.w > 0.0) visit(crossing);
      resting.w = pace.stand;
      for (int axis = 0; axis < 2; ++axis) {
        resting.e = (axis ? dy : dx) / dt;
        for (int a = 0; a < 2; ++a) {
          resting.by[kSlotPlace + a] = a == axis ? spread : 0.0;
          resting.by[kSlotPlaceBefore + a] = a == axis ? -spread : 0.0;
        }
        visit(resting);
      }
    }
  }
}

/// For callers that visit few rows: they share one copy of `person_rows`, which is compiled once.
using RowVisitor = std::function<void(const Row&)>;
extern template void person_rows(const Person&, const std::vector<Frame>&, const Calibration&, const PeopleModel&,
                                 RowVisitor&&, Nodes);

/// Visits the prior of a person's log height, which the marginal prior replaces once there is one.
template <class Visit>
void height_row(const Person& person, const PeopleModel& model, Visit&& visit) {
  if (person.prior.any) return;
  Row row;
  row.e = person.log_height - person.height_mean;
  const double square = row.e * row.e / (person.height_std * person.height_std);
  const Robust robust = student(square, model.height_nu, 1.0);
  row.w = robust.weight / (person.height_std * person.height_std);
  row.cost = robust.cost;
  row.by[kSlotHeight] = 1.0;
  visit(row);
}

/// Sum of the costs of a person's rows. Rows of one law are multiplied first: one logarithm serves many.
class CostSum {
 public:
  void add(const Row& row) {
    sum_ += row.cost;
    if (row.power == 0.0) return;
    power_[row.law] = row.power;
    if (row.base < 1e-100) {  // the product would be 0
      sum_ += row.power * elementary::log(row.base);
      return;
    }
    double& product = product_[row.law];
    product *= row.base;
    if (product > 1e-100 && product < 1e100) return;
    sum_ += row.power * elementary::log(product);
    product = 1.0;
  }
  double sum() const {
    double sum = sum_;
    for (int law = 0; law < Row::kLaws; ++law)
      if (product_[law] != 1.0) sum += power_[law] * elementary::log(product_[law]);
    return sum;
  }

 private:
  double sum_ = 0.0;
  std::array<double, Row::kLaws> power_{}, product_{1.0, 1.0, 1.0, 1.0, 1.0};
};

}  // namespace vbbench
