// Forward-mode derivatives: a value with its gradient by N variables.
#pragma once

#include <array>
#include <cmath>

#include "elementary.hpp"

namespace vbbench {

template <int N>
struct Dual {
  double v = 0.0;
  std::array<double, N> d{};

  Dual() = default;
  Dual(double value) : v(value) {}
  static Dual variable(double value, int index) {
    Dual x(value);
    x.d[index] = 1.0;
    return x;
  }
};

template <int N>
Dual<N> chain(const Dual<N>& a, double value, double by) {
  Dual<N> out(value);
  for (int i = 0; i < N; ++i) out.d[i] = by * a.d[i];
  return out;
}
template <int N>
Dual<N> operator+(Dual<N> a, const Dual<N>& b) {
  a.v += b.v;
  for (int i = 0; i < N; ++i) a.d[i] += b.d[i];
  return a;
}
template <int N>
Dual<N> operator-(Dual<N> a, const Dual<N>& b) {
  a.v -= b.v;
  for (int i = 0; i < N; ++i) a.d[i] -= b.d[i];
  return a;
}
template <int N>
Dual<N> operator*(const Dual<N>& a, const Dual<N>& b) {
  Dual<N> out(a.v * b.v);
  for (int i = 0; i < N; ++i) out.d[i] = a.v * b.d[i] + b.v * a.d[i];
  return out;
}
template <int N>
Dual<N> operator*(double a, const Dual<N>& b) {
  return chain(b, a * b.v, a);
}
template <int N>
Dual<N> operator/(const Dual<N>& a, const Dual<N>& b) {
  return a * chain(b, 1.0 / b.v, -1.0 / (b.v * b.v));
}
template <int N>
Dual<N> operator+(Dual<N> a, double b) {
  a.v += b;
  return a;
}
template <int N>
Dual<N> operator-(double a, const Dual<N>& b) {
  return chain(b, a - b.v, -1.0);
}
template <int N>
Dual<N> sin(const Dual<N>& a) {
  return chain(a, elementary::sin(a.v), elementary::cos(a.v));
}
template <int N>
Dual<N> cos(const Dual<N>& a) {
  return chain(a, elementary::cos(a.v), -elementary::sin(a.v));
}
template <int N>
Dual<N> sqrt(const Dual<N>& a) {
  const double root = std::sqrt(a.v);
  return chain(a, root, 0.5 / root);
}
template <int N>
Dual<N> atan2(const Dual<N>& y, const Dual<N>& x) {
  const double square = x.v * x.v + y.v * y.v;
  Dual<N> out(elementary::atan2(y.v, x.v));
  for (int i = 0; i < N; ++i) out.d[i] = (x.v * y.d[i] - y.v * x.d[i]) / square;
  return out;
}

inline double value_of(double a) { return a; }
template <int N>
double value_of(const Dual<N>& a) {
  return a.v;
}

constexpr double kPi = 3.14159265358979323846;

inline double wrap(double angle) { return angle - 2.0 * kPi * std::round(angle / (2.0 * kPi)); }
template <int N>
Dual<N> wrap(Dual<N> a) {
  a.v = wrap(a.v);
  return a;
}

}  // namespace vbbench
