// Binding of the estimator to Python. Sizes and types of arrays are checked here; what is wrong is a VbbenchError.
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "estimator/estimator.hpp"
#include "estimator/inspection.hpp"

using namespace vbbench;

namespace vbbench {
void bind_cascade(nb::module_& module);
}  // namespace vbbench

namespace {

constexpr int kSmallestWindow = 4, kLargestWindow = 400;  ///< frames

/// The estimator, and the number of columns K that `start` was given.
struct Core {
  Estimator estimator;
  int columns = -1;

  void set(const std::string& name, double v) {
    if (!std::isfinite(v)) refuse(name + " must be a finite number");
    Constants& c = estimator.constants;
    const std::vector<std::pair<const char*, double*>> numbers{{"noise_nu", &c.noise_nu},
                                                               {"noise_spread", &c.noise_spread},
                                                               {"pixel", &c.pixel},
                                                               {"edge", &c.edge},
                                                               {"edge_std", &c.edge_std},
                                                               {"height_std", &c.height_std},
                                                               {"tilt_std", &c.tilt_std},
                                                               {"mount_std", &c.mount_std},
                                                               {"offset_std", &c.offset_std},
                                                               {"sway_std", &c.sway_std},
                                                               {"sway_time", &c.sway_time},
                                                               {"acceleration", &c.acceleration},
                                                               {"gait_speed", &c.gait_speed},
                                                               {"gait_time", &c.gait_time},
                                                               {"walk_nu", &c.walk_nu},
                                                               {"walk_people", &c.walk_people},
                                                               {"walk_own", &c.walk_own},
                                                               {"pace", &c.pace},
                                                               {"walking", &c.walking},
                                                               {"walking_std", &c.walking_std},
                                                               {"walking_mean_std", &c.walking_mean_std},
                                                               {"axis_std", &c.axis_std},
                                                               {"axis_share", &c.axis_share},
                                                               {"axis_weight", &c.axis_weight},
                                                               {"standing", &c.standing},
                                                               {"standing_weight", &c.standing_weight},
                                                               {"running", &c.running},
                                                               {"running_std", &c.running_std},
                                                               {"curve", &c.curve},
                                                               {"drive_nu", &c.drive_nu},
                                                               {"drive_speed", &c.drive_speed},
                                                               {"stay", &c.stay},
                                                               {"noise_share[0]", &c.noise_share[0]},
                                                               {"noise_share[1]", &c.noise_share[1]},
                                                               {"noise_share[2]", &c.noise_share[2]},
                                                               {"noise_time[0]", &c.noise_time[0]},
                                                               {"noise_time[1]", &c.noise_time[1]},
                                                               {"noise_time[2]", &c.noise_time[2]},
                                                               {"drive[0]", &c.drive[0]},
                                                               {"drive[1]", &c.drive[1]},
                                                               {"drive[2]", &c.drive[2]},
                                                               {"slip[0]", &c.slip[0]},
                                                               {"slip[1]", &c.slip[1]},
                                                               {"stand[0]", &c.stand[0]},
                                                               {"stand[1]", &c.stand[1]},
                                                               {"head_lag[0]", &c.head_lag[0]},
                                                               {"head_lag[1]", &c.head_lag[1]},
                                                               {"head_scale[0]", &c.head_scale[0]},
                                                               {"head_scale[1]", &c.head_scale[1]},
                                                               {"head_scale[2]", &c.head_scale[2]}};
    for (const auto& [known, number] : numbers) {
      if (name != known) continue;
      *number = v;
      return;
    }
    if (name == "size") {
      if (v < kSmallestWindow || v > kLargestWindow)
        refuse("size must be from " + std::to_string(kSmallestWindow) + " to " + std::to_string(kLargestWindow) +
               " frames");
      estimator.size = static_cast<int>(v);
      return;
    }
    if (name == "rounds") {
      if (v < 1 || v > 1000) refuse("rounds must be from 1 to 1000");
      estimator.rounds = static_cast<int>(v);
      return;
    }
    if (name == "least") {
      estimator.least = v;
      return;
    }
    refuse("no constant is called " + name);
  }

  template <class T>
  static T fact(const nb::dict& facts, const char* name) {
    T value{};
    if (!facts.contains(name)) refuse(std::string(name) + " is missing");
    if (!nb::try_cast<T>(facts[name], value)) refuse(std::string(name) + " has the wrong type");
    return value;
  }
  static double number(const nb::dict& facts, const char* name, bool positive) {
    const double value = fact<double>(facts, name);
    if (!std::isfinite(value) || value < 0.0 || (positive && value == 0.0))
      refuse(std::string(name) + " must be a number " + (positive ? "above 0" : "of at least 0"));
    return value;
  }

  void start(const nb::dict& facts) {
    Recording r;
    r.dt = number(facts, "dt", true);
    r.height_mean = number(facts, "height_mean", true);
    r.height_std = number(facts, "height_std", false);
    r.pixel_std = number(facts, "pixel_std", false);
    r.box_std = number(facts, "box_std", false);
    r.tilt_std = number(facts, "tilt_std", false);
    r.mount_std = number(facts, "mount_height_std", false);
    r.mount_height = number(facts, "mount_height", true);
    r.box_edge = fact<double>(facts, "box_edge");
    if (std::isinf(r.box_edge)) refuse("box_edge must be finite, or NaN or negative where it is not known");
    r.columns = fact<int>(facts, "columns");
    if (r.columns < 0) refuse("columns must be at least 0");
    r.known_calibration = fact<bool>(facts, "known_calibration");
    r.covariances = fact<bool>(facts, "covariances");
    const int carrier = fact<int>(facts, "carrier");
    if (carrier < 0 || carrier > 3) refuse("carrier must be from 0 to 3");
    r.carrier = static_cast<Carrier>(carrier);
    estimator.start(r);
    columns = r.columns;
  }

  std::size_t people() const {
    if (columns < 0) refuse("start comes before this");
    return static_cast<std::size_t>(columns);
  }

  bool step(const nb::object& boxes, const nb::object& cut, const nb::object& poses, const nb::object& positions,
            const nb::object& motion, const nb::object& motion_covariance, const nb::object& pose,
            const nb::object& pose_covariance, const nb::object& places, const nb::object& place_covariances,
            const nb::object& heights) {
    const std::size_t k = people();
    const auto in_boxes = array<const double>(boxes, "boxes", Shape{k, 5});
    const auto in_cut = array<const int>(cut, "cut", Shape{k});
    const auto in_poses = array<const double>(poses, "poses", Shape{3, 3});
    const auto in_positions = array<const double>(positions, "positions", Shape{3, k, 2});
    const auto in_motion = array<const double>(motion, "motion", Shape{3});
    const auto in_covariance = array<const double>(motion_covariance, "motion_covariance", Shape{3, 3});
    const auto out_pose = array<double>(pose, "pose", Shape{3});
    const auto out_covariance = array<double>(pose_covariance, "pose_covariance", Shape{3, 3});
    const auto out_places = array<double>(places, "places", Shape{k, 2});
    const auto out_spreads = array<double>(place_covariances, "place_covariances", Shape{k, 2, 2});
    const auto out_heights = array<double>(heights, "heights", Shape{k});
    const Input input{in_boxes.data(),     in_cut.data(),    in_poses.data(),
                      in_positions.data(), in_motion.data(), in_covariance.data()};
    Output output{out_pose.data(), out_covariance.data(), out_places.data(), out_spreads.data(), out_heights.data()};
    estimator.step(input, output);
    return output.converged;
  }

  void smoothed(int frame, const nb::object& pose, const nb::object& pose_covariance, const nb::object& places,
                const nb::object& place_covariances) {
    const std::size_t k = people();
    if (frame < 0 || frame >= static_cast<int>(estimator.ages().size()))
      refuse("frame must be from 0 to " + std::to_string(static_cast<int>(estimator.ages().size()) - 1));
    const auto out_pose = array<double>(pose, "pose", Shape{3});
    const auto out_covariance = array<double>(pose_covariance, "pose_covariance", Shape{3, 3});
    const auto out_places = array<double>(places, "places", Shape{k, 2});
    const auto out_spreads = array<double>(place_covariances, "place_covariances", Shape{k, 2, 2});
    Output output{out_pose.data(), out_covariance.data(), out_places.data(), out_spreads.data(), nullptr};
    estimator.smoothed(frame, output);
  }

  std::vector<int> ages() const { return estimator.ages(); }

  void forget(const nb::object& indices) {
    const std::size_t k = people();
    const auto found = array<const int>(indices, "columns", {kAny});
    for (std::size_t i = 0; i < found.size(); ++i)
      if (found.data()[i] < 0 || found.data()[i] >= static_cast<int>(k))
        refuse("columns must be from 0 to " + std::to_string(static_cast<int>(k) - 1) + ", not " +
               std::to_string(found.data()[i]));
    estimator.forget(found.data(), static_cast<int>(found.size()));
  }

  double cost(const nb::object& step) const {
    people();
    const auto size = static_cast<std::size_t>(DenseColumns(estimator.window()).size());
    std::vector<double> by(size, 0.0);
    if (!step.is_none()) std::copy_n(array<const double>(step, "step", Shape{size}).data(), size, by.begin());
    return cost_after(estimator.window(), estimator.model(), by.data());
  }

  nb::bytes state() {
    Writer writer;
    writer(columns);
    estimator.archive(writer);
    return nb::bytes(writer.bytes.data(), writer.bytes.size());
  }

  void restore(const nb::bytes& bytes) {
    new (this) Core();
    Reader reader(bytes.c_str(), bytes.size());
    reader(columns);
    estimator.archive(reader);
    if (!reader.good()) refuse("the state is not that of an estimator of this version");
  }

  nb::dict linear_system() const {
    people();
    Window window = estimator.window();
    window.cost(estimator.model());
    DenseSystem system = dense_system(window, estimator.model());
    const std::size_t rows = system.residuals.size(), n = static_cast<std::size_t>(system.size);
    nb::dict out;
    out["residuals"] = numpy(std::move(system.residuals), {rows});
    out["weights"] = numpy(std::move(system.weights), {rows});
    out["jacobian"] = numpy(std::move(system.jacobian), {rows, n});
    out["information"] = numpy(std::move(system.information), {n, n});
    out["gradient"] = numpy(std::move(system.gradient), {n});
    out["free"] = numpy(std::move(system.free), {n});
    return out;
  }

  nb::object eliminated_step() const {
    people();
    std::vector<double> step = vbbench::eliminated_step(estimator.window(), estimator.model());
    const std::size_t n = step.size();
    return numpy(std::move(step), {n});
  }

  std::vector<double> calibration() const {
    const auto& at = estimator.window().calibration.at;
    return {at.begin(), at.end()};
  }

  std::vector<double> modes() const {
    const auto& posterior = estimator.window().posterior;
    if (posterior.empty()) return {};
    return {posterior.back().begin(), posterior.back().end()};
  }
};

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The solvers' parts in C++.";
  bind_cascade(m);
  nb::class_<Core>(m, "Estimator",
                   "Sliding-window maximum a posteriori estimate of poses, calibration and people's paths.")
      .def(nb::init<>())
      .def("set", &Core::set, nb::arg("name"), nb::arg("value"), "Sets one of the constants, or size, rounds or least.")
      .def("start", &Core::start, nb::arg("facts"), "Begins a recording.")
      .def("step", &Core::step, array_arg("boxes"), array_arg("cut"), array_arg("poses"), array_arg("positions"),
           array_arg("motion"), array_arg("motion_covariance"), array_arg("pose"), array_arg("pose_covariance"),
           array_arg("places"), array_arg("place_covariances"), array_arg("heights"),
           "Takes a frame's boxes and what is given of it, and writes its estimate into the last five arrays.")
      .def("smoothed", &Core::smoothed, nb::arg("frame"), array_arg("pose"), array_arg("pose_covariance"),
           array_arg("places"), array_arg("place_covariances"),
           "Writes the estimate of a frame of the window, by all boxes so far, into the last four arrays.")
      .def("ages", &Core::ages, "Frames since the start of those in the window.")
      .def("forget", &Core::forget, array_arg("columns"), "From the next frame on these columns are new people.")
      .def("__getstate__", &Core::state, "The state as bytes.")
      .def("__setstate__", &Core::restore, nb::arg("state"), "Makes an estimator of the state.")
      .def("cost", &Core::cost, nb::arg("step") = nb::none(),
           "Negative log posterior of the window, or of its state after a step, up to a constant.")
      .def("linear_system", &Core::linear_system, "The window's rows and Gaussian priors, dense.")
      .def("eliminated_step", &Core::eliminated_step, "The undamped Gauss-Newton step of the window, by elimination.")
      .def("calibration", &Core::calibration, "The seven numbers of the shared calibration.")
      .def("modes", &Core::modes, "Posterior of the motion modes in the newest step.");
}
