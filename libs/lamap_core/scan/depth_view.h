#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

namespace lamap
{
/// Parameters of a sensor's field of view. Lengths in metres.
struct FieldRules
{
  double near_m = 0.3;     ///< points within this distance of the sensor are in its field
  double depth_m = 0.3;    ///< the field extends this far behind the end of a ray
  double angle_deg = 2.5;  ///< width of the bins of directions, (0, 90]
};

/** The perceptual field from one sensor position: a depth image by azimuth and elevation, in bins of equal
 * angles.
 *
 * A point is in the field if it is within the maximum range, and either within `near_m` of the sensor or not
 * farther from it than the longest ray of its bin plus `depth_m`. It is open if it is within `near_m`, or not
 * farther than the shortest ray of its bin and of the bins above and below, the next rings of a lidar. At the
 * edge of the field, where one of these two has no rays, what its shortest ray met is taken to go on level,
 * as a floor or a ceiling does, to the far side of the bin. In a planar map all elevations are 0, and a place
 * is open as far as the shortest ray of its fifth of a bin or, if that has none, of the next fifths to its
 * left and right that have. The same on every processor. Immutable once filled: may be shared between
 * threads. */
class DepthView
{
 public:
  DepthView() = default;
  /// @param sensor [m] in any frame; @param rangeMax_m > 0, infinite if there is no limit
  DepthView(const Eigen::Vector3d& sensor, double rangeMax_m, const FieldRules& rules, bool planar);

  /// Adds the end of a ray [m], relative to the sensor. Must not be zero.
  void addRay(const Eigen::Vector3d& fromSensor);
  /// Must be called after the last ray: crops the image to the bins with rays.
  void finish();

  /// @param place [m] in the frame of `sensor`.
  [[nodiscard]] bool contains(const Eigen::Vector3d& place) const
  {
    Seen seen;
    addSeen({place, place, place, place}, seen);
    return seen.inField[0];
  }
  /// What a view sees of four points.
  struct Seen
  {
    std::array<bool, 4> inField{};
    std::array<bool, 4> open{};
  };
  /// Four points at once, which costs no more than one: sets to true what holds of them.
  void addSeen(const std::array<Eigen::Vector3d, 4>& places, Seen& seen) const;

  /// The image, for files: depths by row of elevation, then azimuth; 0 in bins without rays.
  struct Image
  {
    Eigen::Vector3d sensor = Eigen::Vector3d::Zero();
    double rangeMax_m = 0;
    FieldRules rules;
    bool planar = false;
    uint32_t firstRow = 0;
    uint32_t firstColumn = 0;
    uint32_t rows = 0;
    uint32_t columns = 0;
    std::vector<float> depths_m;
    /// How far each part of a bin is open, as a share of its depth in 1/255, rounded down; partsOfBin() a
    /// bin.
    std::vector<uint8_t> openShares;

    [[nodiscard]] uint32_t partsOfBin() const { return planar ? 5 : 1; }

    friend bool operator==(const Image& a, const Image& b);
  };
  [[nodiscard]] const Image& image() const { return image_; }
  /// @throws std::runtime_error if finish() cannot have produced the image.
  static DepthView fromImage(Image image);

  [[nodiscard]] size_t memoryBytes() const
  {
    return sizeof(*this) + image_.depths_m.capacity() * sizeof(float) + image_.openShares.capacity();
  }

 private:
  using Four = Eigen::Array4f;
  struct Bins
  {
    Four rows;  ///< not rounded yet
    Four columns;
  };
  void countBins();
  /// The shortest ray of a part of a bin.
  struct Shortest
  {
    float length_m = 0;  ///< 0: there is no ray
    float row = 0;       ///< its elevation, not rounded
    float sine = 0;      ///< of its elevation
  };
  [[nodiscard]] const Shortest& shortestOf(int64_t row, uint32_t part) const;
  [[nodiscard]] float shortestBeside(uint32_t part) const;
  [[nodiscard]] float shortestAround(int64_t row, uint32_t column) const;
  [[nodiscard]] float lengthBeyond(int64_t row, uint32_t column, int outwards) const;
  [[nodiscard]] float openTo(uint32_t row, uint32_t part) const;
  [[nodiscard]] Bins binsOf(const Four& x, const Four& y, const Four& z) const;
  [[nodiscard]] uint32_t rowOf(float bin) const { return std::min(allRows_ - 1, static_cast<uint32_t>(bin)); }
  [[nodiscard]] uint32_t columnOf(float bin) const
  {
    return std::min(allColumns_ - 1, static_cast<uint32_t>(bin));
  }
  /// Part of the bin of this column.
  [[nodiscard]] uint32_t partOf(float bin, uint32_t column) const
  {
    const uint32_t parts = image_.partsOfBin();
    const float within = (bin - static_cast<float>(column)) * static_cast<float>(parts);
    return std::min(parts - 1, static_cast<uint32_t>(within));
  }

  Image image_;
  std::vector<Shortest> shortest_;  ///< of each part of a bin, until finish()
  uint32_t allRows_ = 0;
  uint32_t allColumns_ = 0;
};

}  // namespace lamap
