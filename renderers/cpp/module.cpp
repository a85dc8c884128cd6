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

/// The meshes of `vbbench_renderers.meshes.Parts`, whose indices are checked once.
class MeshArrays {
 public:
  explicit MeshArrays(const nb::object& of)
      : vertices_(array_of<const float>(of, "vertices", {kAny, 3})),
        normals_(array_of<const float>(of, "normals", {vertices_.shape(0), 3})),
        colours_(array_of<const float>(of, "colours", {vertices_.shape(0), 3})),
        uv_(array_of<const float>(of, "uv", {vertices_.shape(0), 2})),
        triangles_(array_of<const int>(of, "triangles", {kAny, 3})),
        layers_(array_of<const int>(of, "layers", {triangles_.shape(0)})),
        grain_(array_of<const float>(of, "grain", {triangles_.shape(0)})),
        spheres_(array_of<const float>(of, "spheres", {kAny, 4})),
        first_vertex_(array_of<const Int>(of, "first_vertex", {spheres_.shape(0) + 1})),
        first_triangle_(array_of<const Int>(of, "first_triangle", {spheres_.shape(0) + 1})) {
    check_starts(first_vertex_, length(vertices_), "first_vertex");
    check_starts(first_triangle_, length(triangles_), "first_triangle");
    if (length(vertices_) > std::numeric_limits<int>::max()) refuse("vertices must be fewer");
    for (Int part = 0; part < meshes().count; ++part)
      for (Int n = 3 * first_triangle_.data()[part]; n < 3 * first_triangle_.data()[part + 1]; ++n)
        if (triangles_.data()[n] < first_vertex_.data()[part] || triangles_.data()[n] >= first_vertex_.data()[part + 1])
          refuse("triangles must have their corners in their own mesh");
    if (layers_.size()) most_layer_ = *std::max_element(layers_.data(), layers_.data() + layers_.size());
  }

  Meshes meshes() const {
    return {rows<Point>(vertices_),
            rows<Point>(normals_),
            rows<Point>(colours_),
            rows<std::array<float, 2>>(uv_),
            layers_.data(),
            grain_.data(),
            rows<Corners>(triangles_),
            first_vertex_.data(),
            first_triangle_.data(),
            rows<std::array<float, 4>>(spheres_),
            length(spheres_)};
  }

  /// The number of texture layers that triangles need.
  int layers() const { return most_layer_ + 1; }

  /// Which meshes limbs [N] have.
  Array<const int> limbs(const nb::object& mesh) const {
    const auto found = array<const int>(mesh, "mesh", {kAny});
    check_within(found, 0, length(spheres_), "mesh");
    return found;
  }

 private:
  static void check_starts(const Array<const Int>& starts, Int end, const char* name) {
    const Int* const last = starts.data() + starts.size() - 1;
    if (!std::is_sorted(starts.data(), last + 1) || starts.data()[0] != 0 || *last != end)
      refuse(std::string(name) + " must ascend from 0 to the number of rows");
  }

  Array<const float> vertices_, normals_, colours_, uv_;
  Array<const int> triangles_, layers_;
  Array<const float> grain_, spheres_;
  Array<const Int> first_vertex_, first_triangle_;
  int most_layer_ = -1;
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

/// The looks of `vbbench_renderers.raster.Looks`, of N limbs.
struct LookArrays {
  Array<const float> colour, second_colour, gloss, normal;
  Array<const int> pattern;

  LookArrays(const nb::object& of, std::size_t limbs)
      : colour(array_of<const float>(of, "colour", {limbs, 3})),
        second_colour(array_of<const float>(of, "second_colour", {limbs, 3})),
        gloss(array_of<const float>(of, "gloss", {limbs})),
        normal(array_of<const float>(of, "normal", {limbs, 3, 3})),
        pattern(array_of<const int>(of, "pattern", {limbs})) {}

  Looks looks() const {
    return {rows<Point>(colour), rows<Point>(second_colour), pattern.data(), gloss.data(),
            rows<std::array<Point, 3>>(normal)};
  }
};

/// The textures of `vbbench_renderers.raster.Textures`.
struct TextureArrays {
  Array<const std::uint8_t> texels;
  Array<const Int> first, size;
  Array<const float> linear;
  Textures textures;

  TextureArrays(const nb::object& of, int layers)
      : texels(array_of<const std::uint8_t>(of, "texels", {kAny, 3})),
        first(array_of<const Int>(of, "first", {kAny})),
        size(array_of<const Int>(of, "size", {first.size()})),
        linear(array_of<const float>(of, "linear", {256})) {
    for (std::size_t level = 0; level < first.size(); ++level) {
      const Int width = size.data()[level], start = first.data()[level];
      if (width < 1 || start < 0 || start + layers * width * width > length(texels))
        refuse("texels must have every layer of every size");
    }
    if (first.size() == 0) refuse("first must have a size");
    textures = {rows<std::array<std::uint8_t, 3>>(texels), first.data(), size.data(), linear.data(),
                static_cast<Int>(first.size())};
  }
};

/// The map of `vbbench_renderers.raster.ShadowMap`.
struct ShadowArrays {
  Array<const float> heights, highest, open;
  ShadowMap map;

  explicit ShadowArrays(const nb::object& of)
      : heights(square(of, "heights")), highest(square(of, "highest")), open(square(of, "open")) {
    const int size = static_cast<int>(heights.shape(0)), coarse = static_cast<int>(highest.shape(0));
    if (coarse != blocks(size)) refuse("highest must have a number for each block of heights");
    map = {{heights.data(), size},        {highest.data(), coarse},     {open.data(), static_cast<int>(open.shape(0))},
           number<double>(of, "x"),       number<double>(of, "y"),      number<double>(of, "scale"),
           number<double>(of, "slope_x"), number<double>(of, "slope_y")};
  }

  static Array<const float> square(const nb::object& of, const char* name) {
    const auto found = array_of<const float>(of, name, {kAny, kAny});
    if (found.shape(0) != found.shape(1)) refuse(std::string(name) + " must be a square");
    return found;
  }
};

Light light_of(const nb::object& light) {
  const auto found = array<const double>(light, "light", {6, 3});
  const Vec* const row = rows<Vec>(found);
  return {row[0], row[1], row[2], row[3], row[4], row[5][0]};
}

struct EncodingArray {
  Array<const std::uint8_t> bytes;
  explicit EncodingArray(const nb::object& table) : bytes(array<const std::uint8_t>(table, "table", {kAny})) {
    if (bytes.size() < 2) refuse("table must have two bytes");
  }
  Encoding encode() const { return {bytes.data(), static_cast<int>(bytes.size()) - 1}; }
};

/// Limbs as a camera sees them.
class Frame {
 public:
  Frame(const MeshArrays& meshes, const nb::object& mesh, const nb::object& joined, const nb::object& side,
        const nb::object& rays, Int threads)
      : meshes_(meshes), rays_(rays), threads_(whole(threads, "threads", 1)) {
    const auto in_mesh = meshes.limbs(mesh);
    const auto in_joined = array<const double>(joined, "joined", {in_mesh.size(), 3, 4});
    const auto in_side = array<const int>(side, "side", {in_mesh.size()});
    std::vector<int> which(in_mesh.data(), in_mesh.data() + in_mesh.size());
    std::vector<int> sides(in_side.data(), in_side.data() + in_side.size());
    const nb::gil_scoped_release released;
    Team team(threads_);
    placed_ = place(meshes.meshes(), std::move(which), std::move(sides), rows<Transform>(in_joined), rays_.rays, team);
  }

  nb::tuple draw(const nb::object& order, const nb::object& looks, const nb::object& eye, const nb::object& light,
                 const nb::object& textures, const nb::object& people, const nb::object& fixed, const nb::object& table,
                 const nb::object& owners) const {
    const std::size_t limbs = placed_.mesh.size();
    const auto in_order = array<const int>(order, "order", {limbs});
    check_within(in_order, 0, placed_.count(), "order");
    const LookArrays in_looks(looks, limbs);
    const auto in_eye = array<const double>(eye, "eye", {3, 4});
    const TextureArrays in_textures(textures, meshes_.layers());
    const ShadowArrays in_people(people), in_fixed(fixed);
    const EncodingArray encoding(table);
    const auto in_owners = array<const int>(owners, "owners", {limbs + 1});
    const Rays& rays = rays_.rays;
    const Meshes meshes = meshes_.meshes();
    const Looks found_looks = in_looks.looks();
    const Light found_light = light_of(light);
    const auto height = static_cast<std::size_t>(rays.height), width = static_cast<std::size_t>(rays.width);
    New<std::uint8_t> rgb({height, width, 3});
    New<float> depth({height, width});
    New<int> ids({height, width});
    {
      const nb::gil_scoped_release released;
      Team team(threads_);
      renderers::draw({meshes, placed_, found_looks, rays, *rows<Eye>(in_eye), found_light, in_textures.textures,
                       in_people.map, in_fixed.map, encoding.encode()},
                      in_order.data(), in_owners.data(), {rgb.data(), depth.data(), ids.data()}, team);
    }
    return nb::make_tuple(rgb.numpy(), depth.numpy(), ids.numpy());
  }

 private:
  const MeshArrays& meshes_;
  RayArrays rays_;
  int threads_;
  Placed placed_;
};

nb::tuple shadow_heights(const MeshArrays& meshes, const nb::object& mesh, const nb::object& joined, Int texels,
                         Int threads) {
  const auto in_mesh = meshes.limbs(mesh);
  const auto in_joined = array<const double>(joined, "joined", {in_mesh.size(), 3, 4});
  const int size = whole(texels, "texels", 1), team_size = whole(threads, "threads", 1);
  const auto side = static_cast<std::size_t>(size), coarse = static_cast<std::size_t>(blocks(size));
  New<float> heights({side, side}), highest({coarse, coarse});
  {
    const nb::gil_scoped_release released;
    Team team(team_size);
    cast(meshes.meshes(), length(in_mesh), in_mesh.data(), rows<Transform>(in_joined), size, heights.data(),
         highest.data(), team);
  }
  return nb::make_tuple(heights.numpy(), highest.numpy());
}

void stain_ground(const nb::object& spots, double x, double y, double scale, const nb::object& openness) {
  const auto in_spots = array<const double>(spots, "spots", {kAny, 4});
  const auto found = array<float>(openness, "openness", {kAny, kAny});
  if (found.shape(0) != found.shape(1)) refuse("openness must be a square");
  stain(length(in_spots), rows<Spot>(in_spots), x, y, scale, static_cast<int>(found.shape(0)), found.data());
}

}  // namespace

NB_MODULE(_core, m) {
  m.doc() = "The renderers' inner loops in C++.";
  m.attr("NEAR") = kNear;
  m.def("available_threads", &available_threads, "How many threads this process may run at the same time.");
  nb::class_<MeshArrays>(m, "Meshes", "Meshes, joined.").def(nb::init<const nb::object&>(), nb::arg("parts"));
  nb::class_<Frame>(m, "Frame", "Limbs as a camera sees them.")
      .def(nb::init<const MeshArrays&, const nb::object&, const nb::object&, const nb::object&, const nb::object&,
                    Int>(),
           nb::arg("meshes"), array_arg("mesh"), array_arg("joined"), array_arg("side"), nb::arg("rays"),
           nb::arg("threads"), nb::keep_alive<1, 2>())
      .def("draw", &Frame::draw, array_arg("order"), nb::arg("looks"), array_arg("eye"), array_arg("light"),
           nb::arg("textures"), nb::arg("people"), nb::arg("fixed"), array_arg("table"), array_arg("owners"),
           "The picture.");
  m.def("shadow_heights", &shadow_heights, nb::arg("meshes"), array_arg("mesh"), array_arg("joined"), nb::arg("texels"),
        nb::arg("threads"), "Heights of limbs along the sun's rays.");
  m.def("stain", &stain_ground, array_arg("spots"), nb::arg("x"), nb::arg("y"), nb::arg("scale"), array_arg("openness"),
        "Darkens the ground under spots.");
}
