#include <lamap_mrpt/compat/mrpt_compat.h>
#include <lamap_mrpt/observations/observation_fingerprint.h>
#include <mrpt/maps/CPointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRotatingScan.h>
#include <mrpt/obs/CObservationVelodyneScan.h>

#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace lamap
{
namespace
{
using mrpt::obs::CObservation;
using mrpt::obs::CObservation2DRangeScan;
using mrpt::obs::CObservation3DRangeScan;
using mrpt::obs::CObservationPointCloud;
using mrpt::obs::CObservationRotatingScan;
using mrpt::obs::CObservationVelodyneScan;

/// Two independent multiply-and-rotate sums over 8 bytes at a time; for recognition, not against an attacker.
class Hasher
{
 public:
  void bytes(const void* first, size_t count)
  {
    const auto* at = static_cast<const unsigned char*>(first);
    word(count);
    for (; count >= sizeof(uint64_t); at += sizeof(uint64_t), count -= sizeof(uint64_t))
    {
      uint64_t next;
      std::memcpy(&next, at, sizeof(next));
      word(next);
    }
    uint64_t rest = 0;
    if (count > 0) std::memcpy(&rest, at, count);  // an empty vector has no memory
    word(rest);
  }

  template <typename... Numbers>
  void numbers(Numbers... all)
  {
    (number(all), ...);
  }
  void text(std::string_view characters) { bytes(characters.data(), characters.size()); }
  template <typename... Vectors>
  void vectors(const Vectors&... all)
  {
    (bytes(all.data(), all.size() * sizeof(all[0])), ...);
  }
  template <typename T>
  void matrix(const mrpt::math::CMatrixDynamic<T>& image)
  {
    number(image.rows());
    if (image.size() == 0) return;  // MRPT refuses a pointer to an empty image
    bytes(image.data(), static_cast<size_t>(image.rows()) * static_cast<size_t>(image.cols()) * sizeof(T));
  }
  void pose(const mrpt::poses::CPose3D& pose)
  {
    numbers(pose.x(), pose.y(), pose.z(), pose.yaw(), pose.pitch(), pose.roll());
  }

  [[nodiscard]] ObservationFingerprint result() const { return {a_, b_}; }

 private:
  template <typename T>
  void number(T number)
  {
    static_assert(std::is_arithmetic_v<T>);
    uint64_t bits = 0;
    std::memcpy(&bits, &number, sizeof(number));
    word(bits);
  }
  void word(uint64_t next)
  {
    a_ = (a_ ^ next) * 0x9E3779B97F4A7C15ULL;
    a_ ^= a_ >> 32;
    b_ = ((b_ << 23 | b_ >> 41) + next) * 0xD6E8FEB86659FD93ULL;
  }

  uint64_t a_ = 0x243F6A8885A308D3ULL;
  uint64_t b_ = 0x13198A2E03707344ULL;
};

void add(Hasher& hasher, const CObservation2DRangeScan& scan)
{
  hasher.pose(scan.sensorPose);
  hasher.numbers(scan.aperture, scan.rightToLeft, scan.maxRange, scan.deltaPitch);
  const size_t count = scan.getScanSize();
  if (count == 0) return;
  static_assert(std::is_same_v<decltype(scan.getScanRange(0)), const float&>, "ranges are kept in a row");
  hasher.bytes(&scan.getScanRange(0), count * sizeof(float));
  uint64_t valid = 0;
  for (size_t i = 0; i < count; ++i)
  {
    valid = valid << 1 | (scan.getScanRangeValidity(i) ? 1u : 0u);
    if (i % 64 == 63) hasher.numbers(std::exchange(valid, 0));
  }
  hasher.numbers(valid);
}

void add(Hasher& hasher, const CObservation3DRangeScan& scan)
{
  hasher.pose(scan.sensorPose);
  hasher.numbers(scan.maxRange, scan.hasRangeImage, scan.hasPoints3D, scan.rangeUnits, scan.range_is_depth);
  const mrpt::img::TCamera& camera = scan.cameraParams;
  hasher.numbers(camera.fx(), camera.fy(), camera.cx(), camera.cy(), camera.nrows, camera.ncols);
  hasher.vectors(camera.dist);
  if (scan.rangeImage_isExternallyStored()) hasher.text(scan.rangeImage_getExternalStorageFile(""));
  if (scan.points3D_isExternallyStored()) hasher.text(scan.points3D_getExternalStorageFile());
  hasher.matrix(scan.rangeImage);
  hasher.vectors(scan.points3D_x, scan.points3D_y, scan.points3D_z);
}

void add(Hasher& hasher, const CObservationPointCloud& cloud)
{
  hasher.pose(cloud.sensorPose);
  if (cloud.isExternallyStored()) hasher.text(cloud.getExternalStorageFile());
  if (!cloud.pointcloud) return;
  const auto& points = *cloud.pointcloud;
  hasher.vectors(points.getPointsBufferRef_x(), points.getPointsBufferRef_y(), points.getPointsBufferRef_z());
}

void add(Hasher& hasher, const CObservationVelodyneScan& scan)
{
  hasher.pose(scan.sensorPose);
  hasher.numbers(scan.minRange, scan.maxRange);
  hasher.vectors(scan.point_cloud.x, scan.point_cloud.y, scan.point_cloud.z, scan.scan_packets,
                 scan.calibration.laser_corrections);
}

void add(Hasher& hasher, const CObservationRotatingScan& scan)
{
  hasher.pose(scan.sensorPose);
  hasher.numbers(scan.rowCount, scan.minRange, scan.maxRange, scan.rangeResolution, scan.startAzimuth,
                 scan.azimuthSpan);
  hasher.text(scan.lidarModel);
  hasher.matrix(scan.rangeImage);
}

template <typename Observation>
std::optional<ObservationFingerprint> fingerprintIf(const CObservation& observation)
{
  const auto* typed = dynamic_cast<const Observation*>(&observation);
  if (!typed) return std::nullopt;
  Hasher hasher;
  hasher.text(typed->GetRuntimeClass()->className);
  add(hasher, *typed);
  return hasher.result();
}
}  // namespace

std::optional<ObservationFingerprint> fingerprintOf(const CObservation& observation)
{
  if (const auto print = fingerprintIf<CObservation2DRangeScan>(observation)) return print;
  if (const auto print = fingerprintIf<CObservationPointCloud>(observation)) return print;
  if (const auto print = fingerprintIf<CObservation3DRangeScan>(observation)) return print;
  if (const auto print = fingerprintIf<CObservationVelodyneScan>(observation)) return print;
  const auto* rotating = dynamic_cast<const CObservationRotatingScan*>(&observation);
  // Organized points are not part of the fingerprint.
  if (rotating && compat::hasOrganizedPoints(*rotating)) return std::nullopt;
  return fingerprintIf<CObservationRotatingScan>(observation);
}

}  // namespace lamap
