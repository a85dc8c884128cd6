// The estimator: one frame after another, in a sliding window.
#pragma once

#include <vector>

#include "archive.hpp"
#include "association.hpp"
#include "elementary.hpp"
#include "noise.hpp"
#include "occlusion.hpp"

namespace vbbench {

/// The published facts of a recording.
struct Recording {
  double dt = 0.4, height_mean = 1.7, height_std = 0.07, pixel_std = 1.0, box_std = 0.0, tilt_std = 0.0,
         mount_std = 0.0, mount_height = 1.6;
  double box_edge = -1.0;  ///< m, near edge of the source of boxes; negative or NaN = not known
  int columns = 0;
  bool known_calibration = false;
  Carrier carrier = kUnknownCarrier;
  bool covariances = false;
};

/// Measurements and given values of a frame; arrays have a row for each of the K columns, NaN = absent.
struct Input {
  const double* boxes;              ///< [K][5] azimuth, foot, length, pixels, width
  const int* cut;                   ///< [K]
  const double* poses;              ///< [3][3] given at t − 2, t − 1, t
  const double* positions;          ///< [3][K][2] given
  const double* motion;             ///< [3] of odometry, NaN = not measured
  const double* motion_covariance;  ///< [3][3]
};

/// The estimate of a frame; arrays belong to the caller.
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
  Matrix u(3, kLane), inverse(3, kLane);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) u[i][j] = c[3 * i + j] + (i == j ? 1e-12 : 0.0);
    inverse[i][i] = 1.0;
  }
  if (!cholesky(u[0], 3, kLane)) return false;
  solve_lower(u[0], 3, kLane, inverse[0], kLane);  // C⁻¹ = U⁻¹ U⁻ᵀ
  for (int i = 0; i < 3; ++i) std::copy_n(inverse[i], 3, root[i].begin());
  return true;
}

constexpr double kKeyFrame = 0.2;       ///< s from one key frame to the next at least
constexpr double kEdgeKnown = 0.05;     ///< m, standard deviation of a near edge that is given
constexpr double kStray = 0.05;         ///< m, σ of people about constant velocity between key frames
constexpr double kTurning = 0.1;        ///< rad by which a camera may turn between key frames
constexpr int kWalkLate = 4;            ///< frames after which an innovation updates the walk's variance
constexpr double kWalkMemory = 60.0;    ///< s of memory of this variance, and of directions
constexpr double kStrayed = 0.2;        ///< m, σ of people about constant velocity from one key frame to the next
constexpr double kContradiction = 9.0;  ///< squared σ of `kTurning` a person, by which bearings contradict a pose
constexpr double kBlind = 2.0;          ///< s without a person in sight after which given places relocate the camera
constexpr std::array<double, 4> kFastest{30.0, 4.0, 30.0, 5.0};  ///< m/s, a camera by its `Carrier`
constexpr double kFastestPerson = 4.0;                           ///< m/s
constexpr double kFlowSpeed = 0.6, kFlowTime = 4.0;  ///< m/s and s, σ and memory of the common velocity (cold start)
constexpr double kColdTime = 8.0;                    ///< s of the first window after a cold start, at most 2 · `size`
constexpr double kVague = 0.3;                       ///< m and rad, largest σ of odometry that is used
constexpr int kTried = 3;                            ///< newest steps of the hypothesis that a standing camera moves
constexpr double kSurerEach = 0.5;                   ///< the same for each person who has the common velocity
constexpr double kWalks = 3.0;  ///< nats by which it is more probable that a person who carries a camera walks

/// The pose of the camera (column −1), or the place of a column, that was given in a frame.
struct GivenValue {
  int column, age;
  std::array<double, 3> at;
};

class Estimator {
 public:
  using Spread = Window::Covariances::Pose;
  using Pose = std::array<double, 3>;

  Constants constants;
  int size = 20, rounds = 30;  // frames of the window, and steps of a solution at most
  double least = 0.1;          // nats

  void start(const Recording& recording) {
    recording_ = recording;
    stride_ = std::max(1, static_cast<int>(std::floor(kKeyFrame / recording.dt + 1e-6)));
    between_.clear();
    recording_.dt = stride_ * recording.dt;
    moved_ = Pose{};
    moved_spread_ = newest_ = Spread{};
    moved_known_ = false;
    converged_ = true;
    window_ = Window();
    behind_ = next_ = Spread{};
    age_ = 0;
    by_odometry_ = {};
    odometry_spread_ = {};
    unled_ = strayed_ = 0.0;
    cold_ = anchored_ = false;
    ages_.clear();
    blind_ = 0.0;
    where_.assign(recording.columns, -1);
    given_.clear();
    given_age_.assign(1 + recording.columns, -1);
    const Constants& c = constants;
    model_ = Model();
    model_.people.walk = Walk::of(c, recording_.dt);
    model_.people.noise = {c.noise_share, c.noise_time, std::max(recording.pixel_std, 0.05), c.noise_nu};
    model_.people.pace = VelocityPrior::of(c);
    model_.people.stride = stride_;
    model_.motion = EgoMotion::of(c, recording_.dt, recording.carrier);
    model_.sway_memory = elementary::exp(-recording_.dt / c.sway_time);
    Calibration& calibration = window_.calibration;
    const bool edge_known = recording.box_edge >= 0.0;
    const double edge_std = edge_known ? kEdgeKnown : c.edge_std;
    const double edge = edge_known ? recording.box_edge : recording.known_calibration ? 0.0 : c.edge;
    calibration.at = {0.0, 0.0, recording.mount_height, 0.0, edge, 0.0, 0.0};
    const double tilt = recording.tilt_std > 0.0 ? recording.tilt_std : c.tilt_std;
    const double mount = recording.mount_std > 0.0 ? recording.mount_std : c.mount_std;
    std::array<double, kGlobals> std{tilt, tilt, mount, c.offset_std, edge_std, 0.015, 0.02};
    height_std_ = std::max(recording.height_std / recording.height_mean, c.height_std);
    if (recording.known_calibration) {
      for (int g = 0; g < kOdometryScale; ++g) std[g] = 0.0;
      model_.people.noise.share = {0.0, 0.0, 0.0};
      height_std_ = std::max(recording.height_std / recording.height_mean, 1e-4);
    } else {
      model_.people.noise.pixel = std::max(c.pixel, 0.05);
      if (recording.box_std > 0.0) model_.people.noise.share.fill(recording.box_std);
      calibration.sway_std = {c.sway_std, c.sway_std};
    }
    calibration.about = calibration.at;
    if (height_std_ > c.height_std) {  // adults, and others: a Student-t law of this variance
      const double ratio = height_std_ * height_std_ / (c.height_std * c.height_std);
      model_.people.height_nu = 2.0 * ratio / (ratio - 1.0);
      height_std_ = c.height_std;
    }
    association_.start();
    learned_ = true;
    places_.assign(recording.columns, {NAN, NAN, NAN});
    squares_ = count_ = 0.0;
    variance_ = 1.0;
    gone_ = {};
    if (!recording.known_calibration) {
      noise_.start(model_.people.noise, c.noise_spread, recording.dt, recording_.dt);
      model_.people.noise = noise_.noise();
    }
    for (int g = 0; g < kGlobals; ++g) {
      calibration.free[g] = std[g] > 0.0 && g < kOdometryScale;
      calibration.information[g][g] = std[g] > 0.0 ? 1.0 / (std[g] * std[g]) : 0.0;
    }
    window_.mode_prior = model_.motion.start;
  }

  void step(const Input& input, Output& output) {
    finish_key_frame();
    if (age_ > 0) follow_odometry(input);
    note_given(input);
    if (age_ % stride_ == 0) {
      solve_key_frame(input, output);
    } else {
      between_key_frames(input, output);
    }
    ++age_;
  }

  void forget(const int* columns, int count) {
    for (int i = 0; i < count; ++i) {
      where_[columns[i]] = -1;
      given_age_[1 + columns[i]] = age_ - 1;
      std::erase_if(given_, [&](const GivenValue& value) { return value.column == columns[i]; });
      std::erase_if(between_, [&](const Between& one) { return one.node == columns[i]; });
    }
    for (Person& person : window_.people)
      for (int i = 0; i < count; ++i) {
        if (person.column == columns[i]) person.column = -1;
        for (Node& node : person.nodes)
          if (node.column == columns[i]) node.column = -1;
      }
  }

  /// Numbers of the window's frames, counted from the start.
  const std::vector<int>& ages() const { return ages_; }

  /// Writes the estimate of a frame of the window by all boxes so far; NaN = unknown.
  void smoothed(int frame, Output& output) {
    const Frame& camera = window_.frames[frame];
    for (int a = 0; a < 3; ++a) output.pose[a] = camera.at[a];
    for (const Person& person : window_.people) {
      const int i = frame - person.first;
      if (i < 0 || i >= person.frames() || person.nodes[i].column < 0) continue;
      for (int a = 0; a < 2; ++a) output.positions[2 * person.nodes[i].column + a] = person.nodes[i].at[a];
    }
    if (!recording_.covariances) return;
    learn();
    Window::Covariances found;
    if (window_.covariances(model_, frame, false, found)) write_covariances(frame, found, output);
  }

  /// Archives the state on which later frames depend. The last factorisation is not archived, so it is used before.
  template <class Archive>
  void archive(Archive& a) {
    learn();
    a(constants), a(size), a(rounds), a(least), a(recording_), a(moved_), a(moved_spread_), a(newest_);
    a(moved_known_), a(converged_), a(stride_), a(places_), a(by_odometry_), a(odometry_spread_), a(unled_);
    a(strayed_), a(cold_), a(anchored_), a(behind_), a(next_), a(model_), a(where_), a(ages_), a(height_std_), a(age_);
    a(between_), a(given_), a(given_age_), a(blind_), a(noise_), a(squares_), a(count_), a(variance_), a(gone_);
    window_.archive(a);
    association_.archive(a);
  }

  const Window& window() const { return window_; }
  const Model& model() const { return model_; }

 private:
  /// Notes the values that are given in the last three frames and were not before.
  void note_given(const Input& input) {
    for (int back = 3; back >= 1; --back) {
      const int age = age_ + 1 - back, columns = recording_.columns;
      for (int k = -1; k < columns; ++k) {
        const double* at = k < 0 ? input.poses + 3 * (3 - back) : input.positions + 2 * ((3 - back) * columns + k);
        if (age <= given_age_[1 + k] || std::isnan(at[0])) continue;
        given_age_[1 + k] = age;
        given_.push_back({k, age, {at[0], at[1], k < 0 ? at[2] : 0.0}});
      }
    }
  }

  /// The frame of the window at the age or next after it, and the share of the time from the frame before to it; −1 if
  /// the age is before the window.
  int frame_at(int age, double& share) const {
    int frame = static_cast<int>(ages_.size()) - 1;
    while (frame > 0 && ages_[frame - 1] >= age) --frame;
    share = 1.0 - static_cast<double>(ages_[frame] - age) / stride_;
    return share > 0.0 && (frame > 0 || share == 1.0) ? frame : -1;
  }

  /// What the answer of a key frame need not wait for: the model is learned from the solution, and the oldest frames of
  /// a full window are marginalised.
  void finish_key_frame() {
    learn();
    const int first = std::max(size, static_cast<int>(std::min(kColdTime / recording_.dt, 2.0 * size)));
    const bool full = static_cast<int>(window_.frames.size()) >= (anchored_ || window_.held > 0 ? size : first);
    while (full && static_cast<int>(window_.frames.size()) >= size) {
      const Frame& next = window_.frames[kHeld];
      carry_odometry(next);
      behind_ = next.given ? Spread{} : sum(carried(behind_, held_pose(), next.at[0], next.at[1]), next_);
      for (const Person& person : window_.people)
        if (person.first == 0 && person.frames() > 1) gone_.add(person, 1, model_.people.pace, recording_.dt);
      gone_.fade(elementary::exp(-recording_.dt / kWalkMemory));
      window_.marginalise(model_);
      ages_.erase(ages_.begin());
      index_people();
    }
  }

  /// Learns from the last solution, once.
  void learn() {
    if (learned_) return;
    learned_ = true;
    window_.weigh_walks(model_);
    learn_walk();
    learn_pace(window_, model_);
    learn_roughness(window_.frames, window_.posterior, evenness_weight(), model_.motion);
    if (!recording_.known_calibration) learn_boxes();
  }

  void solve_key_frame(const Input& input, Output& output) {
    ages_.push_back(age_);
    add_frame(input);
    add_people(input);
    between_.clear();
    given_.clear();
    if (blind_ > kBlind) relocate();
    Solution solution = window_.solve(model_, rounds, least);
    if (blind_ <= kBlind && !window_.frames.back().given && relocate()) solution = window_.solve(model_, rounds, least);
    try_common_velocities(solution);
    try_other_modes(solution);
    std::vector<int> changed = Occlusion::mark(window_, model_);
    associate(changed);
    if (!changed.empty()) solution = window_.solve_changed(model_, rounds, least, changed);
    watch();
    output.converged = converged_ = solution.steps > 0 && blind_ <= kBlind && is_plausible();
    learned_ = false;
    moved_ = Pose{};
    moved_spread_ = Spread{};
    moved_known_ = true;
    answer(output);
  }

  /// Adds the frame's odometry to the motion since the last key frame.
  void follow_odometry(const Input& input) {
    if (std::isnan(input.motion[0])) {
      moved_known_ = false;
      return;
    }
    anchored_ = true;
    const double c = elementary::cos(moved_[2]), s = elementary::sin(moved_[2]);
    Pose next = moved_;
    move(next, input.motion);
    Spread here{}, turned{};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) here[i][k] = input.motion_covariance[3 * i + k];
    const double r[3][3] = {{c, -s, 0.0}, {s, c, 0.0}, {0.0, 0.0, 1.0}};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) turned[i][k] += r[i][a] * here[a][b] * r[k][b];
    moved_spread_ = sum(carried(moved_spread_, moved_, next[0], next[1]), turned);
    moved_ = next;
  }

  /// Moves a pose by odometry: forward, left and turn.
  template <class P>
  static void move(P& pose, const double* motion) {
    const double c = elementary::cos(pose[2]), s = elementary::sin(pose[2]);
    pose[0] += c * motion[0] - s * motion[1];
    pose[1] += s * motion[0] + c * motion[1];
    pose[2] += motion[2];
  }

  /// Predicts a frame between key frames. The camera moves on from the pose given in the frame before, or from the last
  /// key frame, and people walk on at constant velocity. Boxes place those who come or return; the next key frame uses
  /// all boxes.
  void between_key_frames(const Input& input, Output& output) {
    const std::vector<Frame>& frames = window_.frames;
    const int newest = static_cast<int>(frames.size()) - 1, columns = recording_.columns;
    const double share = static_cast<double>(age_ % stride_) / stride_;
    Frame frame = frames.back();
    const double *last = input.poses + 3, *before = input.poses;  // given in the frames before
    if (!std::isnan(last[0])) {
      std::copy_n(last, kPose, frame.at.begin());
      if (!std::isnan(input.motion[0])) {
        move(frame.at, input.motion);
      } else if (!std::isnan(before[0])) {
        for (int a = 0; a < 2; ++a) frame.at[a] += last[a] - before[a];
        frame.at[2] += wrap(last[2] - before[2]);
      }
    } else if (moved_known_) {
      move(frame.at, moved_.data());
    } else if (newest > 0) {
      for (int a = 0; a < 3; ++a) frame.at[a] += share * (frames[newest].at[a] - frames[newest - 1].at[a]);
    }
    const double* given = input.poses + 6;
    for (int a = 0; a < kPose; ++a) output.pose[a] = std::isnan(given[0]) ? frame.at[a] : given[a];
    output.pose[2] = wrap(output.pose[2]);
    const Pose there{frames.back().at[0], frames.back().at[1], frames.back().at[2]};
    const Spread pose = sum(carried(newest_, there, output.pose[0], output.pose[1]), moved_spread_);
    for (int a = 0; recording_.covariances && a < 3; ++a)
      std::copy_n(pose[a].begin(), 3, output.pose_covariance + 3 * a);
    for (int k = 0; k < columns; ++k) {
      const double* b = input.boxes + 5 * k;
      double *to = output.positions + 2 * k, *spread = output.position_covariances + 4 * k;
      if (!std::isnan(b[0])) {
        const Box box = Box::of(b, input.cut[k]);
        between_.push_back({k, share, true, false, box, {}});
        std::array<double, 2> at;
        std::array<double, 3> place{NAN, NAN, NAN};  // xx, xy, yy
        const Person* person = where_[k] >= 0 ? &window_.people[where_[k]] : nullptr;
        const double variance = person ? predict_person(*person, k, share, input, at) : NAN;
        if (std::isnan(variance)) {
          at = window_.placed(box, person ? person->log_height : elementary::log(recording_.height_mean), frame);
        } else {
          place = {places_[k][0] + variance, places_[k][1], places_[k][2] + variance};
        }
        if (std::isnan(place[0])) {
          const double far = height_std_ * elementary::hypot(at[0] - output.pose[0], at[1] - output.pose[1]);
          place = {pose[0][0] + pose[1][1] + far * far, 0.0, 0.0};
          place[2] = place[0];
        }
        std::copy_n(at.begin(), 2, to);
        if (recording_.covariances) {
          spread[0] = place[0];
          spread[1] = spread[2] = place[1];
          spread[3] = place[2];
        }
      }
      const double* at = input.positions + 2 * (2 * columns + k);
      if (!std::isnan(at[0])) std::copy_n(at, 2, to);
    }
    for (const Person& person : window_.people)
      if (person.column >= 0) output.heights[person.column] = elementary::exp(person.log_height);
    output.converged = converged_;
  }

  /// Predicts where a person is between key frames, by constant velocity from the place given in the frame before, or
  /// from the last key frame. Returns the variance in m²; NaN where the person is in neither.
  double predict_person(const Person& person, int column, double share, const Input& input,
                        std::array<double, 2>& at) const {
    const double* given = input.positions + 2 * (recording_.columns + column);  // in the frame before
    const double* earlier = input.positions + 2 * column;                       // in the frame before that
    if (!std::isnan(given[0])) {
      const bool moves = !std::isnan(earlier[0]);
      for (int a = 0; a < 2; ++a) at[a] = given[a] + (moves ? given[a] - earlier[a] : 0.0);
      return square((moves ? constants.gait_speed : constants.walking) * recording_.dt / stride_);
    }
    if (person.last() + 1 != static_cast<int>(window_.frames.size())) return NAN;
    const int n = person.frames();
    const double time = share * recording_.dt;
    at = person.nodes[n - 1].at;
    if (n == 1) return square(constants.walking * time);
    const auto& older = person.nodes[n - 2].at;
    const double vx = at[0] - older[0], vy = at[1] - older[1];
    const double fastest = kFastestPerson * recording_.dt / (elementary::hypot(vx, vy) + 1e-9);
    at[0] += share * std::min(1.0, fastest) * vx;
    at[1] += share * std::min(1.0, fastest) * vy;
    return kStray * kStray + constants.acceleration * time * time * time / 3.0;
  }

  void index_people() {
    std::fill(where_.begin(), where_.end(), -1);
    for (std::size_t p = 0; p < window_.people.size(); ++p)
      if (window_.people[p].column >= 0) where_[window_.people[p].column] = static_cast<int>(p);
  }

  /// Whether a measured motion is precise enough to replace the ego-motion factor.
  static bool is_precise(const Spread& spread) {
    return spread[0][0] < kVague * kVague && spread[1][1] < kVague * kVague && spread[2][2] < kVague * kVague;
  }

  void add_frame(const Input& input) {
    std::vector<Frame>& frames = window_.frames;
    Frame frame;
    if (!frames.empty()) {
      frame.at = frames.back().at;
      for (int c = 0; c < 2; ++c) frame.at[kPose + c] *= model_.sway_memory;
      if (moved_known_ && !std::isnan(input.motion[0]) && is_precise(moved_spread_)) {
        frame.motion.measured = information_root(moved_spread_[0].data(), frame.motion.root);
        frame.motion.moved = moved_;
        move(frame.at, moved_.data());
        window_.calibration.free[kOdometryScale] = window_.calibration.free[kOdometryTurn] = true;
      } else if (frames.size() > 1) {
        for (int a = 0; a < 2; ++a) frame.at[a] = 2.0 * frame.at[a] - frames[frames.size() - 2].at[a];
      }
    }
    frames.push_back(frame);
    for (const GivenValue& value : given_) {
      double share;
      const int t = value.column < 0 ? frame_at(value.age, share) : -1;
      if (t < 0) continue;
      Frame& at = frames[t];
      std::array<double, 3> pose = value.at;
      const double before = t > 0 ? frames[t - 1].at[2] : pose[2];
      pose[2] = before + wrap(pose[2] - before);
      if (share < 1.0) {
        at.between = share;
        at.between_pose = pose;
        continue;
      }
      at.given = true;
      at.given_pose = pose;
      std::copy_n(pose.begin(), 3, at.at.begin());
    }
  }

  /// Counts the time in which nobody is in sight; it ends with two people in a frame, or one with odometry.
  void watch() {
    int seen = 0;
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    for (const Person& person : window_.people) seen += person.last() == newest && person.nodes.back().seen;
    const bool led = window_.frames.back().motion.measured;
    if (newest == 1 && static_cast<int>(ages_.size()) == 2 && ages_[0] == 0) cold_ = !window_.frames[1].anchored();
    if (cold_ && led) {  // the common velocity is measured again
      strayed_ = astray();
      unled_ = 0.0;
    } else if (cold_ && newest > 0) {
      unled_ += recording_.dt;
    }
    if (led || window_.frames.back().anchored() || seen == 0) {
      blind_ = led || window_.frames.back().anchored() ? 0.0 : blind_ + recording_.dt;
    } else if (blind_ <= kBlind) {
      blind_ = 0.0;
    }
  }

  /// Relocates the camera after a time without people, or where bearings of people with given places contradict its
  /// pose: a rigid fit to the given places of two people or more in the newest frame, with which a new window begins.
  /// Returns whether it did.
  bool relocate() {
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    Frame& frame = window_.frames[newest];
    struct Pair {
      Node* node;
      double std, ahead, left, x, y;  // m: of the given place; relative to the camera by the box; in the world
    };
    std::vector<Pair> pairs;
    double ahead = 0.0, left = 0.0, x = 0.0, y = 0.0;  // means
    for (Person& person : window_.people) {
      Node& node = person.nodes.back();
      const Between* one = person.given_between();
      if (person.last() != newest || !node.seen || !(node.given || one)) continue;
      const std::array<double, 2>& at = node.given ? node.given_at : one->given_at;
      const std::array<double, 2> relative = window_.placed(node.box, person.log_height, Frame());
      const double std = node.given ? node.given_std : constants.walking * (1.0 - one->share) * recording_.dt;
      pairs.push_back({&node, std, relative[0], relative[1], at[0], at[1]});
      ahead += relative[0], left += relative[1], x += at[0], y += at[1];
    }
    const double n = static_cast<double>(pairs.size());
    if (n < 2.0) return false;
    ahead /= n, left /= n, x /= n, y /= n;
    double same = 0.0, cross = 0.0;
    for (const Pair& p : pairs) {
      same += (p.ahead - ahead) * (p.x - x) + (p.left - left) * (p.y - y);
      cross += (p.ahead - ahead) * (p.y - y) - (p.left - left) * (p.x - x);
    }
    const double yaw = elementary::atan2(cross, same), c = elementary::cos(yaw), s = elementary::sin(yaw);
    const std::array<double, kFrame> fit{x - c * ahead + s * left, y - s * ahead - c * left, yaw, 0.0, 0.0};
    const auto contradiction = [&](const std::array<double, kFrame>& pose) {
      double sum = 0.0;
      for (const Pair& p : pairs)
        sum += square(wrap(elementary::atan2(p.y - pose[1], p.x - pose[0]) - pose[2] + p.node->box.azimuth) / kTurning);
      return sum;
    };
    if (blind_ <= kBlind && contradiction(frame.at) < kContradiction * n + contradiction(fit)) return false;
    frame.at = fit;
    for (const Pair& p : pairs) {
      p.node->given = true;
      p.node->given_at = {p.x, p.y};
      p.node->given_std = p.std;
    }
    window_.restart();
    ages_.assign(1, age_);
    window_.mode_prior = model_.motion.start;
    behind_ = next_ = Spread{};
    by_odometry_ = {};
    blind_ = unled_ = strayed_ = 0.0;
    cold_ = false;
    index_people();
    return true;
  }

  /// Whether the speeds of camera and people are possible.
  bool is_plausible() const {
    const std::vector<Frame>& frames = window_.frames;
    const int newest = static_cast<int>(frames.size()) - 1;
    if (newest < 1) return true;
    const auto speed = [&](const auto& now, const auto& before) {
      return elementary::hypot(now[0] - before[0], now[1] - before[1]) / recording_.dt;
    };
    if (speed(frames[newest].at, frames[newest - 1].at) > kFastest[recording_.carrier]) return false;
    int people = 0, fast = 0;
    for (const Person& person : window_.people) {
      const int n = person.frames();
      if (person.last() != newest || n < 2) continue;
      ++people;
      fast += speed(person.nodes[n - 1].at, person.nodes[n - 2].at) > kFastestPerson;
    }
    return 2 * fast <= people;
  }

  /// Propagates the Jacobian of the held pose by odometry's scale and turn to `next`, which is held from now on.
  void carry_odometry(const Frame& next) {
    if (next.given) {
      by_odometry_ = {};
      return;
    }
    const Pose held = held_pose();
    const double x = next.at[0] - held[0], y = next.at[1] - held[1], turn = next.at[2] - held[2];
    if (next.motion.measured) {
      by_odometry_[0][0] -= x;
      by_odometry_[1][0] -= y;
      by_odometry_[2][1] -= turn;
    }
    for (int g = 0; g < 2; ++g) {
      by_odometry_[0][g] -= by_odometry_[2][g] * y;
      by_odometry_[1][g] += by_odometry_[2][g] * x;
    }
  }

  /// Covariance of the pose that the window's covariances are relative to.
  Spread behind() const {
    Spread all = behind_;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int g = 0; g < 2; ++g)
          for (int h = 0; h < 2; ++h) all[a][b] += by_odometry_[a][g] * odometry_spread_[g][h] * by_odometry_[b][h];
    for (int a = 0; a < 2; ++a) all[a][a] += astray();
    return all;
  }

  /// Variance in m² of the drift by the common velocity after a cold start. It is not observable, and the estimate
  /// decays within `kFlowTime` (an Ornstein–Uhlenbeck process).
  double astray() const {
    const double t = unled_;
    return strayed_ +
           2.0 * kFlowSpeed * kFlowSpeed * kFlowTime * (t - kFlowTime * (1.0 - elementary::exp(-t / kFlowTime)));
  }

  Person unknown_person(int column) const {
    Person person;
    person.column = column;
    person.variance = variance_;
    person.height_mean = person.log_height = elementary::log(recording_.height_mean);
    person.height_std = height_std_;
    return person;
  }

  /// Boxes of the newest frames go to the people whom they show; adds those whose paths have changed.
  void associate(std::vector<int>& changed) {
    std::vector<Reassignment> found = association_.associate(window_, model_);
    std::vector<int> removed;
    for (const Reassignment& one : found) {
      (one.node > 0 ? changed : removed).push_back(one.from);
      if (one.node > 0) window_.people[one.from] = Association::before(window_.people[one.from], one.node);
    }
    for (Reassignment& one : found) {
      if (one.to < 0) {
        one.path.variance = variance_;
        one.to = static_cast<int>(window_.people.size());
        window_.people.emplace_back();
      }
      window_.people[one.to] = std::move(one.path);
      changed.push_back(one.to);
    }
    std::sort(removed.begin(), removed.end(), std::greater());
    for (const int n : removed) {
      window_.remove(n);
      std::erase(changed, n);
      for (int& p : changed) p -= p > n;
    }
    std::sort(changed.begin(), changed.end());
    changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
    index_people();
  }

  /// Continues a path to a frame at constant velocity.
  static void extend(Person& person, int frame) {
    while (person.last() < frame) {
      Node node;
      const int n = person.frames();
      if (n > 0) node.growth = person.nodes[n - 1].growth;
      if (n > 1) {
        for (int a = 0; a < 2; ++a) node.at[a] = 2.0 * person.nodes[n - 1].at[a] - person.nodes[n - 2].at[a];
      } else if (n == 1) {
        node.at = person.nodes[0].at;
      }
      person.nodes.push_back(node);
    }
  }

  void add_people(const Input& input) {
    const int newest = static_cast<int>(window_.frames.size()) - 1, columns = recording_.columns;
    Frame& frame = window_.frames[newest];
    for (int k = 0; k < columns; ++k) {
      const double* b = input.boxes + 5 * k;
      const bool seen = !std::isnan(b[0]);
      int begin = newest;  // frame of the first given value
      bool given = false;
      for (const GivenValue& value : given_) {
        double share;
        const int t = value.column == k ? frame_at(value.age, share) : -1;
        if (t < 0) continue;
        given = anchored_ = true;
        begin = std::min(begin, share < 1.0 ? t - 1 : t);
      }
      bool between = false;  // a person in sight since the last key frame, whose path goes on
      for (const Between& one : between_) between = between || one.node == k;
      if (!seen && !given && !(between && where_[k] >= 0)) continue;
      Box box;
      if (seen) box = Box::of(b, input.cut[k]);
      const bool is_new = where_[k] < 0;
      if (is_new) {
        where_[k] = static_cast<int>(window_.people.size());
        window_.people.push_back(unknown_person(k));
        window_.people.back().first = begin;
      }
      Person& person = window_.people[where_[k]];
      const int before = person.frames();
      extend(person, newest);
      for (int i = before; i < person.frames(); ++i) {
        person.nodes[i].column = k;
        if (before == 0 && seen) person.nodes[i].at = window_.placed(box, person.log_height, frame);
      }
      if (seen) {
        person.nodes.back().seen = true;
        person.nodes.back().box = box;
      }
      for (const GivenValue& value : given_) {
        double share;
        const int node = (value.column == k ? frame_at(value.age, share) : -1) - person.first;
        if (value.column != k || node < (share < 1.0 ? 1 : 0)) continue;
        const std::array<double, 2> at{value.at[0], value.at[1]};
        if (share == 1.0) {
          Node& here = person.nodes[node];
          here.given = true;
          here.given_at = here.at = at;
          continue;
        }
        person.between.push_back({node, share, false, true, Box(), at});
        for (int i = node - 1; is_new && i <= node; ++i)
          if (!person.nodes[i].given) person.nodes[i].at = at;
      }
      if (person.frames() < 2) continue;
      for (Between one : between_) {
        if (one.node != k) continue;
        one.node = person.frames() - 1;
        person.between.push_back(one);
      }
      std::sort(person.between.begin(), person.between.end(), [](const Between& one, const Between& other) {
        return one.node + one.share < other.node + other.share;
      });
    }
    if (!frame.given && !frame.motion.measured) turn_to_bearings(frame);
    for (const Person& person : window_.people)
      if (person.last() == newest && person.frames() > 1 && person.nodes.back().seen) inform(person, frame);
    for (Person& person : window_.people) {
      for (Node& node : person.nodes)
        if (node.seen) {
          const Frame& camera = window_.frames[person.first + static_cast<int>(&node - person.nodes.data())];
          const double r = elementary::hypot(node.at[0] - camera.at[0], node.at[1] - camera.at[1]);
          node.box.expected = elementary::exp(person.log_height) / std::max(r - window_.calibration.at[kEdge], 0.5);
        }
      for (Between& one : person.between) {
        const Node& node = person.nodes[one.node];
        one.box.expected = node.seen ? node.box.expected : one.box.length;
      }
    }
  }

  /// Updates the variance of people's innovations by expectation maximisation; the crowd's is the prior of each one's.
  void learn_walk() {
    const int frame = static_cast<int>(window_.frames.size()) - 1 - kWalkLate;
    if (frame < 0) return;
    const double keep = elementary::exp(-recording_.dt / kWalkMemory), own = constants.walk_own;
    squares_ *= keep;
    count_ *= keep;
    for (std::size_t p = 0; p < window_.people.size(); ++p) {
      const std::array<double, 2> sum = window_.innovations(model_, p, frame);
      Person& person = window_.people[p];
      person.squares += sum[0];
      person.count += sum[1];
      squares_ += sum[0];
      count_ += sum[1];
    }
    variance_ = (constants.walk_people + squares_) / (constants.walk_people + count_);
    model_.motion.spread = std::sqrt(variance_);
    for (Person& person : window_.people) person.variance = (own * variance_ + person.squares) / (own + person.count);
  }

  /// Sums of the steps of people who walk, by the weights of expectation maximisation.
  struct Walkers {
    double weight = 0.0, speeds = 0.0;           ///< of all
    double aligned = 0.0, cos = 0.0, sin = 0.0;  ///< of those about the axis; cos, sin: of twice the direction

    /// Forgets all but a share.
    void fade(double keep) {
      for (double* sum : {&weight, &speeds, &aligned, &cos, &sin}) *sum *= keep;
    }

    /// Adds the step of a person into a node.
    void add(const Person& person, int node, const VelocityPrior& prior, double dt) {
      const auto &now = person.nodes[node].at, &before = person.nodes[node - 1].at;
      const double vx = (now[0] - before[0]) / dt, vy = (now[1] - before[1]) / dt;
      const double speed = elementary::hypot(vx, vy) + 1e-9, across = prior.normal[0] * vx + prior.normal[1] * vy;
      const Pace here = prior.at(speed, across, dt);
      const double ratio = square(prior.axis_std * prior.walking / prior.walking_std);
      const double about = prior.aligned > 0.0 ? here.across * ratio : here.walk;
      weight += here.walk;
      speeds += here.walk * speed;
      aligned += about;
      cos += about * (vx * vx - vy * vy) / (speed * speed);
      sin += about * 2.0 * vx * vy / (speed * speed);
    }
  };

  /// Updates the mean speed of people who walk, and the axis about which they do, by expectation maximisation.
  void learn_pace(const Window& window, Model& model) const {
    VelocityPrior& pace = model.people.pace;
    const Constants& c = constants;
    const double information = 1.0 / square(c.walking_mean_std), first = c.axis_weight / square(c.walking_std);
    for (int round = 0; round < 3; ++round) {
      Walkers here = gone_;
      here.weight = here.speeds = 0.0;
      for (const Person& person : window.people)
        for (int i = 1; i < person.frames(); ++i) here.add(person, i, pace, recording_.dt);
      pace.walking = (information * c.walking + here.speeds) / (information + here.weight);
      if (here.aligned == 0.0) continue;
      const double axis = 0.5 * elementary::atan2(here.sin, here.cos);
      pace.normal = {-elementary::sin(axis), elementary::cos(axis)};
      pace.aligned = (c.axis_share * first + here.aligned) / (first + here.weight + gone_.weight);
      pace.axis_information = here.aligned * square(c.walking_std / c.axis_std);
    }
  }

  /// Weight in key frames of the prior of the roughness of the camera's motion; the same time at all frame rates.
  double evenness_weight() const { return constants.walk_own * recording_.dt / 0.4; }

  /// Cost of what is learned, by its priors: people's mean speed, their axis and the share of those about it, and the
  /// roughness of the camera's motion.
  double learned_cost(const Model& model) const {
    const VelocityPrior& pace = model.people.pace;
    const double off = (pace.walking - constants.walking) / constants.walking_mean_std, share = constants.axis_share;
    double sum = 0.5 * off * off + 0.5 * elementary::log(1.0 + pace.axis_information * kPi * kPi / 12.0);
    if (pace.aligned > 0.0)
      sum += constants.axis_weight * (share * elementary::log(share / pace.aligned) +
                                      (1.0 - share) * elementary::log((1.0 - share) / (1.0 - pace.aligned)));
    for (const double r : model.motion.roughness)
      sum += 0.5 * evenness_weight() * (2.0 * elementary::log(r) + 1.0 / (r * r) - 1.0);
    return sum;
  }

  /// Updates the noise of boxes by their residuals, corrected for leverage.
  void learn_boxes() {
    const int frame = static_cast<int>(window_.frames.size()) - 1 - NoiseLearner::kLate;
    if (frame < 0) return;
    if (!window_.weigh_learned(model_, frame)) return;
    noise_.learn(window_, model_);
    model_.people.noise = noise_.noise();
  }

  /// After a cold start boxes fit any velocity that all have in common. Those are tried with which a person stands, or
  /// the camera stands or walks ahead. Neighbours walk alike, so the margin grows with the people.
  void try_common_velocities(Solution& solution) {
    const std::vector<Frame>& frames = window_.frames;
    const int newest = static_cast<int>(frames.size()) - 1;
    if (window_.held > 0 || newest < 2) return;
    for (int t = 1; t <= newest; ++t)
      if (frames[t].anchored() || frames[t].motion.measured) return;
    using Step = std::array<double, 2>;  // m in a key frame
    const auto mean_step = [](const auto& now, const auto& before, int count) {
      return Step{(now[0] - before[0]) / count, (now[1] - before[1]) / count};
    };
    const Step camera = mean_step(frames[newest].at, frames[0].at, newest);
    Step ahead{};
    for (const Frame& frame : frames) {
      ahead[0] += elementary::cos(frame.at[2]);
      ahead[1] += elementary::sin(frame.at[2]);
    }
    const double walk = constants.walking * recording_.dt / (elementary::hypot(ahead[0], ahead[1]) + 1e-9);
    const Step walking{camera[0] - walk * ahead[0], camera[1] - walk * ahead[1]};
    std::vector<Step> steps{camera, walking};
    for (const Person& person : window_.people) {
      const int n = person.frames();
      if (person.last() == newest && n > 2)
        steps.push_back(mean_step(person.nodes[n - 1].at, person.nodes[0].at, n - 1));
    }
    const double nats = kSurer + kSurerEach * static_cast<double>(steps.size() - 2);
    Window other = window_;
    Model model = model_;
    double best = INFINITY;
    Step less{}, chosen{};
    for (const Step& step : steps) {
      other.slow_down({step[0] - less[0], step[1] - less[1]});
      less = step;
      learn_pace(other, model);
      const double cost = other.cost(model) + learned_cost(model);
      if (cost < best) chosen = step;
      best = std::min(best, cost);
    }
    other.slow_down({chosen[0] - less[0], chosen[1] - less[1]});
    learn_pace(other, model);
    take_if_better(other, model, solution, nats);
    if (window_.posterior.back()[kStand] < 0.5) return;
    other = window_;  // a camera that walks, minimised without the mode in which it stands
    model = model_;
    other.slow_down(walking);
    other.trial.steps = newest;
    other.trial.out[kStand] = true;
    learn_pace(other, model);
    other.solve(model, kTried, least);
    learn_pace(other, model);
    learn_roughness(other.frames, other.posterior, evenness_weight(), model.motion);
    other.trial = Trial();
    take_if_better(other, model, solution, recording_.carrier == kPerson ? -kWalks : nats);
  }

  /// Solves another window, and takes it with its model if its cost is lower by so many nats.
  void take_if_better(Window& other, const Model& model, Solution& solution, double nats) {
    const Solution found = other.solve(model, rounds, least);
    if (found.cost + learned_cost(model) >= solution.cost + learned_cost(model_) - nats) return;
    window_ = std::move(other);
    solution = found;
    model_.people.pace = model.people.pace;
    model_.motion.roughness = model.motion.roughness;
  }

  /// Tries other hypotheses of the motion mode, which a descent hardly leaves: that a standing camera has moved for a
  /// few frames, and that one faster than people walk is a vehicle's.
  void try_other_modes(Solution& solution) {
    const std::vector<Frame>& frames = window_.frames;
    if (window_.posterior.empty() || frames.back().motion.measured) return;
    const Modes& now = window_.posterior.back();
    const Frame &last = frames.back(), &before = frames[frames.size() - 2];
    const double speed = elementary::hypot(last.at[0] - before.at[0], last.at[1] - before.at[1]) / recording_.dt;
    Trial trial;
    if (now[kStand] > 0.5) {
      trial.steps = kTried;
      trial.out[kStand] = true;
    } else if (driving(now) < 0.5 && speed > model_.people.pace.running && model_.motion.start[kDrive] > 0.0 &&
               !model_.motion.on_foot) {
      trial.steps = size;
      for (int m = 0; m < kModes; ++m) trial.out[m] = EgoMotion::pedestrian(m);
    } else {
      return;
    }
    Window other = window_;
    other.trial = trial;
    other.solve(model_, 2, least);
    other.trial = Trial();
    take_if_better(other, model_, solution, kSurer);
  }

  /// Initialises the yaw by bearings of people at constant velocity: a head may turn further than a descent from the
  /// last yaw converges.
  void turn_to_bearings(Frame& frame) const {
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    double information = 1.0 / (kTurning * kTurning), turn = 0.0;
    for (const Person& person : window_.people) {
      const int n = person.frames();
      if (person.last() != newest || n < 3 || !person.nodes[n - 1].seen || !person.nodes[n - 2].seen) continue;
      const Box& box = person.nodes[n - 1].box;
      const double dx = person.nodes[n - 1].at[0] - frame.at[0], dy = person.nodes[n - 1].at[1] - frame.at[1];
      const double r = elementary::hypot(dx, dy) + 1e-9;
      const double error = elementary::hypot(model_.people.noise.share[0] * box.width, kStrayed / r);
      const double weight = 1.0 / (error * error);
      turn += weight * wrap(elementary::atan2(dy, dx) - frame.at[2] + box.azimuth - window_.calibration.at[kOffset]);
      information += weight;
    }
    frame.at[2] += turn / information;
  }

  /// Adds the information of the newest box of a person who was seen before about the camera's innovation: second
  /// differences of AR(1) errors with the correlation ρ have the variance (6 − 8ρ + 2ρ²) σ².
  void inform(const Person& person, Frame& frame) const {
    const Box& box = person.nodes.back().box;
    const BoxNoise& noise = model_.people.noise;
    const auto second = [&](int cue) {
      const double rho = elementary::exp(-recording_.dt / noise.time[cue]);
      return (6.0 - 8.0 * rho + 2.0 * rho * rho) * noise.share[cue] * noise.share[cue];
    };
    const double r = elementary::exp(person.log_height) / box.length, sigma = model_.people.walk.sigma,
                 px = noise.pixel / box.pixels;
    double walk = sigma * sigma * person.variance;
    const int n = person.frames();
    if (n == 2 && !(person.nodes[0].given && person.nodes[1].given)) {  // at an unknown velocity
      const double step = kFlowSpeed * recording_.dt;
      walk += step * step;
    }
    const double a = 1.0 / (walk + r * r * box.width * box.width * (second(0) + 6.0 * px * px));
    const double b = 1.0 / (walk + r * r * (second(1) + 12.0 * px * px));
    frame.information[0] += 0.5 * (a + b);
    frame.information[1] += 0.5 * (a + b);
    frame.information[2] += a * r * r;
  }

  void answer(Output& output) {
    const Frame& frame = window_.frames.back();
    const int newest = static_cast<int>(window_.frames.size()) - 1;
    for (int c = 0; c < 3; ++c) output.pose[c] = frame.given ? frame.given_pose[c] : frame.at[c];
    output.pose[2] = wrap(output.pose[2]);
    for (const Person& person : window_.people) {
      if (person.column < 0) continue;
      output.heights[person.column] = elementary::exp(person.log_height);
      if (person.last() != newest) continue;
      for (int a = 0; a < 2; ++a) output.positions[2 * person.column + a] = person.nodes.back().at[a];
    }
    if (!recording_.covariances) return;
    if (!window_.is_linearised()) learn();
    Window::Covariances found;
    if (!window_.covariances(model_, newest, true, found)) return;
    odometry_spread_ = found.odometry;
    write_covariances(newest, found, output);
    newest_ = found.pose;
    places_.assign(recording_.columns, {NAN, NAN, NAN});
    for (std::size_t p = 0; p < window_.people.size(); ++p)
      if (window_.people[p].column >= 0) places_[window_.people[p].column] = found.places[p];
    next_ = found.next;
  }

  /// Writes the covariances of a frame: those relative to the held pose, plus that of the held pose.
  void write_covariances(int frame, Window::Covariances& found, Output& output) const {
    const Pose held = held_pose();
    const Spread base = behind();
    const Frame& camera = window_.frames[frame];
    found.pose = sum(carried(base, held, camera.at[0], camera.at[1]), found.pose);
    for (int a = 0; a < 3; ++a) std::copy_n(found.pose[a].begin(), 3, output.pose_covariance + 3 * a);
    for (std::size_t p = 0; p < window_.people.size(); ++p) {
      const Person& person = window_.people[p];
      std::array<double, 3>& place = found.places[p];  // xx, xy, yy
      if (std::isnan(place[0])) continue;
      const Node& node = person.nodes[frame - person.first];
      const Spread carried_along = carried(base, held, node.at[0], node.at[1]);
      place = {place[0] + carried_along[0][0], place[1] + carried_along[0][1], place[2] + carried_along[1][1]};
      if (node.column < 0) continue;
      double* to = output.position_covariances + 4 * node.column;
      to[0] = place[0];
      to[1] = to[2] = place[1];
      to[3] = place[2];
    }
  }

  /// The pose that the window's covariances are relative to.
  Pose held_pose() const {
    const Frame& frame = window_.frames[std::max(0, window_.held - 1)];
    return {frame.at[0], frame.at[1], frame.at[2]};
  }

  /// The covariance `c` of `pose`, propagated to a point or pose at (x, y) that moves rigidly with it.
  static Spread carried(const Spread& c, const Pose& pose, double x, double y) {
    const double j[3][3] = {{1.0, 0.0, pose[1] - y}, {0.0, 1.0, x - pose[0]}, {0.0, 0.0, 1.0}};
    Spread half{}, out{};
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int k = 0; k < 3; ++k) half[a][b] += j[a][k] * c[k][b];
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        for (int k = 0; k < 3; ++k) out[a][b] += half[a][k] * j[b][k];
    return out;
  }
  static Spread sum(Spread a, const Spread& b) {
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) a[i][k] += b[i][k];
    return a;
  }

  Recording recording_;
  Pose moved_{};  ///< since the last key frame, by odometry
  Spread moved_spread_{}, newest_{};
  bool moved_known_ = false, converged_ = true;
  int stride_ = 1;                             ///< frames from one key frame to the next
  std::vector<std::array<double, 3>> places_;  ///< m², covariances in the last key frame by column
  std::array<std::array<double, 2>, 3> by_odometry_{};
  std::array<std::array<double, 2>, 2> odometry_spread_{};
  double unled_ = 0.0;    ///< s since a cold start, or since odometry, in which nothing measured how the camera moves
  double strayed_ = 0.0;  ///< m², variance of the drift before the last odometry
  bool cold_ = false;
  bool anchored_ = false;     ///< a place or odometry was given, which decides the common velocity
  Spread behind_{}, next_{};  ///< covariance of the pose that is held, and of the next one given that
  Model model_;
  Window window_;
  std::vector<int> where_, ages_;
  std::vector<Between> between_;   ///< boxes since the last key frame; `node` is the column
  std::vector<GivenValue> given_;  ///< since the last key frame
  std::vector<int> given_age_;     ///< last frame in which the pose, then the place of each column was given
  double height_std_ = 0.055;
  int age_ = 0;
  bool learned_ = true;
  double blind_ = 0.0;  ///< s for which nobody was in sight
  NoiseLearner noise_;
  Association association_;
  double squares_ = 0.0, count_ = 0.0, variance_ = 1.0;
  Walkers gone_;  ///< steps that have left the window
};

}  // namespace vbbench
