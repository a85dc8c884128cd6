// What the bindings of all packages share: arrays are checked for type and shape; what is wrong is a VbbenchError.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace vbbench {

namespace nb = nanobind;

template <class T>
using Array = nb::ndarray<T, nb::c_contig, nb::device::cpu>;
using Shape = std::vector<std::size_t>;

constexpr std::size_t kAny = SIZE_MAX;  ///< in a shape that is asked for, a length that may be anything

[[noreturn]] inline void refuse(const std::string& problem) {
  const nb::object error = nb::module_::import_("vbbench.errors").attr("VbbenchError");
  PyErr_SetString(error.ptr(), problem.c_str());
  throw nb::python_error();
}

template <class T>
inline constexpr const char* kTypeName = nullptr;
template <>
inline constexpr const char* kTypeName<double> = "float64";
template <>
inline constexpr const char* kTypeName<float> = "float32";
template <>
inline constexpr const char* kTypeName<int> = "int32";
template <>
inline constexpr const char* kTypeName<std::int64_t> = "int64";
template <>
inline constexpr const char* kTypeName<std::uint8_t> = "uint8";
template <>
inline constexpr const char* kTypeName<bool> = "bool";

inline std::string shape_text(const Shape& shape) {
  std::string text = "[";
  for (std::size_t i = 0; i < shape.size(); ++i)
    text += (i ? ", " : "") + (shape[i] == kAny ? "any" : std::to_string(shape[i]));
  return text + "]";
}

/// The array of this type and shape in C order; one of const numbers need not be writable.
template <class T>
Array<T> array(const nb::object& value, const char* name, const Shape& shape) {
  Array<T> found;
  if (!nb::try_cast<Array<T>>(value, found, false))
    refuse(std::string(name) + " must be an array of " + kTypeName<std::remove_const_t<T>> + " in C order" +
           (std::is_const_v<T> ? "" : " that can be written to"));
  bool fits = found.ndim() == shape.size();
  for (std::size_t i = 0; fits && i < shape.size(); ++i) fits = shape[i] == kAny || found.shape(i) == shape[i];
  if (!fits) {
    Shape has;
    for (std::size_t i = 0; i < found.ndim(); ++i) has.push_back(found.shape(i));
    refuse(std::string(name) + " must have the shape " + shape_text(shape) + ", not " + shape_text(has));
  }
  return found;
}

/// The integer as an int that is at least `least`.
inline int whole(std::int64_t value, const char* name, std::int64_t least) {
  if (value < least || value > 1'000'000'000) refuse(std::string(name) + " must be at least " + std::to_string(least));
  return static_cast<int>(value);
}

/// Rows of numbers as pointers to structs of the same layout.
template <class Row, class T>
auto* rows(const Array<T>& found) {
  return reinterpret_cast<std::conditional_t<std::is_const_v<T>, const Row*, Row*>>(found.data());
}

/// A new NumPy array that owns the values.
template <class T>
nb::object numpy(std::vector<T> values, const Shape& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  T* data = kept->data();
  nb::capsule owner(kept.release(), [](void* p) noexcept { delete static_cast<std::vector<T>*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, T>(data, shape.size(), shape.data(), owner));
}

/// A new array of zeros, which becomes one of NumPy.
template <class T>
class New {
 public:
  explicit New(Shape shape) : shape_(std::move(shape)) {
    std::size_t size = 1;
    for (const std::size_t n : shape_) size *= n;
    values_ = std::make_unique<T[]>(size);
  }
  T* data() { return values_.get(); }
  /// The array, which this no longer owns.
  nb::object numpy() {
    T* data = values_.get();
    nb::capsule owner(data, [](void* p) noexcept { delete[] static_cast<T*>(p); });
    values_.release();
    return nb::cast(nb::ndarray<nb::numpy, T>(data, shape_.size(), shape_.data(), owner));
  }

 private:
  Shape shape_;
  std::unique_ptr<T[]> values_;
};

/// An argument that `array` checks, None included.
inline auto array_arg(const char* name) { return nb::arg(name).none(); }

}  // namespace vbbench
