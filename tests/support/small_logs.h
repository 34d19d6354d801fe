#pragma once

#include <mrpt/core/Clock.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/io/CFileOutputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/serialization/CArchive.h>

#include <string>
#include <vector>

namespace lamap::test
{
using Objects = std::vector<mrpt::serialization::CSerializable::Ptr>;

inline mrpt::Clock::time_point at(double seconds)
{
  return mrpt::Clock::fromDouble(1e9 + seconds);
}

/// A laser scan of nine rays; ranges depend on the time, so that scans differ.
inline mrpt::obs::CObservation2DRangeScan::Ptr laser(mrpt::Clock::time_point time, float range = 2)
{
  auto scan = mrpt::obs::CObservation2DRangeScan::Create();
  scan->timestamp = time;
  scan->aperture = 2;
  scan->maxRange = 20;
  scan->rightToLeft = true;
  scan->resizeScan(9);
  for (size_t i = 0; i < 9; ++i)
  {
    scan->setScanRange(i, range + 0.1F * static_cast<float>(i));
    scan->setScanRangeValidity(i, true);
  }
  return scan;
}

inline mrpt::obs::CObservationOdometry::Ptr odometry(mrpt::Clock::time_point time, double x, double y,
                                                     double phi)
{
  auto reading = mrpt::obs::CObservationOdometry::Create();
  reading->timestamp = time;
  reading->odometry = {x, y, phi};
  return reading;
}

inline mrpt::obs::CActionCollection::Ptr move2D(mrpt::Clock::time_point time, double x, double y, double phi)
{
  mrpt::obs::CActionRobotMovement2D action;
  action.timestamp = time;
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions noise;
  action.computeFromOdometry(mrpt::poses::CPose2D(x, y, phi), noise);
  auto actions = mrpt::obs::CActionCollection::Create();
  actions->insert(action);
  return actions;
}

inline mrpt::obs::CActionCollection::Ptr move3D(mrpt::Clock::time_point time,
                                                const mrpt::poses::CPose3D& increment)
{
  mrpt::obs::CActionRobotMovement3D action;
  action.timestamp = time;
  action.poseChange.mean = increment;  // computeFromOdometry() would draw it at random
  action.poseChange.cov.setIdentity();
  auto actions = mrpt::obs::CActionCollection::Create();
  actions->insert(action);
  return actions;
}

inline mrpt::obs::CSensoryFrame::Ptr frame(const std::vector<mrpt::obs::CObservation::Ptr>& observations)
{
  auto all = mrpt::obs::CSensoryFrame::Create();
  for (const auto& observation : observations) all->insert(observation);
  return all;
}

/// Writes a sequence of objects, gzip-compressed or plain.
inline void writeLog(const std::string& path, const Objects& objects, bool compressed = true)
{
  const auto writeTo = [&](mrpt::io::CStream& stream)
  {
    auto archive = mrpt::serialization::archiveFrom(stream);
    for (const auto& object : objects) archive << *object;
  };
  if (compressed)
  {
    mrpt::io::CFileGZOutputStream file(path);
    writeTo(file);
  }
  else
  {
    mrpt::io::CFileOutputStream file(path);
    writeTo(file);
  }
}

}  // namespace lamap::test
