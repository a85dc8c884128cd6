// Binding of the generators' inner loops to Python. Sizes and types of arrays are checked here; what is wrong is a
// VbbenchError.
#include <nanobind/stl/string.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "social_force/march.hpp"
#include "threads.hpp"

using namespace vbbench;

namespace {

using Int = std::int64_t;

int whole(Int value, const char* name, Int least) {
  if (value < least || value > 1'000'000'000) refuse(std::string(name) + " must be at least " + std::to_string(least));
  return static_cast<int>(value);
}

double finite(const nb::dict& numbers, const char* name) {
  double value = 0.0;
  if (!numbers.contains(name)) refuse(std::string(name) + " is missing");
  if (!nb::try_cast<double>(numbers[name], value) || !std::isfinite(value))
    refuse(std::string(name) + " must be a finite number");
  return value;
}

// Social force ----------------------------------------------------------------------------------------------------

social_force::Settings settings_of(const nb::dict& numbers) {
  using social_force::Settings;
  const std::pair<const char*, double Settings::*> names[] = {{"desired_factor", &Settings::desired_factor},
                                                              {"relaxation_time", &Settings::relaxation_time},
                                                              {"top_speed", &Settings::top_speed},
                                                              {"arrival_radius", &Settings::arrival_radius},
                                                              {"stop_radius", &Settings::stop_radius},
                                                              {"factor", &Settings::factor},
                                                              {"velocity_weight", &Settings::velocity_weight},
                                                              {"reach", &Settings::reach},
                                                              {"side_sharpness", &Settings::side_sharpness},
                                                              {"brake_sharpness", &Settings::brake_sharpness},
                                                              {"fall_off", &Settings::fall_off},
                                                              {"stride_time", &Settings::stride_time},
                                                              {"view_cosine", &Settings::view_cosine},
                                                              {"unseen_weight", &Settings::unseen_weight},
                                                              {"wall_factor", &Settings::wall_factor},
                                                              {"wall_fall_off", &Settings::wall_fall_off},
                                                              {"wall_reach", &Settings::wall_reach},
                                                              {"body_radius", &Settings::body_radius},
                                                              {"cohesion", &Settings::cohesion},
                                                              {"gaze", &Settings::gaze},
                                                              {"separation", &Settings::separation},
                                                              {"personal_space", &Settings::personal_space}};
  Settings settings;
  for (const auto& [name, number] : names) settings.*number = finite(numbers, name);
  const double kind = finite(numbers, "kind");
  if (kind != 0.0 && kind != 1.0 && kind != 2.0) refuse("kind must be 0, 1 or 2");
  settings.kind = static_cast<social_force::Repulsion>(static_cast<int>(kind));
  return settings;
}

std::span<const social_force::Wall> walls_of(const Array<const double>& walls) {
  return {reinterpret_cast<const social_force::Wall*>(walls.data()), walls.shape(0)};
}

void check_scenes(const social_force::Crowds& crowds, std::size_t goals, std::size_t members, std::size_t groups) {
  const auto within = [](Int first, Int last, std::size_t count) {
    return 0 <= first && first <= last && last <= static_cast<Int>(count);
  };
  for (const social_force::Scene& scene : crowds.scenes) {
    const Int people = scene.last - scene.first;
    if (!within(scene.first, scene.last, static_cast<std::size_t>(crowds.people)) || people == 0)
      refuse("scenes must have people who are in states");
    if (!within(scene.first_goal, scene.last_goal, goals) || scene.last_goal - scene.first_goal < people)
      refuse("scenes must have a goal for everybody");
    if (!within(scene.first_group, scene.last_group, groups - 1)) refuse("scenes must have groups that are in groups");
    for (Int g = scene.first_group; g < scene.last_group; ++g) {
      if (!within(crowds.groups[g], crowds.groups[g + 1], members)) refuse("groups must be where members start");
      for (Int m = crowds.groups[g]; m < crowds.groups[g + 1]; ++m)
        if (crowds.members[m] < 0 || crowds.members[m] >= people) refuse("members must be people of their scene");
    }
  }
}

void march(const nb::object& scenes, const nb::object& states, const nb::object& speeds, const nb::object& goals,
           const nb::object& members, const nb::object& groups, const nb::object& walls, const nb::dict& numbers,
           double dt, Int substeps, const nb::object& paths, Int threads, bool large) {
  const auto in_scenes = array<const Int>(scenes, "scenes", {kAny, 6});
  const auto in_states = array<const double>(states, "states", {4, kAny});
  const std::size_t people = in_states.shape(1);
  const auto in_speeds = array<const double>(speeds, "speeds", {people});
  const auto in_goals = array<const double>(goals, "goals", {kAny, 2});
  const auto in_members = array<const Int>(members, "members", {kAny});
  const auto in_groups = array<const Int>(groups, "groups", {kAny});
  const auto in_walls = array<const double>(walls, "walls", {kAny, 4});
  const auto out_paths = array<double>(paths, "paths", {kAny, people, 2});
  const int frames = whole(static_cast<Int>(out_paths.shape(0)), "the number of frames", 1);
  const int team_size = whole(threads, "threads", 1);
  if (in_groups.size() == 0) refuse("groups must end with the number of members");
  social_force::Crowds crowds;
  crowds.scenes = {reinterpret_cast<const social_force::Scene*>(in_scenes.data()), in_scenes.shape(0)};
  crowds.people = static_cast<Int>(people);
  crowds.states = in_states.data();
  crowds.speeds = in_speeds.data();
  crowds.goals = in_goals.data();
  crowds.members = in_members.data();
  crowds.groups = in_groups.data();
  crowds.walls = walls_of(in_walls);
  crowds.settings = settings_of(numbers);
  crowds.dt = dt;
  crowds.substeps = whole(substeps, "substeps", 1);
  check_scenes(crowds, in_goals.shape(0), in_members.size(), in_groups.size());
  const nb::gil_scoped_release released;
  Team team(team_size);
  (large ? social_force::march_large : social_force::march)(crowds, frames, out_paths.data(), team);
}

nb::object row_forces(const nb::object& people, const nb::object& walls, const nb::dict& numbers) {
  const auto rows = array<double>(people, "people", {social_force::People::kRows, kAny});
  const auto in_walls = array<const double>(walls, "walls", {kAny, 4});
  const int count = static_cast<int>(rows.shape(1));
  social_force::Pairs pairs(count);
  social_force::Forces forces(count);
  social_force::add_row_forces({rows.data(), count}, 0, 1, walls_of(in_walls), settings_of(numbers), pairs, forces);
  forces.x.insert(forces.x.end(), forces.y.begin(), forces.y.end());
  return numpy(std::move(forces.x), {2, rows.shape(1)});
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The generators' inner loops in C++.";
  m.def("available_threads", &available_threads, "How many threads this process may run at the same time.");
  m.def("march", &march, array_arg("scenes"), array_arg("states"), array_arg("speeds"), array_arg("goals"),
        array_arg("members"), array_arg("groups"), array_arg("walls"), nb::arg("numbers"), nb::arg("dt"),
        nb::arg("substeps"), array_arg("paths"), nb::arg("threads"), nb::arg("large"), "Walks crowds, into paths.");
  m.def("row_forces", &row_forces, array_arg("people"), array_arg("walls"), nb::arg("numbers"),
        "Forces of others and of walls.");
}
