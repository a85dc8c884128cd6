// Occlusion: outlines of people on level ground, of which nearer ones hide what is below their upper edge.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace vbbench::occlusion {

constexpr int kSamples = 4;  ///< sampled columns a px: people far away are a few px wide

/// A person in the picture: column of the axis, row of the feet, and height, in px.
struct Figure {
  double u, feet, size;
};

/// Box of the visible part, in px.
struct Box {
  double u, v, height, width;
};

/// Upright bands about the axis: within half · height of it an outline rises to top · height.
struct Outline {
  std::span<const double> half, top;
};

/// Sampled columns from first to last.
struct Columns {
  std::int64_t first, last;
};

/// The upper edge of all nearer outlines, column by column of the picture; everything below it is hidden.
class Skyline {
 public:
  /// For a picture of this width in px; one that wraps is a panorama without upper and lower border.
  Skyline(int width, double bottom, bool wraps)
      : rows_(static_cast<std::size_t>(width) * kSamples, bottom), bottom_(bottom), wraps_(wraps) {}

  /// The sampled columns of a figure, also those outside the picture; the narrowest still has one.
  ///
  /// Sample c stands at column (c + ½) / kSamples.
  Columns columns(const Figure& figure, double half) const {
    const double reach = half * figure.size;
    std::int64_t first = whole(std::ceil((figure.u - reach) * kSamples - 0.5));
    std::int64_t last = whole(std::floor((figure.u + reach) * kSamples - 0.5));
    if (last < first) first = last = whole(std::floor(figure.u * kSamples));
    if (wraps_) last = std::min(last, first + count() - 1);
    return {first, last};
  }

  /// The part of the columns that is in the picture.
  Columns inside(const Columns& columns) const {
    if (wraps_) return columns;
    return {std::max<std::int64_t>(columns.first, 0), std::min(columns.last, count() - 1)};
  }

  /// Visible fraction of the next farther person, who is added to the skyline; the box only where something shows.
  double show(const Figure& figure, const Outline& outline, Box& box) {
    const auto [u, feet, size] = figure;
    const double reach = outline.half.back() * size, floor = std::min(feet, bottom_);
    const Columns own = columns(figure, outline.half.back()), seen = inside(own);
    const std::size_t steps = outline.half.size();
    double whole = 0.0, shown = 0.0, head = 0.0, start = 0.0, height = 0.0;
    double near = kInfinity, far = -kInfinity;  // of the axis are the columns of the step
    double top = kInfinity, low = -kInfinity;
    std::int64_t left = own.last + 1, right = own.first - 1;
    for (std::int64_t c = seen.first; c <= seen.last; ++c) {
      const double away = std::abs((static_cast<double>(c) + 0.5) / kSamples - u);
      if (away <= near || away > far) {
        std::size_t step = 0;
        near = -1.0;
        for (; step < steps - 1 && away > outline.half[step] * size; ++step) near = outline.half[step] * size;
        far = step < steps - 1 ? outline.half[step] * size : kInfinity;
        head = feet - outline.top[step] * size;
        start = wraps_ ? head : std::max(head, 0.0);
        height = std::max(floor - start, 0.0);
      }
      whole += height;
      double& sky = rows_[place(c)];
      const double end = std::min(floor, sky);
      if (end > start) {
        shown += end - start;
        top = std::min(top, start);
        low = std::max(low, end);
        left = std::min(left, c);
        right = std::max(right, c);
      }
      sky = std::min(sky, head);
    }
    if (shown > 0.0) {
      // A visible edge of the figure is exact; elsewhere the sample's edge bounds the visible part.
      const double begin = left == own.first ? u - reach : static_cast<double>(left) / kSamples;
      const double end = right == own.last ? u + reach : static_cast<double>(right + 1) / kSamples;
      box = {0.5 * (begin + end), 0.5 * (top + low), low - top, end - begin};
    }
    return whole > 0.0 ? shown / whole : std::numeric_limits<double>::quiet_NaN();
  }

  /// Clears the skyline within these columns.
  void clear(const Columns& columns) {
    if (wraps_) {
      std::ranges::fill(rows_, bottom_);
    } else if (columns.first <= columns.last) {
      std::fill(rows_.begin() + columns.first, rows_.begin() + columns.last + 1, bottom_);
    }
  }

  std::int64_t count() const { return static_cast<std::int64_t>(rows_.size()); }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  static std::int64_t whole(double column) { return static_cast<std::int64_t>(std::clamp(column, -1e9, 1e9)); }
  std::size_t place(std::int64_t column) const {
    if (!wraps_) return static_cast<std::size_t>(column);
    const std::int64_t rest = column % count();
    return static_cast<std::size_t>(rest < 0 ? rest + count() : rest);
  }

  std::vector<double> rows_;
  double bottom_;
  bool wraps_;
};

/// Visible fractions and boxes [T, K] of people at the given distances; NaN = absent, or nothing is visible.
inline void sweep(std::int64_t frames, std::int64_t people, const Figure* figures, const double* distances,
                  const Outline& outline, Skyline& skyline, double* visible, Box* boxes) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  std::fill_n(visible, frames * people, nan);
  std::fill_n(boxes, frames * people, Box{nan, nan, nan, nan});
  std::vector<std::int64_t> inside;
  for (std::int64_t t = 0; t < frames;
       ++t, figures += people, distances += people, visible += people, boxes += people) {
    inside.clear();
    Columns taken{skyline.count(), -1};
    for (std::int64_t k = 0; k < people; ++k) {
      if (std::isnan(distances[k])) continue;
      const auto [begin, end] = skyline.inside(skyline.columns(figures[k], outline.half.back()));
      if (begin > end) continue;  // whoever is beside the picture neither shows nor hides anybody
      inside.push_back(k);
      taken = {std::min(taken.first, begin), std::max(taken.last, end)};
    }
    std::ranges::stable_sort(inside, {}, [&](std::int64_t k) { return distances[k]; });
    for (const std::int64_t k : inside) visible[k] = skyline.show(figures[k], outline, boxes[k]);
    skyline.clear(taken);
  }
}

}  // namespace vbbench::occlusion
