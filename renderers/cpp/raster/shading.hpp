// Colours of the surfaces in the z-buffer, once per pixel; and textures, pre-filtered at successively halved sizes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "../meshes.hpp"
#include "clones.hpp"
#include "filling.hpp"
#include "light.hpp"
#include "shadows.hpp"

namespace vbbench::renderers {

/// L layers of S x S texels.
struct TextureLevel {
  const Bytes* texels;  ///< [L, S, S] sRGB
  Int size;             ///< S
};

/// Layers at every size S, S/2 … 1.
struct Textures {
  const TextureLevel* sizes;  ///< [count]
  Int count;
  const float* linear;  ///< [256] linear value of an sRGB byte

  /// The linear colour of a layer at (u, v), bilinear; row 0 of a layer is at v = 0.
  ///
  /// `spread` is what a pixel covers, in texture widths; the size is taken whose texels come nearest to it.
  Vec read(int layer, double u, double v, double spread) const {
    Int level = 0;
    for (double covered = spread * static_cast<double>(sizes[0].size); covered > 1.5 && level < count - 1;
         covered *= 0.5)
      ++level;
    const Int s = sizes[level].size;
    const double x = (u - std::floor(u)) * static_cast<double>(s) - 0.5;
    const double y = (v - std::floor(v)) * static_cast<double>(s) - 0.5;
    const double left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
    const Int columns[2]{wrapped(left, s), wrapped(left + 1.0, s)}, rows[2]{wrapped(top, s), wrapped(top + 1.0, s)};
    const Bytes* texel = sizes[level].texels + layer * s * s;
    const auto &a = texel[rows[0] * s + columns[0]], &b = texel[rows[0] * s + columns[1]];
    const auto &c = texel[rows[1] * s + columns[0]], &d = texel[rows[1] * s + columns[1]];
    const double wa = (1.0 - fx) * (1.0 - fy), wb = fx * (1.0 - fy), wc = (1.0 - fx) * fy, wd = fx * fy;
    Vec colour;
    for (int band = 0; band < 3; ++band)
      colour[band] = wa * linear[a[band]] + wb * linear[b[band]] + wc * linear[c[band]] + wd * linear[d[band]];
    return colour;
  }

 private:
  static Int wrapped(double place, Int size) {
    const Int n = static_cast<Int>(place);
    return n < 0 ? size - 1 : n < size ? n : 0;
  }
};

/// All that a surface's colour follows from.
struct Shading {
  const Meshes& meshes;
  const Placed& placed;
  const Looks& looks;
  const Rays& rays;
  const Eye& eye;
  const Light& light;
  const Textures& textures;
  const ShadowMap &people, &fixed;  ///< what throws shadows
  Encoding encode;
};

/// A normal of a limb's frame in the world.
inline Vec turned(const std::array<Point, 3>& turn, const Vec& normal) {
  Vec world;
  for (int row = 0; row < 3; ++row)
    world[row] = turn[row][0] * normal[0] + turn[row][1] * normal[1] + turn[row][2] * normal[2];
  const double length = std::sqrt(dot(world, world)) + 1e-20;
  return {world[0] / length, world[1] / length, world[2] / length};
}

/// A triangle, which is the same for many pixels of a column.
struct Surface {
  int limb = -1, number = -1;
  Int face = 0;
  Corners corners{};
  std::array<Vec, 3> edges{};

  void become(const Shading& s, int new_limb, int new_number) {
    if (limb == new_limb && number == new_number) return;
    limb = new_limb;
    number = new_number;
    const int part = s.placed.mesh[limb];
    const Point* points = s.placed.points.data() + s.placed.first[limb] - s.meshes.first_vertex[part];
    face = number + s.meshes.first_triangle[part];
    corners = s.meshes.triangles[face];
    const Point &a = points[corners[0]], &b = points[corners[1]], &c = points[corners[2]];
    edges = {cross(b, c), cross(c, a), cross(a, b)};
  }
};

/// Colour of a surface where the ray (x, up, z), `stretch` long, meets it at a depth and at a place in the world.
inline Vec surface_colour(const Shading& s, const Surface& surface, const Vec& ray, double stretch, double depth,
                          const Vec& towards, const Vec& world) {
  const int limb = surface.limb, pattern = s.looks.pattern[limb], layer = s.meshes.layers[surface.face];
  Vec weights{dot(surface.edges[0], ray), dot(surface.edges[1], ray), dot(surface.edges[2], ray)};
  const double total = weights[0] + weights[1] + weights[2];
  for (double& weight : weights) weight /= total;
  Vec normal = blend(s.meshes.normals, surface.corners, weights);  // surroundings are too flat to need more
  if (pattern >= 0) normal = turned(s.looks.normal[limb], normal);
  const double facing = dot(normal, towards);
  if (facing < 0.0 && pattern < 0) normal = {-normal[0], -normal[1], -normal[2]};
  const Point& dye = dye_of(s.looks, limb, s.meshes.vertices, surface.corners, weights);
  Vec albedo = blend(s.meshes.colours, surface.corners, weights);
  for (int band = 0; band < 3; ++band) albedo[band] *= dye[band];
  if (layer >= 0) {
    const double spread =
        depth * stretch * s.meshes.grain[surface.face] / (s.rays.focal * std::sqrt(std::max(std::abs(facing), 0.02)));
    const auto *uv = s.meshes.uv, &a = uv[surface.corners[0]], &b = uv[surface.corners[1]], &c = uv[surface.corners[2]];
    const double u = weights[0] * a[0] + weights[1] * b[0] + weights[2] * c[0];
    const double v = weights[0] * a[1] + weights[1] * b[1] + weights[2] * c[1];
    const Vec paint = s.textures.read(layer, u, v, spread);
    for (int band = 0; band < 3; ++band) albedo[band] *= paint[band];
  }
  double sun = 0.0;
  if (dot(normal, s.light.sun) > 0.0) {
    sun = s.people.sun_at(world, normal, 0.03, 0.03);
    if (sun > 0.0) sun *= s.fixed.sun_at(world, normal, 2.0 / s.fixed.scale, 0.06);
  }
  const Vec colour = lit(s.light, albedo, normal, towards, s.looks.gloss[limb], sun, s.people.sky_at(world));
  return through_air(s.light, colour, depth * stretch);
}

/// Writes the colours of a column.
VBBENCH_WIDE_WHOLE inline void shade_column(const Shading& s, Buffer& buffer, int column) {
  const Rays& rays = s.rays;
  const Eye& eye = s.eye;
  const double x = rays.side[column], z = rays.ahead[column], flat = x * x + z * z;
  Vec level, at;  // the ray's level part, and the eye, in the world
  for (int axis = 0; axis < 3; ++axis) {
    level[axis] = eye[0][axis] * x + eye[2][axis] * z;
    at[axis] = -(eye[0][axis] * eye[0][3] + eye[1][axis] * eye[1][3] + eye[2][axis] * eye[2][3]);
  }
  Surface surface;
  for (int row = 0; row < rays.height; ++row) {
    const Int pixel = buffer.pixel(column, row);
    const double up = (rays.horizon - row) / rays.focal, stretch = std::sqrt(flat + up * up);
    Vec ray, towards;
    for (int axis = 0; axis < 3; ++axis) {
      ray[axis] = level[axis] + eye[1][axis] * up;
      towards[axis] = -ray[axis] / stretch;
    }
    Vec colour;
    if (buffer.nearness[pixel] == 0.0f) {
      colour = sky_colour(s.light, {-towards[0], -towards[1], -towards[2]});
    } else {
      surface.become(s, buffer.limbs[pixel], buffer.faces[pixel]);
      const double depth = 1.0 / buffer.nearness[pixel];
      const Vec world{at[0] + depth * ray[0], at[1] + depth * ray[1], at[2] + depth * ray[2]};
      colour = surface_colour(s, surface, {x, up, z}, stretch, depth, towards, world);
    }
    for (int band = 0; band < 3; ++band) buffer.colours[pixel][band] = s.encode(colour[band]);
  }
}

}  // namespace vbbench::renderers
