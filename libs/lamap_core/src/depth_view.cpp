#include <lamap_core/depth_view.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lamap
{
namespace
{
constexpr double kPi = 3.141592653589793;

/// atan(z) for z in [0, 1], error below 2e-6 rad, from additions and multiplications alone.
double arctangent(double z)
{
  const double s = z * z;
  double sum = -0.01172120;
  sum = sum * s + 0.05265332;
  sum = sum * s - 0.11643287;
  sum = sum * s + 0.19354346;
  sum = sum * s - 0.33262347;
  sum = sum * s + 0.99997726;
  return sum * z;
}

/// Angle of (x, y) from the x axis, in [−π, π]; 0 for the origin.
double angleOf(double y, double x)
{
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  const double larger = std::max(ax, ay);
  if (!(larger > 0)) return 0;
  double angle = arctangent(std::min(ax, ay) / larger);
  if (ay > ax) angle = 0.5 * kPi - angle;
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

auto fieldsOf(const DepthView::Image& i)
{
  return std::tie(i.sensor.x(), i.sensor.y(), i.sensor.z(), i.rangeMax_m, i.rules.near_m, i.rules.depth_m,
                  i.rules.angle_deg, i.planar, i.firstRow, i.firstColumn, i.rows, i.columns, i.depths_m);
}

}  // namespace

bool operator==(const DepthView::Image& a, const DepthView::Image& b)
{
  return fieldsOf(a) == fieldsOf(b);
}

DepthView::DepthView(const Eigen::Vector3d& sensor, double rangeMax_m, const FieldRules& rules, bool planar)
{
  image_.sensor = sensor;
  image_.rangeMax_m = rangeMax_m;
  image_.rules = rules;
  image_.planar = planar;
  countBins();
  image_.rows = allRows_;
  image_.columns = allColumns_;
  image_.depths_m.assign(size_t{allRows_} * allColumns_, 0.0f);
}

void DepthView::countBins()
{
  allColumns_ = static_cast<uint32_t>(std::ceil(360.0 / image_.rules.angle_deg));
  allRows_ = image_.planar ? 1 : static_cast<uint32_t>(std::ceil(180.0 / image_.rules.angle_deg));
}

DepthView::Bin DepthView::binOf(const Eigen::Vector3d& direction) const
{
  const double binsPerRadian = 180.0 / kPi / image_.rules.angle_deg;
  const double x = direction.x();
  const double y = direction.y();
  Bin bin{0, 0};
  bin.column = std::min(allColumns_ - 1, static_cast<uint32_t>((angleOf(y, x) + kPi) * binsPerRadian));
  if (image_.planar) return bin;
  const double elevation = angleOf(direction.z(), std::sqrt(x * x + y * y));
  bin.row = std::min(allRows_ - 1, static_cast<uint32_t>((elevation + 0.5 * kPi) * binsPerRadian));
  return bin;
}

void DepthView::addRay(const Eigen::Vector3d& fromSensor)
{
  Eigen::Vector3d ray = fromSensor;
  if (image_.planar) ray.z() = 0;
  const Bin bin = binOf(ray);
  float& depth = image_.depths_m[size_t{bin.row} * allColumns_ + bin.column];
  depth = std::max(depth, static_cast<float>(std::sqrt(ray.squaredNorm())));
}

void DepthView::finish()
{
  Image cut = image_;
  uint32_t lowRow = allRows_;
  uint32_t highRow = 0;
  uint32_t lowColumn = allColumns_;
  uint32_t highColumn = 0;
  for (uint32_t row = 0; row < allRows_; ++row)
    for (uint32_t column = 0; column < allColumns_; ++column)
    {
      if (!(image_.depths_m[size_t{row} * allColumns_ + column] > 0)) continue;
      lowRow = std::min(lowRow, row);
      highRow = std::max(highRow, row);
      lowColumn = std::min(lowColumn, column);
      highColumn = std::max(highColumn, column);
    }
  cut.depths_m.clear();
  const bool any = lowRow < allRows_;
  cut.firstRow = any ? lowRow : 0;
  cut.firstColumn = any ? lowColumn : 0;
  cut.rows = any ? highRow - lowRow + 1 : 0;
  cut.columns = any ? highColumn - lowColumn + 1 : 0;
  cut.depths_m.reserve(size_t{cut.rows} * cut.columns);
  for (uint32_t row = 0; row < cut.rows; ++row)
  {
    const float* from = image_.depths_m.data() + size_t{cut.firstRow + row} * allColumns_ + cut.firstColumn;
    cut.depths_m.insert(cut.depths_m.end(), from, from + cut.columns);
  }
  image_ = std::move(cut);
}

bool DepthView::contains(const Eigen::Vector3d& place) const
{
  Eigen::Vector3d direction = place - image_.sensor;
  if (image_.planar) direction.z() = 0;
  const double range = std::sqrt(direction.squaredNorm());
  if (range > image_.rangeMax_m) return false;
  if (range <= image_.rules.near_m) return true;
  const Bin bin = binOf(direction);
  const uint32_t row = bin.row - image_.firstRow;
  const uint32_t column = bin.column - image_.firstColumn;
  if (row >= image_.rows || column >= image_.columns) return false;
  const float depth = image_.depths_m[size_t{row} * image_.columns + column];
  return depth > 0 && range <= static_cast<double>(depth) + image_.rules.depth_m;
}

DepthView DepthView::fromImage(Image image)
{
  const auto refuse = [](const char* what)
  { throw std::runtime_error(std::string("a depth image of the map is corrupt: ") + what); };
  const FieldRules& rules = image.rules;
  if (!image.sensor.allFinite()) refuse("its sensor is nowhere");
  if (!(image.rangeMax_m > 0)) refuse("its range is not positive");
  if (!(rules.near_m >= 0) || !(rules.depth_m >= 0) || !(rules.angle_deg >= 0.1 && rules.angle_deg <= 90))
    refuse("its rules are not legal");
  DepthView view;
  view.image_ = std::move(image);
  view.countBins();
  const Image& held = view.image_;
  if (held.rows > view.allRows_ || held.firstRow > view.allRows_ - held.rows ||
      held.columns > view.allColumns_ || held.firstColumn > view.allColumns_ - held.columns)
    refuse("it is larger than its bins");
  if (held.depths_m.size() != size_t{held.rows} * held.columns) refuse("its size does not fit its depths");
  if (!std::all_of(held.depths_m.begin(), held.depths_m.end(),
                   [](float depth) { return depth >= 0 && std::isfinite(depth); }))
    refuse("a depth is none");
  return view;
}

}  // namespace lamap
