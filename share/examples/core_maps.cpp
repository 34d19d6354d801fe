// The four maps of the core, without MRPT: insert a scan, ask at points.
#include <lamap_core/bgk/map.h>
#include <lamap_core/gp/map.h>
#include <lamap_core/hilbert/map.h>
#include <lamap_core/overlapping/map.h>

#include <iostream>

template <class Map, class Inference>
bool tryOut(const char* name, const lamap::Scan& scan, Map map, const Inference& howToLearn)
{
  map.insert(scan, howToLearn);
  const lamap::StateThresholds thresholds;             // from where on a cell counts as free or occupied
  const auto wall = map.at({3.05, 0, 0}, thresholds);  // nothing where the map knows nothing
  const auto free = map.at({1.55, 0, 0}, thresholds);
  if (!wall || !free) return false;
  std::cout << name << ": P(occupied) " << wall->prob << " at the wall, " << free->prob << " before it\n";
  return wall->state == lamap::CellState::Occupied && free->state == lamap::CellState::Free;
}

int main()
{
  lamap::RayFan fan;  // a wall 3 m ahead of the sensor
  for (int y = -20; y <= 20; ++y)
    for (int z = -10; z <= 10; ++z) fan.addReturn({3.05, 0.05 * y, 0.05 * z});
  lamap::Scan scan;  // whose sensor is at the origin of the map
  scan.fans.push_back(fan);

  bool good = tryOut("BGK", scan, lamap::BgkMap(), lamap::BgkInference());
  good = tryOut("Gaussian process", scan, lamap::GpMap(), lamap::GpInference()) && good;
  good = tryOut("Hilbert", scan, lamap::HilbertMap(), lamap::HilbertInference()) && good;
  good = tryOut("overlapping Hilbert", scan, lamap::OverlappingHilbertMap(), lamap::OverlappingInference()) &&
         good;
  return good ? 0 : 1;
}
