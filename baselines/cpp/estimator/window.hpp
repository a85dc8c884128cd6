// A window of frames with the people in it, and how it is solved: Levenberg–Marquardt on the reduced system.
#pragma once

#include <vector>

#include "elementary.hpp"
#include "factors/camera.hpp"
#include "schur.hpp"

namespace vbbench {

/// The densities of all factors. Within a recording only the noise of boxes and the walk's scale change.
struct Model {
  PeopleModel people;
  EgoMotion motion;
  double sway_memory = 0.0;
};

/// How a solution ended.
struct Solution {
  double cost = 0.0;
  int steps = 0;
};

constexpr double kSurer = 1.0;                              ///< nats by which another hypothesis must be better
constexpr double kLongestStep = 10.0, kLongestWay = 100.0;  ///< m, of poses and places: far away robust costs are flat

/// The frames and people of a sliding window, the cost of their state, and its minimisation.
class Window {
 public:
  std::vector<Frame> frames;
  std::vector<Person> people;
  Calibration calibration;
  Modes mode_prior{};            ///< of the step into frame 1
  std::vector<Modes> posterior;  ///< of the steps into frames 1, 2, …
  int held = 0;
  Trial trial;

  /// −ln of the posterior density, up to a constant.
  double cost(const Model& model);

  /// Minimises the cost in at most `rounds` steps, until the next gain is expected below `least`. Convergence is
  /// linear: the ratio of the last two gains predicts it. With an uncertain calibration, a step reuses the last
  /// factorisation while that converges; the first one, too, if it is `factorised`.
  Solution solve(const Model& model, int rounds, double least, bool factorised = false);

  /// Solves again after a few people have changed, first with the factors of all others.
  Solution solve_changed(const Model& model, int rounds, double least, const std::vector<int>& changed);

  /// Sum of squared innovations of a person's path in a frame, and how many of them the boxes decide (MacKay's γ).
  std::array<double, 2> innovations(const Model& model, std::size_t p, int frame);

  /// Builds the system of a person's own variables at the present camera and calibration, which are held; returns the
  /// cost. What it adds to the `rest` is of these, and not used.
  double linearise_alone(const Person& person, const Model& model, Elimination& alone, Reduced& rest) const;

  /// Computes `Node::growth`, w e² of the walk into each node, at the present state; nodes whose walk is marginalised
  /// keep theirs.
  void weigh_walks(const Model& model) {
    for (Person& person : people) {
      for (Node& node : person.nodes)
        if (!node.walk_absorbed) node.growth = 0.0;
      person_rows(person, frames, calibration, model.people, RowVisitor([&](const Row& row) {
                    if (row.walk) person.nodes[row.node].growth += row.w * row.e * row.e;
                  }),
                  {.boxes = false});
    }
  }

  /// Computes the leverage of each cue of a frame's boxes, w gᵀ H⁻¹ g over all unknowns, at the last linearisation;
  /// false if that failed.
  bool weigh_learned(const Model& model, int frame);

  /// Covariances, given the poses that are held: of a frame's `pose` and its people's places (NaN where absent), and of
  /// the pose that is held `next`.
  struct Covariances {
    using Pose = std::array<std::array<double, 3>, 3>;
    Pose pose{}, next{};
    std::array<std::array<double, 2>, 2> odometry{};  ///< of the scale and turn of odometry
    std::vector<std::array<double, 3>> places;        ///< xx, xy, yy
  };

  /// Computes the covariances of a frame, with the last linearisation if that is `fresh`: the step since then was
  /// small.
  bool covariances(const Model& model, int frame, bool fresh, Covariances& out);

  /// Whether the factors are those of the last step, without damping.
  bool is_linearised() const { return damping_ <= kDamping; }

  /// Marginalises the oldest frame into priors of people and calibration.
  void marginalise(const Model& model);

  /// Subtracts a velocity, in m per frame, from camera and people.
  void slow_down(const std::array<double, 2>& step) {
    for (int a = 0; a < 2; ++a) {
      for (int t = 0; t < static_cast<int>(frames.size()); ++t) frames[t].at[a] -= t * step[a];
      for (Person& person : people)
        for (int i = 0; i < person.frames(); ++i) person.nodes[i].at[a] -= (person.first + i) * step[a];
    }
  }

  /// The place of a person of this log height by a box.
  std::array<double, 2> placed(const Box& box, double log_height, const Frame& frame) const {
    const double r = elementary::exp(log_height) / box.length + calibration.at[kEdge];
    const double angle = frame.at[2] - box.azimuth;
    return {frame.at[0] + r * elementary::cos(angle), frame.at[1] + r * elementary::sin(angle)};
  }

  /// Visits every number that a step changes.
  template <class Visit>
  void each_number(Visit&& visit) {
    for (Frame& frame : frames)
      for (double& value : frame.at) visit(value);
    for (Person& person : people) {
      for (Node& node : person.nodes)
        for (double& value : node.at) visit(value);
      visit(person.log_height);
    }
    for (double& value : calibration.at) visit(value);
  }

  /// Removes a person.
  void remove(int p) {
    people.erase(people.begin() + p);
    if (p < static_cast<int>(eliminations_.size())) eliminations_.erase(eliminations_.begin() + p);
  }

  /// Removes all frames but the newest, and people who are not in it; the calibration's information stays.
  void restart();

  /// Archives the state that remains between two solutions.
  template <class Archive>
  void archive(Archive& a) {
    a(frames), a(people), a(mode_prior), a(posterior), a(held);
    a(calibration.at), a(calibration.free), a(calibration.information), a(calibration.vector), a(calibration.about);
    a(calibration.sway_std);
  }

  /// Takes one step with this damping, whatever becomes of the cost; false if the system is not positive definite.
  bool take_step(const Model& model, double damping) {
    if (!linearise(model, damping)) return false;
    apply();
    return true;
  }

 private:
  /// Visits the rows of a person, and returns their cost with that of the marginal prior.
  template <class Visit>
  double visit_person(const Person& person, const Model& model, Visit&& visit) const;

  /// The cost of motion modes, whose posteriors it computes, and of the camera's rows.
  double camera_cost(const Model& model) {
    mode_costs(frames, model.motion, trial, costs_);
    double sum = mode_posteriors(model.motion, costs_, mode_prior, posterior);
    camera_rows(frames, calibration, model.motion, std::vector<Modes>(frames.size()), model.sway_memory, held,
                [&](const CameraRow& row) { sum += row.cost; });
    return sum;
  }

  void save() {
    saved_.clear();
    each_number([&](double& value) { saved_.push_back(value); });
  }
  void restore() {
    std::size_t i = 0;
    each_number([&](double& value) { value = saved_[i++]; });
  }

  double calibration_cost() const {
    double sum = 0.0;
    for (int a = 0; a < kGlobals; ++a) {
      if (!calibration.free[a]) continue;
      const double off = calibration.at[a] - calibration.about[a];
      sum -= calibration.vector[a] * off;
      for (int b = 0; b < kGlobals; ++b)
        if (calibration.free[b])
          sum += 0.5 * off * calibration.information[a][b] * (calibration.at[b] - calibration.about[b]);
    }
    return sum;
  }

  /// Builds the reduced system and the cost at the present state, and factorises it; false if it is not positive
  /// definite. It keeps what covariances of people in the `kept` newest frames need.
  bool linearise(const Model& model, double damping, int kept = kKept);

  /// Builds the system of a person, and adds its part of the reduced one; returns the person's cost.
  double linearise(const Person& person, const Model& model, const Layout& layout, double damping,
                   Elimination& elimination, Reduced& reduced) const;

  /// Eliminates a person from a reduced system, and adds the person's cost; false as above.
  bool eliminate(std::size_t p, const Model& model, double damping, Reduced& reduced, double& cost);

  void add_calibration(bool hessian_too) {
    for (int a = 0; a < kGlobals; ++a) {
      if (!calibration.free[a]) continue;
      double gradient = calibration.vector[a];
      for (int b = 0; b < kGlobals; ++b) {
        if (!calibration.free[b]) continue;
        gradient -= calibration.information[a][b] * (calibration.at[b] - calibration.about[b]);
        if (hessian_too && b >= a) reduced_.hessian(a, b) += calibration.information[a][b];
      }
      reduced_.gradient(a) += gradient;
    }
  }

  /// The cost and the gradient at the present state, for another step with the factors of the last linearisation. Where
  /// frames are held, people whose own step would gain more than `least` are minimised alone before.
  void differentiate(const Model& model, double least);

  /// The cost of a person at the present state; adds the gradient.
  double differentiate(std::size_t p, const Model& model);

  /// Minimises the cost of a person at the present camera and calibration, until a step gains less than `least`. The
  /// speeds of newcomers converge so slowly that the whole window would wait for them.
  void minimise_alone(Person& person, const Model& model, double least);

  /// Solves for the reduced part of the next step.
  void solve_reduced();

  /// Takes the step of the linearised system. Returns whether it is within `kLongestStep`.
  bool apply();

  /// Moves the information of the factors of node 0 into the person's marginal prior.
  void absorb(Person& person, const Model& model);

  /// Adds to the calibration's prior the information that a person who leaves the window has about it.
  void retire(const Person& person);

  static constexpr double kDamping = 1e-8;  ///< of the diagonal, at least
  static constexpr int kKept = 4;           ///< newest frames of which noise and answers need covariances
  static constexpr double kSlow = 0.3;      ///< ratio of two gains above which the system is factorised again

  Layout layout_;
  Reduced reduced_;
  std::vector<Elimination> eliminations_;
  Elimination alone_;
  std::vector<Modes> costs_;
  std::vector<double> own_, saved_, step_, gradient_;
  double damping_ = INFINITY;  ///< of the last linearisation
  double cost_ = 0.0;          ///< cost at the state of the gradient
  double predicted_ = 0.0;     ///< gain of the next step with the factors of the last linearisation
};

}  // namespace vbbench
