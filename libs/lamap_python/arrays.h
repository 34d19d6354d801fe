#pragma once

#include <lamap_core/scan/scan.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Core>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

namespace lamap::python
{
/** The memory of an array of numbers, of any strides.
 *
 * Arrays of float32 and float64 are read where they are. Others, whole numbers and nested lists for example,
 * are converted first. Reading needs no GIL. */
class Numbers
{
 public:
  /// @param name  in messages
  /// @throws TypeError unless these are real numbers
  Numbers(const pybind11::handle& numbers, std::string name);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<pybind11::ssize_t>& shape() const { return shape_; }
  [[nodiscard]] std::string shapeText() const;
  /// @throws std::invalid_argument "<name>: must have the shape <due>, not <shape>"
  [[noreturn]] void refuseShape(const std::string& due) const;

 protected:
  /// @param offset of the number from the first one [bytes]
  [[nodiscard]] double at(pybind11::ssize_t offset) const
  {
    if (isSingle_)
    {
      float number = 0;
      std::memcpy(&number, first_ + offset, sizeof number);
      return static_cast<double>(number);
    }
    double number = 0;
    std::memcpy(&number, first_ + offset, sizeof number);
    return number;
  }
  [[nodiscard]] const std::vector<pybind11::ssize_t>& strides() const { return strides_; }

 private:
  pybind11::array array_;
  std::string name_;
  std::vector<pybind11::ssize_t> shape_;
  std::vector<pybind11::ssize_t> strides_;
  const char* first_;
  bool isSingle_;
};

/// N vectors, of the shape (N, 3).
class Vectors : public Numbers
{
 public:
  /// @param orOne  the shape (3,) is legal, too: one vector that stands for all
  /// @throws std::invalid_argument for another shape
  Vectors(const pybind11::handle& numbers, const std::string& name, bool orOne = false);

  [[nodiscard]] size_t size() const { return size_; }
  /// Whether it is one vector that stands for all.
  [[nodiscard]] bool isOne() const { return shape().size() == 1; }
  [[nodiscard]] Eigen::Vector3d operator[](size_t i) const
  {
    const pybind11::ssize_t row = isOne() ? 0 : static_cast<pybind11::ssize_t>(i) * strides().front();
    const pybind11::ssize_t step = strides().back();
    return {at(row), at(row + step), at(row + 2 * step)};
  }

 private:
  size_t size_;
};

/// One vector [m]. @throws std::invalid_argument unless it has the shape (3,) and is finite
[[nodiscard]] Eigen::Vector3d vectorOf(const pybind11::handle& numbers, const std::string& name);

/** Poses in the map: a matrix of the shape (4, 4), the six numbers (x, y, z, yaw, pitch, roll) [m, rad], or
 * several of either along a first axis.
 * @throws std::invalid_argument for another shape, what is not finite, or is no rigid motion */
struct Poses
{
  Poses(const pybind11::handle& numbers, const std::string& name);

  std::vector<Scan::Pose> poses;
  bool isOne = true;  ///< without the first axis
};
[[nodiscard]] Scan::Pose onePoseOf(const pybind11::handle& numbers, const std::string& name);

/// A covariance in MRPT's order. @throws std::invalid_argument unless it has the shape (6, 6), is finite and
/// symmetric with no negative variance
[[nodiscard]] Eigen::Matrix<double, 6, 6> covarianceOf(const pybind11::handle& numbers);

/// All numbers of an array, in the order of its axes.
[[nodiscard]] std::vector<double> numbersOf(const pybind11::handle& numbers, const std::string& name);

/// One truth value for each of so many. @throws std::invalid_argument for another shape, TypeError for
/// another type
[[nodiscard]] std::vector<bool> maskOf(const pybind11::handle& flags, const std::string& name, size_t size);

}  // namespace lamap::python
