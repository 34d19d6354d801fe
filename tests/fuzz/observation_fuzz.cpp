// Observations of every class with any numbers, into each map: learned or refused, and the map stays sound.
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/maps/CSimplePointsMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationPointCloud.h>
#include <mrpt/obs/CObservationRange.h>
#include <mrpt/obs/CObservationRotatingScan.h>

#include <lamap_mrpt/compat/mrpt_compat.h>

#include "fuzz_input.h"
#include "map_use.h"

namespace
{
using namespace lamap;
using namespace lamap::fuzz;
using mrpt::obs::CObservation;

CObservation::Ptr laserScan(FuzzInput& input)
{
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  scan->aperture = input.shortNumber();
  scan->maxRange = input.shortNumber();
  scan->rightToLeft = input.yesOrNo();
  scan->beamAperture = input.shortNumber();
  scan->stdError = input.shortNumber();
  scan->sensorPose = input.pose();
  const size_t rays = input.below(12);
  scan->resizeScan(rays);
  for (size_t i = 0; i < rays; ++i)
  {
    scan->setScanRange(i, input.shortNumber());
    scan->setScanRangeValidity(i, input.yesOrNo());
  }
  return scan;
}

CObservation::Ptr depthPoints(FuzzInput& input)
{
  auto scan = mrpt::obs::CObservation3DRangeScan::Create();
  scan->maxRange = input.shortNumber();
  scan->sensorPose = input.pose();
  scan->hasPoints3D = true;
  const size_t points = input.below(12);
  scan->points3D_x.resize(points);
  scan->points3D_y.resize(points);
  scan->points3D_z.resize(input.yesOrNo() ? points : input.below(12));
  for (auto* axis : {&scan->points3D_x, &scan->points3D_y, &scan->points3D_z})
    for (float& coordinate : *axis) coordinate = input.shortNumber();
  return scan;
}

CObservation::Ptr depthImage(FuzzInput& input)
{
  auto scan = mrpt::obs::CObservation3DRangeScan::Create();
  scan->maxRange = input.shortNumber();
  scan->sensorPose = input.pose();
  scan->hasRangeImage = true;
  scan->rangeUnits = input.shortNumber();
  scan->range_is_depth = input.yesOrNo();
  const auto rows = static_cast<int>(1 + input.below(6));
  const auto columns = static_cast<int>(1 + input.below(6));
  scan->rangeImage_setSize(rows, columns);
  scan->cameraParams.ncols = static_cast<uint32_t>(columns);
  scan->cameraParams.nrows = static_cast<uint32_t>(rows);
  scan->cameraParams.setIntrinsicParamsFromValues(input.number(), input.number(), input.number(),
                                                  input.number());
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      scan->rangeImage(row, column) = static_cast<uint16_t>(input.below(65536));
  return scan;
}

CObservation::Ptr cloud(FuzzInput& input)
{
  auto points = mrpt::maps::CSimplePointsMap::Create();
  for (size_t count = input.below(12); count > 0; --count)
    points->insertPointFast(input.shortNumber(), input.shortNumber(), input.shortNumber());
  auto observation = mrpt::obs::CObservationPointCloud::Create();
  if (input.yesOrNo()) observation->pointcloud = points;
  observation->sensorPose = input.pose();
  return observation;
}

CObservation::Ptr ranges(FuzzInput& input)
{
  auto observation = mrpt::obs::CObservationRange::Create();
  observation->minSensorDistance = input.shortNumber();
  observation->maxSensorDistance = input.shortNumber();
  compat::setConeAperture(*observation, input.number());
  for (size_t count = input.below(8); count > 0; --count)
  {
    mrpt::obs::CObservationRange::TMeasurement measurement;
    measurement.sensedDistance = input.shortNumber();
    measurement.sensorPose = input.pose().asTPose();
    observation->sensedData.push_back(measurement);
  }
  return observation;
}

CObservation::Ptr rotatingScan(FuzzInput& input)
{
  auto scan = mrpt::obs::CObservationRotatingScan::Create();
  scan->rowCount = static_cast<uint16_t>(input.below(5));
  scan->columnCount = static_cast<uint16_t>(input.below(9));
  scan->rangeResolution = input.number();
  scan->startAzimuth = input.number();
  scan->azimuthSpan = input.number();
  scan->minRange = input.number();
  scan->maxRange = input.number();
  scan->sensorPose = input.pose();
  const size_t rows = input.yesOrNo() ? scan->rowCount : input.below(5);
  scan->rangeImage.resize(rows, scan->columnCount);
  for (size_t row = 0; row < rows; ++row)
    for (size_t column = 0; column < scan->columnCount; ++column)
      scan->rangeImage(row, column) = static_cast<uint16_t>(input.below(65536));
  return scan;
}

CObservation::Ptr observationFor(FuzzInput& input)
{
  using Maker = CObservation::Ptr (*)(FuzzInput&);
  constexpr Maker kMakers[] = {laserScan, depthPoints, depthImage, cloud, ranges, rotatingScan};
  return kMakers[input.below(std::size(kMakers))](input);
}

/// Rays of kilometres are legal, and take seconds.
template <typename Map>
std::shared_ptr<CLearnedMap> shortSighted(double resolution_m)
{
  auto map = std::make_shared<Map>(resolution_m);
  map->insertionOptions.maxRange = 20;
  return map;
}

std::shared_ptr<CLearnedMap> mapFor(FuzzInput& input)
{
  const double resolution_m = input.yesOrNo() ? 1 : 0.5;  // few cells: each counts under the sanitizers
  switch (input.below(4))
  {
    case 0:
      return shortSighted<CBGKMap>(resolution_m);
    case 1:
      return shortSighted<CGPMap>(resolution_m);
    case 2:
      return shortSighted<CHilbertMap>(resolution_m);
    default:
      return shortSighted<COverlappingHilbertMap>(resolution_m);
  }
}
}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t size)
{
  FuzzInput input(bytes, size);
  const auto map = mapFor(input);
  quieten(*map);
  for (int i = 0; i < 2 && !input.isEmpty(); ++i)
  {
    const auto observation = observationFor(input);
    const mrpt::poses::CPose3D robotPose = input.pose();
    (void)map->insertObservation(*observation, robotPose);
    const double likelihood = map->computeObservationLikelihood(*observation, robotPose);
    if (likelihood != likelihood) breakPromise("a likelihood is a number");
  }
  ask(*map);
  requireSaves(*map);
  return 0;
}
