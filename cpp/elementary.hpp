// exp, log, sin, cos, atan2 and what follows from them, to within 2.5 ulp: the same bytes with every mathematical
// library.
//
// Additions, multiplications, divisions and square roots are alone rounded in the same way everywhere; libraries differ
// in these functions. A range is reduced exactly, or in two parts, and a polynomial does the rest. Polynomials
// interpolate at Chebyshev's points, by 60 digits of mpmath; the comments have function, variable and range. Branches
// are choices between values, so that loops over these functions become vectors.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace vbbench::elementary {

constexpr double kInfinite = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kLn2High = 0x1.62e42ffp-1, kLn2Low = -0x1.718432a1b0e26p-35;  ///< ln 2; the first has 32 bits
constexpr double kWhole = 0x1.8p52;  ///< added and taken away again it leaves an integer, which stands in the low bits
constexpr std::uint64_t kOne = 0x3ff0'0000'0000'0000;  ///< bits of 1

/// c₀ + c₁ x + c₂ x² + …; even and odd powers are summed side by side, as processors add.
template <std::size_t N>
constexpr double polynomial(const std::array<double, N>& c, double x) {
  const double square = x * x;
  double even = c[(N - 1) / 2 * 2], odd = c[N / 2 * 2 - 1];
  for (std::size_t i = (N - 1) / 2; i-- > 0;) even = even * square + c[2 * i];
  for (std::size_t i = N / 2 - 1; i-- > 0;) odd = odd * square + c[2 * i + 1];
  return even + x * odd;
}

/// (eʳ − 1 − r)/r² by r, |r| ≤ ½ ln 2.
constexpr std::array kExp{0.5,
                          0.1666666666666667,
                          0.04166666666666667,
                          0.008333333333326141,
                          0.0013888888888883752,
                          0.00019841269874800493,
                          2.4801587325533363e-05,
                          2.7557255425746435e-06,
                          2.7557273661348637e-07,
                          2.510520637395701e-08,
                          2.0914679376583935e-09};
/// (2 artanh(s)/s − 2)/s² by s², |s| ≤ (√2 − 1)/(√2 + 1).
constexpr std::array kLog{0.6666666666666666,  0.4000000000000088,  0.28571428570803614, 0.22222222391713917,
                          0.18181795640132906, 0.15386239702814658, 0.13268773138656886, 0.13086626147840102};
/// (sin(x)/x − 1)/x² by x², |x| ≤ ¼ π.
constexpr std::array kSin{-0.16666666666666666,   0.008333333333333331,    -0.00019841269841265065,
                          2.7557319219339167e-06, -2.5052106232447578e-08, 1.6058531618986147e-10,
                          -7.586697117706918e-13};
/// (cos(x) − 1 + ½ x²)/x⁴ by x², |x| ≤ ¼ π.
constexpr std::array kCos{0.041666666666666664,    -0.0013888888888887398, 2.480158729876569e-05,
                          -2.7557317271729793e-07, 2.08761462684032e-09,   -1.1382632425521717e-11};
/// (atan(q)/q − 1)/q² by q², |q| ≤ ½.
constexpr std::array kAtan{-0.3333333333333333,  0.19999999999999488, -0.14285714285599188, 0.11111111100917376,
                           -0.09090908620322523, 0.07692294712540285, -0.06666435677235948, 0.05879578429582425,
                           -0.05240099507994713, 0.04628024868570153, -0.03806653672057366, 0.025006503566489507,
                           -0.009215792047089858};
/// k π/4 as two numbers.
constexpr std::array<std::array<double, 2>, 5> kQuarters{{{0.0, 0.0},
                                                          {0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55},
                                                          {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54},
                                                          {0x1.2d97c7f3321d2p+1, 0x1.a79394c9e8a0ap-54},
                                                          {0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53}}};

/// eˣ − 1 = 2ᵏ (m + 1) − 1: k as an integer of 64 bits, and m.
struct Power {
  std::uint64_t k;
  double m;
};
inline Power power_of(double x) {
  const double shifted = x * 1.4426950408889634 + kWhole, k = shifted - kWhole;
  const double high = x - k * kLn2High, low = k * kLn2Low, r = high - low;
  return {std::bit_cast<std::uint64_t>(shifted) - std::bit_cast<std::uint64_t>(kWhole),
          r + (r * r * polynomial(kExp, r) + ((high - r) - low))};
}

inline double exp(double x) {
  x = x < -746.0 ? -746.0 : x;  // where it is 0, and where it is infinite
  x = x > 710.0 ? 710.0 : x;
  const Power power = power_of(x);
  const std::uint64_t half = ((power.k + 2048) >> 1) - 1024;  // powers of 2 that are too small or large are products
  const double first = std::bit_cast<double>(kOne + (half << 52));
  return (1.0 + power.m) * first * std::bit_cast<double>(kOne + ((power.k - half) << 52));
}

inline double log(double x) {
  constexpr double kSmallest = std::numeric_limits<double>::min();
  constexpr std::uint64_t kRootHalf = 0x3fe6'a09e'667f'3bcd, kMantissa = 0x000f'ffff'ffff'ffff;
  const bool tiny = x < kSmallest;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(tiny ? x * 0x1p54 : x) + (kOne - kRootHalf);
  // x = 2ᵏ m with √½ ≤ m < √2.
  const double exponent = std::bit_cast<double>((bits >> 52) | std::bit_cast<std::uint64_t>(0x1p52));
  const double k = exponent - (0x1p52 + 1023.0) - (tiny ? 54.0 : 0.0);
  const double f = std::bit_cast<double>((bits & kMantissa) + kRootHalf) - 1.0, s = f / (2.0 + f), square = s * s;
  // ln m = 2 artanh s = f − s (f − s² p(s²))
  const double found = k * kLn2High + (f - (s * (f - square * polynomial(kLog, square)) - k * kLn2Low));
  const double known = x < kInfinite ? found : x;  // infinite, or no number
  return x > 0.0 ? known : x == 0.0 ? -kInfinite : kNan;
}

/// ln(1 + x).
inline double log1p(double x) {
  const double sum = 1.0 + x, rest = (x - (sum - 1.0)) / sum;  // what rounding takes of the sum
  const double found = log(sum) + (sum > 0.0 && sum < kInfinite ? rest : 0.0);
  return x == 0.0 ? x : found;  // −0, too
}

struct SinCos {
  double sin, cos;
};

/// Beyond 2²⁰ quarter turns, of a number that is within half an ulp of x.
inline SinCos sin_cos(double x) {
  if (!(std::abs(x) < 0x1p20)) x = std::fmod(x, 0x1.921fb54442d18p+2);  // NaN of what is not finite
  const double shifted = x * 0.6366197723675814 + kWhole, n = shifted - kWhole;
  const std::uint64_t quarter = std::bit_cast<std::uint64_t>(shifted);
  const double rough = x - n * 0x1.921fb544p+0, second = n * 0x1.0b4611a6p-34,
               high = rough - second;  // ½ π: 32 + 32 bits
  const double low = ((rough - high) - second) - n * 0x1.3198a2e037073p-69;
  const double r = high + low, rest = (high - r) + low, square = r * r, half = 0.5 * square, one = 1.0 - half;
  const double s = r + (square * r * polynomial(kSin, square) + rest * one);
  const double c = one + (((1.0 - one) - half) + (square * square * polynomial(kCos, square) - r * rest));
  const bool odd = quarter & 1;
  const double sin = odd ? c : s, cos = odd ? s : c;
  const double exact = x == 0.0 ? x : sin;  // −0, too
  return {quarter & 2 ? -exact : exact, (quarter + 1) & 2 ? -cos : cos};
}
inline double sin(double x) { return sin_cos(x).sin; }
inline double cos(double x) { return sin_cos(x).cos; }

inline double atan2(double y, double x) {
  const double a = std::abs(x), b = std::abs(y);
  const bool steep = b > a, behind = std::signbit(x), both = a == kInfinite && b == kInfinite;
  double less = both ? 1.0 : steep ? a : b, more = both ? 1.0 : steep ? b : a;
  const double scale = more > 0x1p1000 ? 0x1p-60 : more < 0x1p-900 ? 0x1p100 : 1.0;  // their sum is finite
  less *= scale;
  more *= scale;
  const bool wide = less > 0.5 * more;  // from ¼ π on
  const double upper = wide ? less - more : less, lower = wide ? less + more : more;
  const double q = lower > 0.0 ? upper / lower : 0.0, square = q * q;
  const double angle = q + q * (square * polynomial(kAtan, square));
  const int first = wide ? 1 : 0, second = steep ? 2 - first : first, quarters = behind ? 4 - second : second;
  const auto& [high, low] = kQuarters[quarters];
  const double found = high + ((steep != behind ? -angle : angle) + low);
  return std::isnan(x + y) && !both ? x + y : std::copysign(found, y);
}

/// √(x² + y²) of lengths whose squares are numbers.
inline double hypot(double x, double y) { return std::sqrt(x * x + y * y); }

}  // namespace vbbench::elementary
