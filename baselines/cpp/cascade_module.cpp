// Binding of the cascade and of extrapolation. NamedTuples of Python (`Factors`, `Spreads`, …) come as tuples.
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "cascade/ego_motion.hpp"
#include "cascade/factors.hpp"
#include "cascade/people.hpp"

using namespace vbbench;
using namespace vbbench::cascade;

namespace {

using Object = const nb::object&;
using Tuple = const nb::tuple&;

std::size_t rows(int count) { return static_cast<std::size_t>(count); }

const double* read(nb::handle value, const char* name, const Shape& shape) {
  return array<const double>(nb::borrow(value), name, shape).data();
}

/// The length of an array along its first axis; its other axes are `shape`.
int length(nb::handle value, const char* name, Shape shape) {
  shape.insert(shape.begin(), kAny);
  return static_cast<int>(array<const double>(nb::borrow(value), name, shape).shape(0));
}

Pose pose_of(nb::handle value, const char* name) {
  const double* numbers = read(value, name, {3});
  return {numbers[0], numbers[1], numbers[2]};
}

Factors factors_of(Tuple terms) {
  if (terms.size() != 6) refuse("factors must have six terms, not " + std::to_string(terms.size()));
  Factors f;
  f.people = length(terms[3], "factors.std", {});
  const std::size_t k = rows(f.people);
  f.relative = read(terms[0], "factors.relative", {k, 2});
  f.covariance = read(terms[1], "factors.covariance", {k, 3});
  f.expected = read(terms[2], "factors.expected", {k, 2});
  f.std = read(terms[3], "factors.std", {k});
  f.walk = pose_of(terms[4], "factors.walk");
  f.walk_std = nb::cast<double>(terms[5]);
  return f;
}

Sightings sightings_of(Tuple seen, int people) {
  if (seen.size() != 3) refuse("sightings must have three arrays, not " + std::to_string(seen.size()));
  const std::size_t k = rows(people);
  return {read(seen[0], "rays", {k, 2}), read(seen[1], "sideways", {k, 2}), read(seen[2], "stretch", {k})};
}

Spreads spreads_of(Tuple spreads) {
  if (spreads.size() != 4) refuse("spreads must have four numbers, not " + std::to_string(spreads.size()));
  return {nb::cast<double>(spreads[0]), nb::cast<double>(spreads[1]), nb::cast<double>(spreads[2]),
          nb::cast<double>(spreads[3])};
}

/// Edges [E, 2] between so many nodes.
Array<const std::int64_t> edges_of(Object value, int nodes) {
  const auto edges = array<const std::int64_t>(value, "edges", {kAny, 2});
  for (std::size_t i = 0; i < edges.size(); ++i)
    if (edges.data()[i] < 0 || edges.data()[i] >= nodes)
      refuse("edges must be from 0 to " + std::to_string(nodes - 1) + ", not " + std::to_string(edges.data()[i]));
  return edges;
}

CrowdGraph graph_of(Tuple graph, int people) {
  if (graph.size() != 3) refuse("a graph must have three terms, not " + std::to_string(graph.size()));
  const auto edges = edges_of(nb::borrow(graph[0]), people);
  return {edges.data(), static_cast<int>(edges.shape(0)), nb::cast<double>(graph[1]), nb::cast<double>(graph[2])};
}

Choices choices_of(Object energies, Object edges, Object pair) {
  const auto unary = array<const double>(energies, "energies", {kAny, kAny});
  const std::size_t samples = unary.shape(1);
  if (samples == 0) refuse("energies must be of one sample at least");
  const int nodes = static_cast<int>(unary.shape(0));
  const auto links = edges_of(edges, nodes);
  const std::size_t count = links.shape(0);
  return {unary.data(),
          nodes,
          static_cast<int>(samples),
          links.data(),
          read(pair, "pair", {count, samples, samples}),
          static_cast<int>(count)};
}

/// A new array of this shape, into which `write` puts its numbers.
template <class Write>
nb::object written(const Shape& shape, Write write) {
  New<double> made(shape);
  write(made.data());
  return made.numpy();
}

nb::object pose_array(const Pose& pose) { return numpy<double>({pose.begin(), pose.end()}, {3}); }

nb::object covariance_array(const Matrix3& matrix) { return numpy<double>({matrix.begin(), matrix.end()}, {3, 3}); }

nb::tuple measured(Tuple seen, Object heights, Object variances) {
  const int people = length(heights, "heights", {});
  const std::size_t k = rows(people);
  std::vector<double> relative(2 * k), covariance(3 * k);
  measure(sightings_of(seen, people), read(heights, "heights", {k}), read(variances, "variances", {k}), people,
          relative.data(), covariance.data());
  return nb::make_tuple(numpy(std::move(relative), {k, 2}), numpy(std::move(covariance), {k, 3}));
}

void learn_heights(Object mean, Object variance, Object pose, Object positions, Object spread, Tuple seen,
                   double pose_std, double lowest, double highest) {
  const int people = length(mean, "mean", {});
  const std::size_t k = rows(people);
  const Heights heights{array<double>(mean, "mean", {k}).data(), array<double>(variance, "variance", {k}).data()};
  heights.learn(pose_of(pose, "pose"), read(positions, "positions", {k, 2}), read(spread, "spread", {k}),
                sightings_of(seen, people), people, pose_std, lowest, highest);
}

nb::tuple people_continued(Object positions, Object given, Tuple spreads, double kept) {
  const auto places = array<const double>(positions, "positions", {3, kAny, 2});
  const std::size_t k = places.shape(1);
  std::vector<double> expected(2 * k), std(k);
  continue_people(places.data(), array<const bool>(given, "given", {3, k}).data(), static_cast<int>(k),
                  spreads_of(spreads), kept, expected.data(), std.data());
  return nb::make_tuple(numpy(std::move(expected), {k, 2}), numpy(std::move(std), {k}));
}

nb::tuple observer_continued(Object poses, Object given, Tuple spreads, double kept) {
  const bool* known = array<const bool>(given, "given", {3}).data();
  return nb::make_tuple(pose_array(continue_observer(read(poses, "poses", {3, 3}), kept)),
                        spreads_of(spreads).total(known[0], known[1]));
}

nb::object velocities_adapted(Object positions, Object velocities, double radius, double rate) {
  const int people = length(positions, "positions", {2});
  const std::size_t k = rows(people);
  const double *places = read(positions, "positions", {k, 2}), *speeds = read(velocities, "velocities", {k, 2});
  return written({k, 2}, [&](double* out) { adapt_velocities(places, speeds, people, radius, rate, out); });
}

nb::object localised(Object pose, Tuple terms) {
  const Factors factors = factors_of(terms);
  return written({rows(factors.people), 2}, [&](double* out) { localise(pose_of(pose, "pose"), factors, out); });
}

nb::object energies_of_poses(Object poses, Tuple terms, double softness, double facing) {
  const int count = length(poses, "poses", {3});
  const double* where = read(poses, "poses", {kAny, 3});
  return written({rows(count)},
                 [&](double* out) { pose_energies(where, count, factors_of(terms), softness, facing, out); });
}

nb::object covariances_of_positions(Object pose, Object sigma, Tuple terms) {
  const Factors factors = factors_of(terms);
  const double* spread = read(sigma, "sigma", {3, 3});
  return written({rows(factors.people), 2, 2},
                 [&](double* out) { position_covariances(pose_of(pose, "pose"), spread, factors, out); });
}

nb::tuple minimum(Tuple terms, Object pose, double softness, int rounds, double tolerance, double facing) {
  Minimum found = minimise(factors_of(terms), pose_of(pose, "pose"), softness, {rounds, tolerance}, facing);
  const std::size_t k = found.weights.size();
  return nb::make_tuple(pose_array(found.pose), numpy(std::move(found.positions), {k, 2}),
                        numpy(std::move(found.weights), {k}));
}

nb::object linked(Object positions, double reach, int most) {
  if (most < 1) refuse("most must be at least 1");
  const int people = length(positions, "positions", {2});
  auto edges = link(read(positions, "positions", {kAny, 2}), people, reach, most);
  const std::size_t count = edges.size() / 2;
  return numpy(std::move(edges), {count, 2});
}

nb::tuple sampled(double yaw, Object positions, Object weights, Object rays, Tuple terms, double softness, int most,
                  double spacing) {
  if (most < 1 || most % 2 == 0) refuse("most must be odd and at least 1");
  const Factors factors = factors_of(terms);
  const std::size_t k = rows(factors.people), s = rows(most);
  Samples samples = sample_rays(yaw, read(positions, "positions", {k, 2}), read(weights, "weights", {k}),
                                read(rays, "rays", {k, 2}), factors, softness, most, spacing);
  return nb::make_tuple(numpy(std::move(samples.places), {k, s, 2}), numpy(std::move(samples.energies), {k, s}));
}

nb::tuple tabulated(Object places, Object energies, Tuple graph) {
  const auto rows_of_energies = array<const double>(energies, "energies", {kAny, kAny});
  const std::size_t k = rows_of_energies.shape(0), s = rows_of_energies.shape(1);
  Table table = tabulate(read(places, "places", {k, s, 2}), rows_of_energies.data(), static_cast<int>(s),
                         graph_of(graph, static_cast<int>(k)));
  const std::size_t count = table.edges.size() / 2;
  return nb::make_tuple(numpy(std::move(table.edges), {count, 2}), numpy(std::move(table.pair), {count, s, s}));
}

nb::tuple messages_passed(Object energies, Object edges, Object pair, int rounds, double damping, double tolerance) {
  const Choices choices = choices_of(energies, edges, pair);
  int done = 0;
  auto chosen = pass_messages(choices, {rounds, damping, tolerance}, done);
  return nb::make_tuple(numpy(std::move(chosen), {rows(choices.nodes)}), done);
}

nb::object believed(Object energies, Object edges, Object pair, int rounds, double damping, double tolerance) {
  const Choices choices = choices_of(energies, edges, pair);
  return numpy(ray_beliefs(choices, {rounds, damping, tolerance}), {rows(choices.nodes), rows(choices.samples)});
}

nb::object descended(Object pose, Object positions, Tuple terms, double softness, Tuple graph, int rounds,
                     double tolerance) {
  const Factors factors = factors_of(terms);
  const std::size_t k = rows(factors.people);
  return numpy(descend(pose_of(pose, "pose"), read(positions, "positions", {k, 2}), factors, softness,
                       graph_of(graph, factors.people), {rounds, tolerance}),
               {k, 2});
}

}  // namespace

namespace vbbench {

void bind_cascade(nb::module_& m) {
  m.def("measure", &measured, nb::arg("sightings"), array_arg("heights"), array_arg("variances"));
  m.def("learn_heights", &learn_heights, array_arg("mean"), array_arg("variance"), array_arg("pose"),
        array_arg("positions"), array_arg("spread"), nb::arg("sightings"), nb::arg("pose_std"), nb::arg("lowest"),
        nb::arg("highest"));
  m.def("continue_people", &people_continued, array_arg("positions"), array_arg("given"), nb::arg("spreads"),
        nb::arg("kept"));
  m.def("continue_observer", &observer_continued, array_arg("poses"), array_arg("given"), nb::arg("spreads"),
        nb::arg("kept"));
  m.def("adapt_velocities", &velocities_adapted, array_arg("positions"), array_arg("velocities"), nb::arg("radius"),
        nb::arg("rate"));
  m.def(
      "fit_pose", [](Tuple factors, double facing) { return pose_array(fit_pose(factors_of(factors), facing)); },
      nb::arg("factors"), nb::arg("facing") = kVague);
  m.def("localise", &localised, array_arg("pose"), nb::arg("factors"));
  m.def(
      "pose_covariance",
      [](Object pose, Tuple factors, double facing) {
        return covariance_array(pose_covariance(pose_of(pose, "pose"), factors_of(factors), facing));
      },
      array_arg("pose"), nb::arg("factors"), nb::arg("facing") = kVague);
  m.def("position_covariances", &covariances_of_positions, array_arg("pose"), array_arg("sigma"), nb::arg("factors"));
  m.def("minimise", &minimum, nb::arg("factors"), array_arg("pose"), nb::arg("softness"), nb::arg("rounds"),
        nb::arg("tolerance"), nb::arg("facing") = kVague);
  m.def("link", &linked, array_arg("positions"), nb::arg("reach"), nb::arg("most"));
  m.def("potential", &potential, nb::arg("squared"), nb::arg("sigma"));
  m.def("sample_rays", &sampled, nb::arg("yaw"), array_arg("positions"), array_arg("weights"), array_arg("rays"),
        nb::arg("factors"), nb::arg("softness"), nb::arg("most"), nb::arg("spacing"));
  m.def("tabulate", &tabulated, array_arg("places"), array_arg("energies"), nb::arg("graph"));
  m.def("pass_messages", &messages_passed, array_arg("energies"), array_arg("edges"), array_arg("pair"),
        nb::arg("rounds"), nb::arg("damping"), nb::arg("tolerance"));
  m.def("ray_beliefs", &believed, array_arg("energies"), array_arg("edges"), array_arg("pair"), nb::arg("rounds"),
        nb::arg("damping"), nb::arg("tolerance"));
  m.def("descend", &descended, array_arg("pose"), array_arg("positions"), nb::arg("factors"), nb::arg("softness"),
        nb::arg("graph"), nb::arg("rounds"), nb::arg("tolerance"));
  m.def("pose_energies", &energies_of_poses, array_arg("poses"), nb::arg("factors"), nb::arg("softness"),
        nb::arg("facing"));
}

}  // namespace vbbench
