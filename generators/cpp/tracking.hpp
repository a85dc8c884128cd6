// Boxes of detector and tracker: IoU, merging, and non-maximum suppression.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vbbench::tracking {

/// Centre column, centre row, width and height in px.
struct Box {
  double u, v, width, height;
};

/// The distance of `apart` columns, the shorter one in a panorama of the width `period` px; 0 = borders.
inline double shorter(double apart, double period) {
  return period > 0.0 ? apart - period * std::nearbyint(apart / period) : apart;
}

/// Intersection over union; 0 where one is NaN or empty.
inline double iou(const Box& a, const Box& b, double period) {
  const double apart = shorter(b.u - a.u, period);
  const double along = std::min(std::min(0.5 * (a.width + b.width) - std::abs(apart), a.width), b.width);
  const double bottom = std::min(a.v + 0.5 * a.height, b.v + 0.5 * b.height);
  const double top = std::max(a.v - 0.5 * a.height, b.v - 0.5 * b.height);
  if (!(along > 0.0 && bottom > top)) return 0.0;
  const double shared = along * (bottom - top);
  return shared / (a.width * a.height + b.width * b.height - shared);
}

/// Writes the excess over `least` of the IoU of N and M boxes, times the scores of the latter, into worth [N, M].
inline void worths(std::int64_t tracks, std::int64_t detections, const Box* track, const Box* detection,
                   const double* scores, double least, double period, double* worth) {
  for (std::int64_t i = 0; i < tracks; ++i)
    for (std::int64_t j = 0; j < detections; ++j)
      *worth++ = std::max(iou(track[i], detection[j], period) * scores[j] - least, 0.0);
}

/// The extent of two in one coordinate, each given by its middle and its size.
inline void join(double& middle, double& size, double other_middle, double other_size) {
  const double a = 0.5 * size, b = 0.5 * other_size;
  const double low = std::min(middle - a, other_middle - b), high = std::max(middle + a, other_middle + b);
  middle = 0.5 * (low + high);
  size = high - low;
}

/// Merges some pairs of people into one box about both, in place; `kept` [N] marks the detections that remain.
///
/// A pair merges if the IoU of the true boxes exceeds `overlap` and the first's `chance` is below `rate`.
inline void merge_people(std::int64_t count, Box* boxes, double* scores, const Box* truth, const double* chance,
                         double overlap, double rate, double period, bool* kept) {
  std::fill_n(kept, count, true);
  for (std::int64_t i = 0; i < count; ++i) {
    for (std::int64_t j = i + 1; j < count; ++j) {
      if (!(kept[i] && kept[j] && chance[i] < rate) || iou(truth[i], truth[j], period) <= overlap) continue;
      const double shift = period > 0.0 ? period * std::nearbyint((boxes[i].u - boxes[j].u) / period) : 0.0;
      join(boxes[i].u, boxes[i].width, boxes[j].u + shift, boxes[j].width);
      join(boxes[i].v, boxes[i].height, boxes[j].v, boxes[j].height);
      scores[i] = std::max(scores[i], scores[j]);
      kept[j] = false;
    }
  }
}

/// Non-maximum suppression, best first: `kept` [N] marks boxes whose IoU with all better kept ones is at most
/// `overlap`.
inline void remaining(std::int64_t count, const Box* boxes, const std::int64_t* order, double overlap, double period,
                      bool* kept) {
  std::fill_n(kept, count, true);
  for (std::int64_t place = 0; place < count; ++place) {
    const std::int64_t i = order[place];
    if (!kept[i]) continue;
    for (std::int64_t later = place + 1; later < count; ++later) {
      const std::int64_t j = order[later];
      if (kept[j] && iou(boxes[i], boxes[j], period) > overlap) kept[j] = false;
    }
  }
}

}  // namespace vbbench::tracking
