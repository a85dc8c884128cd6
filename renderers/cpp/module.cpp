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
      spheres_.push_back(sphere_around(rows<Point>(vertices), count));
      first_vertex_.push_back(static_cast<Int>(vertices_.size()));
      first_triangle_.push_back(static_cast<Int>(triangles_.size()));
    }
  }

  Meshes meshes() const {
    return {
        vertices_.data(),  normals_.data(),      colours_.data(),        uv_.data(),      layers_.data(), grain_.data(),
        triangles_.data(), first_vertex_.data(), first_triangle_.data(), spheres_.data(), count()};
  }

  /// The number of texture layers that triangles need.
  int layers() const { return layer_count_; }

  /// Which meshes limbs [N] have.
  Array<const int> limbs(const nb::object& mesh) const {
    const auto found = array<const int>(mesh, "mesh", {kAny});
    check_within(found, 0, count(), "mesh");
    return found;
  }

  nb::object spheres() const {
    New<float> found({spheres_.size(), 4});
    if (!spheres_.empty()) std::copy_n(spheres_[0].data(), 4 * spheres_.size(), found.data());
    return found.numpy();
  }

 private:
  Int count() const { return static_cast<Int>(spheres_.size()); }

  template <class Row, class T>
  static void append(std::vector<Row>& all, const Array<const T>& more) {
    all.insert(all.end(), rows<Row>(more), rows<Row>(more) + more.shape(0));
  }

  std::vector<Point> vertices_, normals_, colours_;
  std::vector<std::array<float, 2>> uv_;
  std::vector<Corners> triangles_;
  std::vector<int> layers_;
  std::vector<float> grain_;
  std::vector<std::array<float, 4>> spheres_;
  std::vector<Int> first_vertex_{0}, first_triangle_{0};
  int layer_count_ = 0;
};

/// The rays of `vbbench_renderers.views.Rays`.
struct RayArrays {
  Array<const double> side, ahead;
  Rays rays;

  explicit RayArrays(const nb::object& of)
      : side(array_of<const double>(of, "side", {kAny})), ahead(array_of<const double>(of, "ahead", {side.size()})) {
    rays = {side.data(),
            ahead.data(),
            whole(static_cast<Int>(side.size()), "the width of a picture", 1),
            whole(number<Int>(of, "height"), "height", 1),
            number<double>(of, "focal"),
            number<double>(of, "across"),
            number<double>(of, "horizon"),
            number<double>(of, "centre"),
            number<bool>(of, "closed")};
  }
};

/// The looks of `vbbench_renderers.meshes.Limbs`, of N limbs, with the normals of a `Placement`.
struct LookArrays {
  Array<const float> colour, second_colour, gloss, normal;
  Array<const int> pattern;

  LookArrays(const nb::object& of, const nb::object& placement, std::size_t limbs)
      : colour(array_of<const float>(of, "colour", {limbs, 3})),
        second_colour(array_of<const float>(of, "second_colour", {limbs, 3})),
        gloss(array_of<const float>(of, "gloss", {limbs})),
        normal(array_of<const float>(placement, "normal", {limbs, 3, 3})),
        pattern(array_of<const int>(of, "pattern", {limbs})) {}

  Looks looks() const {
    return {rows<Point>(colour), rows<Point>(second_colour), pattern.data(), gloss.data(),
            rows<std::array<Point, 3>>(normal)};
  }
};

/// Texture layers [L, S, S, 3] at every size, and the linear value of each byte.
class TextureArrays {
 public:
  TextureArrays(const nb::list& sizes, const nb::object& linear)
      : linear_(array<const float>(linear, "linear", {256})) {
    for (const nb::handle size : sizes) {
      levels_.push_back(array<const std::uint8_t>(nb::borrow(size), "sizes", {kAny, kAny, kAny, 3}));
      const auto& level = levels_.back();
      if (level.shape(0) != levels_[0].shape(0) || level.shape(1) != level.shape(2) || !level.size())
        refuse("sizes must have squares of the same layers");
      views_.push_back({rows<Texel>(level), static_cast<Int>(level.shape(1))});
    }
    if (views_.empty()) refuse("sizes must have a size");
  }

  Textures textures(int layers) const {
    if (layers > length(levels_[0])) refuse("sizes must have every layer");
    return {views_.data(), static_cast<Int>(views_.size()), linear_.data()};
  }

 private:
  std::vector<Array<const std::uint8_t>> levels_;
  std::vector<TextureLevel> views_;
  Array<const float> linear_;
};

/// What limbs keep from the sun and, where they are on the ground, from the sky.
class Shadows {
 public:
  Shadows(const Library& meshes, const nb::object& mesh, const nb::object& joined, const nb::object& ground, Int texels,
          Int threads)
      : size_(whole(texels, "texels", 4)),
        heights_(square(size_)),
        highest_(square(blocks(size_))),
        open_(square(size_ / 4), 1.0f) {
    const auto in_mesh = meshes.limbs(mesh);
    const auto in_joined = array<const double>(joined, "joined", {in_mesh.size(), 3, 4});
    const auto in_ground = array<const double>(ground, "ground", {5});
    const int team_size = whole(threads, "threads", 1);
    std::copy_n(in_ground.data(), 5, ground_.begin());
    const nb::gil_scoped_release released;
    Team team(team_size);
    cast(meshes.meshes(), length(in_mesh), in_mesh.data(), rows<Transform>(in_joined), size_, heights_.data(),
         highest_.data(), team);
  }

  void stain(const nb::object& spots) {
    const auto found = array<const double>(spots, "spots", {kAny, 4});
    const auto [x, y, scale, slope_x, slope_y] = ground_;
    renderers::stain(length(found), rows<Spot>(found), x, y, 0.25 * scale, size_ / 4, open_.data());
  }

  ShadowMap map() const {
    const auto [x, y, scale, slope_x, slope_y] = ground_;
    return {{heights_.data(), size_},
            {highest_.data(), blocks(size_)},
            {open_.data(), size_ / 4},
            x,
            y,
            scale,
            slope_x,
            slope_y};
  }

 private:
  static std::size_t square(int side) { return static_cast<std::size_t>(side) * side; }

  int size_;
  std::vector<float> heights_, highest_, open_;
  std::array<double, 5> ground_{};
};

/// The picture of limbs: sRGB, depth and ids.
nb::tuple draw_limbs(const Library& library, const nb::object& limbs, const nb::object& placement,
                     const nb::object& rays, const nb::object& scenery, Int threads) {
  const auto mesh = library.limbs(limbs.attr("mesh"));
  const std::size_t count = mesh.size();
  const LookArrays looks(limbs, placement, count);
  const auto joined = array_of<const double>(placement, "joined", {count, 3, 4});
  const auto side = array_of<const int>(placement, "side", {count});
  const auto order = array_of<const int>(placement, "order", {count});
  const auto owners = array_of<const int>(placement, "owners", {count + 1});
  const auto eye = array_of<const double>(placement, "eye", {3, 4});
  check_within(order, 0, length(mesh), "order");
  const RayArrays in_rays(rays);
  const auto light = array_of<const double>(scenery, "light", {6, 3});
  const Vec* const row = rows<Vec>(light);
  const Light found_light{row[0], row[1], row[2], row[3], row[4], row[5][0]};
  const auto table = array_of<const std::uint8_t>(scenery, "table", {kAny});
  if (table.size() < 2) refuse("table must have two bytes");
  const Textures textures = nb::cast<const TextureArrays&>(scenery.attr("textures")).textures(library.layers());
  const ShadowMap people = nb::cast<const Shadows&>(scenery.attr("people")).map();
  const ShadowMap fixed = nb::cast<const Shadows&>(scenery.attr("fixed")).map();
  const int team_size = whole(threads, "threads", 1);
  const auto height = static_cast<std::size_t>(in_rays.rays.height), width = in_rays.side.size();
  New<std::uint8_t> rgb({height, width, 3});
  New<float> depth({height, width});
  New<int> ids({height, width});
  {
    const nb::gil_scoped_release released;
    Team team(team_size);
    const Meshes meshes = library.meshes();
    const Placed placed = place(meshes, {mesh.data(), mesh.data() + count}, {side.data(), side.data() + count},
                                rows<Transform>(joined), in_rays.rays, team);
    draw({meshes,
          placed,
          looks.looks(),
          in_rays.rays,
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
  nb::class_<Library>(m, "Meshes", "Meshes, joined.")
      .def(nb::init<const nb::sequence&>(), nb::arg("meshes"))
      .def_prop_ro("spheres", &Library::spheres, "Centres and radii.");
  nb::class_<TextureArrays>(m, "Textures", "Layers at every size.")
      .def(nb::init<const nb::list&, const nb::object&>(), nb::arg("sizes"), array_arg("linear"));
  nb::class_<Shadows>(m, "Shadows", "What limbs keep from the sun.")
      .def(nb::init<const Library&, const nb::object&, const nb::object&, const nb::object&, Int, Int>(),
           nb::arg("meshes"), array_arg("mesh"), array_arg("joined"), array_arg("ground"), nb::arg("texels"),
           nb::arg("threads"))
      .def("stain", &Shadows::stain, array_arg("spots"), "Darkens the ground under spots.");
  m.def("draw", &draw_limbs, nb::arg("meshes"), nb::arg("limbs"), nb::arg("placement"), nb::arg("rays"),
        nb::arg("scenery"), nb::arg("threads"), "The picture.");
}
