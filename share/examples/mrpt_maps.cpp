// The four maps as MRPT maps: insert a scan, ask, cast a ray, save and load.
#include <lamap_mrpt/maps/CBGKMap.h>
#include <lamap_mrpt/maps/CGPMap.h>
#include <lamap_mrpt/maps/CHilbertMap.h>
#include <lamap_mrpt/maps/COverlappingHilbertMap.h>
#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/io/CFileGZOutputStream.h>
#include <mrpt/obs/CObservation2DRangeScan.h>
#include <mrpt/serialization/CArchive.h>

#include <iostream>

bool tryOut(lamap::CLearnedMap& map, const mrpt::obs::CObservation& scan)
{
  map.insertObservation(scan);
  const auto wall = map.estimateAt({3, 0, 0});  // nothing where the map knows nothing
  const auto free = map.estimateAt({1.5, 0, 0});
  mrpt::math::TPoint3D hit;
  const bool met = map.castRay({0, 0, 0}, {1, 0, 0}, hit);
  if (!wall || !free || !met) return false;

  const std::string file = map.alias() + ".lamap.gz";  // as `lamap info` and every MRPT program read it
  mrpt::io::CFileGZOutputStream out(file);
  mrpt::serialization::archiveFrom(out) << map;
  out.close();
  mrpt::io::CFileGZInputStream in(file);
  mrpt::serialization::CSerializable::Ptr object;
  mrpt::serialization::archiveFrom(in) >> object;
  const auto loaded = std::dynamic_pointer_cast<lamap::CLearnedMap>(object);

  std::cout << map.alias() << ": P(occupied) " << wall->prob << " at the wall, " << free->prob
            << " before it; a ray ends at x = " << hit.x << " m\n";
  return wall->prob > 0.7 && free->prob < 0.3 && loaded && loaded->estimateAt({3, 0, 0})->prob == wall->prob;
}

int main()
{
  mrpt::obs::CObservation2DRangeScan scan;  // half a circle of wall, 3 m around the sensor
  scan.aperture = 3.14159F;
  scan.maxRange = 10;
  scan.resizeScan(181);
  for (size_t ray = 0; ray < 181; ++ray) scan.setScanRange(ray, 3), scan.setScanRangeValidity(ray, true);

  lamap::CBGKMap bgk;
  lamap::CGPMap gp;
  lamap::CHilbertMap hilbert;
  lamap::COverlappingHilbertMap overlapping;
  bool good = true;
  for (lamap::CLearnedMap* map :
       std::initializer_list<lamap::CLearnedMap*>{&bgk, &gp, &hilbert, &overlapping})
    good = tryOut(*map, scan) && good;
  return good ? 0 : 1;
}
