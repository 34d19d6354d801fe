#include <lamap_core/options/legal_range.h>
#include <lamap_mrpt/observations/isometry.h>
#include <lamap_python/arrays.h>
#include <mrpt/poses/CPose3D.h>

#include <Eigen/Geometry>
#include <stdexcept>

namespace py = pybind11;

namespace lamap::python
{
namespace
{
bool isReadInPlace(const py::dtype& type)
{
  const bool isNative = type.byteorder() == '=' || type.byteorder() == '|';
  return type.kind() == 'f' && (type.itemsize() == 4 || type.itemsize() == 8) && isNative;
}

py::array asNumbers(const py::handle& numbers, const std::string& name)
{
  const auto array = py::array::ensure(numbers);
  if (!array) throw py::type_error(name + ": must be an array of numbers");
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw py::type_error(name + ": must be an array of numbers, not of dtype " +
                         std::string(py::str(array.dtype())));
  if (isReadInPlace(array.dtype())) return array;
  return py::array_t<double, py::array::forcecast>(array);
}
}  // namespace

Numbers::Numbers(const py::handle& numbers, std::string name)
    : array_(asNumbers(numbers, name)),
      name_(std::move(name)),
      shape_(array_.shape(), array_.shape() + array_.ndim()),
      strides_(array_.strides(), array_.strides() + array_.ndim()),
      first_(static_cast<const char*>(array_.data())),
      isSingle_(array_.itemsize() == 4)
{
}

std::string Numbers::shapeText() const
{
  std::string text = "(";
  for (size_t axis = 0; axis < shape_.size(); ++axis)
    text += (axis == 0 ? "" : ", ") + std::to_string(shape_[axis]);
  return text + (shape_.size() == 1 ? ",)" : ")");
}

void Numbers::refuseShape(const std::string& due) const
{
  throw std::invalid_argument(name_ + ": must have the shape " + due + ", not " + shapeText());
}

Vectors::Vectors(const py::handle& numbers, const std::string& name, bool orOne)
    : Numbers(numbers, name), size_(1)
{
  const bool areVectors = !shape().empty() && shape().back() == 3;
  if (areVectors && shape().size() == 2)
    size_ = static_cast<size_t>(shape().front());
  else if (!(areVectors && shape().size() == 1 && orOne))
    refuseShape(orOne ? "(N, 3) or (3,)" : "(N, 3)");
}

Eigen::Vector3d vectorOf(const py::handle& numbers, const std::string& name)
{
  const Vectors vector(numbers, name, true);
  if (!vector.isOne()) vector.refuseShape("(3,)");
  if (!vector[0].allFinite()) throw std::invalid_argument(name + ": must be finite");
  return vector[0];
}

namespace
{
/// Numbers of any shape, in the order of their axes.
struct AllNumbers : public Numbers
{
  AllNumbers(const py::handle& numbers, const std::string& name) : Numbers(numbers, name) { append(0, 0); }
  std::vector<double> all;

 private:
  void append(size_t axis, py::ssize_t offset)
  {
    if (axis == shape().size())
    {
      all.push_back(at(offset));
      return;
    }
    for (py::ssize_t i = 0; i < shape()[axis]; ++i) append(axis + 1, offset + i * strides()[axis]);
  }
};

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

/// Equal poses shall give equal bytes.
Scan::Pose withoutNegativeZeros(const Scan::Pose& pose)
{
  return Scan::Pose(Eigen::Matrix4d(pose.matrix().array() + 0.0));
}

Scan::Pose poseFromMatrix(const RowMajor4& matrix, const std::string& name)
{
  Scan::Pose pose = Scan::Pose::Identity();
  pose.linear() = matrix.topLeftCorner<3, 3>();
  pose.translation() = matrix.topRightCorner<3, 1>();
  // Text and float32 round rotations.
  constexpr double kRounded = 1e-3;
  const Eigen::Matrix3d rotation = pose.linear();
  const double off = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off > kRounded || rotation.determinant() < 0 || matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1))
    throw std::invalid_argument(
        name +
        ": must be a rigid motion: a rotation R, a translation, and 0, 0, 0, 1; R times its "
        "transpose may be off by 0.001, not by " +
        roundedText(off));
  if (!isRotation(rotation)) pose.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  return withoutNegativeZeros(pose);
}

Scan::Pose poseFromAngles(const double* numbers)
{
  const mrpt::poses::CPose3D pose(numbers[0], numbers[1], numbers[2], numbers[3], numbers[4], numbers[5]);
  return withoutNegativeZeros(Scan::Pose(isometryOf(pose).matrix()));
}
}  // namespace

Poses::Poses(const py::handle& numbers, const std::string& name)
{
  const AllNumbers given(numbers, name);
  const auto& shape = given.shape();
  const size_t axes = shape.size();
  const bool areMatrices = axes >= 2 && axes <= 3 && shape[axes - 1] == 4 && shape[axes - 2] == 4;
  const bool areAngles = axes >= 1 && axes <= 2 && shape[axes - 1] == 6;
  if (!areMatrices && !areAngles)
    throw std::invalid_argument(
        name + ": must be a (4, 4) matrix or the 6 numbers x, y, z, yaw, pitch, roll, not of shape " +
        given.shapeText());
  if (!Eigen::Map<const Eigen::ArrayXd>(given.all.data(), static_cast<Eigen::Index>(given.all.size()))
           .isFinite()
           .all())
    throw std::invalid_argument(name + ": must be finite");
  isOne = areMatrices ? axes == 2 : axes == 1;
  const size_t each = areMatrices ? 16 : 6;
  for (size_t first = 0; first < given.all.size(); first += each)
  {
    const double* pose = given.all.data() + first;
    poses.push_back(areMatrices ? poseFromMatrix(Eigen::Map<const RowMajor4>(pose), name)
                                : poseFromAngles(pose));
  }
}

Scan::Pose onePoseOf(const py::handle& numbers, const std::string& name)
{
  const Poses poses(numbers, name);
  if (!poses.isOne) throw std::invalid_argument(name + ": must be one pose, not several");
  return poses.poses.front();
}

Eigen::Matrix<double, 6, 6> covarianceOf(const py::handle& numbers)
{
  const AllNumbers given(numbers, "covariance");
  if (given.shape() != std::vector<py::ssize_t>{6, 6}) given.refuseShape("(6, 6)");
  const Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Map<const Eigen::Matrix<double, 6, 6>>(given.all.data());
  const double scale = covariance.cwiseAbs().maxCoeff();
  if (!covariance.allFinite() || !(covariance.diagonal().array() >= 0).all() ||
      !((covariance - covariance.transpose()).cwiseAbs().maxCoeff() <= 1e-6 * scale))
    throw std::invalid_argument("covariance: must be finite and symmetric, with variances >= 0");
  return covariance;
}

std::vector<double> numbersOf(const py::handle& numbers, const std::string& name)
{
  return AllNumbers(numbers, name).all;
}

std::vector<bool> maskOf(const py::handle& flags, const std::string& name, size_t size)
{
  const auto array = py::array::ensure(flags);
  if (!array || array.dtype().kind() != 'b') throw py::type_error(name + ": must be an array of bool");
  if (array.ndim() != 1 || static_cast<size_t>(array.shape(0)) != size)
    throw std::invalid_argument(name + ": must have the shape (" + std::to_string(size) +
                                ",), one for each point");
  std::vector<bool> mask(size);
  const auto read = py::array_t<bool>(array).unchecked<1>();
  for (size_t i = 0; i < size; ++i) mask[i] = read(static_cast<py::ssize_t>(i));
  return mask;
}

}  // namespace lamap::python
