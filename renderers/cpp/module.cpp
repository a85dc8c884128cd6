// Binding of the renderers' inner loops to Python. Sizes and types of arrays are checked here; what is wrong is a
// VbbenchError.
#include <nanobind/stl/string.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "binding.hpp"
#include "meshes.hpp"
#include "raster/drawing.hpp"
#include "threads.hpp"

using namespace vbbench;
using namespace vbbench::renderers;

namespace {

/// A number that is an attribute.
template <class T>
T number(const nb::object& of, const char* name) {
  T value{};
  if (!nb::try_cast<T>(of.attr(name), value)) refuse(std::string(name) + " must be a number");
  return value;
}

template <class T>
Array<T> array_of(const nb::object& of, const char* name, const Shape& shape) {
  return array<T>(of.attr(name), name, shape);
}

template <class T>
void check_within(const Array<const T>& found, Int least, Int below, const char* name) {
  const T* const end = found.data() + found.size();
  if (std::any_of(found.data(), end, [&](T n) { return n < least || n >= below; }))
    refuse(std::string(name) + " must be from " + std::to_string(least) + " to below " + std::to_string(below));
}

Int length(const auto& found) { return static_cast<Int>(found.shape(0)); }

/// Several of `vbbench_renderers.meshes.Mesh`, joined.
class Library {
 public:
  explicit Library(const nb::sequence& of) {
    for (const nb::handle item : of) {
      const auto mesh = nb::borrow(item);
      const auto vertices = array_of<const float>(mesh, "vertices", {kAny, 3});
      const std::size_t count = vertices.shape(0), start = vertices_.size();
      const auto normals = array_of<const float>(mesh, "normals", {count, 3});
      const auto colours = array_of<const float>(mesh, "colours", {count, 3});
      const auto uv = array_of<const float>(mesh, "uv", {count, 2});
      const auto layers = array_of<const int>(mesh, "layers", {count});
      const auto triangles = array_of<const int>(mesh, "triangles", {kAny, 3});
      if (count == 0) refuse("vertices must be there");
      if (start + count > static_cast<std::size_t>(std::numeric_limits<int>::max())) refuse("vertices must be fewer");
      check_within(triangles, 0, length(vertices), "triangles");
      append(vertices_, vertices);
      append(normals_, normals);
      append(colours_, colours);
      append(uv_, uv);
      for (std::size_t n = 0; n < triangles.shape(0); ++n) {
        const Corners& corners = rows<Corners>(triangles)[n];
        const int shift = static_cast<int>(start), layer = layers.data()[corners[0]];
        triangles_.push_back({corners[0] + shift, corners[1] + shift, corners[2] + shift});
        layers_.push_back(layer);
        grain_.push_back(grain_of(vertices_.data(), uv_.data(), triangles_.back()));
        layer_count_ = std::max(layer_count_, layer + 1);
      }
      first_vertex_.push_back(static_cast<Int>(vertices_.size()));
      first_triangle_.push_back(static_cast<Int>(triangles_.size()));
    }
  }

  Meshes meshes() const {
    return {vertices_.data(),  normals_.data(),      colours_.data(),       uv_.data(), layers_.data(), grain_.data(),
            triangles_.data(), first_vertex_.data(), first_triangle_.data()};
  }

  /// The number of texture layers that triangles need.
  int layers() const { return layer_count_; }

  /// Which meshes limbs [N] have.
  Array<const int> limbs(const nb::object& mesh) const {
    const auto found = array<const int>(mesh, "mesh", {kAny});
    check_within(found, 0, static_cast<Int>(first_vertex_.size()) - 1, "mesh");
    return found;
  }

 private:
  template <class Row, class T>
  static void append(std::vector<Row>& all, const Array<const T>& more) {
    all.insert(all.end(), rows<Row>(more), rows<Row>(more) + more.shape(0));
  }

  std::vector<Point> vertices_, normals_, colours_;
  std::vector<std::array<float, 2>> uv_;
  std::vector<Corners> triangles_;
  std::vector<int> layers_;
  std::vector<float> grain_;
  std::vector<Int> first_vertex_{0}, first_triangle_{0};
  int layer_count_ = 0;
};

// Structs below point into arrays that the Python objects hold as long as the picture takes.

/// The rays of `vbbench_renderers.views.Rays`.
Rays rays_of(const nb::object& of) {
  const auto side = array_of<const double>(of, "side", {kAny});
  return {side.data(),
          array_of<const double>(of, "ahead", {side.size()}).data(),
          whole(length(side), "the width of a picture", 1),
          whole(number<Int>(of, "height"), "height", 1),
          number<double>(of, "focal"),
          number<double>(of, "across"),
          number<double>(of, "horizon"),
          number<double>(of, "centre"),
          number<bool>(of, "closed")};
}

/// The looks of N `vbbench_renderers.meshes.Limbs`, with the normals of a `Placement`.
Looks looks_of(const nb::object& limbs, const nb::object& placement, std::size_t count) {
  return {rows<Point>(array_of<const float>(limbs, "colour", {count, 3})),
          rows<Point>(array_of<const float>(limbs, "second_colour", {count, 3})),
          array_of<const int>(limbs, "pattern", {count}).data(), array_of<const float>(limbs, "gloss", {count}).data(),
          rows<std::array<Point, 3>>(array_of<const float>(placement, "normal", {count, 3, 3}))};
}

/// Texture layers [L, S, S, 3] at every size, of which the meshes need the first `layers`.
std::vector<TextureLevel> textures_of(const nb::object& of, std::size_t layers) {
  std::vector<TextureLevel> levels;
  for (const nb::handle size : of) {
    const auto level = array<const std::uint8_t>(nb::borrow(size), "textures", {kAny, kAny, kAny, 3});
    if (level.shape(0) < layers || level.shape(1) != level.shape(2) || !level.size())
      refuse("textures must have squares of every layer");
    levels.push_back({rows<Bytes>(level), static_cast<Int>(level.shape(1))});
  }
  if (levels.empty()) refuse("textures must have a size");
  return levels;
}

/// `vbbench_renderers.raster.Shadows`.
ShadowMap shadows_of(const nb::object& of) {
  const auto heights = array_of<const float>(of, "heights", {kAny, kAny});
  const std::size_t size = heights.shape(0);
  array_of<const float>(of, "heights", {size, size});
  const double* const ground = array_of<const double>(of, "ground", {5}).data();
  return {{heights.data(), whole(length(heights), "texels", 4)},
          {array_of<const float>(of, "open", {size / 4, size / 4}).data(), static_cast<int>(size / 4)},
          ground[0],
          ground[1],
          ground[2],
          ground[3],
          ground[4]};
}

/// The heights [S, S] of limbs along the sun's rays, by their transforms to texels.
nb::object cast_shadows(const Library& library, const nb::object& mesh, const nb::object& joined, Int texels,
                        Int threads) {
  const auto in_mesh = library.limbs(mesh);
  const auto in_joined = array<const double>(joined, "joined", {in_mesh.size(), 3, 4});
  const int size = whole(texels, "texels", 4), team_size = whole(threads, "threads", 1);
  const auto side = static_cast<std::size_t>(size);
  New<float> heights({side, side});
  {
    const nb::gil_scoped_release released;
    Team team(team_size);
    cast(library.meshes(), length(in_mesh), in_mesh.data(), rows<Transform>(in_joined), size, heights.data(), team);
  }
  return heights.numpy();
}

/// The picture of limbs: sRGB, depth and ids.
nb::tuple draw_limbs(const Library& library, const nb::object& limbs, const nb::object& placement,
                     const nb::object& rays, const nb::object& scenery, Int threads) {
  const auto mesh = library.limbs(limbs.attr("mesh"));
  const std::size_t count = mesh.size();
  const Looks looks = looks_of(limbs, placement, count);
  const auto joined = array_of<const double>(placement, "joined", {count, 3, 4});
  const auto side = array_of<const int>(placement, "side", {count});
  const auto order = array_of<const int>(placement, "order", {count});
  const auto owners = array_of<const int>(placement, "owners", {count + 1});
  const auto eye = array_of<const double>(placement, "eye", {3, 4});
  check_within(order, 0, length(mesh), "order");
  const Rays found_rays = rays_of(rays);
  const auto light = array_of<const double>(scenery, "light", {6, 3});
  const Vec* const row = rows<Vec>(light);
  const Light found_light{row[0], row[1], row[2], row[3], row[4], row[5][0]};
  const auto table = array_of<const std::uint8_t>(scenery, "table", {kAny});
  if (table.size() < 2) refuse("table must have two bytes");
  const std::vector<TextureLevel> levels = textures_of(scenery.attr("textures"), library.layers());
  const Textures textures{levels.data(), static_cast<Int>(levels.size()),
                          array_of<const float>(scenery, "linear", {256}).data()};
  const ShadowMap people = shadows_of(scenery.attr("people")), fixed = shadows_of(scenery.attr("fixed"));
  const int team_size = whole(threads, "threads", 1);
  const auto height = static_cast<std::size_t>(found_rays.height), width = static_cast<std::size_t>(found_rays.width);
  New<std::uint8_t> rgb({height, width, 3});
  New<float> depth({height, width});
  New<int> ids({height, width});
  {
    const nb::gil_scoped_release released;
    Team team(team_size);
    const Meshes meshes = library.meshes();
    const Placed placed = place(meshes, {mesh.data(), mesh.data() + count}, {side.data(), side.data() + count},
                                rows<Transform>(joined), found_rays, team);
    draw({meshes,
          placed,
          looks,
          found_rays,
          *rows<Eye>(eye),
          found_light,
          textures,
          people,
          fixed,
          {table.data(), static_cast<int>(table.size()) - 1}},
         order.data(), owners.data(), {rgb.data(), depth.data(), ids.data()}, team);
  }
  return nb::make_tuple(rgb.numpy(), depth.numpy(), ids.numpy());
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The renderers' inner loops in C++.";
  m.attr("NEAR") = kNear;
  m.def("available_threads", &available_threads, "How many threads this process may run at the same time.");
  nb::class_<Library>(m, "Meshes", "Meshes, joined.").def(nb::init<const nb::sequence&>(), nb::arg("meshes"));
  m.def("cast_shadows", &cast_shadows, nb::arg("meshes"), array_arg("mesh"), array_arg("joined"), nb::arg("texels"),
        nb::arg("threads"), "Heights along the sun's rays.");
  m.def("draw", &draw_limbs, nb::arg("meshes"), nb::arg("limbs"), nb::arg("placement"), nb::arg("rays"),
        nb::arg("scenery"), nb::arg("threads"), "The picture.");
}
