// Ornstein–Uhlenbeck processes.
#pragma once

#include <cstdint>

namespace vbbench {

/// Makes each row of independent numbers [T, N] depend on the one before.
inline void link(std::int64_t rows, std::int64_t columns, double kept, double fresh, double* numbers) {
  for (std::int64_t n = columns; n < rows * columns; ++n) numbers[n] = kept * numbers[n - columns] + fresh * numbers[n];
}

}  // namespace vbbench
