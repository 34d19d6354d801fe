#pragma once

/** The only header that knows MRPT's versions: 2.5 (Debian 12), 2.14 (Debian 13), 2.15.
 *
 * Differences are detected by features, not by the version number, whose format also changed. Contains only
 * what our code needs.
 */

#include <mrpt/core/exceptions.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/CSimpleMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include <Eigen/Core>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

// MRPT 2.11.3 brought NearestNeighborsCapable and the virtual CMetricMap::boundingBox().
#if __has_include(<mrpt/maps/NearestNeighborsCapable.h>)
#define LAMAP_MRPT_SINCE_2_11_3 1
/// For methods that override one of CMetricMap since MRPT 2.11.3 but not before.
#define LAMAP_OVERRIDE_SINCE_2_11_3 override
#include <mrpt/maps/NearestNeighborsCapable.h>
#else
#define LAMAP_MRPT_SINCE_2_11_3 0
#define LAMAP_OVERRIDE_SINCE_2_11_3
#endif

namespace lamap::compat
{
/// What the factories of a map class return: pointers, which the caller owns, or shared pointers.
using CreatedDefinition = mrpt::maps::internal::MapDefCtorFunctor::result_type;
using CreatedMap = mrpt::maps::internal::MapCtorFromDefFunctor::result_type;
/// The same for a map of known class.
template <typename Map>
using CreatedOf = std::conditional_t<std::is_pointer_v<CreatedMap>, Map*, std::shared_ptr<Map>>;

/// Hands a new object over in the form that this MRPT's factories take.
template <typename Created = CreatedMap, typename T>
[[nodiscard]] Created handOver(std::unique_ptr<T> object)
{
  if constexpr (std::is_pointer_v<Created>)
    return object.release();
  else
    return Created(std::move(object));
}

/// An exception's message, without the source lines and call stack that MRPT adds to it.
[[nodiscard]] std::string messageOf(const std::exception& error);

namespace detail
{
/// Whether a type has what an expression asks of it.
template <template <typename> typename Expression, typename T, typename = void>
inline constexpr bool has = false;
template <template <typename> typename Expression, typename T>
inline constexpr bool has<Expression, T, std::void_t<Expression<T>>> = true;

template <typename T>
using KeyframePose = decltype(std::declval<const T&>().get(std::size_t{}).pose);
template <typename T>
using OrganizedPoints = decltype(std::declval<const T&>().organizedPoints);
template <typename T>
using ExternallyStored = decltype(std::declval<const T&>().isExternallyStored());
template <typename T>
using ConeAperture = decltype(std::declval<const T&>().sensorConeAperture);
}  // namespace detail

/// One pose of a simple map and the observations from it.
struct Keyframe
{
  mrpt::poses::CPose3DPDF::ConstPtr pose;
  mrpt::obs::CSensoryFrame::ConstPtr frame;
};

/// The i-th keyframe of a simple map: a pair in MRPT 2.5, a struct that also has a twist since 2.11.
template <typename SimpleMap = mrpt::maps::CSimpleMap>
[[nodiscard]] Keyframe keyframeAt(const SimpleMap& map, std::size_t index)
{
  if constexpr (detail::has<detail::KeyframePose, SimpleMap>)
  {
    const auto& keyframe = map.get(index);
    return {keyframe.pose, keyframe.sf};
  }
  else
  {
    const auto pair = map.getAsPair(index);
    return {pair.pose, pair.sf};
  }
}

/// Opening angle of a range finder's cone [rad]; the member was misspelt in MRPT 2.5.
template <typename Range = mrpt::obs::CObservationRange>
[[nodiscard]] double coneApertureOf(const Range& range)
{
  if constexpr (detail::has<detail::ConeAperture, Range>)
    return range.sensorConeAperture;
  else
    return range.sensorConeApperture;
}

template <typename Range = mrpt::obs::CObservationRange>
void setConeAperture(Range& range, double aperture_rad)
{
  if constexpr (detail::has<detail::ConeAperture, Range>)
    range.sensorConeAperture = static_cast<float>(aperture_rad);
  else
    range.sensorConeApperture = static_cast<float>(aperture_rad);
}

/// CObservationRotatingScan is always in memory in MRPT 2.5, and may be stored externally in later versions.
template <typename Rotating = mrpt::obs::CObservationRotatingScan>
[[nodiscard]] bool isExternallyStored([[maybe_unused]] const Rotating& rotating)
{
  if constexpr (detail::has<detail::ExternallyStored, Rotating>)
    return rotating.isExternallyStored();
  else
    return false;
}

/// Whether a rotating scan has its points, or may have them in external storage (never in MRPT 2.5).
template <typename Rotating = mrpt::obs::CObservationRotatingScan>
[[nodiscard]] bool hasOrganizedPoints([[maybe_unused]] const Rotating& rotating)
{
  if constexpr (detail::has<detail::OrganizedPoints, Rotating>)
    return isExternallyStored(rotating) || rotating.organizedPoints.size() != 0;
  else
    return false;
}

/// Calls visit(Eigen::Vector3d) for each organized point that has a range, in the sensor's frame.
template <typename Visitor, typename Rotating = mrpt::obs::CObservationRotatingScan>
void forEachOrganizedPoint([[maybe_unused]] const Rotating& rotating, [[maybe_unused]] const Visitor& visit)
{
  if constexpr (detail::has<detail::OrganizedPoints, Rotating>)
  {
    const auto& points = rotating.organizedPoints;
    if (points.rows() != rotating.rangeImage.rows() || points.cols() != rotating.rangeImage.cols())
      throw std::runtime_error("its points and its range image differ in size");
    for (int row = 0; row < points.rows(); ++row)
      for (int column = 0; column < points.cols(); ++column)
        if (rotating.rangeImage(row, column) != 0)
          visit(Eigen::Vector3d(points(row, column).x, points(row, column).y, points(row, column).z));
  }
}

}  // namespace lamap::compat
