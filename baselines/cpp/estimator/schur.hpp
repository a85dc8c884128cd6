// The linear system of one step: every person is eliminated exactly, which leaves camera and calibration.
#pragma once

#include <algorithm>
#include <vector>

#include "factors/person.hpp"

namespace vbbench {

/// Columns of the reduced system: globals, then the frames that are not held, in order.
struct Layout {
  int held = 0, frames = 0, unknowns = kFrame;
  int kept = 0;  ///< newest nodes of a person whose rows of X are kept

  int size() const { return kGlobals + std::max(0, frames - held) * unknowns; }
  int camera(int index) const {  ///< of frame component `index`; −1 where it is held or fixed
    const int frame = index / kFrame, component = index % kFrame;
    if (frame < held || component >= unknowns) return -1;
    return begin(frame) + component;
  }
  int begin(int frame) const { return kGlobals + std::max(0, frame - held) * unknowns; }
  int of(const Variable& v) const { return v.kind == Variable::kShared ? v.index : camera(v.index); }
};

/// The reduced system: line 0 holds −gradient, the lines below the upper half of H, or its Cholesky factor.
struct Reduced {
  Matrix lines;
  int size = 0;
  Matrix rows;  ///< of one person, while it is eliminated
  std::vector<int> high;

  void reset(int unknowns) {
    size = unknowns;
    lines.reset(1 + size, padded(1 + size) + kLane);
  }
  double& gradient(int column) { return lines[0][1 + column]; }
  double& hessian(int row, int column) { return lines[1 + row][1 + column]; }  ///< row ≤ column
  const double* factor() const { return lines[1] + 1; }

  void add(const CameraRow& row, const Layout& layout, bool hessian_too = true) {
    for (int a = 0; a < row.count; ++a) {
      const int i = layout.of(row.variables[a]);
      if (i < 0) continue;
      gradient(i) -= row.w * row.e * row.by[a];
      for (int b = 0; hessian_too && b < row.count; ++b) {
        const int j = layout.of(row.variables[b]);
        if (i <= j) hessian(i, j) += row.w * row.by[a] * row.by[b];
      }
    }
  }

  /// Removes an unknown: its step is 0.
  void fix(int column) {
    for (int i = 0; i < column; ++i) hessian(i, column) = 0.0;
    std::fill_n(&hessian(column, column), size - column, 0.0);
    hessian(column, column) = 1.0;
    gradient(column) = 0.0;
  }
  bool factorise() { return cholesky(lines[1] + 1, size, lines.cols()); }
};

constexpr int kDense = 1 + kGlobals;  ///< columns that all rows of a person may have
static_assert(kDense % kLane == 0);

constexpr int kBand = 2 * kReach + 2;  ///< rows of a column of a person's path, its own one included

/// Weight and gradient of a box's row, for elimination.
struct BoxRow {
  double w = 0.0;
  std::array<double, kSlots> by{};
};

/// The local system of one person: A x = b + B c, of which the factor L Lᵀ = A remains after elimination.
///
/// Columns of A and L hold the rows from their diagonal on within the reach of a walk, then that of the log height,
/// which comes last. Its own column has a diagonal alone.
class Elimination {
 public:
  int path = 0;  ///< 2 · nodes: number of coordinates, and index of the log height

  void reset(const Person& person, const Layout& layout, double damping) {
    path = 2 * person.frames();
    first_ = person.first;
    layout_ = layout;
    damping_ = damping;
    pending_ = 0;
    columns_.assign(path + 1, Column{});
    sides_.assign(path, Side{});
    height_side_.assign(1 + layout.size(), 0.0);
  }

  int index_of(const Variable& v) const {
    if (v.kind == Variable::kPath) return v.index < path ? v.index : -1;
    return v.kind == Variable::kHeight ? path : -1;
  }

  void add(const Row& row, Reduced& reduced) {
    if (row.of_box) {
      if (pending_ == 4 || (pending_ > 0 && pending_node_ != row.node)) add_boxes(reduced);
      pending_node_ = row.node;
      BoxRow& box = boxes_[pending_++];
      box.w = row.w;
      box.by = row.by;
      box.by[kSlotResidual] = -row.e;
      return;
    }
    if (row.walk) {
      for (int j = 0; j <= row.reach; ++j) {
        const int newer = 2 * (row.node - j) + row.axis;
        const double weighted = row.w * row.chain[j];
        sides_[newer][0] -= weighted * row.e;
        for (int k = j; k <= row.reach; ++k) columns_[newer - 2 * (k - j)][2 * (k - j)] += weighted * row.chain[k];
      }
      return;
    }
    if (row.node < 0) {
      const double by = row.by[kSlotHeight];
      height_side_[0] -= row.w * row.e * by;
      columns_[path][0] += row.w * by * by;
      return;
    }
    for (int a = 0; a < 2 + 2 * row.reach; ++a) {  // places: the newest, then the one before
      const double weighted = row.w * row.by[a];
      const int i = 2 * row.node + (a < 2 ? a : a - 4);
      sides_[i][0] -= weighted * row.e;
      for (int b = 0; b < 2 + 2 * row.reach; ++b) {
        const int j = 2 * row.node + (b < 2 ? b : b - 4);
        if (j <= i) columns_[j][i - j] += weighted * row.by[b];
      }
    }
  }

  /// Clears the right-hand side; the factor remains.
  void clear_right() {
    for (Side& side : sides_) side[0] = 0.0;
    height_side_[0] = 0.0;
  }

  /// Adds a row to the right-hand side alone.
  void add_right(const Row& row, Reduced& reduced) {
    const double by = -row.w * row.e;
    const int i = 2 * row.node;
    if (row.walk) {
      for (int j = 0; j <= row.reach; ++j) sides_[i - 2 * j + row.axis][0] += by * row.chain[j];
      return;
    }
    for (int a = 0; a < 2; ++a) {
      if (row.node >= 0) sides_[i + a][0] += by * row.by[kSlotPlace + a];
      if (row.reach > 0) sides_[i - 2 + a][0] += by * row.by[kSlotPlaceBefore + a];
    }
    height_side_[0] += by * row.by[kSlotHeight];
    if (!row.of_box) return;
    for (int g = 0; g < kBoxGlobals; ++g) reduced.gradient(g) += by * row.by[kSlotShared + g];
    const int frame = first_ + row.node;
    for (int t = std::max(frame - 1, layout_.held); t <= frame; ++t)
      for (int k = 0; k < layout_.unknowns; ++k)
        reduced.gradient(layout_.begin(t) + k) += by * row.by[(t < frame ? kSlotCameraBefore : kSlotCamera) + k];
  }

  /// Solves for the right-hand side b; returns ½ bᵀ A⁻¹ b, by which a step of the person alone lowers the cost.
  double solve_right() {
    scratch_.resize(path + 1);
    for (int i = 0; i <= path; ++i) scratch_[i] = side(i)[0];
    solve(scratch_.data(), 0);
    double sum = 0.0;
    for (int i = 0; i <= path; ++i) sum += scratch_[i] * side(i)[0];
    return 0.5 * sum;
  }

  /// Subtracts Bᵀ A⁻¹ b from the reduced right-hand side, after `solve_right`.
  void reduce_right(Reduced& reduced) const {
    for (int i = 0; i <= path; ++i) add_through(i, -scratch_[i], &reduced.gradient(0));
  }

  /// Adds the marginal prior of the person, or its part of the right-hand side.
  void add_prior(const Person& person, const Calibration& calibration, Reduced& reduced, bool hessian_too = true) {
    const MarginalPrior& prior = person.prior;
    if (!prior.any) return;
    double off[kPrior], gradient[kPrior];
    int inner[kPrior], outer[kPrior];
    prior_offsets(person, calibration, off);
    for (int a = 0; a < kPrior; ++a) {
      gradient[a] = prior.vector[a];
      for (int b = 0; b < kPrior; ++b) gradient[a] -= prior.information[a][b] * off[b];
      const Variable v = prior_variable(a);
      inner[a] = index_of(v);
      outer[a] = v.kind == Variable::kShared ? v.index : -1;
    }
    for (int a = 0; a < kPrior; ++a) {
      if (inner[a] >= 0) {
        side(inner[a])[0] += gradient[a];
        for (int b = 0; hessian_too && b < kPrior; ++b) {
          if (inner[b] >= 0 && inner[b] <= inner[a]) at(inner[a], inner[b]) += prior.information[a][b];
          if (outer[b] >= 0 && outer[b] < kBoxGlobals) side(inner[a])[1 + outer[b]] += prior.information[a][b];
        }
      } else if (outer[a] >= 0) {
        reduced.gradient(outer[a]) += gradient[a];
        for (int b = 0; hessian_too && b < kPrior; ++b)
          if (outer[b] >= outer[a]) reduced.hessian(outer[a], outer[b]) += prior.information[a][b];
      }
    }
  }

  static void prior_offsets(const Person& person, const Calibration& calibration, double* off) {
    for (int a = 0; a < kPrior; ++a) {
      const Variable v = prior_variable(a);
      double at = v.kind == Variable::kShared ? calibration.at[v.index] : person.log_height;
      if (v.kind == Variable::kPath)
        at = v.index / 2 < person.frames() ? person.nodes[v.index / 2].at[v.index % 2] : person.prior.about[a];
      off[a] = at - person.prior.about[a];
    }
  }
  static double prior_cost(const Person& person, const Calibration& calibration) {
    if (!person.prior.any) return 0.0;
    double off[kPrior], sum = 0.0;
    prior_offsets(person, calibration, off);
    for (int a = 0; a < kPrior; ++a) {
      double row = 0.0;
      for (int b = 0; b < kPrior; ++b) row += person.prior.information[a][b] * off[b];
      sum += off[a] * (0.5 * row - person.prior.vector[a]);
    }
    return sum;
  }

  /// Factorises, and subtracts Bᵀ A⁻¹ B from the reduced system. False if A is not positive definite.
  bool eliminate(Reduced& reduced) {
    if (pending_ > 0) add_boxes(reduced);
    for (Column& column : columns_) column[0] += damping_ * column[0] + 1e-9;
    double& height = columns_[path][0];
    for (int j = 0; j <= path; ++j) {
      Column& column = columns_[j];
      if (!(column[0] > 0.0)) return false;
      const double scale = 1.0 / std::sqrt(column[0]);
      for (double& value : column) value *= scale;
      for (int m = 1; m < std::min(kBand, path - j); ++m) {
        const double by = column[m];
        Column& other = columns_[j + m];
        for (int k = m; k < kBand; ++k) other[k - m] -= by * column[k];
        other[kBand] -= by * column[kBand];
      }
      height -= column[kBand] * column[kBand];
    }
    substitute(reduced);
    return true;
  }

  /// The step of the person's own variables, given that of the reduced ones.
  void back_substitute(const std::vector<double>& step, std::vector<double>& own) const {
    own.resize(path + 1);
    for (int i = 0; i < path; ++i) {
      const Side& side = sides_[i];
      double sum = side[0];
      for (int g = 0; g < kBoxGlobals; ++g) sum -= side[1 + g] * step[g];
      const Span span = frames_about(i / 2);
      for (int k = 0; k < span.count; ++k) sum -= side[span.slot + k] * step[span.column + k];
      own[i] = sum;
    }
    own[path] = height_side_[0];
    for (int c = 0; c < layout_.size(); ++c) own[path] -= height_side_[1 + c] * step[c];
    solve(own.data(), 0);
  }

  /// ln of the determinant of A.
  double log_determinant() const {
    double sum = 0.0, product = 1.0;
    for (const Column& column : columns_) {
      product *= column[0];
      if (product > 1e-100 && product < 1e100) continue;
      sum += elementary::log(product);
      product = 1.0;
    }
    return 2.0 * (sum + elementary::log(product));
  }

  /// L⁻¹ g of a gradient g by the person's own variables, in place.
  void whiten(double* g, int begin = 0) const {
    for (int j = begin; j <= path; ++j) {
      const Column& column = columns_[j];
      const double value = g[j] /= column[0];
      for (int k = 1; k < std::min(kBand, path - j); ++k) g[j + k] -= value * column[k];
      if (j < path) g[path] -= value * column[kBand];
    }
  }

  /// Computes A⁻¹ within the pattern of L (Takahashi's equations) from a node on, for leverages.
  void invert(int node) {
    inverse_.resize(path);
    const double height = 1.0 / (columns_[path][0] * columns_[path][0]);
    for (int j = path - 1; j >= 2 * node; --j) {
      const Column& l = columns_[j];
      Column sum{};
      for (int k = 1; k < std::min(kBand, path - j); ++k) {
        const Column& z = inverse_[j + k];
        const double by = l[k];
        double here = z[0] * by + z[kBand] * l[kBand];
        for (int t = k + 1; t < kBand; ++t) {
          sum[t] += by * z[t - k];
          here += l[t] * z[t - k];
        }
        sum[k] += here;
        sum[kBand] += by * z[kBand];
      }
      sum[kBand] += height * l[kBand];
      const double scale = 1.0 / l[0];
      double rest = scale;
      Column& z = inverse_[j];
      for (int k = 1; k <= kBand; ++k) {
        z[k] = -sum[k] * scale;
        rest -= l[k] * z[k];
      }
      z[0] = rest * scale;
    }
  }

  /// Leverage w gᵀ A⁻¹ g of an innovation with the gradient g by the person's path; call `invert` first.
  double leverage(const Row& row) const {
    double sum = 0.0;
    for (int i = 0; i <= row.reach; ++i) {
      const Column& z = inverse_[2 * (row.node - i) + row.axis];
      double others = 0.0;
      for (int j = 0; j < i; ++j) others += row.chain[j] * z[2 * (i - j)];
      sum += row.chain[i] * (row.chain[i] * z[0] + 2.0 * others);
    }
    return row.w * sum;
  }

  /// gᵀ A⁻¹ g of a row with the gradient g by the person's variables, of whose nodes X has been kept. Writes its
  /// gradient after their elimination, c − Xᵀ L⁻¹ g with c by the reduced variables, into a column of `through`
  /// [size][stride].
  double eliminated(const Row& row, double* through, int stride) {
    std::vector<double>&by = scratch_, &line = line_;
    by.assign(path + 1, 0.0);
    line.assign(kept_.cols(), 0.0);
    row.each(first_, [&](const Variable& v, double value) {
      const int i = index_of(v), column = i < 0 ? layout_.of(v) : -1;
      if (i >= 0) by[i] += value;
      if (column >= 0) line[1 + column] += value;
    });
    const double sum = project(2 * (row.node - row.reach), line.data());
    for (int c = 0; c < layout_.size(); ++c) through[static_cast<std::ptrdiff_t>(c) * stride] = line[1 + c];
    return sum;
  }

  /// Covariance xx, xy, yy of the place of a node, of which X has been kept, given the reduced variables. Writes
  /// −Bᵀ A⁻¹ of the place into two columns of `through` [size][stride].
  std::array<double, 3> place_covariance(int node, double* through, int stride) {
    std::vector<double> first;
    std::array<double, 3> covariance{};
    for (int axis = 0; axis < 2; ++axis) {
      scratch_.assign(path + 1, 0.0);
      line_.assign(kept_.cols(), 0.0);
      scratch_[2 * node + axis] = 1.0;
      covariance[2 * axis] = project(2 * node, line_.data());
      for (int c = 0; c < layout_.size(); ++c) through[static_cast<std::ptrdiff_t>(c) * stride + axis] = line_[1 + c];
      if (axis == 0) first = scratch_;
    }
    for (int i = 2 * node; i <= path; ++i) covariance[1] += first[i] * scratch_[i];
    return covariance;
  }

 private:
  static constexpr int kAbout = 1 + kBoxGlobals;  ///< where in a side the frames begin: before, at, after the node
  using Column = std::array<double, kBand + 1>;
  using Side = std::array<double, (kAbout + 3 * kFrame + 3) / 4 * 4>;  ///< −gradient, globals, frames

  /// A at row i and column j ≤ i.
  double& at(int i, int j) { return columns_[j][i < path || i == j ? i - j : kBand]; }
  double* side(int i) { return i < path ? sides_[i].data() : height_side_.data(); }

  /// Free frames next to a node: their first slot in its row of B, first column in the reduced system, and columns.
  struct Span {
    int slot, column, count;
  };
  Span frames_about(int node) const {
    const int frame = first_ + node, from = std::max(frame - 1, layout_.held);
    const int to = std::min(frame + 2, layout_.frames);
    return {kAbout + layout_.unknowns * (from - frame + 1), layout_.begin(from),
            std::max(0, to - from) * layout_.unknowns};
  }
  void add_through(int i, double by, double* through) const {
    if (i == path) {
      for (int c = 0; c < layout_.size(); ++c) through[c] += height_side_[1 + c] * by;
      return;
    }
    const Side& side = sides_[i];
    const Span span = frames_about(i / 2);
    for (int g = 0; g < kBoxGlobals; ++g) through[g] += side[1 + g] * by;
    for (int k = 0; k < span.count; ++k) through[span.column + k] += side[span.slot + k] * by;
  }

  /// y = L⁻¹ g of the gradient in `scratch_`, whose first `begin` are zero: line −= Xᵀ y. Returns |y|².
  double project(int begin, double* line) {
    whiten(scratch_.data(), begin);
    const int from = path + 1 - kept_.rows();
    double sum = 0.0;
    for (int i = begin; i <= path; i += 8) {
      const int count = std::min(8, path + 1 - i);
      const double* rows[8];
      for (int k = 0; k < count; ++k) {
        rows[k] = kept_[i + k - from];
        sum += scratch_[i + k] * scratch_[i + k];
      }
      subtract_rows(line, rows, &scratch_[i], count, 0, kept_.cols());
    }
    return sum;
  }

  /// Adds the rows of the boxes of a node, which have the same variables.
  void add_boxes(Reduced& reduced);

  /// X = L⁻¹ [b | B], and H −= Xᵀ X.
  void substitute(Reduced& reduced);

  /// Solves L Lᵀ x = b in place, where the first `begin` of b are zero.
  void solve(double* x, int begin) const {
    whiten(x, begin);
    x[path] /= columns_[path][0];
    for (int j = path - 1; j >= 0; --j) {
      const Column& column = columns_[j];
      double sum = x[j] - column[kBand] * x[path];
      for (int k = 1; k < std::min(kBand, path - j); ++k) sum -= column[k] * x[j + k];
      x[j] = sum / column[0];
    }
  }

  Layout layout_;
  int first_ = 0, pending_ = 0, pending_node_ = -1;
  double damping_ = 0.0;
  std::array<BoxRow, 4> boxes_;
  std::vector<Column> columns_, inverse_;
  std::vector<Side> sides_;          ///< −gradient and B of the path
  std::vector<double> height_side_;  ///< of the log height, which all columns of the reduced system may have
  Matrix kept_;                      ///< newest rows of X
  std::vector<double> scratch_, line_;
};

}  // namespace vbbench
