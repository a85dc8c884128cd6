// Layers of the learned network, by name among its weights: linear, normalised, gated and attending. All in float.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "elementary.hpp"

namespace vbbench::former {

constexpr int kWidth = 48, kHeads = 3, kHidden = 96, kBlocks = 2;  ///< as `layers.py` has them

struct Weight {
  std::vector<std::size_t> shape;
  std::vector<float> values;
};

class Weights {
 public:
  explicit Weights(std::map<std::string, Weight> weights) : weights_(std::move(weights)) {}

  /// The values of this name; throws std::invalid_argument if their shape differs.
  const std::vector<float>& of(const std::string& name, const std::vector<std::size_t>& shape) const {
    const auto found = weights_.find(name);
    if (found == weights_.end()) throw std::invalid_argument("the weights '" + name + "' are missing");
    if (found->second.shape != shape)
      throw std::invalid_argument("the weights '" + name + "' have not the shape of the network");
    return found->second.values;
  }

  bool has(const std::string& name, const std::vector<std::size_t>& shape) const {
    const auto found = weights_.find(name);
    return found != weights_.end() && found->second.shape == shape;
  }

 private:
  std::map<std::string, Weight> weights_;
};

inline float sigmoid(float x) { return 1.0f / (1.0f + elementary::exp(-x)); }
inline float silu(float x) { return x / (1.0f + elementary::exp(-x)); }
inline float clip(float x, float low, float high) { return x < low ? low : x > high ? high : x; }
inline float square(float x) { return x * x; }

/// Rows of equal length, one after the other.
struct Rows {
  Rows(int rows, int length) : count(rows), width(length), values(static_cast<std::size_t>(rows) * length) {}
  float* operator[](int row) { return values.data() + static_cast<std::size_t>(row) * width; }
  const float* operator[](int row) const { return values.data() + static_cast<std::size_t>(row) * width; }

  int count, width;
  std::vector<float> values;
};

/// A linear layer with a bias, applied to each row.
class Linear {
 public:
  Linear(const Weights& weights, const std::string& name, int of, int to)
      : of_(of), to_(to), padded_((to + kColumns - 1) / kColumns * kColumns) {
    const std::size_t in = static_cast<std::size_t>(of), out = static_cast<std::size_t>(to);
    const auto& matrix = weights.of(name + ".weights", {out, in});
    const auto& bias = weights.of(name + ".bias", {out});
    matrix_.assign(in * padded_, 0.0f);
    bias_.assign(padded_, 0.0f);
    for (int j = 0; j < to_; ++j) {
      bias_[j] = bias[j];
      for (int k = 0; k < of_; ++k) matrix_[k * padded_ + j] = matrix[j * of_ + k];
    }
  }

  Rows operator()(const Rows& x) const {
    Rows made(x.count, to_);
    for (int first = 0; first < x.count; first += kRows)
      for (int column = 0; column < to_; column += kColumns) block(x, first, column, made);
    return made;
  }

  std::vector<float> operator()(const std::vector<float>& x) const {
    Rows row(1, of_);
    row.values = x;
    return (*this)(row).values;
  }

 private:
  /// Rows and columns of the block of sums computed at once, each in the order of k. g++ vectorises no fewer columns.
  static constexpr int kRows = 4, kColumns = 24;

  void block(const Rows& x, int first, int column, Rows& made) const {
    const float* rows[kRows];
    for (int r = 0; r < kRows; ++r) rows[r] = x[std::min(first + r, x.count - 1)];
    float a[kColumns], b[kColumns], c[kColumns], d[kColumns];
    for (int j = 0; j < kColumns; ++j) a[j] = b[j] = c[j] = d[j] = bias_[column + j];
    const float* weights = matrix_.data() + column;
    for (int k = 0; k < of_; ++k, weights += padded_) {
      const float p = rows[0][k], q = rows[1][k], r = rows[2][k], s = rows[3][k];
      for (int j = 0; j < kColumns; ++j) {
        a[j] += p * weights[j];
        b[j] += q * weights[j];
        c[j] += r * weights[j];
        d[j] += s * weights[j];
      }
    }
    const float* sums[kRows] = {a, b, c, d};
    for (int r = 0; r < std::min(kRows, x.count - first); ++r)
      std::copy_n(sums[r], std::min(kColumns, to_ - column), made[first + r] + column);
  }

  int of_, to_, padded_;
  std::vector<float> matrix_, bias_;  ///< [of, padded], [padded]
};

/// A linear layer and SiLU.
template <class X>
X hidden(const Linear& layer, const X& x) {
  X made = layer(x);
  if constexpr (requires { made.values; })
    for (float& value : made.values) value = silu(value);
  else
    for (float& value : made) value = silu(value);
  return made;
}

/// Two linear layers with SiLU between.
struct Perceptron {
  Perceptron(const Weights& weights, const std::string& name, int of, int between, int to)
      : in(weights, name + ".in", of, between), out(weights, name + ".out", between, to) {}

  template <class X>
  X operator()(const X& x) const {
    return out(hidden(in, x));
  }

  Linear in, out;
};

/// Layer normalisation.
struct Normalisation {
  Normalisation(const Weights& weights, const std::string& name)
      : gain(weights.of(name + ".gain", {kWidth})), bias(weights.of(name + ".bias", {kWidth})) {}

  Rows operator()(const Rows& x) const {
    constexpr float kLeastVariance = 1e-5f, kCount = kWidth;
    Rows made(x.count, kWidth);
    for (int r = 0; r < x.count; ++r) {
      const float* from = x[r];
      float* to = made[r];
      float total = 0.0f, variance = 0.0f;
      for (int k = 0; k < kWidth; ++k) total += from[k];
      for (int k = 0; k < kWidth; ++k) {
        to[k] = from[k] - total / kCount;
        variance += square(to[k]);
      }
      const float deviation = std::sqrt(variance / kCount + kLeastVariance);
      for (int k = 0; k < kWidth; ++k) to[k] = to[k] / deviation * gain[k] + bias[k];
    }
    return made;
  }

  std::vector<float> gain, bias;
};

/// A gated recurrent unit (Cho et al. 2014).
struct Memory {
  Memory(const Weights& weights, const std::string& name, int of, int numbers)
      : size(numbers),
        fresh(weights, name + ".new", of, 3 * numbers),
        old(weights, name + ".old", numbers, 3 * numbers) {}

  /// `memory` [size] after the gates of `news` and `kept` [3 size], linear in the input and in the memory.
  void renew(const float* news, const float* kept, const float* memory, float* made) const {
    for (int m = 0; m < size; ++m) {
      const float change = sigmoid(news[m] + kept[m]), reset = sigmoid(news[size + m] + kept[size + m]);
      const float wanted = elementary::tanh(news[2 * size + m] + reset * kept[2 * size + m]);
      made[m] = memory[m] + change * (wanted - memory[m]);
    }
  }

  std::vector<float> operator()(const std::vector<float>& x, const std::vector<float>& memory) const {
    std::vector<float> made(memory.size());
    renew(fresh(x).data(), old(memory).data(), memory.data(), made.data());
    return made;
  }

  int size;
  Linear fresh, old;
};

/// A block of a transformer (Vaswani et al. 2017) with normalisation before each part (Xiong et al. 2020).
struct Block {
  Block(const Weights& weights, const std::string& name)
      : before_asking(weights, name + ".before_asking"),
        before_thinking(weights, name + ".before_thinking"),
        ask(weights, name + ".ask", kWidth, 3 * kWidth),
        tell(weights, name + ".tell", kWidth, kWidth),
        think(weights, name + ".think", kWidth, kHidden, kWidth) {}

  /// Rows after attention; `absent` is added to the logits, a large negative number for absent people.
  void attend(Rows& rows, const std::vector<float>& absent) const {
    add(rows, tell(attended(ask(before_asking(rows)), absent)));
    add(rows, think(before_thinking(rows)));
  }

  static void add(Rows& rows, const Rows& more) {
    for (std::size_t i = 0; i < rows.values.size(); ++i) rows.values[i] += more.values[i];
  }

  /// Softmax attention of rows of queries, keys and values, each by heads.
  static Rows attended(const Rows& parts, const std::vector<float>& absent) {
    constexpr int kSize = kWidth / kHeads;
    const float scale = 1.0f / std::sqrt(static_cast<float>(kSize));
    Rows made(parts.count, kWidth);
    std::vector<float> share(parts.count);
    for (int r = 0; r < parts.count; ++r)
      for (int head = 0; head < kHeads; ++head) {
        const float* query = parts[r] + head * kSize;
        float most = -INFINITY, total = 0.0f;
        for (int other = 0; other < parts.count; ++other) {
          const float* key = parts[other] + kWidth + head * kSize;
          float match = 0.0f;
          for (int k = 0; k < kSize; ++k) match += query[k] * scale * key[k];
          share[other] = match + absent[other];
          most = std::max(most, share[other]);
        }
        for (float& one : share) total += one = elementary::exp(one - most);
        float* mean = made[r] + head * kSize;
        for (int other = 0; other < parts.count; ++other) {
          const float* value = parts[other] + 2 * kWidth + head * kSize;
          const float weight = share[other] / total;
          for (int k = 0; k < kSize; ++k) mean[k] += weight * value[k];
        }
      }
    return made;
  }

  Normalisation before_asking, before_thinking;
  Linear ask, tell;
  Perceptron think;
};

}  // namespace vbbench::former
