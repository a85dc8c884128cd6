// Binding of the generators' inner loops to Python. Sizes and types of arrays are checked here; what is wrong is a
// VbbenchError.
#include <nanobind/stl/array.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "cuboids.hpp"
#include "elementary.hpp"
#include "lifting.hpp"
#include "observers.hpp"
#include "odometry.hpp"
#include "sights.hpp"
#include "skyline.hpp"
#include "social_force.hpp"
#include "tracking.hpp"

using namespace vbbench;

namespace {

using Int = std::int64_t;

double finite(const nb::dict& numbers, const char* name) {
  double value = 0.0;
  if (!numbers.contains(name) || !nb::try_cast<double>(numbers[name], value) || !std::isfinite(value))
    refuse(std::string(name) + " must be a finite number");
  return value;
}

Int length(const auto& found, std::size_t axis = 0) { return static_cast<Int>(found.shape(axis)); }

void check_indices(const Array<const Int>& found, std::size_t count, const char* name) {
  for (std::size_t n = 0; n < found.size(); ++n)
    if (found.data()[n] < 0 || found.data()[n] >= static_cast<Int>(count))
      refuse(std::string(name) + " must be from 0 to below " + std::to_string(count));
}

nb::object elementary_function(const std::string& name, const nb::object& of, const nb::object& and_of) {
  using Of = double (*)(double, double);
  const std::pair<const char*, Of> known[] = {
      {"exp", [](double a, double) { return elementary::exp(a); }},
      {"log", [](double a, double) { return elementary::log(a); }},
      {"log1p", [](double a, double) { return elementary::log1p(a); }},
      {"sin", [](double a, double) { return elementary::sin(a); }},
      {"cos", [](double a, double) { return elementary::cos(a); }},
      {"atan2", [](double a, double b) { return elementary::atan2(a, b); }},
  };
  const auto x = array<const double>(of, "x", {kAny}), y = array<const double>(and_of, "y", {x.size()});
  for (const auto& [called, function] : known) {
    if (name != called) continue;
    New<double> found({x.size()});
    std::transform(x.data(), x.data() + x.size(), y.data(), found.data(), function);
    return found.numpy();
  }
  refuse("no elementary function is called " + name);
}

// Social force ----------------------------------------------------------------------------------------------------

social_force::Settings settings_of(const nb::dict& numbers) {
  using social_force::Settings;
  const std::pair<const char*, double Settings::*> names[] = {{"relaxation_time", &Settings::relaxation_time},
                                                              {"top_speed", &Settings::top_speed},
                                                              {"arrival_radius", &Settings::arrival_radius},
                                                              {"stop_radius", &Settings::stop_radius},
                                                              {"factor", &Settings::factor},
                                                              {"velocity_weight", &Settings::velocity_weight},
                                                              {"reach", &Settings::reach},
                                                              {"side_sharpness", &Settings::side_sharpness},
                                                              {"brake_sharpness", &Settings::brake_sharpness},
                                                              {"wall_factor", &Settings::wall_factor},
                                                              {"wall_fall_off", &Settings::wall_fall_off},
                                                              {"wall_reach", &Settings::wall_reach},
                                                              {"body_radius", &Settings::body_radius}};
  Settings settings;
  for (const auto& [name, number] : names) settings.*number = finite(numbers, name);
  return settings;
}

void march(const nb::object& states, const nb::object& speeds, const nb::object& goals, const nb::object& walls,
           const nb::dict& numbers, double dt, Int substeps, const nb::object& paths) {
  const auto in_states = array<const double>(states, "states", {4, kAny});
  const std::size_t people = in_states.shape(1);
  const auto in_speeds = array<const double>(speeds, "speeds", {people});
  const auto in_goals = array<const double>(goals, "goals", {people, kAny, 2});
  const auto in_walls = array<const double>(walls, "walls", {kAny, 4});
  const auto out_paths = array<double>(paths, "paths", {kAny, people, 2});
  const int frames = whole(static_cast<Int>(out_paths.shape(0)), "the number of frames", 1);
  social_force::Crowd crowd;
  crowd.people = whole(static_cast<Int>(people), "the number of people", 0);
  crowd.goals_each = whole(static_cast<Int>(in_goals.shape(1)), "the number of goals", 1);
  crowd.states = in_states.data();
  crowd.speeds = in_speeds.data();
  crowd.goals = in_goals.data();
  crowd.walls = {rows<social_force::Wall>(in_walls), in_walls.shape(0)};
  crowd.settings = settings_of(numbers);
  crowd.dt = dt;
  crowd.substeps = whole(substeps, "substeps", 1);
  const nb::gil_scoped_release released;
  social_force::march(crowd, frames, out_paths.data());
}

// Tiers -----------------------------------------------------------------------------------------------------------

nb::tuple sweep(const nb::object& figures, const nb::object& distances, const nb::object& half, const nb::object& top,
                Int columns, double bottom, bool wraps) {
  const auto in_distances = array<const double>(distances, "distances", {kAny, kAny});
  const std::size_t frames = in_distances.shape(0), people = in_distances.shape(1);
  const auto in_figures = array<const double>(figures, "figures", {frames, people, 3});
  const auto in_half = array<const double>(half, "half", {kAny});
  const auto in_top = array<const double>(top, "top", {in_half.size()});
  if (in_half.size() == 0) refuse("half must have a step");
  occlusion::Skyline skyline(whole(columns, "columns", 1), bottom, wraps);
  New<double> visible({frames, people}), boxes({frames, people, 4});
  occlusion::sweep(length(in_distances), length(in_distances, 1), rows<occlusion::Figure>(in_figures),
                   in_distances.data(), {{in_half.data(), in_half.size()}, {in_top.data(), in_top.size()}}, skyline,
                   visible.data(), reinterpret_cast<occlusion::Box*>(boxes.data()));
  return nb::make_tuple(visible.numpy(), boxes.numpy());
}

void link_rows(const nb::object& numbers, double kept, double fresh) {
  const auto found = array<double>(numbers, "numbers", {kAny, kAny});
  double* const all = found.data();
  const std::size_t columns = found.shape(1);
  for (std::size_t n = columns; n < found.size(); ++n) all[n] = kept * all[n - columns] + fresh * all[n];
}

nb::object sights(const nb::object& there, const nb::object& relative, const nb::object& positions,
                  const nb::object& poses, const nb::object& heights, const nb::object& mounts, const nb::object& tilt,
                  const nb::object& amplitudes, const nb::object& phases, const nb::object& waves, double near_edge) {
  const auto in_there = array<const Int>(there, "there", {kAny});
  const auto in_relative = array<const double>(relative, "relative", {kAny, kAny, 2});
  const std::size_t frames = in_relative.shape(0), people = in_relative.shape(1);
  const auto in_positions = array<const double>(positions, "positions", {frames, people, 2});
  const auto in_poses = array<const double>(poses, "poses", {frames, 3});
  const auto in_heights = array<const double>(heights, "heights", {people});
  const auto in_mounts = array<const double>(mounts, "mounts", {frames});
  const auto in_tilt = array<const double>(tilt, "tilt", {4, frames});
  const auto in_amplitudes = array<const double>(amplitudes, "amplitudes", {kAny});
  const auto in_phases = array<const double>(phases, "phases", {in_amplitudes.size()});
  const auto in_waves = array<const double>(waves, "waves", {in_amplitudes.size(), 2});
  check_indices(in_there, frames * people, "there");
  const field::Carriage carriage{
      length(in_relative),
      length(in_relative, 1),
      in_relative.data(),
      in_positions.data(),
      in_poses.data(),
      in_heights.data(),
      in_mounts.data(),
      in_tilt.data(),
      {length(in_amplitudes), in_amplitudes.data(), in_phases.data(), in_waves.data()},
      near_edge,
  };
  New<double> directions({in_there.size(), 2, 3});
  field::sights(carriage, length(in_there), in_there.data(), directions.data());
  return directions.numpy();
}

nb::object project_cuboids(const nb::object& frame, const nb::object& centres, const nb::object& rotations,
                           const nb::object& sizes, const nb::object& turns, const nb::object& shifts,
                           const std::array<double, 4>& intrinsics, bool cylinder, double behind) {
  const auto in_frame = array<const Int>(frame, "frame", {kAny});
  const auto in_centres = array<const double>(centres, "centres", {in_frame.size(), 3});
  const auto in_rotations = array<const double>(rotations, "rotations", {in_frame.size(), 3, 3});
  const auto in_sizes = array<const double>(sizes, "sizes", {in_frame.size(), 3});
  const auto in_turns = array<const double>(turns, "turns", {kAny, 3, 3});
  const auto in_shifts = array<const double>(shifts, "shifts", {in_turns.shape(0), 3});
  check_indices(in_frame, in_turns.shape(0), "frame");
  const cuboids::Scene scene{length(in_frame), in_frame.data(), in_centres.data(), in_rotations.data(),
                             in_sizes.data(),  in_turns.data(), in_shifts.data()};
  const auto [fx, fy, cx, cy] = intrinsics;
  New<double> boxes({in_frame.size(), 4});
  cuboids::project(scene, {fx, fy, cx, cy, cylinder, behind}, reinterpret_cast<cuboids::Box*>(boxes.data()));
  return boxes.numpy();
}

// Tracking --------------------------------------------------------------------------------------------------------

nb::object worths(const nb::object& tracks, const nb::object& detections, const nb::object& scores, double least,
                  double period) {
  const auto in_tracks = array<const double>(tracks, "tracks", {kAny, 4});
  const auto in_detections = array<const double>(detections, "detections", {kAny, 4});
  const auto in_scores = array<const double>(scores, "scores", {in_detections.shape(0)});
  New<double> worth({in_tracks.shape(0), in_detections.shape(0)});
  tracking::worths(length(in_tracks), length(in_detections), rows<tracking::Box>(in_tracks),
                   rows<tracking::Box>(in_detections), in_scores.data(), least, period, worth.data());
  return worth.numpy();
}

nb::object merge_people(const nb::object& boxes, const nb::object& scores, const nb::object& truth,
                        const nb::object& chance, double overlap, double rate, double period) {
  const auto found = array<double>(boxes, "boxes", {kAny, 4});
  const std::size_t count = found.shape(0);
  const auto in_scores = array<double>(scores, "scores", {count});
  const auto in_truth = array<const double>(truth, "true", {count, 4});
  const auto in_chance = array<const double>(chance, "chance", {count});
  New<bool> kept({count});
  tracking::merge_people(length(found), rows<tracking::Box>(found), in_scores.data(), rows<tracking::Box>(in_truth),
                         in_chance.data(), overlap, rate, period, kept.data());
  return kept.numpy();
}

nb::object remaining(const nb::object& boxes, const nb::object& order, double overlap, double period) {
  const auto found = array<const double>(boxes, "boxes", {kAny, 4});
  const auto in_order = array<const Int>(order, "order", {found.shape(0)});
  check_indices(in_order, found.shape(0), "order");
  New<bool> kept({found.shape(0)});
  tracking::remaining(length(found), rows<tracking::Box>(found), in_order.data(), overlap, period, kept.data());
  return kept.numpy();
}

// Views -----------------------------------------------------------------------------------------------------------

nb::tuple look_round(const nb::object& places, const nb::object& crowd, const nb::object& ways, Int wanted,
                     const std::array<double, 4>& limits) {
  const auto in_places = array<const double>(places, "places", {kAny, kAny, 2});
  const std::size_t frames = in_places.shape(0), people = in_places.shape(1);
  const auto in_crowd = array<const bool>(crowd, "crowd", {frames, people});
  const auto in_ways = array<const double>(ways, "ways", {kAny, frames, 3});
  const views::People around{length(in_places), length(in_places, 1), in_places.data(), in_crowd.data()};
  New<Int> runs({in_ways.shape(0), 2});
  New<double> nearest({in_ways.shape(0), frames});
  views::look_round(around, length(in_ways), in_ways.data(), wanted, {limits[0], limits[1], limits[2], limits[3]},
                    runs.data(), nearest.data());
  return nb::make_tuple(runs.numpy(), nearest.numpy());
}

nb::object steer(const nb::object& goals, const nb::object& start, double top_speed, double acceleration,
                 double turn_rate, double turn_time, double lead, double step) {
  const auto in_goals = array<const double>(goals, "goals", {kAny, 2});
  const auto in_start = array<const double>(start, "start", {2});
  New<double> way({in_goals.shape(0), 5});
  views::steer(length(in_goals), in_goals.data(), in_start.data(),
               {top_speed, acceleration, turn_rate, turn_time, lead, step}, way.data());
  return way.numpy();
}

nb::object turn_towards(const nb::object& course, double most) {
  const auto found = array<const double>(course, "course", {kAny});
  New<double> yaws({found.size()});
  views::turn_towards(length(found), found.data(), most, yaws.data());
  return yaws.numpy();
}

// Footage ---------------------------------------------------------------------------------------------------------

nb::tuple filter_readings(const nb::object& times, const nb::object& values, const nb::object& kinds) {
  const auto in_times = array<const double>(times, "times", {kAny});
  const std::size_t count = in_times.size();
  const auto in_values = array<const double>(values, "values", {count});
  const auto in_kinds = array<const Int>(kinds, "kinds", {count});
  check_indices(in_kinds, odometry::kFrame + 1, "kinds");
  const auto frames = static_cast<std::size_t>(
      std::count(in_kinds.data(), in_kinds.data() + count, static_cast<Int>(odometry::kFrame)));
  New<double> poses({frames, 3}), covariances({frames, 3, 3}), motions({frames, 3}), spreads({frames, 3, 3});
  odometry::filter(length(in_times), in_times.data(), in_values.data(), in_kinds.data(),
                   {poses.data(), covariances.data(), motions.data(), spreads.data()});
  return nb::make_tuple(poses.numpy(), covariances.numpy(), motions.numpy(), spreads.numpy());
}

// Lifting ---------------------------------------------------------------------------------------------------------

nb::object smooth(const nb::object& known, const nb::object& noise, const nb::object& starts, double q, double dt) {
  const auto in_known = array<const double>(known, "known", {kAny});
  const auto in_noise = array<const double>(noise, "noise", {in_known.size()});
  const auto in_starts = array<const Int>(starts, "starts", {kAny});
  for (std::size_t k = 0; k + 1 < in_starts.size(); ++k)
    if (in_starts.data()[k] < 0 || in_starts.data()[k + 1] <= in_starts.data()[k] ||
        in_starts.data()[k + 1] > length(in_known))
      refuse("starts must ascend, and end where known ends");
  New<double> smoothed({in_known.size()});
  lifting::Smoother smoother(q, dt);
  for (std::size_t k = 0; k + 1 < in_starts.size(); ++k) {
    const Int first = in_starts.data()[k], count = in_starts.data()[k + 1] - first;
    smoother.smooth(count, in_known.data() + first, in_noise.data() + first, smoothed.data() + first);
  }
  return smoothed.numpy();
}

nb::tuple whiten(const nb::object& value, const nb::object& phi, const nb::object& weight, const nb::object& person,
                 double between) {
  const auto in_value = array<const double>(value, "value", {kAny});
  const std::size_t count = in_value.size();
  const auto in_phi = array<const double>(phi, "phi", {count});
  const auto in_weight = array<const double>(weight, "weight", {count});
  const auto in_person = array<const Int>(person, "person", {count});
  const lifting::Normal normal =
      lifting::whiten(length(in_value), in_value.data(), in_phi.data(), in_weight.data(), in_person.data(), between);
  constexpr std::size_t terms = lifting::kTerms;
  return nb::make_tuple(numpy(std::vector<double>(normal.matrix.begin(), normal.matrix.end()), {terms, terms}),
                        numpy(std::vector<double>(normal.right.begin(), normal.right.end()), {terms}), normal.square,
                        normal.log_determinant);
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The generators' inner loops in C++.";
  m.def("elementary", &elementary_function, nb::arg("name"), array_arg("x"), array_arg("y"),
        "What the function of elementary.hpp called `name` is of x; `atan2` of x and y.");
  m.def("march", &march, array_arg("states"), array_arg("speeds"), array_arg("goals"), array_arg("walls"),
        nb::arg("numbers"), nb::arg("dt"), nb::arg("substeps"), array_arg("paths"), "Walks a crowd, into paths.");
  m.def("sweep", &sweep, array_arg("figures"), array_arg("distances"), array_arg("half"), array_arg("top"),
        nb::arg("columns"), nb::arg("bottom"), nb::arg("wraps"), "What shows of people whom nearer ones hide.");
  m.def("link_rows", &link_rows, array_arg("numbers"), nb::arg("kept"), nb::arg("fresh"),
        "Makes each row depend on the last.");
  m.def("sights", &sights, array_arg("there"), array_arg("relative"), array_arg("positions"), array_arg("poses"),
        array_arg("heights"), array_arg("mounts"), array_arg("tilt"), array_arg("amplitudes"), array_arg("phases"),
        array_arg("waves"), nb::arg("near_edge"), "Directions of a tilted camera to feet and heads.");
  m.def("project_cuboids", &project_cuboids, array_arg("frame"), array_arg("centres"), array_arg("rotations"),
        array_arg("sizes"), array_arg("turns"), array_arg("shifts"), nb::arg("intrinsics"), nb::arg("cylinder"),
        nb::arg("behind"), "Boxes around the corners of cuboids.");
  m.def("worths", &worths, array_arg("tracks"), array_arg("detections"), array_arg("scores"), nb::arg("least"),
        nb::arg("period"), "How much boxes overlap.");
  m.def("merge_people", &merge_people, array_arg("boxes"), array_arg("scores"), array_arg("true"), array_arg("chance"),
        nb::arg("overlap"), nb::arg("rate"), nb::arg("period"), "Pairs become one box.");
  m.def("remaining", &remaining, array_arg("boxes"), array_arg("order"), nb::arg("overlap"), nb::arg("period"),
        "Non-maximum suppression.");
  m.def("look_round", &look_round, array_arg("places"), array_arg("crowd"), array_arg("ways"), nb::arg("wanted"),
        nb::arg("limits"), "What a vehicle sees along ways.");
  m.def("steer", &steer, array_arg("goals"), array_arg("start"), nb::arg("top_speed"), nb::arg("acceleration"),
        nb::arg("turn_rate"), nb::arg("turn_time"), nb::arg("lead"), nb::arg("step"), "A robot's way.");
  m.def("turn_towards", &turn_towards, array_arg("course"), nb::arg("most"), "Yaws of a head.");
  m.def("filter_readings", &filter_readings, array_arg("times"), array_arg("values"), array_arg("kinds"),
        "Where a robot was, from wheels and gyro.");
  m.def("smooth", &smooth, array_arg("known"), array_arg("noise"), array_arg("starts"), nb::arg("q"), nb::arg("dt"),
        "Smooths tracks.");
  m.def("whiten", &whiten, array_arg("value"), array_arg("phi"), array_arg("weight"), array_arg("person"),
        nb::arg("between"), "Normal equations of the harmonics of log speeds.");
}
