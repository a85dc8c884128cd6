// Binding of the estimator to Python.
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <stdexcept>
#include <string>

#include "estimator/estimator.hpp"

namespace nb = nanobind;
using namespace vbbench;

using Doubles = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using Ints = nb::ndarray<const int, nb::c_contig, nb::device::cpu>;
using Room = nb::ndarray<double, nb::c_contig, nb::device::cpu>;

NB_MODULE(_core, m) {
  m.doc() = "The estimator in C++.";
  nb::class_<Estimator>(m, "Estimator")
      .def(nb::init<>())
      .def("set", [](Estimator& e, const std::string& name, double v) {
        Constants& c = e.constants;
#define NUMBER(n) if (name == #n) { c.n = v; return; }
        NUMBER(noise_nu) NUMBER(noise_spread) NUMBER(pixel) NUMBER(edge) NUMBER(edge_std) NUMBER(edge_person_std) NUMBER(height_std)
        NUMBER(tilt_std) NUMBER(mount_std) NUMBER(offset_std) NUMBER(sway_std) NUMBER(sway_time) NUMBER(acceleration)
        NUMBER(gait_speed) NUMBER(gait_time) NUMBER(walk_nu) NUMBER(walk_people) NUMBER(first_speed) NUMBER(pace)
        NUMBER(drive_nu) NUMBER(drive_speed) NUMBER(stay)
        NUMBER(noise_share[0]) NUMBER(noise_share[1]) NUMBER(noise_share[2]) NUMBER(noise_time[0]) NUMBER(noise_time[1])
        NUMBER(noise_time[2]) NUMBER(drive[0]) NUMBER(drive[1]) NUMBER(drive[2]) NUMBER(slip[0]) NUMBER(slip[1])
        NUMBER(stand[0]) NUMBER(stand[1]) NUMBER(head_lag[0]) NUMBER(head_lag[1]) NUMBER(head_scale[0])
        NUMBER(head_scale[1]) NUMBER(head_scale[2])
#undef NUMBER
        if (name == "size") { e.size = static_cast<int>(v); return; }
        if (name == "rounds") { e.rounds = static_cast<int>(v); return; }
        if (name == "least") { e.least = v; return; }
        throw std::invalid_argument("no constant is called " + name);
      })
      .def("start", [](Estimator& e, nb::dict facts) {
        Recording r;
        const auto number = [&](const char* name) { return nb::cast<double>(facts[name]); };
        r.dt = number("dt");
        r.height_mean = number("height_mean");
        r.height_std = number("height_std");
        r.pixel_std = number("pixel_std");
        r.box_std = number("box_std");
        r.tilt_std = number("tilt_std");
        r.mount_std = number("mount_height_std");
        r.mount_height = number("mount_height");
        r.columns = nb::cast<int>(facts["columns"]);
        r.known_calibration = nb::cast<bool>(facts["known_calibration"]);
        r.covariances = nb::cast<bool>(facts["covariances"]);
        r.carrier = static_cast<Carrier>(nb::cast<int>(facts["carrier"]));
        e.start(r);
      })
      .def("step",
           [](Estimator& e, Doubles boxes, Ints cut, Doubles poses, Doubles positions, Doubles motion,
              Doubles motion_covariance, Room pose, Room pose_covariance, Room places, Room place_covariances,
              Room heights) {
             Input input{boxes.data(), cut.data(), poses.data(), positions.data(), motion.data(), motion_covariance.data()};
             Output output{pose.data(), pose_covariance.data(), places.data(), place_covariances.data(), heights.data()};
             e.step(input, output);
             return output.converged;
           })
      .def("forget", [](Estimator& e, Ints columns) { e.forget(columns.data(), static_cast<int>(columns.size())); })
      .def("gradient_errors", [](Estimator& e) {
        nb::list out;
        for (double v : e.gradient_errors()) out.append(v);
        return out;
      })
      .def("calibration", [](const Estimator& e) {
        nb::list out;
        for (double v : e.window().calibration.at) out.append(v);
        return out;
      })
      .def("modes", [](const Estimator& e) {
        nb::list out;
        if (!e.window().posterior.empty())
          for (double v : e.window().posterior.back()) out.append(v);
        return out;
      });
}
