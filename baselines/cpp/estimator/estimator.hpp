// The estimator: one frame after another, in a sliding window.
#pragma once

#include <vector>

#include "noise.hpp"

namespace vbbench {

/// What is published about a recording.
struct Recording {
  double dt = 0.4, height_mean = 1.7, height_std = 0.07, pixel_std = 1.0, box_std = 0.0, tilt_std = 0.0,
         mount_std = 0.0, mount_height = 1.6;
  int columns = 0;
  bool known_calibration = false;
  Carrier carrier = kUnknownCarrier;
  bool covariances = false;
};

/// What a frame brings; arrays have a row for each column, NaN = absent.
struct Input {
  const double* boxes;              ///< [K][5] azimuth, foot, length, pixels, width
  const int* cut;                   ///< [K]
  const double* poses;              ///< [3][3] given at t − 2, t − 1, t
  const double* positions;          ///< [3][K][2] given
  const double* motion;             ///< [3] of odometry, NaN = not measured
  const double* motion_covariance;  ///< [3][3]
};

/// What is answered; arrays belong to the caller.
struct Output {
  double* pose;                  ///< [3]
  double* pose_covariance;       ///< [3][3]
  double* positions;             ///< [K][2]
  double* position_covariances;  ///< [K][2][2]
  double* heights;               ///< [K]
  bool converged = true;
};

/// Lower triangular R with Rᵀ R = C⁻¹.
inline bool information_root(const double* c, std::array<std::array<double, 3>, 3>& root) {
  Matrix l(3, 3);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) l[i][j] = c[3 * i + j] + (i == j ? 1e-12 : 0.0);
  if (!cholesky(l, 3)) return false;
  for (int c2 = 0; c2 < 3; ++c2) {  // columns of L⁻¹, of which Σ⁻¹ = L⁻ᵀ L⁻¹; rows of L⁻¹ whiten
    double unit[3] = {0.0, 0.0, 0.0};
    unit[c2] = 1.0;
    solve_lower(l, 3, unit);
    for (int r = 0; r < 3; ++r) root[r][c2] = unit[r];
  }
  return true;
}

constexpr int kWalkLate = 4;          ///< frames after which an innovation counts
constexpr double kWalkMemory = 60.0;  ///< s for which it counts
constexpr int kTried = 3;             ///< newest steps in which a camera that stands may have moved
constexpr double kSurer = 1.0;        ///< nats by which another solution must be better

class Estimator {
 public:
  Constants constants;
  int size = 20, rounds = 4;
  double least = 1e-3;

  void start(const Recording& recording) {
    recording_ = recording;
    window_ = Window();
    age_ = 0;
    where_.assign(recording.columns, -1);
    const Constants& c = constants;
    model_.people.walk = Walk::of(c, recording.dt);
    model_.people.noise = {c.noise_share, c.noise_time, std::max(recording.pixel_std, 0.05), c.noise_nu};
    model_.people.pace = c.pace;
    model_.people.first_speed = c.first_speed;
    model_.people.own_edge_std = c.edge_person_std;
    model_.motion = EgoMotion::of(c, recording.dt, recording.carrier);
    model_.sway_memory = std::exp(-recording.dt / c.sway_time);
    Calibration& calibration = window_.calibration;
    calibration.at = {0.0, 0.0, recording.mount_height, 0.0, c.edge, 0.0, 0.0};
    const double tilt = recording.tilt_std > 0.0 ? recording.tilt_std : c.tilt_std;
    const double mount = recording.mount_std > 0.0 ? recording.mount_std : c.mount_std;
    std::array<double, kGlobals> std{tilt, tilt, mount, c.offset_std, c.edge_std, 0.015, 0.02};
    height_std_ = std::max(recording.height_std / recording.height_mean, c.height_std);
    if (recording.known_calibration) {
      calibration.at[kEdge] = 0.0;
      for (int g = 0; g < kOdometryScale; ++g) std[g] = 0.0;
      model_.people.noise.share = {0.0, 0.0, 0.0};
      model_.people.own_edge_std = 1e-4;
      height_std_ = std::max(recording.height_std / recording.height_mean, 1e-4);
    } else {
      model_.people.noise.pixel = std::max(model_.people.noise.pixel * 0.0 + c.pixel, 0.05);
      if (recording.box_std > 0.0) model_.people.noise.share.fill(recording.box_std);
      calibration.sway_std = {c.sway_std, c.sway_std};
    }
    calibration.about = calibration.at;
    odometry_ = false;
    squares_ = count_ = 0.0;
    variance_ = 1.0;
    learns_ = !recording.known_calibration;
    if (learns_) noise_.start(model_.people.noise, c.noise_spread, recording.dt);
    for (int g = 0; g < kGlobals; ++g) {
      calibration.free[g] = std[g] > 0.0 && g < kOdometryScale;
      calibration.information[g][g] = std[g] > 0.0 ? 1.0 / (std[g] * std[g]) : 0.0;
    }
    window_.mode_prior = model_.motion.start;
  }

  void step(const Input& input, Output& output) {
    if (static_cast<int>(window_.frames.size()) == size) {
      window_.marginalise(model_);
      index_people();
    }
    add_frame(input);
    add_people(input);
    Solution solution = window_.solve(model_, rounds, least);
    if (!window_.posterior.empty() && window_.posterior.back()[kStand] > 0.5) leave_rest(solution);
    output.converged = solution.ended || solution.steps > 0;
    window_.weigh_boxes(model_);
    learn_walk();
    if (learns_) {
      noise_.learn(window_, model_);
      model_.people.noise = noise_.noise();
    }
    answer(output);
    ++age_;
  }

  void forget(const int* columns, int count) {
    for (int i = 0; i < count; ++i) where_[columns[i]] = -1;
    for (Person& person : window_.people)
      for (int i = 0; i < count; ++i)
        if (person.column == columns[i]) person.column = -1;
  }

  double variance() const { return variance_; }
  const Window& window() const { return window_; }
  const Model& model() const { return model_; }
  std::array<double, 5> gradient_errors() { return window_.gradient_errors(model_); }

 private:
  void index_people() {
    std::fill(where_.begin(), where_.end(), -1);
    for (std::size_t p = 0; p < window_.people.size(); ++p)
      if (window_.people[p].column >= 0) where_[window_.people[p].column] = static_cast<int>(p);
  }

  void add_frame(const Input& input) {
    std::vector<Frame>& frames = window_.frames;
    Frame frame;
    if (!frames.empty()) {
      frame.at = frames.back().at;
      for (int c = 0; c < 2; ++c) frame.at[kPose + c] *= model_.sway_memory;
      if (frames.size() > 1) predict(frames, frame);
    }
    if (!std::isnan(input.motion[0]) && !frames.empty()) {
      frame.motion.measured = information_root(input.motion_covariance, frame.motion.root);
      for (int c = 0; c < 3; ++c) frame.motion.moved[c] = input.motion[c];
      const std::array<double, kFrame>& last = frames.back().at;
      const double ca = std::cos(last[2]), sa = std::sin(last[2]);
      frame.at[0] = last[0] + ca * input.motion[0] - sa * input.motion[1];
      frame.at[1] = last[1] + sa * input.motion[0] + ca * input.motion[1];
      frame.at[2] = last[2] + input.motion[2];
      if (!odometry_) {
        odometry_ = true;
        window_.calibration.free[kOdometryScale] = window_.calibration.free[kOdometryTurn] = true;
      }
    }
    frames.push_back(frame);
    const int n = static_cast<int>(frames.size());
    for (int back = std::min(3, n); back >= 1; --back) {
      const double* pose = input.poses + 3 * (3 - back);
      if (std::isnan(pose[0])) continue;
      Frame& at = frames[n - back];
      at.given = true;
      const double before = back < n ? frames[n - back - 1].at[2] : pose[2];
      for (int c = 0; c < 3; ++c) at.given_pose[c] = pose[c];
      at.given_pose[2] = before + wrap(pose[2] - before);
      for (int c = 0; c < 3; ++c) at.at[c] = at.given_pose[c];
    }
  }

  void predict(const std::vector<Frame>& frames, Frame& frame) const {
    const std::array<double, kFrame>&last = frames.back().at, &before = frames[frames.size() - 2].at;
    const bool drives = !window_.posterior.empty() && window_.posterior.back()[kDrive] > 0.5;
    double dx = last[0] - before[0], dy = last[1] - before[1];
    if (drives) {
      const double turn = last[2] - before[2], c = std::cos(turn), s = std::sin(turn), x = dx;
      dx = c * x - s * dy;
      dy = s * x + c * dy;
      frame.at[2] = last[2] + turn;
    }
    frame.at[0] = last[0] + dx;
    frame.at[1] = last[1] + dy;
  }

  std::array<double, 2> placed(const Box& box, double log_height, const Frame& frame) const {
    const double r = std::exp(log_height) / box.length + window_.calibration.at[kEdge];
    const double angle = frame.at[2] - box.azimuth;
    return {frame.at[0] + r * std::cos(angle), frame.at[1] + r * std::sin(angle)};
  }

  void add_people(const Input& input) {
    const int newest = static_cast<int>(window_.frames.size()) - 1, columns = recording_.columns;
    Frame& frame = window_.frames[newest];
    for (int k = 0; k < columns; ++k) {
      const double* b = input.boxes + 5 * k;
      const bool seen = !std::isnan(b[0]);
      bool given = false;
      for (int back = 1; back <= std::min(3, newest + 1); ++back)
        given = given || !std::isnan(input.positions[2 * ((3 - back) * columns + k)]);
      if (!seen && !given) continue;
      Box box;
      if (seen) box = {b[0], b[1], b[2], b[3], b[4], input.cut[k], b[2]};
      if (where_[k] < 0) {
        Person person;
        person.column = k;
        person.variance = variance_;
        person.height_mean = person.log_height = std::log(recording_.height_mean);
        person.height_std = height_std_;
        int begin = newest;
        for (int back = 1; back <= std::min(3, newest + 1); ++back)
          if (!std::isnan(input.positions[2 * ((3 - back) * columns + k)])) begin = newest + 1 - back;
        person.first = begin;
        where_[k] = static_cast<int>(window_.people.size());
        window_.people.push_back(person);
      }
      Person& person = window_.people[where_[k]];
      while (person.last() < newest) {  // the path goes on as it went
        Node node;
        const int n = person.frames();
        if (n > 1) {
          for (int a = 0; a < 2; ++a) node.at[a] = 2.0 * person.nodes[n - 1].at[a] - person.nodes[n - 2].at[a];
        } else if (n == 1) {
          node.at = person.nodes[0].at;
        } else if (seen) {
          node.at = placed(box, person.log_height, frame);
        }
        person.nodes.push_back(node);
      }
      const bool alone = person.frames() == 1;
      if (seen) {
        person.nodes.back().seen = true;
        person.nodes.back().box = box;
        if (!alone && person.last() - last_seen_before(person) > 1)
          interpolate(person, placed(box, person.log_height, frame));
      }
      for (int back = 3; back >= 1; --back) {
        const double* at = input.positions + 2 * ((3 - back) * columns + k);
        const int node = newest + 1 - back - person.first;
        if (std::isnan(at[0]) || node < 0 || node >= person.frames()) continue;
        Node& here = person.nodes[node];
        here.given = true;
        here.given_at = here.at = {at[0], at[1]};
      }
    }
    for (const Person& person : window_.people)
      if (person.last() == newest && person.frames() > 1 && person.nodes.back().seen) inform(person, frame);
    for (Person& person : window_.people)
      for (Node& node : person.nodes)
        if (node.seen) {
          const Frame& camera = window_.frames[person.first + static_cast<int>(&node - person.nodes.data())];
          const double r = std::hypot(node.at[0] - camera.at[0], node.at[1] - camera.at[1]);
          node.box.expected = std::exp(person.log_height) / std::max(r - window_.calibration.at[kEdge], 0.5);
        }
  }

  /// The variance of people's innovations, as expectation maximisation has it.
  void learn_walk() {
    const int frame = static_cast<int>(window_.frames.size()) - 1 - kWalkLate;
    if (frame < 0) return;
    const std::array<double, 2> sum = window_.innovations(model_, frame);
    const double keep = std::exp(-recording_.dt / kWalkMemory);
    squares_ = keep * squares_ + sum[0];
    count_ = keep * count_ + sum[1];
    const double variance = (constants.walk_people + squares_) / (constants.walk_people + count_);
    for (Person& person : window_.people) person.variance = variance;
    variance_ = variance;
  }

  /// A descent hardly leaves a mode as narrow as standing: it is tried that the camera has moved for a few frames.
  void leave_rest(Solution& solution) {
    Window other = window_;
    other.moving = kTried;
    other.solve(model_, 2, least);
    other.moving = 0;
    const Solution found = other.solve(model_, rounds, least);
    if (found.cost < solution.cost - kSurer) {
      window_ = std::move(other);
      solution = found;
    }
  }

  /// Adds what the newest box of a person who was seen before shows of the camera's step.
  void inform(const Person& person, Frame& frame) const {
    const Box& box = person.nodes.back().box;
    const BoxNoise& noise = model_.people.noise;
    const double r = std::exp(person.log_height) / box.length, walk = model_.people.walk.sigma,
                 px = noise.pixel / box.pixels;
    const double across = r * box.width * std::hypot(noise.share[0], px), along = r * std::hypot(noise.share[1], px);
    const double a = 1.0 / (walk * walk + across * across), b = 1.0 / (walk * walk + along * along);
    frame.information[0] += 0.5 * (a + b);
    frame.information[1] += 0.5 * (a + b);
    frame.information[2] += a * r * r;
  }

  static int last_seen_before(const Person& person) {
    for (int i = person.frames() - 2; i >= 0; --i)
      if (person.nodes[i].seen || person.nodes[i].given) return person.first + i;
    return person.first;
  }

  /// A person who was out of sight comes back: the path between is straight.
  static void interpolate(Person& person, const std::array<double, 2>& now) {
    const int from = last_seen_before(person) - person.first, to = person.frames() - 1;
    const std::array<double, 2> start = person.nodes[from].at;
    for (int i = from + 1; i <= to; ++i)
      for (int a = 0; a < 2; ++a) person.nodes[i].at[a] = start[a] + (now[a] - start[a]) * (i - from) / (to - from);
  }

  void answer(Output& output) {
    const Frame& frame = window_.frames.back();
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    output.pose[0] = frame.at[0];
    output.pose[1] = frame.at[1];
    output.pose[2] = wrap(frame.at[2]);
    for (const Person& person : window_.people) {
      if (person.column < 0) continue;
      output.heights[person.column] = std::exp(person.log_height);
      if (person.last() != newest) continue;
      for (int a = 0; a < 2; ++a) output.positions[2 * person.column + a] = person.nodes.back().at[a];
    }
    if (!recording_.covariances) return;
    std::array<std::array<double, 3>, 3> pose;
    std::vector<std::array<double, 3>> places;
    if (!window_.covariances(model_, pose, places)) return;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) output.pose_covariance[3 * a + b] = pose[a][b];
    for (std::size_t p = 0; p < window_.people.size(); ++p) {
      const int column = window_.people[p].column;
      if (column < 0 || std::isnan(places[p][0])) continue;
      double* to = output.position_covariances + 4 * column;
      to[0] = places[p][0];
      to[1] = to[2] = places[p][1];
      to[3] = places[p][2];
    }
  }

  Recording recording_;
  Model model_;
  Window window_;
  std::vector<int> where_;
  double height_std_ = 0.055;
  int age_ = 0;
  bool odometry_ = false, learns_ = false;
  NoiseLearner noise_;
  double squares_ = 0.0, count_ = 0.0, variance_ = 1.0;
};

}  // namespace vbbench
