// Large triangles for a panorama, divided until straight edges follow the cylinder.
//
// A straight line that spans an azimuth θ bows from its chord by (v − cy) θ²/8 rows, whatever its distance; so edges
// are halved until they span little. The test looks at nothing but the edge's ends, so that neighbours agree on every
// cut and no cracks open.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "meshes.hpp"

namespace vbbench::renderers {

constexpr int kColumns = 12;  ///< numbers of a vertex, of which the first three are its place
/// Edges span at most this azimuth (rad), 5°: 0.23 px at the border of a picture 480 px high.
constexpr double kWidest = 5.0 * (3.141592653589793 / 180.0);
constexpr int kDeepest = 14;  ///< how often an edge is halved at most

using Vertex = std::array<float, kColumns>;
using BasedVertex = std::array<float, kColumns + 1>;  ///< with the azimuth of a corner of its triangle

/// A camera that turns about: place, heading, and slopes of the picture's borders.
struct View {
  Vec eye;
  double yaw, low, high;
};

class Refiner {
 public:
  /// Room for `most` corners; more are counted, and not written.
  Refiner(const View& view, Int most, BasedVertex* out)
      : view_(view),
        sin_(std::sin(view.yaw)),
        cos_(std::cos(view.yaw)),
        steepest_(std::tan(kWidest)),
        most_(most),
        out_(out) {}

  void refine(const std::array<Vertex, 3>& triangle) {
    waiting_.assign(1, {triangle, 0});
    while (!waiting_.empty()) {
      const Piece piece = waiting_.back();
      waiting_.pop_back();
      if (outside(piece.corners)) continue;
      std::array<double, 3> right, forward;
      for (int c = 0; c < 3; ++c) {
        const double dx = piece.corners[c][0] - view_.eye[0], dy = piece.corners[c][1] - view_.eye[1];
        right[c] = dx * sin_ - dy * cos_;
        forward[c] = dx * cos_ + dy * sin_;
      }
      std::array<bool, 3> wide;
      for (int c = 0; c < 3; ++c) {
        const int d = (c + 1) % 3;
        wide[c] = std::abs(right[c] * forward[d] - right[d] * forward[c]) >
                  steepest_ * (right[c] * right[d] + forward[c] * forward[d]);
      }
      if ((wide[0] || wide[1] || wide[2]) && piece.depth < kDeepest) {
        cut(piece, wide);
      } else {
        write(piece.corners,
              {std::atan2(right[0], forward[0]), std::atan2(right[1], forward[1]), std::atan2(right[2], forward[2])});
      }
    }
  }

  Int filled() const { return filled_; }

 private:
  struct Piece {
    std::array<Vertex, 3> corners;
    int depth;
  };

  bool outside(const std::array<Vertex, 3>& corners) const {
    bool below = true, above = true;
    for (const Vertex& corner : corners) {
      const double reach = std::hypot(corner[0] - view_.eye[0], corner[1] - view_.eye[1]);
      const double rise = corner[2] - view_.eye[2];
      below = below && rise < view_.low * reach;
      above = above && rise > view_.high * reach;
    }
    return below || above;
  }

  /// Puts in the place of a triangle the two, three or four that result from halving its wide edges.
  void cut(const Piece& piece, const std::array<bool, 3>& wide) {
    const auto& corner = piece.corners;
    std::array<Vertex, 3> middle;
    for (int c = 0; c < 3; ++c)
      for (int n = 0; n < kColumns; ++n) middle[c][n] = 0.5f * (corner[c][n] + corner[(c + 1) % 3][n]);
    const auto push = [&](const Vertex& a, const Vertex& b, const Vertex& c) {
      waiting_.push_back({{a, b, c}, piece.depth + 1});
    };
    const int count = wide[0] + wide[1] + wide[2];
    if (count == 3) {
      for (int c = 0; c < 3; ++c) push(corner[c], middle[c], middle[(c + 2) % 3]);
      push(middle[0], middle[1], middle[2]);
    } else if (count == 1) {
      const int a = wide[0] ? 0 : wide[1] ? 1 : 2;
      push(corner[a], middle[a], corner[(a + 2) % 3]);
      push(middle[a], corner[(a + 1) % 3], corner[(a + 2) % 3]);
    } else {  // edges a and a + 1 are wide
      const int a = !wide[0] ? 1 : !wide[1] ? 2 : 0, b = (a + 1) % 3, c = (a + 2) % 3;
      push(middle[a], corner[b], middle[b]);
      push(corner[a], middle[a], middle[b]);
      push(corner[a], middle[b], corner[c]);
    }
  }

  /// Writes one triangle; if it crosses the seam, once more at the other border.
  void write(const std::array<Vertex, 3>& corners, const std::array<double, 3>& azimuth) {
    constexpr double pi = 3.141592653589793, turn = 2.0 * pi;
    const double base = azimuth[0];
    double least = base, most = base;
    for (int c = 1; c < 3; ++c) {
      const double apart = azimuth[c] - base, shorter = apart - turn * std::nearbyint(apart / turn);
      least = std::min(least, base + shorter);
      most = std::max(most, base + shorter);
    }
    write(corners, base);
    if (least < -pi) {
      write(corners, base + turn);
    } else if (most > pi) {
      write(corners, base - turn);
    }
  }

  void write(const std::array<Vertex, 3>& corners, double base) {
    for (const Vertex& corner : corners) {
      if (filled_ < most_) {
        std::copy(corner.begin(), corner.end(), out_[filled_].begin());
        out_[filled_][kColumns] = static_cast<float>(base);
      }
      ++filled_;
    }
  }

  View view_;
  double sin_, cos_, steepest_;
  Int most_, filled_ = 0;
  BasedVertex* out_;
  std::vector<Piece> waiting_;
};

}  // namespace vbbench::renderers
