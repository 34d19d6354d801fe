// A program of another project: inserts one laser scan into a CBGKMap, saves the map and reads it back
// through MRPT's class factory.
#include <all_installed_headers.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/maps/CMetricMap.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>

namespace
{
[[noreturn]] void fail(const std::string& what)
{
  std::cerr << what << "\n";
  std::exit(1);
}

// A semicircular wall 3 m around the sensor.
mrpt::obs::CObservation2DRangeScan roundWallScan()
{
  mrpt::obs::CObservation2DRangeScan scan;
  scan.aperture = static_cast<float>(M_PI);
  scan.maxRange = 10.0F;
  scan.resizeScan(181);
  for (size_t ray = 0; ray < 181; ++ray)
  {
    scan.setScanRange(ray, 3.0F);
    scan.setScanRangeValidity(ray, true);
  }
  return scan;
}

void expectWallAndFreeSpace(const lamap::CBGKMap& map, const std::string& whichMap)
{
  const auto atWall = map.estimateAt({3.0, 0.0, 0.0});
  const auto before = map.estimateAt({1.5, 0.0, 0.0});
  if (!atWall || atWall->state != lamap::CellState::Occupied) fail(whichMap + ": the wall is not occupied");
  if (!before || before->state != lamap::CellState::Free)
    fail(whichMap + ": the space before the wall is not free");
}
}  // namespace

int main(int argc, char** argv)
{
  if (argc != 2) fail("usage: consumer FILE");
  const std::string fileName = argv[1];

  lamap::CBGKMap map;
  if (!map.insertObservation(roundWallScan())) fail("the scan was not inserted");
  expectWallAndFreeSpace(map, "the map");
  {
    mrpt::io::CFileGZOutputStream file(fileName);
    auto archive = mrpt::serialization::archiveFrom(file);
    archive << map;
  }

  mrpt::io::CFileGZInputStream file(fileName);
  auto archive = mrpt::serialization::archiveFrom(file);
  mrpt::serialization::CSerializable::Ptr object;
  archive >> object;
  const auto readBack = std::dynamic_pointer_cast<lamap::CBGKMap>(object);
  if (!readBack) fail(fileName + " holds no CBGKMap");
  expectWallAndFreeSpace(*readBack, "the map read back");
  std::cout << readBack->asString() << "\n";
  return 0;
}
