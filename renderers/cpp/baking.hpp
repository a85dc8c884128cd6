// Limbs baked into the world: one node per limb would cost pyrender ten times the draw calls.
#pragma once

#include <cmath>

#include "meshes.hpp"

namespace vbbench::renderers {

/// The vertices of all limbs in the world, limb after limb.
struct Baked {
  Point *points, *normals, *colours;  ///< linear RGB
  Corners* triangles;                 ///< rows of points
};

/// Limbs of meshes by their transforms [N] to the world, dyed vertex by vertex.
inline void bake(const Meshes& meshes, Int limbs, const int* mesh, const std::array<std::array<float, 4>, 3>* transform,
                 const Looks& looks, const Baked& baked) {
  Int point = 0, triangle = 0;
  for (Int limb = 0; limb < limbs; ++limb) {
    const auto& turn = transform[limb];
    const Int begin = meshes.first_vertex[mesh[limb]], end = meshes.first_vertex[mesh[limb] + 1];
    const int shift = static_cast<int>(point - begin);
    for (Int row = meshes.first_triangle[mesh[limb]]; row < meshes.first_triangle[mesh[limb] + 1]; ++row, ++triangle)
      for (int corner = 0; corner < 3; ++corner)
        baked.triangles[triangle][corner] = meshes.triangles[row][corner] + shift;
    for (Int vertex = begin; vertex < end; ++vertex, ++point) {
      const int n = static_cast<int>(vertex);
      const Point& dye = dye_of(looks, limb, meshes.vertices, {n, n, n}, {1.0, 0.0, 0.0});
      double length = 0.0;
      for (int row = 0; row < 3; ++row) {
        float place = turn[row][3];
        double normal = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
          place += turn[row][axis] * meshes.vertices[vertex][axis];
          normal += looks.normal[limb][row][axis] * meshes.normals[vertex][axis];
        }
        baked.points[point][row] = place;
        baked.normals[point][row] = static_cast<float>(normal);
        baked.colours[point][row] = dye[row] * meshes.colours[vertex][row];
        length += normal * normal;
      }
      for (float& value : baked.normals[point]) value = static_cast<float>(value / (std::sqrt(length) + 1e-20));
    }
  }
}

}  // namespace vbbench::renderers
