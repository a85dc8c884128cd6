// How textures are read: layers that are pre-filtered at successively halved sizes.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "../meshes.hpp"

namespace vbbench::renderers {

/// L layers of S x S texels at every size S, S/2 … 1.
struct Textures {
  const std::array<std::uint8_t, 3>* texels;  ///< [sum of L S²] sRGB; size after size, layer after layer, row after row
  const Int *first, *size;                    ///< [levels] where each size begins, and S of each
  const float* linear;                        ///< [256] linear value of an sRGB byte
  Int levels;

  /// The linear colour of a layer at (u, v), bilinear; row 0 of a layer is at v = 0.
  ///
  /// `spread` is what a pixel covers, in texture widths; the size is taken whose texels come nearest to it.
  Vec read(int layer, double u, double v, double spread) const {
    Int level = 0;
    for (double covered = spread * static_cast<double>(size[0]); covered > 1.5 && level < levels - 1; covered *= 0.5)
      ++level;
    const Int s = size[level];
    const double x = (u - std::floor(u)) * static_cast<double>(s) - 0.5;
    const double y = (v - std::floor(v)) * static_cast<double>(s) - 0.5;
    const double left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
    const Int columns[2]{wrapped(left, s), wrapped(left + 1.0, s)}, rows[2]{wrapped(top, s), wrapped(top + 1.0, s)};
    const auto* texel = texels + first[level] + layer * s * s;
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

}  // namespace vbbench::renderers
