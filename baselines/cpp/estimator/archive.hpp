// Serialisation of an estimator's state: a copy gives the same answers as the original.
#pragma once

#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "state.hpp"

namespace vbbench {

/// Appends values to bytes.
class Writer {
 public:
  std::string bytes;

  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(values.size());
    for (const T& value : values) (*this)(value);
  }
  void operator()(const Person& person) { const_cast<Person&>(person).archive(*this); }
  void operator()(const Matrix& matrix) {
    for (int i = 0; i < matrix.rows(); ++i)
      for (int j = 0; j < matrix.cols(); ++j) (*this)(matrix[i][j]);
  }
};

/// Reads the same values from bytes; `good` is whether their number matches.
class Reader {
 public:
  Reader(const char* begin, std::size_t size) : at_(begin), left_(size) {}

  template <class T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    good_ = good_ && left_ >= sizeof value;
    if (!good_) return;
    std::memcpy(static_cast<void*>(&value), at_, sizeof value);
    at_ += sizeof value;
    left_ -= sizeof value;
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    std::size_t count = 0;
    (*this)(count);
    good_ = good_ && count <= left_;
    values.clear();
    for (std::size_t i = 0; good_ && i < count; ++i) {
      values.emplace_back();
      (*this)(values.back());
    }
  }
  void operator()(Person& person) { person.archive(*this); }
  void operator()(Matrix& matrix) {
    for (int i = 0; i < matrix.rows(); ++i)
      for (int j = 0; j < matrix.cols(); ++j) (*this)(matrix[i][j]);
  }
  bool good() const { return good_ && left_ == 0; }

 private:
  const char* at_;
  std::size_t left_;
  bool good_ = true;
};

}  // namespace vbbench
