#include <lamap_core/scan/depth_view.h>
#include <lamap_core/scan/direction_angles.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lamap
{
namespace
{
using Four = Eigen::Array4f;
constexpr double kPi = 3.141592653589793;

constexpr double kWholeShare = 255;

uint8_t shareOf(float shortest_m, float depth_m)
{
  constexpr double kRounding = 1e-3;  // rays that are equally long but for rounding are equally long
  const double share = static_cast<double>(shortest_m) / static_cast<double>(depth_m) * kWholeShare;
  return static_cast<uint8_t>(std::min(share + kRounding, kWholeShare));
}

auto fieldsOf(const DepthView::Image& i)
{
  return std::tie(i.sensor.x(), i.sensor.y(), i.sensor.z(), i.rangeMax_m, i.rules.near_m, i.rules.depth_m,
                  i.rules.angle_deg, i.planar, i.firstRow, i.firstColumn, i.rows, i.columns, i.depths_m,
                  i.openShares);
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
  shortest_.assign(image_.depths_m.size() * image_.partsOfBin(), {});
}

void DepthView::countBins()
{
  allColumns_ = static_cast<uint32_t>(std::ceil(360.0 / image_.rules.angle_deg));
  allRows_ = image_.planar ? 1 : static_cast<uint32_t>(std::ceil(180.0 / image_.rules.angle_deg));
}

DepthView::Bins DepthView::binsOf(const Four& x, const Four& y, const Four& z) const
{
  const auto binsPerRadian = static_cast<float>(180.0 / kPi / image_.rules.angle_deg);
  constexpr auto kPiF = static_cast<float>(kPi);
  Bins bins;
  bins.columns = (anglesOf(y, x) + kPiF) * binsPerRadian;
  bins.rows = Four::Zero();
  if (image_.planar) return bins;
  const Four xx = x * x;
  const Four yy = y * y;
  const Four across = (xx + yy).sqrt();
  bins.rows = (anglesOf(z, across) + 0.5f * kPiF).max(0.0f) * binsPerRadian;
  return bins;
}

void DepthView::addRay(const Eigen::Vector3d& fromSensor)
{
  Eigen::Vector3d ray = fromSensor;
  if (image_.planar) ray.z() = 0;
  const Bins bins =
      binsOf(Four::Constant(static_cast<float>(ray.x())), Four::Constant(static_cast<float>(ray.y())),
             Four::Constant(static_cast<float>(ray.z())));
  const uint32_t column = columnOf(bins.columns[0]);
  const size_t bin = size_t{rowOf(bins.rows[0])} * allColumns_ + column;
  const auto length = static_cast<float>(std::sqrt(ray.squaredNorm()));
  image_.depths_m[bin] = std::max(image_.depths_m[bin], length);
  Shortest& shortest = shortest_[bin * image_.partsOfBin() + partOf(bins.columns[0], column)];
  const Shortest own{length, bins.rows[0], static_cast<float>(ray.z()) / length};
  const bool isShorter = std::tie(own.length_m, own.row) < std::tie(shortest.length_m, shortest.row);
  if (!(shortest.length_m > 0) || isShorter) shortest = own;
}

/// @param row there may be none of this number. @param part of all parts of the row's bins
const DepthView::Shortest& DepthView::shortestOf(int64_t row, uint32_t part) const
{
  static const Shortest kNone;
  if (row < 0 || row >= int64_t{allRows_}) return kNone;
  return shortest_[static_cast<size_t>(row) * allColumns_ * image_.partsOfBin() + part];
}

/// Of the only row, before the image is cropped: the shorter of the next rays to the left and to the right of
/// a part without rays, at most two bins away.
float DepthView::shortestBeside(uint32_t part) const
{
  const uint32_t count = allColumns_ * image_.partsOfBin();
  float left = 0;
  float right = 0;
  for (uint32_t step = 1; step <= std::min(2 * image_.partsOfBin(), count - 1); ++step)
  {
    if (!(left > 0)) left = shortestOf(0, (part + count - step) % count).length_m;
    if (!(right > 0)) right = shortestOf(0, (part + step) % count).length_m;
  }
  return left > 0 && right > 0 ? std::min(left, right) : std::max(left, right);
}

/// Of the bin, the one above and the one below, before the image is cropped.
float DepthView::shortestAround(int64_t row, uint32_t column) const
{
  float shortest = shortestOf(row, column).length_m;
  for (const int side : {-1, 1})
  {
    const float beside = shortestOf(row + side, column).length_m;
    if (beside > 0) shortest = std::min(shortest, beside);
    // A floor goes on below the lowest ring that meets it, a ceiling above the highest one.
    shortest = std::min(shortest, lengthBeyond(row, column, side));
  }
  return shortest;
}

/** At the edge of the field: how long rays would be at the far side of the bin if the shortest one met a
 * level floor or ceiling; else infinite. @param outwards −1: downwards, 1: upwards */
float DepthView::lengthBeyond(int64_t row, uint32_t column, int outwards) const
{
  constexpr float kUnlimited = std::numeric_limits<float>::infinity();
  const Shortest& edge = shortestOf(row, column);
  const float sine = edge.sine * static_cast<float>(outwards);
  const bool isEdge = !(shortestOf(row + outwards, column).length_m > 0);
  if (!isEdge || !(sine > 0)) return kUnlimited;
  const auto farSide = static_cast<float>(outwards < 0 ? row : row + 1);
  const auto bin_rad = static_cast<float>(image_.rules.angle_deg * kPi / 180);
  const float turn = std::abs(farSide - edge.row) * bin_rad;
  const float cosine = std::sqrt(std::max(0.0f, 1 - sine * sine));
  const float squared = turn * turn;
  const float sineOfTurn = turn * (1 - squared / 6 * (1 - squared / 20));
  const float cosineOfTurn = 1 - squared / 2 * (1 - squared / 12);
  return edge.length_m * sine / (sine * cosineOfTurn + cosine * sineOfTurn);
}

float DepthView::openTo(uint32_t row, uint32_t part) const
{
  if (!image_.planar) return shortestAround(row, part);
  const float own = shortestOf(row, part).length_m;
  return own > 0 ? own : shortestBeside(part);
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
  const uint32_t parts = image_.partsOfBin();
  cut.openShares.reserve(size_t{cut.rows} * cut.columns * parts);
  for (uint32_t row = 0; row < cut.rows; ++row)
  {
    const float* from = image_.depths_m.data() + size_t{cut.firstRow + row} * allColumns_ + cut.firstColumn;
    cut.depths_m.insert(cut.depths_m.end(), from, from + cut.columns);
    for (uint32_t part = 0; part < cut.columns * parts; ++part)
    {
      const float depth = from[part / parts];
      const uint32_t inRow = cut.firstColumn * parts + part;
      cut.openShares.push_back(depth > 0 ? shareOf(openTo(cut.firstRow + row, inRow), depth) : uint8_t{0});
    }
  }
  shortest_ = {};
  image_ = std::move(cut);
}

void DepthView::addSeen(const std::array<Eigen::Vector3d, 4>& places, Seen& seen) const
{
  Four x;
  Four y;
  Four z;
  for (size_t i = 0; i < 4; ++i)
  {
    const auto lane = static_cast<int>(i);
    x[lane] = static_cast<float>(places[i].x() - image_.sensor.x());
    y[lane] = static_cast<float>(places[i].y() - image_.sensor.y());
    z[lane] = image_.planar ? 0.0f : static_cast<float>(places[i].z() - image_.sensor.z());
  }
  const Four xx = x * x;
  const Four yy = y * y;
  const Four zz = z * z;
  const Four ranges = ((xx + yy) + zz).sqrt();
  const Bins bins = binsOf(x, y, z);
  for (int i = 0; i < 4; ++i)
  {
    const auto range = static_cast<double>(ranges[i]);
    if (range > image_.rangeMax_m) continue;
    bool& inField = seen.inField[static_cast<size_t>(i)];
    bool& open = seen.open[static_cast<size_t>(i)];
    const bool isNear = range <= image_.rules.near_m;
    inField = inField || isNear;
    open = open || isNear;
    const uint32_t row = rowOf(bins.rows[i]) - image_.firstRow;
    const uint32_t inRow = columnOf(bins.columns[i]);
    const uint32_t column = inRow - image_.firstColumn;
    if (open || row >= image_.rows || column >= image_.columns) continue;
    const size_t bin = size_t{row} * image_.columns + column;
    const float depth = image_.depths_m[bin];
    inField = inField || (depth > 0 && range <= static_cast<double>(depth) + image_.rules.depth_m);
    const size_t part = bin * image_.partsOfBin() + partOf(bins.columns[i], inRow);
    open = range * kWholeShare <= static_cast<double>(depth) * image_.openShares[part];
  }
}

DepthView DepthView::fromImage(Image image)
{
  const auto refuse = [](const char* what)
  { throw std::runtime_error(std::string("a depth image of the map is corrupt: ") + what); };
  const FieldRules& rules = image.rules;
  if (!image.sensor.allFinite()) refuse("its sensor is nowhere");
  if (!(image.rangeMax_m > 0)) refuse("its range is not positive");
  constexpr double kMost_m = 1e6;
  const auto isLength = [](double length_m) { return length_m >= 0 && length_m <= kMost_m; };
  if (!isLength(rules.near_m) || !isLength(rules.depth_m) ||
      !(rules.angle_deg >= 0.1 && rules.angle_deg <= 90))
    refuse("its rules are not legal");
  DepthView view;
  view.image_ = std::move(image);
  view.countBins();
  const Image& held = view.image_;
  if (held.rows > view.allRows_ || held.firstRow > view.allRows_ - held.rows ||
      held.columns > view.allColumns_ || held.firstColumn > view.allColumns_ - held.columns)
    refuse("it is larger than its bins");
  const size_t bins = size_t{held.rows} * held.columns;
  if (held.depths_m.size() != bins || held.openShares.size() != bins * held.partsOfBin())
    refuse("its size does not fit its depths");
  if (!std::all_of(held.depths_m.begin(), held.depths_m.end(),
                   [](float depth) { return depth >= 0 && std::isfinite(depth); }))
    refuse("a depth is negative or not finite");
  return view;
}

}  // namespace lamap
