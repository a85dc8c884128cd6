// The z-buffer: which triangle is seen through each pixel, and how far away it is.
//
// A triangle with corners a, b, c in eye coordinates is met by the ray d where d·(b×c), d·(c×a) and d·(a×b) are not
// negative; its inverse depth there is their sum over a·(b×c) (Olano and Greer 1997, "Triangle scan conversion using 2D
// homogeneous coordinates"). Nothing has to be clipped, and the same test serves both cameras. In one column it leaves
// an interval of rows. Neighbours share their edges to the last bit: no pixel between them is missed or drawn twice.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "../meshes.hpp"
#include "clones.hpp"
#include "placing.hpp"

namespace vbbench::renderers {

constexpr int kStrip = 32;        ///< columns that one thread draws at a time; the picture does not depend on it
constexpr double kMargin = 1e-2;  ///< columns (px) by which bounds are widened because of rounding

/// Columns from begin to end − 1.
struct Strip {
  int begin, end;
};

/// Whether columns low … high touch a strip.
inline bool reaches(const Span& reach, const Strip& strip, const Rays& rays) {
  const auto [low, high] = reach;
  if (low > high) return false;
  const auto touches = [&](double turn) { return low + turn <= strip.end && high + turn >= strip.begin; };
  return touches(0.0) || (rays.closed && (touches(-rays.width) || touches(rays.width)));
}

/// The columns of a triangle in a closed picture, where an edge takes the shorter way around.
inline Span columns_round(float a, float b, float c, double width) {
  const auto shorter = [&](float apart) {
    return static_cast<double>(apart) - width * std::floor(static_cast<double>(apart) / width + 0.5);
  };
  const double to_b = shorter(b - a), to_c = shorter(c - a), across = shorter(c - b);
  if (std::abs(to_b + across - to_c) > 0.5 * width) return {0.0, width};  // it lies under or over the camera
  return {a + std::min(std::min(0.0, to_b), to_c), a + std::max(std::max(0.0, to_b), to_c)};
}

using Triangle = std::array<Int, 3>;  ///< its corners, rows of points

/// The columns (px) between which a triangle lies; low > high if it is behind the camera.
inline Span face_columns(const Placed& placed, const Triangle& t, const Rays& rays) {
  const auto& columns = placed.columns;
  if (rays.closed) return columns_round(columns[t[0]], columns[t[1]], columns[t[2]], rays.width);
  const std::array<const Point*, 3> points{&placed.points[t[0]], &placed.points[t[1]], &placed.points[t[2]]};
  const auto ahead = [](const Point& point) { return point[2] >= kNear; };
  double low = kInfinity, high = -kInfinity;
  for (int n = 0; n < 3; ++n) {
    const Point &start = *points[n], &stop = *points[(n + 1) % 3];
    if (ahead(start)) {
      low = std::min<double>(low, columns[t[n]]);
      high = std::max<double>(high, columns[t[n]]);
    }
    if (ahead(start) != ahead(stop)) {
      const double share = (kNear - start[2]) / (stop[2] - start[2]);
      const double side = start[0] + share * (stop[0] - start[0]);
      const double column = rays.centre + rays.across * side / kNear;
      low = std::min(low, column);
      high = std::max(high, column);
    }
  }
  return {low, high};
}

/// The normal of the plane through the eye and two points; for (b, a) its exact negative.
inline Vec cross(const Point& a, const Point& b) {
  const double ax = a[0], ay = a[1], az = a[2], bx = b[0], by = b[1], bz = b[2];
  return {ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx};
}

/// Rows from top to bottom − 1 of a triangle in a column, and 1 / depth: its value in row 0 and what each row adds.
struct Rows {
  double top, bottom, level, fall;
};

/// A triangle as columns see it: on the horizon 1 / depth of the ray (x, z) is (across·x + ahead·z) / volume.
class Face {
 public:
  Face(const Placed& placed, const Triangle& t, int side, const Rays& rays) : rays_(rays) {
    const Point &a = placed.points[t[0]], &b = placed.points[t[1]], &c = placed.points[t[2]];
    edges_ = {cross(b, c), cross(c, a), cross(a, b)};
    volume_ = a[0] * edges_[0][0] + a[1] * edges_[0][1] + a[2] * edges_[0][2];
    seen_ = volume_ * side >= 0.0 && volume_ != 0.0;
    if (volume_ < 0.0) {
      for (Vec& edge : edges_) edge = {-edge[0], -edge[1], -edge[2]};
      volume_ = -volume_;
    }
    Vec sum;
    for (int axis = 0; axis < 3; ++axis) sum[axis] = edges_[0][axis] + edges_[1][axis] + edges_[2][axis];
    across_ = sum[0];
    ahead_ = sum[2];
    fall_ = -sum[1] / (rays.focal * volume_);
    for (int n = 0; n < 3; ++n) scales_[n] = rays.focal / edges_[n][1];
  }

  /// Whether it shows the side (0: either) that it was made for.
  bool seen() const { return seen_; }

  Rows rows(int column) const {
    const double x = rays_.side[column], z = rays_.ahead[column];
    Rows rows{0.0, static_cast<double>(rays_.height), 0.0, fall_};
    for (int n = 0; n < 3; ++n) trim(edges_[n][0] * x + edges_[n][2] * z, edges_[n][1], scales_[n], rows);
    rows.level = (across_ * x + ahead_ * z) / volume_ - fall_ * rays_.horizon;
    return rows;
  }

 private:
  /// Cuts rows to those on the inner side of an edge, whose function has the value at the horizon.
  void trim(double value, double up, double scale, Rows& rows) const {
    if (up < 0.0) {
      rows.top = std::max(rows.top, std::ceil(value * scale + rays_.horizon));
    } else if (up > 0.0) {
      rows.bottom = std::min(rows.bottom, std::ceil(value * scale + rays_.horizon));
    } else if (!(value >= 0.0)) {
      rows.bottom = rows.top;
    }
  }

  const Rays& rays_;
  std::array<Vec, 3> edges_;
  Vec scales_;
  double across_, ahead_, volume_, fall_;
  bool seen_;
};

/// What is seen through W x H pixels, column after column.
struct Buffer {
  std::vector<float> nearness;  ///< 1 / depth; 0 where nothing is seen
  std::vector<int> limbs;       ///< N where nothing is seen
  std::vector<int> faces;       ///< triangle within its mesh; anything where nothing is seen
  std::vector<Bytes> colours;   ///< sRGB, before edges are smooth
  int height;

  explicit Buffer(const Rays& rays)
      : nearness(static_cast<std::size_t>(rays.width) * rays.height),
        limbs(nearness.size()),
        faces(nearness.size()),
        colours(nearness.size()),
        height(rays.height) {}

  Int pixel(int column, int row) const { return static_cast<Int>(column) * height + row; }
};

/// Draws limbs into the columns of a strip, fastest when near ones come first in the `order` [N].
VBBENCH_WIDE_WHOLE inline void fill(const Meshes& meshes, const Placed& placed, const int* order, const Rays& rays,
                                    const Strip& strip, Buffer& buffer) {
  const Int from = static_cast<Int>(strip.begin) * rays.height, to = static_cast<Int>(strip.end) * rays.height;
  std::fill(buffer.nearness.begin() + from, buffer.nearness.begin() + to, 0.0f);
  std::fill(buffer.limbs.begin() + from, buffer.limbs.begin() + to, static_cast<int>(placed.count()));
  const auto draw_face = [&](const Face& face, int first, int last, int limb, Int number) {
    for (int column = first; face.seen() && column <= last; ++column) {
      const Rows rows = face.rows(column);
      if (!(rows.top < rows.bottom)) continue;
      const Int start = static_cast<Int>(column) * rays.height;
      for (int row = static_cast<int>(rows.top), bottom = static_cast<int>(rows.bottom); row < bottom; ++row) {
        const float near = static_cast<float>(rows.level + rows.fall * row);
        if (near > buffer.nearness[start + row] && near <= 1.0 / kNear) {
          buffer.nearness[start + row] = near;
          buffer.limbs[start + row] = limb;
          buffer.faces[start + row] = static_cast<int>(number);
        }
      }
    }
  };
  for (Int n = 0; n < placed.count(); ++n) {
    const int limb = order[n];
    if (!reaches(placed.reach[limb], strip, rays)) continue;
    const int part = placed.mesh[limb];
    const Int shift = placed.first[limb] - meshes.first_vertex[part], begin = meshes.first_triangle[part];
    for (Int number = begin; number < meshes.first_triangle[part + 1]; ++number) {
      const Corners& corners = meshes.triangles[number];
      const Triangle triangle{corners[0] + shift, corners[1] + shift, corners[2] + shift};
      const auto [low, high] = face_columns(placed, triangle, rays);
      if (low > high) continue;
      const auto turned = [&](double turn) {
        const int first = static_cast<int>(std::max<double>(std::ceil(low - 0.5 - kMargin) + turn, strip.begin));
        const int last = static_cast<int>(std::min<double>(std::floor(high - 0.5 + kMargin) + turn, strip.end - 1));
        if (first <= last)
          draw_face(Face(placed, triangle, placed.side[limb], rays), first, last, limb, number - begin);
      };
      if (rays.closed) {
        turned(-rays.width);
        turned(rays.width);
      }
      turned(0.0);
    }
  }
}

}  // namespace vbbench::renderers
