#include "schur.hpp"

namespace vbbench {

/// Lines −= Xᵀ X for rows X [count][stride], whose columns are zero but for the first kDense and those from `low` to
/// `high` of a row. Rows are taken eight at a time.
VBBENCH_WIDE_WHOLE static void subtract_products(const double* x, int count, int stride, int low, const int* high,
                                                 double* lines) {
  constexpr int kBlock = 8;
  const bool joined = low / kLane * kLane == kDense;
  for (int begin = 0; begin < count; begin += kBlock) {
    const int block = std::min(kBlock, count - begin);
    const double* rows[kBlock];
    double by[kBlock];
    int end = low;
    for (int k = 0; k < block; ++k) {
      rows[k] = x + static_cast<std::ptrdiff_t>(begin + k) * stride;
      end = std::max(end, high[begin + k]);
    }
    for (int a = 0; a < end; a = a + 1 == kDense ? low : a + 1) {
      for (int k = 0; k < block; ++k) by[k] = rows[k][a];
      double* line = lines + static_cast<std::ptrdiff_t>(a) * stride;
      if (a < kDense && !joined) subtract_rows(line, rows, by, block, a, kDense);
      subtract_rows(line, rows, by, block, joined ? a : std::max(a, low), end);
    }
  }
}

/// X = L⁻¹ X of rows X [path + 1][stride] as above; L has `columns` [path + 1][kBand + 1].
VBBENCH_WIDE_WHOLE static void substitute_rows(const double* columns, int path, double* x, int stride, int low,
                                               const int* high) {
  const bool joined = low / kLane * kLane == kDense;
  for (int i = 0; i <= path; ++i) {
    double* row = x + static_cast<std::ptrdiff_t>(i) * stride;
    for (int begin = i < path ? std::max(0, i - kBand + 2 - i % 2) : 0; begin < i; begin += 8) {
      const int count = std::min(8, i - begin);
      const double* rows[8];
      double by[8];
      for (int k = 0; k < count; ++k) {
        const int j = begin + k;
        rows[k] = x + static_cast<std::ptrdiff_t>(j) * stride;
        by[k] = columns[j * (kBand + 1) + (i < path ? i - j : kBand)];
      }
      if (!joined) subtract_rows(row, rows, by, count, 0, kDense);
      subtract_rows(row, rows, by, count, joined ? 0 : low, high[i]);
    }
    const double scale = 1.0 / columns[i * (kBand + 1)];
    for (int c = 0; c < high[i]; ++c) row[c] *= scale;
  }
}

/// The upper half of Σ w by byᵀ of four rows, [kSlots][kSlots]; what is left of the diagonal's lane is not set.
VBBENCH_WIDE_WHOLE static void add_squares(const BoxRow* rows, double* __restrict out) {
  for (int a = 0; a < kSlotEnd; ++a) {
    double by[4];
    for (int r = 0; r < 4; ++r) by[r] = rows[r].w * rows[r].by[a];
    double* __restrict line = out + a * kSlots;
    for (int c = a / kLane * kLane; c < kSlots; ++c)
      line[c] = by[0] * rows[0].by[c] + by[1] * rows[1].by[c] + by[2] * rows[2].by[c] + by[3] * rows[3].by[c];
  }
}

void Elimination::add_boxes(Reduced& reduced) {
  for (; pending_ < 4; ++pending_) boxes_[pending_].w = 0.0;
  pending_ = 0;
  double squares[kSlots * kSlots];
  add_squares(boxes_.data(), squares);
  const auto line = [&](int slot) { return squares + slot * kSlots; };
  const int i = pending_node_, frame = first_ + i, unknowns = layout_.unknowns;
  // Pieces of a line that the reduced system has, with their columns there.
  struct Piece {
    int slot, column, count;
  };
  const Piece pieces[3] = {{kSlotResidual, 0, kAbout},
                           {kSlotCameraBefore, 1 + layout_.begin(frame - 1), frame > layout_.held ? unknowns : 0},
                           {kSlotCamera, 1 + layout_.begin(frame), frame >= layout_.held ? unknowns : 0}};
  for (int p = 0; p < 3; ++p)
    for (int k = 0; k < pieces[p].count; ++k) {
      const double* from = line(pieces[p].slot + k);
      double* to = reduced.lines[pieces[p].column + k];
      for (int q = p; q < 3; ++q)
        for (int c = q == p ? k : 0; c < pieces[q].count; ++c) to[pieces[q].column + c] += from[pieces[q].slot + c];
    }
  for (int a = 0; a < 2; ++a) {
    const double* place = line(kSlotPlace + a);
    Side& side = sides_[2 * i + a];
    for (int c = 0; c < kAbout; ++c) side[c] += place[kSlotResidual + c];
    for (int c = 0; c < unknowns; ++c) {
      side[kAbout + c] += place[kSlotCameraBefore + c];
      side[kAbout + unknowns + c] += place[kSlotCamera + c];
    }
    Column& column = columns_[2 * i + a];
    for (int b = a; b < 2; ++b) column[b - a] += place[kSlotPlace + b];
    column[kBand] += place[kSlotHeight];
  }
  const double* height = line(kSlotHeight);
  columns_[path][0] += height[kSlotHeight];
  for (const Piece& piece : pieces)
    for (int c = 0; c < piece.count; ++c) height_side_[piece.column + c] += height[piece.slot + c];
  if (i == 0) return;
  for (int a = 0; a < 2; ++a) {
    const double* place = line(kSlotPlaceBefore + a);
    Side& side = sides_[2 * i - 2 + a];
    for (int c = 0; c < kAbout; ++c) side[c] += place[kSlotResidual + c];
    for (int c = 0; c < unknowns; ++c) {
      side[kAbout + unknowns + c] += place[kSlotCameraBefore + c];
      side[kAbout + 2 * unknowns + c] += place[kSlotCamera + c];
    }
    Column& column = columns_[2 * i - 2 + a];
    for (int b = a; b < 2; ++b) column[b - a] += place[kSlotPlaceBefore + b];
    for (int b = 0; b < 2; ++b) column[2 + b - a] += line(kSlotPlace + b)[kSlotPlaceBefore + a];
    column[kBand] += place[kSlotHeight];
  }
}

void Elimination::substitute(Reduced& reduced) {
  const int stride = reduced.lines.cols(), width = 1 + reduced.size;
  const int low = 1 + layout_.begin(first_);
  Matrix& x = reduced.rows;
  x.reset(path + 1, stride);
  std::vector<int>& high = reduced.high;
  high.assign(path + 1, width);
  for (int i = 0; i < path; ++i) {
    const Span span = frames_about(i / 2);
    std::copy_n(sides_[i].begin(), kAbout, x[i]);
    std::copy_n(sides_[i].begin() + span.slot, span.count, x[i] + 1 + span.column);
    high[i] = std::max(low, 1 + span.column + span.count);
  }
  std::copy_n(height_side_.begin(), width, x[path]);
  substitute_rows(columns_[0].data(), path, x[0], stride, low, high.data());
  subtract_products(x[0], path + 1, stride, low, high.data(), reduced.lines[0]);
  const int kept = std::min(path, 2 * layout_.kept) + 1;
  kept_.reset(kept, stride);
  std::copy_n(x[path + 1 - kept], kept * stride, kept_[0]);
}

}  // namespace vbbench
